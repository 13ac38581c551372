//! Makes a mesh of what a file says in its own numbers.

use crate::{CellData, IoError, MeshData, Place};
use csalf_geom::{Point2, QuadId, VertexId};
use csalf_mesh::{NamedSets, QuadMesh};

/// Where an element of the file ended up.
#[derive(Clone, Copy, Debug)]
enum Element {
    Quad(u32),
    Triangle,
    Line([VertexId; 2]),
    Point(VertexId),
}

/// Numbers of a file, sorted, with the positions they stand for.
#[derive(Debug, Default)]
struct Numbers {
    /// (number, position), ascending; empty while the numbers are `first`, `first + 1`, ...
    sorted: Vec<(u64, u32)>,
    first: u64,
    n: u64,
}

impl Numbers {
    /// Takes the numbers in file order. Of equal numbers, the one first seen counts.
    fn new(numbers: &[u64]) -> Self {
        let first = numbers.first().copied().unwrap_or(0);
        let n = numbers.len() as u64;
        if numbers.iter().zip(0..).all(|(&x, i)| x.checked_sub(first) == Some(i)) {
            return Self { sorted: Vec::new(), first, n };
        }
        let mut sorted: Vec<(u64, u32)> = numbers.iter().copied().zip(0..).collect();
        sorted.sort_unstable();
        Self { sorted, first, n }
    }

    fn get(&self, number: u64) -> Option<u32> {
        if self.sorted.is_empty() {
            let i = number.checked_sub(self.first)?;
            return (i < self.n).then_some(i as u32);
        }
        let k = self.sorted.partition_point(|&(x, _)| x < number);
        self.sorted.get(k).filter(|e| e.0 == number).map(|e| e.1)
    }

    fn repeated(&self) -> Option<u64> {
        self.sorted.windows(2).find(|w| w[0].0 == w[1].0).map(|w| w[0].0)
    }
}

/// Collects nodes, elements and sets under the numbers of the file; [`Builder::finish`] turns them into a mesh.
#[derive(Debug)]
pub(crate) struct Builder {
    format: &'static str,
    node_numbers: Vec<u64>,
    points: Vec<Point2>,
    heights: Vec<f64>,
    element_numbers: Vec<u64>,
    /// Corner numbers of all elements, one behind the other.
    corners: Vec<u64>,
    /// End of each element's corners.
    ends: Vec<usize>,
    /// Numbers of nodes between corners, of elements of second order.
    middles: Vec<u64>,
    /// Where each element was found: line or cell, as `place_of` says it.
    places: Vec<u32>,
    place_of: fn(usize) -> Place,
    /// Node sets by node number.
    pub node_sets: Vec<(String, Vec<u64>)>,
    /// Element sets by element number, of elements of any dimension.
    pub element_sets: Vec<(String, Vec<u64>)>,
    /// Names and values per element, in file order.
    pub cell_data: Vec<CellData>,
    /// What to tell the caller.
    pub notes: Vec<String>,
}

impl Builder {
    /// An empty mesh; `place_of` says what the places of nodes and elements mean.
    pub(crate) fn new(format: &'static str, place_of: fn(usize) -> Place) -> Self {
        Self {
            format,
            node_numbers: Vec::new(),
            points: Vec::new(),
            heights: Vec::new(),
            element_numbers: Vec::new(),
            corners: Vec::new(),
            ends: Vec::new(),
            middles: Vec::new(),
            places: Vec::new(),
            place_of,
            node_sets: Vec::new(),
            element_sets: Vec::new(),
            cell_data: Vec::new(),
            notes: Vec::new(),
        }
    }

    pub(crate) fn n_nodes(&self) -> usize {
        self.points.len()
    }

    /// Adds a node.
    pub(crate) fn node(&mut self, number: u64, [x, y, z]: [f64; 3], place: usize) -> Result<(), IoError> {
        if !(x.is_finite() && y.is_finite() && z.is_finite()) {
            let message = format!("node {number} is not at a finite place: ({x}, {y}, {z})");
            return Err(IoError::syntax(self.format, (self.place_of)(place), message));
        }
        self.node_numbers.push(number);
        self.points.push(Point2::new(x, y));
        self.heights.push(z);
        Ok(())
    }

    /// Adds an element of 1 to 4 corners: point, line, triangle, quad.
    pub(crate) fn element(&mut self, number: u64, corners: &[u64], place: usize) {
        self.element_numbers.push(number);
        self.corners.extend_from_slice(corners);
        self.ends.push(self.corners.len());
        self.places.push(u32::try_from(place).unwrap_or(u32::MAX));
    }

    /// Names nodes between the corners of an element of second order: what is no corner of any element is left out.
    pub(crate) fn middles(&mut self, nodes: &[u64]) {
        self.middles.extend_from_slice(nodes);
    }

    /// Takes out what [`Self::middles`] named, from the node sets, too.
    fn leave_out_middles(&mut self) {
        let mut corners = self.corners.clone();
        corners.sort_unstable();
        let mut gone = std::mem::take(&mut self.middles);
        gone.sort_unstable();
        gone.dedup();
        gone.retain(|m| corners.binary_search(m).is_err());
        let stays = |n: u64| gone.binary_search(&n).is_err();
        let kept: Vec<bool> = self.node_numbers.iter().map(|&n| stays(n)).collect();
        fn keep<T>(list: &mut Vec<T>, kept: &[bool]) {
            let mut k = kept.iter();
            list.retain(|_| k.next() == Some(&true));
        }
        keep(&mut self.node_numbers, &kept);
        keep(&mut self.points, &kept);
        keep(&mut self.heights, &kept);
        for (_, members) in &mut self.node_sets {
            members.retain(|&n| stays(n));
        }
        let n = kept.iter().filter(|k| !**k).count();
        if n > 0 {
            self.notes
                .push(format!("{n} nodes between corners were left out: elements are taken as straight"));
        }
    }

    pub(crate) fn n_elements(&self) -> usize {
        self.ends.len()
    }

    /// The mesh.
    pub(crate) fn finish(self) -> Result<MeshData, IoError> {
        Ok(self.finish_with_lines()?.0)
    }

    /// The mesh, which may lie in space, and all lines. Elements keep their order; an element number that comes again with the same corners is the same
    /// element (Gmsh 2.2 writes one in two groups so).
    pub(crate) fn finish_with_lines(mut self) -> Result<(MeshData, Vec<[VertexId; 2]>), IoError> {
        if !self.middles.is_empty() {
            self.leave_out_middles();
        }
        let (format, place_of) = (self.format, self.place_of);
        let fail =
            |i: usize, message: String| IoError::syntax(format, place_of(self.places[i] as usize), message);
        let mut notes = self.notes;
        if self.points.len() > u32::MAX as usize || self.ends.len() > u32::MAX as usize {
            return Err(IoError::unsupported(format, Place::Whole, "more than 2^32 nodes or elements"));
        }
        let mut heights = self.heights;
        let z = heights.first().copied().unwrap_or(0.0);
        if heights.iter().all(|other| *other == z) {
            heights.clear();
            if z != 0.0 {
                notes.push(format!("all nodes lie at z = {z}; z was dropped"));
            }
        }
        let nodes = Numbers::new(&self.node_numbers);
        if let Some(n) = nodes.repeated() {
            return Err(IoError::syntax(format, Place::Whole, format!("node number {n} is used twice")));
        }
        let mut mesh = QuadMesh { points: self.points, ..QuadMesh::default() };
        let numbers = Numbers::new(&self.element_numbers);
        let mut elements: Vec<Element> = Vec::with_capacity(self.ends.len());
        let mut start = 0;
        let begins: Vec<usize> = std::iter::once(0).chain(self.ends.iter().copied()).collect();
        let (mut of_quads, mut of_triangles, mut lines) = (Vec::new(), Vec::new(), Vec::new());
        for (i, &end) in self.ends.iter().enumerate() {
            let corners = &self.corners[start..end];
            start = end;
            let first = numbers.get(self.element_numbers[i]).unwrap_or(i as u32) as usize;
            if first < i {
                if self.corners[begins[first]..begins[first + 1]] == *corners {
                    elements.push(elements[first]);
                    continue;
                }
                let message = format!("element number {} is used twice", self.element_numbers[i]);
                return Err(fail(i, message));
            }
            let mut v = [VertexId::default(); 4];
            for (k, &c) in corners.iter().enumerate().take(4) {
                let message =
                    || format!("element {} uses node {c}, which is not there", self.element_numbers[i]);
                v[k] = VertexId(nodes.get(c).ok_or_else(|| fail(i, message()))?);
            }
            elements.push(match corners.len() {
                4 => {
                    of_quads.push(i);
                    mesh.quads.push(v);
                    Element::Quad(mesh.quads.len() as u32 - 1)
                }
                3 => {
                    of_triangles.push(i);
                    mesh.triangles.push([v[0], v[1], v[2]]);
                    Element::Triangle
                }
                2 => {
                    lines.push([v[0], v[1]]);
                    Element::Line([v[0], v[1]])
                }
                1 => Element::Point(v[0]),
                n => return Err(fail(i, format!("an element with {n} corners"))),
            });
        }
        let mut sets = NamedSets::default();
        for (name, members) in self.node_sets {
            let found: Vec<VertexId> = members.iter().filter_map(|&n| nodes.get(n).map(VertexId)).collect();
            if found.len() < members.len() {
                notes.push(format!("set {name}: {} nodes are not there", members.len() - found.len()));
            }
            sets.nodes.push((name, found));
        }
        for (name, members) in self.element_sets {
            let (mut points, mut edges, mut quads) = (Vec::new(), Vec::new(), Vec::new());
            let mut missing = 0;
            for n in members {
                match numbers.get(n).map(|i| elements[i as usize]) {
                    Some(Element::Quad(q)) => quads.push(QuadId(q)),
                    Some(Element::Line(l)) => edges.push(l),
                    Some(Element::Point(p)) => points.push(p),
                    Some(Element::Triangle) => {}
                    None => missing += 1,
                }
            }
            if missing > 0 {
                notes.push(format!("set {name}: {missing} elements are not there"));
            }
            if !points.is_empty() {
                sets.nodes.push((name.clone(), points));
            }
            if !edges.is_empty() {
                sets.edges.push((name.clone(), edges));
            }
            if !quads.is_empty() {
                sets.quads.push((name, quads));
            }
        }
        let mut cell_data = self.cell_data;
        for d in &mut cell_data {
            let of = |i: &usize| d.values.get(*i).copied().unwrap_or(f64::NAN);
            d.values = of_quads.iter().chain(&of_triangles).map(of).collect();
        }
        Ok((MeshData { mesh, heights, sets, cell_data, notes }, lines))
    }
}

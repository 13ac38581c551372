//! Reads `.msh` 2.2 and 4.1, text and binary.
//!
//! ```text
//!   $MeshFormat      version, text or binary, byte order
//!   $PhysicalNames   (dimension, tag) → name
//!   $Entities        4.1: (dimension, entity) → physical tags
//!   $Nodes           2.2: one list; 4.1: blocks, tags first
//!   $Elements        2.2: type and tags each; 4.1: blocks by entity and type
//! ```

use super::{ALL, FORMAT};
use crate::{IoError, MeshData, Place, builder::Builder, text::Cursor};

/// Reads numbers as text or as bytes.
struct Source<'a> {
    text: Cursor<'a>,
    binary: bool,
    big_endian: bool,
}

impl Source<'_> {
    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], IoError> {
        let mut out = [0; N];
        out.copy_from_slice(self.text.raw(N)?);
        if self.big_endian {
            out.reverse();
        }
        Ok(out)
    }
    /// A 32-bit integer.
    fn int(&mut self) -> Result<i64, IoError> {
        if self.binary {
            Ok(i32::from_le_bytes(self.bytes()?).into())
        } else {
            self.text.number("an integer")
        }
    }
    /// A 64-bit count or tag.
    fn size(&mut self) -> Result<u64, IoError> {
        if self.binary {
            Ok(u64::from_le_bytes(self.bytes()?))
        } else {
            self.text.number("a count or number")
        }
    }
    fn real(&mut self) -> Result<f64, IoError> {
        if self.binary { Ok(f64::from_le_bytes(self.bytes()?)) } else { self.text.number("a coordinate") }
    }
    fn skip(&mut self, n: u64, one: fn(&mut Self) -> Result<(), IoError>) -> Result<(), IoError> {
        (0..n).try_for_each(|_| one(self))
    }
}

/// Corners and nodes of an element type that is kept: point, line, triangle, quad, the last three also of second order,
/// where corners come first.
fn corners_of(kind: i64) -> Option<(usize, usize)> {
    match kind {
        15 => Some((1, 1)),
        1 => Some((2, 2)),
        8 => Some((2, 3)),
        2 => Some((3, 3)),
        9 => Some((3, 6)),
        3 => Some((4, 4)),
        16 => Some((4, 8)),
        10 => Some((4, 9)),
        _ => None,
    }
}

/// Most nodes of an element.
const MOST_NODES: usize = 9;

/// What has been gathered of one file.
pub(super) struct Gathered {
    pub builder: Builder,
    names: Vec<((i64, i64), String)>,
    /// (dimension, entity) → physical tags.
    entities: Vec<((i64, i64), Vec<i64>)>,
    /// (dimension, physical tag, element).
    members: Vec<(i64, i64, u64)>,
}

/// Reads a mesh; points and lines become sets only.
///
/// # Errors
/// [`IoError::Syntax`] or [`IoError::Unsupported`].
pub fn read(bytes: &[u8]) -> Result<MeshData, IoError> {
    let mut g = gather(bytes)?;
    g.name_sets();
    let mut data = g.builder.finish()?;
    // Our own group of all (2.2: of the rest) says nothing.
    data.sets.quads.retain(|(name, _)| name != ALL);
    Ok(data)
}

impl Gathered {
    /// Turns physical groups into element sets of the builder.
    pub(super) fn name_sets(&mut self) {
        self.members.sort_by_key(|m| (m.0, m.1));
        for run in self.members.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let key = (run[0].0, run[0].1);
            let name = self.names.iter().find(|n| n.0 == key).map(|n| n.1.clone());
            let name = name.unwrap_or_else(|| format!("physical{}", key.1));
            self.builder.element_sets.push((name, run.iter().map(|m| m.2).collect()));
        }
    }
}

/// Reads all sections.
pub(super) fn gather(bytes: &[u8]) -> Result<Gathered, IoError> {
    let mut src = Source { text: Cursor::new(bytes, FORMAT), binary: false, big_endian: false };
    let mut version = 0.0;
    let mut g = Gathered {
        builder: Builder::new(FORMAT, |n| Place::Path(format!("entry {n}"))),
        names: Vec::new(),
        entities: Vec::new(),
        members: Vec::new(),
    };
    while let Some(section) = src.text.token() {
        let Some(name) = section.strip_prefix('$') else {
            return Err(src.text.error(format!("{section:?} where a section should begin")));
        };
        if version == 0.0 && name != "MeshFormat" {
            return Err(src.text.error("the file does not begin with $MeshFormat"));
        }
        match name {
            "MeshFormat" => version = read_format(&mut src)?,
            "PhysicalNames" => read_names(&mut src, &mut g)?,
            "Entities" if version >= 4.0 => {
                src.text.line();
                read_entities(&mut src, &mut g)?;
            }
            "Nodes" | "Elements" => {
                // Text may have its count on the same line, bytes begin on the next.
                let count = if version < 4.0 { Some(src.text.number::<u64>("a count")?) } else { None };
                if src.binary {
                    src.text.line();
                }
                match (name, count) {
                    ("Nodes", Some(n)) => nodes_22(&mut src, &mut g, n)?,
                    ("Nodes", None) => nodes_41(&mut src, &mut g)?,
                    (_, Some(n)) => elements_22(&mut src, &mut g, n)?,
                    (_, None) => elements_41(&mut src, &mut g)?,
                }
            }
            _ => {
                let end = format!("$End{name}");
                loop {
                    match src.text.line() {
                        Some(l) if l.trim_ascii_end().ends_with(end.as_bytes()) => break,
                        Some(_) => {}
                        None => return Err(src.text.error(format!("section ${name} does not end"))),
                    }
                }
                continue;
            }
        }
        match src.text.token() {
            Some(t) if t.strip_prefix("$End") == Some(name) => {}
            t => return Err(src.text.error(format!("{:?} where $End{name} should be", t.unwrap_or("")))),
        }
    }
    if version == 0.0 {
        return Err(src.text.error("the file is empty"));
    }
    Ok(g)
}

fn read_format(src: &mut Source<'_>) -> Result<f64, IoError> {
    let version: f64 = src.text.number("a version")?;
    if !((2.0..3.0).contains(&version) || version == 4.1) {
        return Err(src.text.unsupported(format!("version {version}; versions 2.2 and 4.1 are read")));
    }
    src.binary = src.text.number::<u32>("0 or 1")? == 1;
    src.text.number::<u32>("a size")?;
    if src.binary {
        src.text.line();
        let one = src.text.raw(4)?;
        src.big_endian = match one {
            [1, 0, 0, 0] => false,
            [0, 0, 0, 1] => true,
            _ => return Err(src.text.error("the byte order mark is not 1")),
        };
    }
    Ok(version)
}

fn read_names(src: &mut Source<'_>, g: &mut Gathered) -> Result<(), IoError> {
    let n: u64 = src.text.number("a count")?;
    for _ in 0..n {
        let key = (src.text.number("a dimension")?, src.text.number("a number")?);
        let line = String::from_utf8_lossy(src.text.line().unwrap_or(b"")).into_owned();
        let name = line.trim().trim_matches('"').to_owned();
        g.names.push((key, name));
    }
    Ok(())
}

fn read_entities(src: &mut Source<'_>, g: &mut Gathered) -> Result<(), IoError> {
    let counts = [src.size()?, src.size()?, src.size()?, src.size()?];
    for (dim, &n) in (0i64..).zip(&counts) {
        for _ in 0..n {
            let tag = src.int()?;
            src.skip(if dim == 0 { 3 } else { 6 }, |s| s.real().map(|_| ()))?;
            let n_groups = src.size()?;
            let mut groups = Vec::new();
            for _ in 0..n_groups {
                groups.push(src.int()?.abs());
            }
            if dim > 0 {
                let n_bounds = src.size()?;
                src.skip(n_bounds, |s| s.int().map(|_| ()))?;
            }
            g.entities.push(((dim, tag), groups));
        }
    }
    g.entities.sort_by_key(|e| e.0);
    Ok(())
}

fn nodes_22(src: &mut Source<'_>, g: &mut Gathered, n: u64) -> Result<(), IoError> {
    for i in 0..n {
        let number = positive(src, "node")?;
        let xyz = [src.real()?, src.real()?, src.real()?];
        g.builder.node(number, xyz, i as usize)?;
    }
    Ok(())
}

fn nodes_41(src: &mut Source<'_>, g: &mut Gathered) -> Result<(), IoError> {
    let n_blocks = src.size()?;
    src.skip(3, |s| s.size().map(|_| ()))?;
    for _ in 0..n_blocks {
        let dim = src.int()?;
        let (_entity, parametric) = (src.int()?, src.int()?);
        let n = src.size()?;
        let extra = if parametric != 0 { dim.clamp(0, 3) as u64 } else { 0 };
        let mut numbers = Vec::new();
        for _ in 0..n {
            numbers.push(src.size()?);
        }
        for (i, number) in numbers.into_iter().enumerate() {
            let xyz = [src.real()?, src.real()?, src.real()?];
            src.skip(extra, |s| s.real().map(|_| ()))?;
            g.builder.node(number, xyz, i)?;
        }
    }
    Ok(())
}

/// A number of 2.2, which is a 32-bit integer, as 64 bits.
fn positive(src: &mut Source<'_>, what: &str) -> Result<u64, IoError> {
    let n = src.int()?;
    u64::try_from(n).map_err(|_| src.text.error(format!("{what} number {n} is negative")))
}

fn add_element(
    src: &Source<'_>,
    g: &mut Gathered,
    kind: i64,
    number: u64,
    nodes: &[u64],
) -> Result<(), IoError> {
    let Some((n_corners, _)) = corners_of(kind).filter(|k| k.1 == nodes.len()) else {
        return Err(src
            .text
            .unsupported(format!("element type {kind}; points, lines, triangles and quads are read")));
    };
    let place = g.builder.n_elements();
    g.builder.element(number, &nodes[..n_corners], place);
    g.builder.middles(&nodes[n_corners..]);
    Ok(())
}

fn elements_22(src: &mut Source<'_>, g: &mut Gathered, n: u64) -> Result<(), IoError> {
    let mut left = n;
    // In bytes, elements come in runs of one type with one header; in text, each is a run of its own.
    while left > 0 {
        let (kind, run, n_tags, text_number);
        if src.binary {
            (kind, run, n_tags, text_number) =
                (src.int()?, positive(src, "run")?.min(left), src.int()?, None);
            if run == 0 {
                return Err(src.text.error("a run of no elements"));
            }
        } else {
            text_number = Some(positive(src, "element")?);
            (kind, run, n_tags) = (src.int()?, 1, src.int()?);
        }
        let Some((n_corners, n_nodes)) = corners_of(kind) else {
            return Err(src.text.unsupported(format!("element type {kind}")));
        };
        let dim = [0, 1, 2, 2][n_corners - 1];
        for _ in 0..run {
            let number = match text_number {
                Some(n) => n,
                None => positive(src, "element")?,
            };
            for k in 0..n_tags {
                let tag = src.int()?;
                if k == 0 && tag != 0 {
                    g.members.push((dim, tag, number));
                }
            }
            let mut nodes = [0; MOST_NODES];
            for c in &mut nodes[..n_nodes] {
                *c = positive(src, "node")?;
            }
            add_element(src, g, kind, number, &nodes[..n_nodes])?;
        }
        left -= run;
    }
    Ok(())
}

fn elements_41(src: &mut Source<'_>, g: &mut Gathered) -> Result<(), IoError> {
    let n_blocks = src.size()?;
    src.skip(3, |s| s.size().map(|_| ()))?;
    for _ in 0..n_blocks {
        let (dim, entity, kind) = (src.int()?, src.int()?, src.int()?);
        let n = src.size()?;
        let Some((_, n_nodes)) = corners_of(kind) else {
            return Err(src.text.unsupported(format!("element type {kind}")));
        };
        let groups = g.entities.binary_search_by_key(&(dim, entity), |e| e.0);
        let groups = groups.map(|k| g.entities[k].1.clone()).unwrap_or_default();
        for _ in 0..n {
            let number = src.size()?;
            let mut nodes = [0; MOST_NODES];
            for c in &mut nodes[..n_nodes] {
                *c = src.size()?;
            }
            g.members.extend(groups.iter().map(|&t| (dim, t, number)));
            add_element(src, g, kind, number, &nodes[..n_nodes])?;
        }
    }
    Ok(())
}

//! Reads `.vtu`: arrays in text, base64 or appended (raw or base64), plain or compressed by zlib.
//!
//! 1. Cut the file at `<AppendedData>`: what is before is XML, what is behind may be anything.
//! 2. Parse the XML; decode arrays as they are asked for.
//! 3. Cells to elements; `nset:`, `eset:` and `qset:` arrays of the grid to sets.

use super::FORMAT;
use crate::{CellData, IoError, MeshData, Place, builder::Builder};
use base64::Engine as _;
use csalf_geom::{QuadId, VertexId};
use roxmltree::{Document, Node};

/// How the arrays of one file are stored.
struct Store<'a> {
    /// Bytes behind the underscore of `<AppendedData>`.
    appended: &'a [u8],
    appended_is_raw: bool,
    compressed: bool,
    little: bool,
    wide_header: bool,
}

/// One decoded array, as numbers of one kind.
enum Values {
    Float(Vec<f64>),
    Int(Vec<i64>),
}

impl Values {
    fn floats(self) -> Vec<f64> {
        match self {
            Self::Float(v) => v,
            Self::Int(v) => v.into_iter().map(|i| i as f64).collect(),
        }
    }

    fn ints(self, what: &str) -> Result<Vec<i64>, IoError> {
        match self {
            Self::Int(v) => Ok(v),
            Self::Float(_) => Err(bad(format!("{what} are not integers"))),
        }
    }
}

fn bad(message: impl Into<String>) -> IoError {
    IoError::syntax(FORMAT, Place::Whole, message)
}

/// Reads a mesh. Cells of one or two corners become sets only; more than four corners are not supported.
///
/// # Errors
/// [`IoError::Syntax`] or [`IoError::Unsupported`].
pub fn read(bytes: &[u8]) -> Result<MeshData, IoError> {
    let tag = b"<AppendedData";
    let cut = bytes.windows(tag.len()).position(|w| w == tag);
    let (mut head, mut appended, mut appended_is_raw) = (bytes.to_vec(), &bytes[..0], true);
    if let Some(cut) = cut {
        let rest = &bytes[cut..];
        let end = rest.iter().position(|&b| b == b'>').ok_or_else(|| bad("<AppendedData> is not closed"))?;
        appended_is_raw = !rest[..end].windows(6).any(|w| w == b"base64");
        let from =
            rest[end..].iter().position(|&b| b == b'_').ok_or_else(|| bad("appended data without `_`"))?;
        appended = &rest[end + from + 1..];
        head.truncate(cut);
        head.extend_from_slice(b"</VTKFile>");
    }
    let text = String::from_utf8(head).map_err(|e| {
        IoError::syntax(FORMAT, Place::Byte(e.utf8_error().valid_up_to()), "the XML part is not UTF-8")
    })?;
    let doc = Document::parse(&text)
        .map_err(|e| IoError::syntax(FORMAT, Place::Line(e.pos().row as usize), e.to_string()))?;
    let root = doc.root_element();
    if root.tag_name().name() != "VTKFile" || root.attribute("type") != Some("UnstructuredGrid") {
        return Err(bad("not a VTKFile of type UnstructuredGrid"));
    }
    let compressed = match root.attribute("compressor") {
        None | Some("") => false,
        Some("vtkZLibDataCompressor") => true,
        Some(c) => return Err(IoError::unsupported(FORMAT, Place::Whole, format!("compressor {c}"))),
    };
    let store = Store {
        appended,
        appended_is_raw,
        compressed,
        little: root.attribute("byte_order") != Some("BigEndian"),
        wide_header: root.attribute("header_type") == Some("UInt64"),
    };
    let grid = child(root, "UnstructuredGrid").ok_or_else(|| bad("no <UnstructuredGrid>"))?;
    let mut out = Builder::new(FORMAT, |i| Place::Path(format!("cell {i}")));
    let mut n_cells = 0;
    for piece in grid.children().filter(|n| n.has_tag_name("Piece")) {
        read_piece(piece, &store, &mut out, &mut n_cells)?;
    }
    let mut data = out.finish()?;
    if let Some(fields) = child(grid, "FieldData") {
        read_sets(fields, &store, &mut data)?;
    }
    Ok(data)
}

fn child<'a, 'i>(node: Node<'a, 'i>, name: &str) -> Option<Node<'a, 'i>> {
    node.children().find(|n| n.has_tag_name(name))
}

fn read_piece(
    piece: Node<'_, '_>,
    store: &Store<'_>,
    out: &mut Builder,
    n_cells: &mut usize,
) -> Result<(), IoError> {
    let first = out.n_nodes() as u64;
    let points =
        child(piece, "Points").and_then(|n| child(n, "DataArray")).ok_or_else(|| bad("no <Points>"))?;
    let xyz = store.decode(points)?.floats();
    let width = points.attribute("NumberOfComponents").and_then(|s| s.parse().ok()).unwrap_or(3);
    if !matches!(width, 2 | 3) || xyz.len() % width != 0 {
        return Err(bad(format!("{} coordinates of {width} components", xyz.len())));
    }
    for (i, p) in xyz.chunks_exact(width).enumerate() {
        let z = p.get(2).copied().unwrap_or(0.0);
        out.node(first + i as u64, [p[0], p[1], z], i)?;
    }
    let Some(cells) = child(piece, "Cells") else { return Ok(()) };
    let array = |name: &str| {
        let node =
            cells.children().find(|n| n.has_tag_name("DataArray") && n.attribute("Name") == Some(name));
        store.decode(node.ok_or_else(|| bad(format!("no array `{name}` in <Cells>")))?)?.ints(name)
    };
    let (connectivity, offsets, types) = (array("connectivity")?, array("offsets")?, array("types")?);
    if offsets.len() != types.len() {
        return Err(bad(format!("{} offsets for {} cell types", offsets.len(), types.len())));
    }
    let first_cell = *n_cells;
    let mut start = 0usize;
    for (i, (&end, &kind)) in offsets.iter().zip(&types).enumerate() {
        let corners = usize::try_from(end).ok().and_then(|e| connectivity.get(start..e));
        let corners = corners.ok_or_else(|| bad(format!("offset {end} of cell {i} is out of range")))?;
        start = end as usize;
        let mut c = [0u64; 4];
        let n = match (kind, corners.len()) {
            (1, 1) | (3 | 4, 2) | (5 | 7, 3) | (7 | 9, 4) | (8, 4) => corners.len(),
            // Of second order, corners first.
            (21, 3) => 2,
            (22, 6) | (34, 7) => 3,
            (23, 8) | (28, 9) => 4,
            (1 | 3 | 4 | 5 | 8 | 9 | 21 | 22 | 23 | 28, n) => {
                return Err(bad(format!("cell {i} of type {kind} has {n} corners")));
            }
            _ => {
                let message = format!("cell type {kind} with {} corners", corners.len());
                return Err(IoError::unsupported(FORMAT, Place::Path(format!("cell {i}")), message));
            }
        };
        let number = |from: i64| {
            u64::try_from(from).ok().and_then(|v| v.checked_add(first)).ok_or_else(|| {
                IoError::syntax(FORMAT, Place::Path(format!("cell {i}")), format!("vertex number {from}"))
            })
        };
        for (to, &from) in c[..n].iter_mut().zip(corners) {
            *to = number(from)?;
        }
        for &from in &corners[n..] {
            out.middles(&[number(from)?]);
        }
        if kind == 8 {
            c.swap(2, 3); // A pixel counts its corners by rows.
        }
        out.element(*n_cells as u64, &c[..n], i);
        *n_cells += 1;
    }
    let arrays = child(piece, "CellData").into_iter().flat_map(|n| n.children());
    for a in arrays.filter(|n| n.has_tag_name("DataArray")) {
        let name = a.attribute("Name").unwrap_or("");
        let values = match store.decode(a) {
            Ok(v) => v.floats(),
            Err(_) => Vec::new(),
        };
        if values.len() != types.len() {
            out.notes.push(format!("cell array {name} was left out: not one number per cell"));
            continue;
        }
        let k = out.cell_data.iter().position(|d| d.name == name).unwrap_or_else(|| {
            out.cell_data.push(CellData { name: name.to_owned(), values: Vec::new() });
            out.cell_data.len() - 1
        });
        out.cell_data[k].values.resize(first_cell, f64::NAN);
        out.cell_data[k].values.extend(values);
    }
    Ok(())
}

/// Sets of our own files: arrays `nset:NAME`, `eset:NAME`, `qset:NAME` of the grid.
fn read_sets(fields: Node<'_, '_>, store: &Store<'_>, data: &mut MeshData) -> Result<(), IoError> {
    for a in fields.children().filter(|n| n.has_tag_name("DataArray")) {
        let Some((prefix, name)) = a.attribute("Name").and_then(|n| n.split_once(':')) else { continue };
        if !matches!(prefix, "nset" | "eset" | "qset") {
            continue;
        }
        let limit = if prefix == "qset" { data.mesh.quads.len() } else { data.mesh.points.len() };
        let mut members = Vec::new();
        for i in store.decode(a)?.ints(name)? {
            let i = u32::try_from(i).ok().filter(|&i| (i as usize) < limit);
            members.push(i.ok_or_else(|| bad(format!("set {name} is out of range")))?);
        }
        let name = name.to_owned();
        match prefix {
            "nset" => data.sets.nodes.push((name, members.into_iter().map(VertexId).collect())),
            "qset" => data.sets.quads.push((name, members.into_iter().map(QuadId).collect())),
            _ => {
                let pairs = members.chunks_exact(2).map(|e| [VertexId(e[0]), VertexId(e[1])]);
                data.sets.edges.push((name, pairs.collect()));
            }
        }
    }
    Ok(())
}

impl Store<'_> {
    fn decode(&self, array: Node<'_, '_>) -> Result<Values, IoError> {
        let kind = array.attribute("type").unwrap_or("Float64");
        let name = array.attribute("Name").unwrap_or("Points");
        let text = || array.text().unwrap_or("").as_bytes();
        let bytes = match array.attribute("format").unwrap_or("ascii") {
            "ascii" => return parse_text(array.text().unwrap_or(""), kind, name),
            "binary" => self.block(&without_space(text()), false)?,
            "appended" => {
                let offset: usize = array
                    .attribute("offset")
                    .and_then(|s| s.trim().parse().ok())
                    .ok_or_else(|| bad(format!("array {name} has no offset")))?;
                let from = self.appended.get(offset..).ok_or_else(|| {
                    IoError::syntax(FORMAT, Place::Byte(offset), format!("array {name} lies behind the data"))
                })?;
                if self.appended_is_raw {
                    self.block(from, true)?
                } else {
                    self.block(&without_space(from), false)?
                }
            }
            f => return Err(bad(format!("array {name} has the unknown format {f:?}"))),
        };
        self.numbers(&bytes, kind)
    }

    /// One unsigned number of a block's header.
    fn header_number(&self, bytes: &[u8], i: usize) -> Result<usize, IoError> {
        let size = if self.wide_header { 8 } else { 4 };
        let part =
            bytes.get(i * size..(i + 1) * size).ok_or_else(|| bad("an array ends within its header"))?;
        let fold = |n: u64, b: &u8| n << 8 | u64::from(*b);
        let n = if self.little { part.iter().rev().fold(0, fold) } else { part.iter().fold(0, fold) };
        usize::try_from(n).map_err(|_| bad("an array is too long"))
    }

    /// The bytes of one array: header, then data, both raw or both base64.
    fn block(&self, from: &[u8], raw: bool) -> Result<Vec<u8>, IoError> {
        let size = if self.wide_header { 8 } else { 4 };
        // Bytes `a..b` of the stored stream that begins at `from`.
        let take = |from: &[u8], a: usize, b: usize| -> Result<Vec<u8>, IoError> {
            if raw {
                let part = from.get(a..b).ok_or_else(|| bad("an array ends too early"))?;
                return Ok(part.to_vec());
            }
            let chars =
                from.get(..b.div_ceil(3).saturating_mul(4)).ok_or_else(|| bad("an array ends too early"))?;
            let all = base64::engine::general_purpose::STANDARD
                .decode(chars)
                .map_err(|e| bad(format!("an array is not base64: {e}")))?;
            all.get(a..b).map(<[u8]>::to_vec).ok_or_else(|| bad("an array ends too early"))
        };
        if from.is_empty() {
            return Ok(Vec::new());
        }
        let head_chars = |n: usize| n.div_ceil(3) * 4;
        if !self.compressed {
            let n = self.header_number(&take(from, 0, size)?, 0)?;
            // Some writers encode the header by itself: then it ends with padding.
            if !raw && from.get(head_chars(size) - 1) == Some(&b'=') {
                return take(&from[head_chars(size)..], 0, n);
            }
            return take(from, size, size.checked_add(n).ok_or_else(|| bad("an array is too long"))?);
        }
        let n_blocks = self.header_number(&take(from, 0, size)?, 0)?;
        if n_blocks > from.len() {
            return Err(bad("an array has more blocks than bytes"));
        }
        let head_size = (3 + n_blocks) * size;
        let head = take(from, 0, head_size)?;
        let (full, last) = (self.header_number(&head, 1)?, self.header_number(&head, 2)?);
        let mut rest = &from[if raw { head_size } else { head_chars(head_size) }.min(from.len())..];
        let mut packed_size = 0usize;
        for k in 0..n_blocks {
            packed_size = packed_size.saturating_add(self.header_number(&head, 3 + k)?);
        }
        let decoded;
        if !raw {
            decoded = take(rest, 0, packed_size)?;
            rest = &decoded;
        }
        let mut out = Vec::new();
        for k in 0..n_blocks {
            let n = self.header_number(&head, 3 + k)?;
            let packed = rest.get(..n).ok_or_else(|| bad("a compressed array ends too early"))?;
            rest = &rest[n..];
            let want = if k + 1 == n_blocks && last > 0 { last } else { full };
            let plain = miniz_oxide::inflate::decompress_to_vec_zlib_with_limit(packed, want)
                .map_err(|e| bad(format!("a compressed array is broken: {e}")))?;
            if plain.len() != want {
                return Err(bad("a compressed array is too short"));
            }
            out.extend_from_slice(&plain);
        }
        Ok(out)
    }

    fn numbers(&self, bytes: &[u8], kind: &str) -> Result<Values, IoError> {
        macro_rules! convert {
            ($t:ty, $as:ty, $variant:ident) => {{
                const N: usize = std::mem::size_of::<$t>();
                let one = |c: &[u8]| {
                    let mut a = [0; N];
                    a.copy_from_slice(c);
                    (if self.little { <$t>::from_le_bytes(a) } else { <$t>::from_be_bytes(a) }) as $as
                };
                Values::$variant(bytes.chunks_exact(N).map(one).collect())
            }};
        }
        Ok(match kind {
            "Float64" => convert!(f64, f64, Float),
            "Float32" => convert!(f32, f64, Float),
            "Int8" => convert!(i8, i64, Int),
            "UInt8" => convert!(u8, i64, Int),
            "Int16" => convert!(i16, i64, Int),
            "UInt16" => convert!(u16, i64, Int),
            "Int32" => convert!(i32, i64, Int),
            "UInt32" => convert!(u32, i64, Int),
            "Int64" => convert!(i64, i64, Int),
            "UInt64" => convert!(u64, i64, Int),
            _ => return Err(IoError::unsupported(FORMAT, Place::Whole, format!("array of type {kind}"))),
        })
    }
}

fn parse_text(text: &str, kind: &str, name: &str) -> Result<Values, IoError> {
    let wrong = |w: &str| bad(format!("{w:?} in array {name} is not a number of type {kind}"));
    Ok(if kind.starts_with("Float") {
        let parsed = text.split_ascii_whitespace().map(|w| w.parse::<f64>().map_err(|_| wrong(w)));
        Values::Float(parsed.collect::<Result<_, _>>()?)
    } else {
        let parsed = text.split_ascii_whitespace().map(|w| w.parse::<i64>().map_err(|_| wrong(w)));
        Values::Int(parsed.collect::<Result<_, _>>()?)
    })
}

fn without_space(bytes: &[u8]) -> Vec<u8> {
    bytes.iter().copied().filter(|b| !b.is_ascii_whitespace()).collect()
}

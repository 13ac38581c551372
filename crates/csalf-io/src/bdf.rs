//! Nastran bulk data (`.bdf`): `GRID*` (16-character fields), `CQUAD4`, `CTRIA3`; sets as case control `SET`s, each
//! with a comment that gives its kind and name.
//!
//! A field of 16 characters holds 11 to 15 digits of a coordinate: it comes back with a relative error below 1e-10,
//! not bit for bit as in the other text formats.

use crate::{
    IoError, MeshData, MeshView, MidNodes, Place,
    builder::Builder,
    inp::node_sets,
    text::{Cursor, one_line},
};
use csalf_geom::VertexId;
use std::io::Write;

const FORMAT: &str = "Nastran";

/// Writes a mesh.
///
/// # Errors
/// [`IoError::Write`]; [`IoError::Unsupported`] if a number needs more than the eight digits of a field.
pub fn write(out: &MeshView<'_>, w: &mut dyn Write) -> Result<(), IoError> {
    write_with(out, None, w)
}

/// Writes a mesh; with mid-side nodes `CQUAD8` (of nine nodes `CQUAD`) and `CTRIA6`.
///
/// # Errors
/// As [`write()`].
pub fn write_with(out: &MeshView<'_>, mid: Option<&MidNodes>, w: &mut dyn Write) -> Result<(), IoError> {
    let mesh = out.mesh;
    if (mesh.points.len() + mid.map_or(0, MidNodes::n_nodes)).max(mesh.quads.len() + mesh.triangles.len())
        > 99_999_999
    {
        return Err(IoError::unsupported(FORMAT, Place::Whole, "more than 99,999,999 nodes or elements"));
    }
    writeln!(w, "$ {}", one_line(out.title))?;
    let mut set = 0;
    let mut write_set =
        |kind: &str, name: &str, members: Vec<u32>, w: &mut dyn Write| -> Result<(), IoError> {
            if members.is_empty() {
                return Ok(());
            }
            set += 1;
            writeln!(w, "$ {kind} {set}: {}", one_line(name))?;
            write!(w, "SET {set} = ")?;
            for (k, n) in members.iter().enumerate() {
                let gap = match k {
                    0 => "",
                    k if k % 6 == 0 => ",\n    ",
                    _ => ", ",
                };
                write!(w, "{gap}{}", n + 1)?;
            }
            Ok(writeln!(w)?)
        };
    for (name, nodes) in node_sets(out, mid) {
        write_set("NODES", &name, nodes, w)?;
    }
    for (name, quads) in &out.sets.quads {
        write_set("ELEMENTS", name, quads.iter().map(|q| q.0).collect(), w)?;
    }
    writeln!(w, "BEGIN BULK")?;
    for (i, [x, y, z]) in out.all_xyz(mid).enumerate() {
        writeln!(w, "GRID*   {:<16}{:<16}{:<16}{:<16}*", i + 1, "", field(x), field(y))?;
        writeln!(w, "*       {:<16}", field(z))?;
    }
    for (i, q) in mesh.quads.iter().enumerate() {
        if let Some(m) = mid {
            let card = if m.has_centres() { "CQUAD" } else { "CQUAD8" };
            write_card(card, i + 1, &m.quad(i, q), w)?;
            continue;
        }
        let [a, b, c, d] = q.map(|v| v.0 + 1);
        writeln!(w, "CQUAD4  {:<8}{:<8}{a:<8}{b:<8}{c:<8}{d:<8}", i + 1, 1)?;
    }
    for (i, t) in mesh.triangles.iter().enumerate() {
        if let Some(m) = mid {
            write_card("CTRIA6", mesh.quads.len() + i + 1, &m.triangle(t), w)?;
            continue;
        }
        let [a, b, c] = t.map(|v| v.0 + 1);
        writeln!(w, "CTRIA3  {:<8}{:<8}{a:<8}{b:<8}{c:<8}", mesh.quads.len() + i + 1, 1)?;
    }
    writeln!(w, "ENDDATA")?;
    Ok(())
}

/// One element of many nodes: six on the first line, the rest on a continuation.
fn write_card(card: &str, number: usize, nodes: &[VertexId], w: &mut dyn Write) -> Result<(), IoError> {
    write!(w, "{card:<8}{number:<8}{:<8}", 1)?;
    for (k, v) in nodes.iter().enumerate() {
        if k == 6 {
            write!(w, "\n        ")?;
        }
        write!(w, "{:<8}", v.0 + 1)?;
    }
    Ok(writeln!(w)?)
}

/// The text of at most 16 characters that is nearest to `x`; always with a point.
fn field(x: f64) -> String {
    const WIDTH: usize = 16;
    let mut best = String::from("0.");
    let mut best_error = x.abs();
    let mut consider = |s: String| {
        if s.len() <= WIDTH {
            let error = (parse_real(&s).unwrap_or(f64::INFINITY) - x).abs();
            // Of equally good ones the shortest, so that 0.5 does not become 5.E-1.
            if error < best_error || (error == best_error && s.len() < best.len()) {
                best_error = error;
                best = s;
            }
        }
    };
    let trim = |s: &str| -> String {
        let s = if s.contains('.') { s.trim_end_matches('0') } else { s };
        let s = if s.contains('.') { s.to_owned() } else { format!("{s}.") };
        s.replacen(
            "0.",
            ".",
            usize::from(s.trim_start_matches('-').starts_with("0.") && s.trim_start_matches('-').len() > 2),
        )
    };
    /// Smaller numbers have more digits with an exponent.
    const LEAST_PLAIN: f64 = 1e-4;
    if (LEAST_PLAIN..1e14).contains(&x.abs()) {
        for decimals in (0..=16).rev() {
            let s = trim(&format!("{x:.decimals$}"));
            if s.len() <= WIDTH {
                consider(s);
                break;
            }
        }
    }
    for digits in (0..=16).rev() {
        // Nastran's form of exponent: 1.25-7 is 1.25e-7.
        let s = format!("{x:.digits$e}");
        let Some((m, e)) = s.split_once('e') else { break };
        let m = if m.contains('.') { m.trim_end_matches('0').to_owned() } else { format!("{m}.") };
        let s = format!("{m}{}{e}", if e.starts_with('-') { "" } else { "+" });
        if s.len() <= WIDTH {
            consider(s);
            break;
        }
    }
    best
}

/// A Nastran real: `1.5`, `1.5E-3`, `1.5D-3`, `1.5-3`.
fn parse_real(s: &str) -> Option<f64> {
    let s = s.trim();
    if s.is_empty() {
        return Some(0.0);
    }
    let e = s.to_ascii_uppercase().replace('D', "E");
    if e.contains('E') {
        return e.parse().ok();
    }
    // A sign behind the first character begins an exponent.
    match e.char_indices().skip(1).find(|c| matches!(c.1, '+' | '-')) {
        Some((k, _)) => format!("{}E{}", &e[..k], &e[k..]).parse().ok(),
        None => e.parse().ok(),
    }
}

/// One logical entry: its name and fields, continuation lines joined.
struct Entry {
    name: String,
    fields: Vec<String>,
    line: usize,
    /// Expects a continuation of the same width.
    wide: bool,
}

/// Splits one physical line into its data fields (8 small or 4 wide ones); `true` if it is wide.
fn split_line(line: &str) -> (String, Vec<String>, bool) {
    if line.contains(',') {
        let mut fields: Vec<String> = line.split(',').map(|f| f.trim().to_owned()).collect();
        let name = fields.remove(0);
        let wide = name.ends_with('*');
        fields.truncate(if wide { 4 } else { 8 });
        return (name, fields, wide);
    }
    let chars: Vec<char> = line.chars().collect();
    let part = |a: usize, b: usize| -> String {
        chars
            .get(a.min(chars.len())..b.min(chars.len()))
            .map(|c| c.iter().collect::<String>())
            .unwrap_or_default()
    };
    let name = part(0, 8).trim().to_owned();
    let wide = name.ends_with('*') || name.starts_with('*');
    let (n, width) = if wide { (4, 16) } else { (8, 8) };
    let fields = (0..n).map(|k| part(8 + k * width, 8 + (k + 1) * width).trim().to_owned()).collect();
    (name, fields, wide)
}

/// Reads `GRID`, `CQUAD4`, `CTRIA3` (and `CQUADR`, `CTRIAR`, `CBAR`, `CROD` ...) and named sets.
///
/// # Errors
/// [`IoError::Syntax`] or [`IoError::Unsupported`], with the line.
pub fn read(bytes: &[u8]) -> Result<MeshData, IoError> {
    let mut text = Cursor::new(bytes, FORMAT);
    let mut out = Builder::new(FORMAT, Place::Line);
    let mut current: Option<Entry> = None;
    let mut set_name: Option<(bool, String)> = None;
    let mut open_set: Option<bool> = None;
    let mut n_lines = 0;
    // A file without BEGIN BULK is all bulk data.
    let bulk = b"BEGIN";
    let mut in_bulk = !bytes.windows(bulk.len()).any(|w| w.eq_ignore_ascii_case(bulk));
    while let Some(line) = text.line() {
        n_lines += 1;
        let line = String::from_utf8_lossy(line);
        if let Some(comment) = line.strip_prefix('$') {
            if !in_bulk {
                set_name = named_set(comment);
            }
            continue;
        }
        let line = line.split('$').next().unwrap_or("").trim_end();
        if line.is_empty() {
            continue;
        }
        if !in_bulk {
            let upper = line.trim_start().to_ascii_uppercase();
            in_bulk = upper.starts_with("BEGIN");
            if let Some((_, list)) = upper.split_once('=').filter(|_| upper.starts_with("SET ")) {
                open_set = set_name.take().map(|(nodes, name)| {
                    let sets = if nodes { &mut out.node_sets } else { &mut out.element_sets };
                    sets.push((name, Vec::new()));
                    nodes
                });
                add_members(list, &mut open_set, &mut out, bytes.len());
            } else if open_set.is_some() {
                add_members(&upper, &mut open_set, &mut out, bytes.len());
            }
            continue;
        }
        let (name, fields, wide) = split_line(line);
        if name.is_empty() || name.starts_with(['+', '*']) {
            if let Some(e) = current.as_mut().filter(|e| e.fields.len() < 64) {
                // Where a wide line has four fields, eight of an entry are two lines.
                e.fields.resize(e.fields.len().next_multiple_of(if e.wide { 4 } else { 8 }), String::new());
                e.fields.extend(fields);
            }
            continue;
        }
        if let Some(e) = current.take() {
            take_entry(&e, &mut out)?;
        }
        let name = name.trim_end_matches('*').to_ascii_uppercase();
        if name == "ENDDATA" {
            break;
        }
        current = Some(Entry { name, fields, line: n_lines, wide });
    }
    if let Some(e) = current {
        take_entry(&e, &mut out)?;
    }
    out.finish()
}

/// `" NODES 3: name"` of a comment: whether it is a set of nodes, and its name.
fn named_set(comment: &str) -> Option<(bool, String)> {
    let (head, name) = comment.split_once(": ")?;
    let mut words = head.split_ascii_whitespace();
    let nodes = match words.next()? {
        "NODES" => true,
        "ELEMENTS" => false,
        _ => return None,
    };
    words.next()?.parse::<u32>().ok()?;
    Some((nodes, name.trim().to_owned()))
}

/// Adds `1, 2, 5 THRU 9,` to the set that was opened last; a list that does not end with a comma closes it.
fn add_members(list: &str, open: &mut Option<bool>, out: &mut Builder, file_size: usize) {
    let Some(nodes) = *open else { return };
    let sets = if nodes { &mut out.node_sets } else { &mut out.element_sets };
    if let Some((_, members)) = sets.last_mut() {
        for item in list.split(',').map(str::trim) {
            if let Some((a, b)) = item.split_once("THRU") {
                if let (Ok(a), Ok(b)) = (a.trim().parse::<u64>(), b.trim().parse::<u64>()) {
                    // No more members than the file can have entities.
                    members.extend((a..=b).take(file_size));
                }
            } else if let Ok(n) = item.parse() {
                members.push(n);
            }
        }
    }
    if !list.trim_end().ends_with(',') {
        *open = None;
    }
}

fn take_entry(e: &Entry, out: &mut Builder) -> Result<(), IoError> {
    let fail = |m: String| IoError::syntax(FORMAT, Place::Line(e.line), m);
    let field = |k: usize| e.fields.get(k).map_or("", String::as_str);
    let number = |k: usize| {
        let s = field(k);
        s.parse::<u64>().map_err(|_| fail(format!("{s:?} is not a number of a node or element")))
    };
    // Corners, and fields of nodes between them, which may be blank.
    let (n_corners, n_middles) = match e.name.as_str() {
        "GRID" => {
            if !matches!(field(1), "" | "0") {
                return Err(IoError::unsupported(
                    FORMAT,
                    Place::Line(e.line),
                    "a coordinate system of its own",
                ));
            }
            let mut xyz = [0.0; 3];
            for (k, x) in xyz.iter_mut().enumerate() {
                let s = field(2 + k);
                *x = parse_real(s).ok_or_else(|| fail(format!("{s:?} is not a coordinate")))?;
            }
            return out.node(number(0)?, xyz, e.line);
        }
        "CQUAD4" | "CQUADR" | "CSHEAR" => (4, 0),
        "CQUAD8" => (4, 4),
        "CQUAD" => (4, 5),
        "CTRIA3" | "CTRIAR" => (3, 0),
        "CTRIA6" => (3, 3),
        "CBAR" | "CBEAM" | "CROD" => (2, 0),
        "CTETRA" | "CHEXA" | "CPENTA" | "CPYRAM" => {
            return Err(IoError::unsupported(FORMAT, Place::Line(e.line), format!("element {}", e.name)));
        }
        _ => return Ok(()),
    };
    let mut corners = [0; 4];
    for (k, c) in corners.iter_mut().enumerate().take(n_corners) {
        *c = number(2 + k)?;
    }
    out.element(number(0)?, &corners[..n_corners], e.line);
    for k in (0..n_middles).map(|k| 2 + n_corners + k).filter(|&k| !matches!(field(k), "" | "0")) {
        out.middles(&[number(k)?]);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_keep_as_many_digits_as_fit() {
        for (x, want) in [(0.0, "0."), (0.5, ".5"), (-2.0, "-2."), (1e-7, "1.-7"), (-1.25e300, "-1.25+300")] {
            assert_eq!(field(x), want);
        }
        let mut x = 1.0 / 3.0;
        for _ in 0..200 {
            for v in [x, -x, 1.0 / x] {
                let s = field(v);
                assert!(s.len() <= 16 && s.contains('.'), "{s}");
                let back = parse_real(&s).unwrap();
                assert!((back / v - 1.0).abs() < 1e-10 || v.abs() < 1e-90, "{v} {s}");
            }
            x *= -0.37;
        }
    }

    #[test]
    fn reals_of_all_forms() {
        for s in ["1.5-3", "1.5E-3", "1.5d-3", " 0.0015 ", ".0015"] {
            assert_eq!(parse_real(s), Some(0.0015), "{s}");
        }
        assert_eq!(parse_real("-1.-2"), Some(-0.01));
        assert_eq!(parse_real("x"), None);
    }

    #[test]
    fn small_fields_and_free_form() {
        let text = "GRID,1,,0.,0.,0.\nGRID    2               1.      0.      0.\nGRID,3,,1.,1.\n\
                    GRID*                  4                              0.              1.*\n*                     0.\n\
                    CQUAD4  7       1       1       2       3       4\n";
        let m = read(text.as_bytes()).unwrap();
        assert_eq!((m.mesh.points.len(), m.mesh.quads.len()), (4, 1));
        assert_eq!(m.mesh.points[3], csalf_geom::Point2::new(0.0, 1.0));
    }
}

//! Faults: cut off, bytes, lines, words, numbers and references changed.

/// A linear congruential generator: the same tries on every machine.
pub(super) struct Random(u64);

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        let mut r = Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
        r.below(2);
        r
    }

    /// A number below `n`; 0 for 0.
    pub(super) fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % n.max(1)
    }
}

/// Words that a number may become.
const NUMBERS: [&str; 16] = [
    "0",
    "0.0",
    "-1.0",
    "1e6",
    "-1E6",
    "1E+300",
    "1e-300",
    "nan",
    "inf",
    "-0.0",
    "1e-9",
    "0.5",
    "3",
    "1e3",
    "",
    "99999999999",
];

/// The bytes with one to four faults.
pub(super) fn change(bytes: &[u8], is_text: bool, r: &mut Random) -> Vec<u8> {
    let mut out = bytes.to_vec();
    for _ in 0..=r.below(4) {
        out = if is_text && r.below(8) > 0 { lines(&out, r) } else { raw(&out, r) };
    }
    out
}

/// Faults that know nothing of the format.
fn raw(bytes: &[u8], r: &mut Random) -> Vec<u8> {
    let mut out = bytes.to_vec();
    let at = r.below(out.len());
    match r.below(5) {
        0 => out.truncate(at),
        1 => out.iter_mut().skip(at).take(1).for_each(|b| *b = r.below(256) as u8),
        2 => out.iter_mut().skip(at).take(1).for_each(|b| *b ^= 1 << r.below(8)),
        3 => out.insert(at, b"0123456789.-#,()'TF$*;\n"[r.below(23)]),
        _ => {
            let end = (at + 1 + r.below(40)).min(out.len());
            out.drain(at.min(end)..end);
        }
    }
    out
}

/// Faults in one line, or of whole lines.
fn lines(bytes: &[u8], r: &mut Random) -> Vec<u8> {
    let text = String::from_utf8_lossy(bytes).into_owned();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    if lines.is_empty() {
        return bytes.to_vec();
    }
    let at = r.below(lines.len());
    match r.below(9) {
        0 => {
            lines.remove(at);
        }
        1 => {
            let copy = lines[at].clone();
            lines.insert(r.below(lines.len()), copy);
        }
        2 => {
            let other = r.below(lines.len());
            lines.swap(at, other);
        }
        3 => lines[at] = lines[at].replace(".T.", ".F."),
        4 => {
            // One line says what another one says.
            let other = lines[r.below(lines.len())].clone();
            let tail = |s: &str| s.split_once('=').map_or_else(|| s.to_owned(), |t| t.1.to_owned());
            lines[at] = match lines[at].split_once('=') {
                Some((head, _)) => format!("{head}={}", tail(&other)),
                None => other,
            };
        }
        _ => lines[at] = number(&lines[at], r),
    }
    let mut out = lines.join("\n");
    out.push('\n');
    out.into_bytes()
}

/// One number or reference of the line becomes another one.
fn number(line: &str, r: &mut Random) -> String {
    let is_part = |c: char| c.is_ascii_digit() || ".-+eE".contains(c);
    let mut spans: Vec<(usize, usize)> = Vec::new();
    let mut start = None;
    for (i, c) in line.char_indices().chain([(line.len(), ' ')]) {
        match (is_part(c), start) {
            (true, None) => start = Some(i),
            (false, Some(s)) => {
                if line[s..i].contains(|c: char| c.is_ascii_digit()) {
                    spans.push((s, i));
                }
                start = None;
            }
            _ => {}
        }
    }
    if spans.is_empty() {
        return line.to_owned();
    }
    let (a, b) = spans[r.below(spans.len())];
    let old = &line[a..b];
    let new = match (r.below(5), old.parse::<f64>()) {
        (0, Ok(x)) => format!("{}", x * 1e6),
        (1, Ok(x)) => format!("{}", x + 1.0),
        (2, Ok(x)) => format!("{}", -x),
        // A near place: slivers, and references to a neighbour.
        (3, Ok(x)) => format!("{}", x * (1.0 + 0.05 * (r.below(9) as f64 - 4.0))),
        _ => NUMBERS[r.below(NUMBERS.len())].to_owned(),
    };
    format!("{}{new}{}", &line[..a], &line[b..])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_try_depends_on_its_seed_alone() {
        let text = b"#1=CARTESIAN_POINT('',(0.5,1.,2.E1));\n#2=VERTEX_POINT('',#1);\n";
        for seed in 0..200 {
            let run = || change(text, true, &mut Random::new(seed));
            assert_eq!(run(), run());
        }
        let n = (0..200).filter(|s| change(text, true, &mut Random::new(*s)) != text).count();
        assert!(n > 150, "{n}");
    }
}

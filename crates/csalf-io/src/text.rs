//! Help for text formats: a cursor that knows its line, and numbers that survive.

use crate::{IoError, Place};
use std::fmt;

/// Walks over bytes by line, by token or by raw bytes, and knows the line for errors.
#[derive(Clone, Debug)]
pub(crate) struct Cursor<'a> {
    bytes: &'a [u8],
    pos: usize,
    line: usize,
    format: &'static str,
}

impl<'a> Cursor<'a> {
    pub(crate) fn new(bytes: &'a [u8], format: &'static str) -> Self {
        Self { bytes, pos: 0, line: 1, format }
    }

    /// A syntax error at the current line.
    pub(crate) fn error(&self, message: impl Into<String>) -> IoError {
        IoError::syntax(self.format, Place::Line(self.line), message)
    }

    /// An error of something valid but not supported, at the current line.
    pub(crate) fn unsupported(&self, message: impl Into<String>) -> IoError {
        IoError::unsupported(self.format, Place::Line(self.line), message)
    }

    /// The rest of the current line without its end, which is passed over. `None` at the end of the file.
    pub(crate) fn line(&mut self) -> Option<&'a [u8]> {
        let rest = &self.bytes[self.pos..];
        if rest.is_empty() {
            return None;
        }
        let n = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        self.pos += (n + 1).min(rest.len());
        self.line += usize::from(n < rest.len());
        let line = &rest[..n];
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }

    /// The next word between white space (ends of lines too), passed over.
    pub(crate) fn token(&mut self) -> Option<&'a str> {
        while let Some(b) = self.bytes.get(self.pos).filter(|b| b.is_ascii_whitespace()) {
            self.line += usize::from(*b == b'\n');
            self.pos += 1;
        }
        let rest = &self.bytes[self.pos..];
        let n = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.pos += n;
        let word = std::str::from_utf8(&rest[..n]).unwrap_or("\u{fffd}");
        (!word.is_empty()).then_some(word)
    }

    /// The next word as a number.
    pub(crate) fn number<T: std::str::FromStr>(&mut self, what: &str) -> Result<T, IoError> {
        match self.token() {
            None => Err(self.error(format!("the file ends where {what} should be"))),
            Some(t) => t.parse().map_err(|_| self.error(format!("{t:?} is not {what}"))),
        }
    }

    /// The next `n` raw bytes, passed over.
    pub(crate) fn raw(&mut self, n: usize) -> Result<&'a [u8], IoError> {
        let out = self.bytes.get(self.pos..self.pos.saturating_add(n));
        let short = || IoError::syntax(self.format, Place::Byte(self.pos), "the file ends too early");
        let out = out.ok_or_else(short)?;
        self.pos += n;
        Ok(out)
    }
}

/// The shortest decimal text that reads back as the same number, with a point in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Num(pub f64);

impl fmt::Display for Num {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let x = self.0;
        /// Smaller numbers are shorter with an exponent.
        const LEAST_PLAIN: f64 = 1e-4;
        // `Debug` of f64 is the shortest text that reads back; it is without a point only as `1e300`.
        if x == 0.0 || (LEAST_PLAIN..1e15).contains(&x.abs()) {
            return write!(f, "{x:?}");
        }
        let text = format!("{x:e}");
        match text.split_once('e') {
            Some((m, e)) if !m.contains('.') => write!(f, "{m}.0e{e}"),
            _ => f.write_str(&text),
        }
    }
}

/// A number in at most 20 characters, as the input of Abaqus and CalculiX wants it: exact if it fits, else with a
/// relative error below 1e-12.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Num20(pub f64);

impl fmt::Display for Num20 {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const WIDTH: usize = 20;
        let with_point = |s: String| match s.split_once('e') {
            Some((m, e)) if !m.contains('.') => format!("{m}.0e{e}"),
            _ => s,
        };
        let exact = [Num(self.0).to_string(), with_point(format!("{:e}", self.0))];
        if let Some(s) = exact.iter().find(|s| s.len() <= WIDTH) {
            return f.write_str(s);
        }
        // The sign, a digit, the point and an exponent of up to four characters and a sign leave at least 12.
        let mut rounded = (12..=16).rev().map(|digits| format!("{:.digits$e}", self.0));
        f.write_str(&rounded.find(|s| s.len() <= WIDTH).unwrap_or_default())
    }
}

/// A set's name in a format that allows only letters, digits, `_` and `-`, beginning with a letter.
pub(crate) fn plain_name(name: &str) -> String {
    let mut out: String =
        name.chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' }).collect();
    if !out.starts_with(|c: char| c.is_ascii_alphabetic()) {
        out.insert_str(0, "S_");
    }
    out
}

/// `text` on one line, without control characters.
pub(crate) fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_survive_and_have_a_point() {
        for x in
            [0.0, -0.0, 1.0, -2.5, 0.1 + 0.2, 1e-300, 5e-324, 1.7976931348623157e308, 1e15, 1e-5, -3.25e-7]
        {
            let s = Num(x).to_string();
            assert!(s.contains('.'), "{s}");
            assert_eq!(s.parse::<f64>().unwrap().to_bits(), x.to_bits(), "{s}");
        }
    }

    #[test]
    fn twenty_characters_are_enough() {
        let hard =
            [-7.105427357601002e-15, -0.012345678901234568, 1.2345678901234567e-300, -1.7976931348623157e308];
        for x in hard.into_iter().chain([0.0, -1.5, 5e-324, 123456789.12345678, -1e16]) {
            let s = Num20(x).to_string();
            assert!(s.len() <= 20 && s.contains('.'), "{s}");
            let back: f64 = s.parse().unwrap();
            assert!((back - x).abs() <= 1e-12 * x.abs(), "{s} is not {x}");
        }
        assert_eq!(Num20(0.1 + 0.2).to_string(), "0.30000000000000004");
    }

    #[test]
    fn the_cursor_knows_its_line() {
        let mut c = Cursor::new(b"a 1\r\nbc\n\n 2.5 x", "T");
        assert_eq!(c.line(), Some(&b"a 1"[..]));
        assert_eq!(c.token(), Some("bc"));
        assert_eq!(c.number::<f64>("a number").unwrap(), 2.5);
        let e = c.number::<f64>("a number").unwrap_err().to_string();
        assert!(e.contains("line 4") && e.contains("\"x\""), "{e}");
        assert_eq!(c.token(), None);
    }

    #[test]
    fn plain_names() {
        assert_eq!(plain_name("hole 0"), "hole_0");
        assert_eq!(plain_name("3é"), "S_3_");
    }
}

//! Patterns of names: `*` stands for any characters, `hole<12` for holes with a diameter below 12.

/// Whether a name fits a pattern in which `*` stands for any characters, none included.
pub fn matches(pattern: &str, name: &str) -> bool {
    let mut parts = pattern.split('*');
    let first = parts.next().unwrap_or("");
    let Some(mut rest) = name.strip_prefix(first) else { return false };
    let mut parts = parts.peekable();
    if parts.peek().is_none() {
        return rest.is_empty();
    }
    while let Some(part) = parts.next() {
        if parts.peek().is_none() {
            return rest.ends_with(part);
        }
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    true
}

/// Whether a loop fits a pattern: a pattern of names, or `PATTERN<D`, `PATTERN<=D`, `PATTERN>D`, `PATTERN>=D` for
/// holes of a diameter; before the sign, `hole` stands for `hole*`.
pub fn loop_matches(pattern: &str, name: &str, diameter: Option<f64>) -> bool {
    let Some(at) = pattern.find(['<', '>']) else { return matches(pattern, name) };
    let (head, tail) = pattern.split_at(at);
    let (sign, or_equal) = (&tail[..1], tail[1..].starts_with('='));
    let number = tail[1..].trim_start_matches('=').trim();
    let (Some(d), Ok(limit)) = (diameter, number.parse::<f64>()) else { return false };
    /// Diameters of files carry six to eight digits.
    const SAME: f64 = 1e-6;
    let equal = (d - limit).abs() <= SAME * limit.abs();
    let fits = (or_equal && equal) || (!equal && if sign == "<" { d < limit } else { d > limit });
    let head = head.trim();
    fits && (matches(head, name) || (!head.contains('*') && name.starts_with(head)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stars_and_diameters() {
        assert!(matches("hole*", "hole12") && matches("*", "") && matches("a*c*e", "abcde"));
        assert!(!matches("hole*", "outer") && !matches("hole", "hole1") && !matches("a*c", "abcd"));
        assert!(
            loop_matches("hole<12", "hole3", Some(10.0)) && !loop_matches("hole<12", "hole3", Some(12.0))
        );
        assert!(
            loop_matches("hole<=12", "hole3", Some(12.0)) && loop_matches("hole*>5", "hole3", Some(12.0))
        );
        assert!(!loop_matches("hole<12", "hole3", None) && !loop_matches("hole<x", "hole3", Some(1.0)));
        assert!(!loop_matches("slot<12", "hole3", Some(1.0)));
    }
}

//! A scanner of Rust source, as deep as tidy needs: it tells code from comments, strings and test modules.

/// Source with the contents of comments, strings and characters replaced by blanks. Lines stay where they were.
pub(super) fn code_only(source: &str) -> String {
    let s: Vec<char> = source.chars().collect();
    let mut out = String::with_capacity(source.len());
    let blank = |c: char| if c == '\n' { '\n' } else { ' ' };
    let mut i = 0;
    while i < s.len() {
        let end = match s[i] {
            '/' if s.get(i + 1) == Some(&'/') => line_end(&s, i),
            '/' if s.get(i + 1) == Some(&'*') => block_end(&s, i),
            '"' => string_end(&s, i + 1),
            'r' if !follows_name(&s, i) => raw_end(&s, i).unwrap_or(i),
            '\'' => char_end(&s, i).unwrap_or(i),
            _ => i,
        };
        if end == i {
            out.push(s[i]);
            i += 1;
        } else {
            out.extend(s[i..end].iter().map(|&c| blank(c)));
            i = end;
        }
    }
    out
}

/// Blanks the bodies of `#[cfg(test)] mod name { ... }` in text that [`code_only`] made.
pub(super) fn without_tests(code: &str) -> String {
    let mut out = code.to_owned();
    let mut from = 0;
    while let Some(at) = out[from..].find("#[cfg(test)]") {
        let start = from + at;
        from = start + 1;
        let after = &out[start..];
        let Some(open) = after.find(['{', ';']) else { break };
        if !after.starts_with("#[cfg(test)]") || after.as_bytes()[open] == b';' {
            continue;
        }
        let mut depth = 0usize;
        let close = after[open..].char_indices().find_map(|(k, c)| {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                _ => {}
            }
            (depth == 0).then_some(open + k + 1)
        });
        let end = start + close.unwrap_or(after.len());
        let blanked: String = out[start..end].chars().map(|c| if c == '\n' { '\n' } else { ' ' }).collect();
        out.replace_range(start..end, &blanked);
    }
    out
}

/// A float literal, with the line that it stands in (from 1) and whether that line belongs to a constant.
#[derive(Debug, PartialEq)]
pub(super) struct Literal {
    pub(super) line: usize,
    pub(super) value: f64,
    pub(super) in_constant: bool,
}

/// All float literals of text that [`code_only`] made.
pub(super) fn float_literals(code: &str) -> Vec<Literal> {
    let mut found = Vec::new();
    let mut in_constant = false;
    for (k, line) in code.lines().enumerate() {
        let mut words = line.split_whitespace().skip_while(|w| w.starts_with("pub"));
        let head = words.next().unwrap_or_default();
        in_constant |= matches!(head, "const" | "static") && words.next() != Some("fn");
        for value in numbers(line) {
            found.push(Literal { line: k + 1, value, in_constant });
        }
        if line.trim_end().ends_with(';') {
            in_constant = false;
        }
    }
    found
}

/// The float literals of one line: digits with a point or an exponent.
fn numbers(line: &str) -> Vec<f64> {
    let s: Vec<char> = line.chars().collect();
    let mut found = Vec::new();
    let mut i = 0;
    while i < s.len() {
        if !s[i].is_ascii_digit() || follows_name(&s, i) {
            i += 1;
            continue;
        }
        let start = i;
        let hex = s[i] == '0' && matches!(s.get(i + 1), Some('x' | 'b' | 'o'));
        while i < s.len() {
            let exponent_sign = matches!(s[i], '+' | '-') && !hex && matches!(s[i - 1], 'e' | 'E');
            let point = s[i] == '.'
                && s.get(i + 1).is_none_or(|c| c.is_ascii_digit() || !c.is_alphabetic() && *c != '.');
            if !(s[i].is_ascii_alphanumeric() || s[i] == '_' || point || exponent_sign) {
                break;
            }
            i += 1;
        }
        let word: String = s[start..i].iter().filter(|c| **c != '_').collect();
        let word = word.trim_end_matches("f64").trim_end_matches("f32");
        if !hex && word.contains(['.', 'e', 'E']) {
            found.extend(word.parse::<f64>().ok());
        }
    }
    found
}

fn follows_name(s: &[char], i: usize) -> bool {
    i > 0 && (s[i - 1].is_alphanumeric() || s[i - 1] == '_')
}

fn line_end(s: &[char], i: usize) -> usize {
    (i..s.len()).find(|&k| s[k] == '\n').unwrap_or(s.len())
}

/// End of a block comment; they nest.
fn block_end(s: &[char], mut i: usize) -> usize {
    let mut depth = 0;
    while i + 1 < s.len() {
        match (s[i], s[i + 1]) {
            ('/', '*') => depth += 1,
            ('*', '/') => depth -= 1,
            _ => {
                i += 1;
                continue;
            }
        }
        i += 2;
        if depth == 0 {
            return i;
        }
    }
    s.len()
}

/// End of a string whose first inner character is `i`.
fn string_end(s: &[char], mut i: usize) -> usize {
    while i < s.len() && s[i] != '"' {
        i += if s[i] == '\\' { 2 } else { 1 };
    }
    (i + 1).min(s.len())
}

/// End of a raw string that starts at `i` with `r`, if one does.
fn raw_end(s: &[char], i: usize) -> Option<usize> {
    let hashes = s[i + 1..].iter().take_while(|c| **c == '#').count();
    let body = i + 1 + hashes;
    (s.get(body) == Some(&'"')).then(|| {
        (body + 1..s.len())
            .find(|&k| s[k] == '"' && s[k + 1..].iter().take_while(|c| **c == '#').count() >= hashes)
            .map_or(s.len(), |k| k + 1 + hashes)
    })
}

/// End of a character literal at `i`; `None` for a lifetime.
fn char_end(s: &[char], i: usize) -> Option<usize> {
    if s.get(i + 1) == Some(&'\\') {
        return (i + 3..s.len().min(i + 14)).find(|&k| s[k] == '\'').map(|k| k + 1);
    }
    (s.get(i + 2) == Some(&'\'')).then_some(i + 3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_strings_and_characters_are_blanked() {
        let code = code_only("a // b\n/* c /* d */ e */ f \"g\\\"h\" i r#\"j\"k\"# l 'm' n: &'o str '\\n' p");
        let words: Vec<&str> = code.split_whitespace().collect();
        assert_eq!(words, ["a", "f", "i", "l", "n:", "&'o", "str", "p"]);
        assert_eq!(code.lines().count(), 2);
    }

    #[test]
    fn test_modules_are_blanked() {
        let code = without_tests("fn a() {}\n#[cfg(test)]\nmod tests {\n  fn b() {}\n}\nfn c() {}\n");
        assert!(code.contains("fn a") && code.contains("fn c") && !code.contains("fn b"));
        assert_eq!(code.lines().count(), 6);
        assert!(without_tests("#[cfg(test)]\nmod tests;\nfn a() { 1 }\n").contains("fn a"));
    }

    #[test]
    fn literals_know_their_constants() {
        let code = "pub const A: f64 =\n  1e-6;\nlet b = 2.5e-4_f64 + x.0 + 0x1e3 as f64 + 1..4 + 7;\npub const fn c() { 1e-9 }\n";
        let found = float_literals(code);
        let get = |line| {
            found.iter().filter(|l| l.line == line).map(|l| (l.value, l.in_constant)).collect::<Vec<_>>()
        };
        assert_eq!(get(2), [(1e-6, true)]);
        assert_eq!(get(3), [(2.5e-4, false)]);
        assert_eq!(get(4), [(1e-9, false)]);
    }
}

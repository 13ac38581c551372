//! Licences of everything in the dependency tree: permissive ones only.

use super::{list, text};
use serde_json::Value;

/// Licences that a program under MIT OR Apache-2.0 may link without further duties on its users.
const ALLOWED: [&str; 15] = [
    "MIT",
    "MIT-0",
    "Apache-2.0",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "ISC",
    "Zlib",
    "MPL-2.0",
    "Unicode-3.0",
    "Unicode-DFS-2016",
    "CC0-1.0",
    "Unlicense",
    "BSL-1.0",
    "0BSD",
    "NCSA",
];

/// Packages whose licence is missing or not permissive, one line each.
pub(super) fn check(metadata: &Value) -> Vec<String> {
    list(metadata, "packages")
        .iter()
        .filter_map(|p| {
            let licence = text(p, "license");
            (!permissive(licence))
                .then(|| format!("{} {}: licence '{licence}'", text(p, "name"), text(p, "version")))
        })
        .collect()
}

/// True if an SPDX expression can be met by allowed licences alone: `OR` lets us choose, `AND` does not.
fn permissive(expression: &str) -> bool {
    let spaced = expression.replace('/', " OR ").replace('(', " ( ").replace(')', " ) ");
    let words: Vec<&str> = spaced.split_whitespace().collect();
    let mut rest = words.as_slice();
    either(&mut rest) && rest.is_empty()
}

/// `both (OR both)*`
fn either(rest: &mut &[&str]) -> bool {
    let mut ok = both(rest);
    while rest.first() == Some(&"OR") {
        *rest = &rest[1..];
        ok |= both(rest);
    }
    ok
}

/// `leaf (AND leaf)*`
fn both(rest: &mut &[&str]) -> bool {
    let mut ok = leaf(rest);
    while rest.first() == Some(&"AND") {
        *rest = &rest[1..];
        ok &= leaf(rest);
    }
    ok
}

/// `( either )`, or a licence with or without an exception (an exception only ever grants more).
fn leaf(rest: &mut &[&str]) -> bool {
    let Some((&word, tail)) = rest.split_first() else { return false };
    *rest = tail;
    if word == "(" {
        let ok = either(rest);
        let closed = rest.first() == Some(&")");
        *rest = rest.get(1..).unwrap_or_default();
        return ok && closed;
    }
    if rest.first() == Some(&"WITH") {
        *rest = rest.get(2..).unwrap_or_default();
    }
    ALLOWED.contains(&word)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expressions() {
        for good in [
            "MIT",
            "MIT OR Apache-2.0",
            "MIT/Apache-2.0",
            "Apache-2.0 WITH LLVM-exception OR MIT",
            "(MIT OR Apache-2.0) AND Unicode-3.0",
            "MIT OR Apache-2.0 OR LGPL-2.1-or-later",
        ] {
            assert!(permissive(good), "{good}");
        }
        for bad in [
            "",
            "GPL-3.0-only",
            "LGPL-3.0",
            "MIT AND GPL-2.0",
            "(MIT",
            "MIT) OR",
            "AGPL-3.0 AND (MIT OR ISC)",
        ] {
            assert!(!permissive(bad), "{bad}");
        }
    }
}

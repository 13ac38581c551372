//! The book (docs/SUMMARY.md): every page is in it once, and every link within the repository leads somewhere.

use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

/// Findings, one line each.
pub(super) fn check(root: &Path) -> Result<Vec<String>, String> {
    let docs = root.join("docs");
    let mut pages = Vec::new();
    collect(&docs, &mut pages)?;
    let mut findings = Vec::new();
    let summary = read(&docs.join("SUMMARY.md"))?;
    let mut listed = BTreeSet::new();
    for link in links(&summary) {
        let page = docs.join(&link);
        if !listed.insert(page.clone()) {
            findings.push(format!("docs/SUMMARY.md lists {link} twice"));
        }
        if !page.is_file() {
            findings.push(format!("docs/SUMMARY.md: there is no {link}"));
        }
    }
    for page in pages.iter().filter(|p| p.file_name().is_some_and(|n| n != "SUMMARY.md")) {
        if !listed.contains(page) {
            findings.push(format!("{} is not in docs/SUMMARY.md", shown(root, page)));
        }
    }
    let top = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md"].map(|f| root.join(f));
    for file in pages.iter().chain(&top) {
        let text = read(file)?;
        let folder = file.parent().unwrap_or(root);
        for link in links(&text).iter().filter(|l| !l.contains("://") && !l.starts_with("mailto:")) {
            let (path, anchor) = link.split_once('#').unwrap_or((link, ""));
            let target = if path.is_empty() { file.clone() } else { plain(&folder.join(path)) };
            if !target.exists() {
                findings.push(format!("{}: the link {link} leads nowhere", shown(root, file)));
            } else if !anchor.is_empty() && target.extension().is_some_and(|e| e == "md") {
                let found = headings(&read(&target)?).any(|h| h == anchor);
                if !found {
                    findings.push(format!("{}: {link}: there is no such heading", shown(root, file)));
                }
            }
        }
    }
    Ok(findings)
}

/// All pages below a folder, sorted.
fn collect(folder: &Path, pages: &mut Vec<PathBuf>) -> Result<(), String> {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut paths: Vec<PathBuf> = entries.filter_map(|e| Some(e.ok()?.path())).collect();
    paths.sort();
    for path in paths {
        // What mdbook writes is not ours.
        if path.is_dir() && path.file_name().is_some_and(|n| n != "book") {
            collect(&path, pages)?;
        } else if path.extension().is_some_and(|e| e == "md") {
            pages.push(path);
        }
    }
    Ok(())
}

fn read(path: &Path) -> Result<String, String> {
    std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))
}

fn shown(root: &Path, path: &Path) -> String {
    path.strip_prefix(root).unwrap_or(path).display().to_string()
}

/// Targets of `[...](target)` outside of code, in order.
fn links(text: &str) -> Vec<String> {
    let mut out = Vec::new();
    let mut fenced = false;
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
        }
        if fenced {
            continue;
        }
        // Every second piece between back quotes is code.
        let prose: Vec<&str> = line.split('`').step_by(2).collect();
        let prose = prose.join("`");
        let mut rest = prose.as_str();
        while let Some(at) = rest.find("](") {
            rest = &rest[at + 2..];
            let Some(end) = rest.find(')') else { break };
            out.push(rest[..end].to_owned());
            rest = &rest[end..];
        }
    }
    out
}

/// Headings, as links name them.
fn headings(text: &str) -> impl Iterator<Item = String> + '_ {
    text.lines().filter(|l| l.starts_with('#')).map(|l| {
        let title = l.trim_start_matches('#').trim().to_lowercase();
        let kept = title.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    })
}

/// The path without `.` and `..`.
fn plain(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for c in path.components() {
        match c {
            Component::ParentDir => {
                out.pop();
            }
            Component::CurDir => {}
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_outside_of_code() {
        let text = "[a](b.md) and `[c](d)` and [e](f.md#g).\n```\n[h](i)\n```\n![j](k.png)\n";
        assert_eq!(links(text), ["b.md", "f.md#g", "k.png"]);
        assert_eq!(headings("# A b, c\n## `d`-e\ntext").collect::<Vec<_>>(), ["a-b-c", "d-e"]);
        assert_eq!(plain(Path::new("/a/b/../c/./d")), Path::new("/a/c/d"));
    }

    #[test]
    fn the_book_is_whole() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let findings = check(&plain(&root)).expect("the documents can be read");
        assert!(findings.is_empty(), "{}", findings.join("\n"));
    }
}

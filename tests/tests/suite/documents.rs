//! What the documents promise: a short front page, links that lead somewhere, no page that nothing links to.

use std::fs;
use std::path::{Path, PathBuf};

use crate::root;

/// The longest that the front page may be, words as `wc -w` counts them.
const MAX_README_WORDS: usize = 1200;

/// Markdown files that a reader may open, relative to the root.
pub(crate) fn documents() -> Vec<PathBuf> {
    let mut found = Vec::new();
    for folder in ["", "docs", "eval", "vocab", "crates/dsfeat/models", "crates/dsfeat/training"] {
        for entry in fs::read_dir(root().join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|e| e == "md") {
                found.push(path.strip_prefix(root()).unwrap().to_owned());
            }
        }
    }
    found.sort();
    assert!(found.len() > 10, "only {found:?}");
    found
}

fn read(document: &Path) -> String {
    fs::read_to_string(root().join(document)).unwrap()
}

/// Targets of the links and pictures of a Markdown text that are files, without anchors.
fn linked_files(text: &str) -> Vec<&str> {
    text.split("](")
        .skip(1)
        .filter_map(|rest| rest.split_once(')'))
        .map(|(target, _)| target.split('#').next().unwrap())
        .filter(|target| !target.is_empty() && !target.contains("://"))
        .collect()
}

#[test]
fn the_front_page_is_short() {
    let n_words = read(Path::new("README.md")).split_whitespace().count();
    assert!(n_words <= MAX_README_WORDS, "README.md has {n_words} words, more than {MAX_README_WORDS}");
}

#[test]
fn every_link_leads_to_a_file() {
    let mut n_links = 0;
    for document in documents() {
        let folder = root().join(&document).parent().unwrap().to_owned();
        for target in linked_files(&read(&document)) {
            n_links += 1;
            assert!(folder.join(target).exists(), "{}: {target} does not exist", document.display());
        }
    }
    assert!(n_links > 20, "only {n_links} links found");
}

#[test]
fn the_front_page_links_to_every_page() {
    let readme = read(Path::new("README.md"));
    let linked = linked_files(&readme);
    for document in documents().iter().filter(|document| document.starts_with("docs")) {
        let name = document.to_str().unwrap();
        assert!(linked.contains(&name), "README.md does not link to {name}");
    }
}

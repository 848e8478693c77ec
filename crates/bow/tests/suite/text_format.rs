//! ORB-SLAM2's text format.

use super::support::{images, small_vocabulary};
use dsslam_bow::{FormatError, Vocabulary};
use features::Descriptor;
use std::fmt::Write;

/// `"b b b ..."`: 32 times the same byte.
fn bytes(byte: u8) -> String {
    vec![byte.to_string(); 32].join(" ")
}

/// A file of these (parent, leaf, byte, weight) lines.
fn file(head: &str, nodes: &[(u32, u8, u8, &str)]) -> String {
    let mut text = format!("{head}\n");
    for (parent, leaf, byte, weight) in nodes {
        writeln!(text, "{parent} {leaf} {} {weight}", bytes(*byte)).unwrap();
    }
    text
}

/// In DBoW2's order: the children of the root, those of node 1, those of node 2.
fn known() -> String {
    file(
        "10 6 0 0",
        &[
            (0, 0, 0, "0"),
            (0, 0, 255, "0"),
            (0, 1, 170, "2.5"),
            (1, 1, 1, "9.95675"),
            (1, 1, 2, "0"),
            (2, 1, 254, "1.5"),
            (2, 1, 253, "0.000123457"),
        ],
    )
}

fn error(text: &str) -> String {
    Vocabulary::from_text(text).expect_err("to be refused").to_string()
}

#[test]
fn a_known_file() {
    let vocabulary = Vocabulary::from_text(&known()).unwrap();
    assert_eq!((vocabulary.branching(), vocabulary.levels()), (10, 6));
    assert_eq!((vocabulary.n_nodes(), vocabulary.n_words()), (8, 5));
    assert_eq!(vocabulary.children(0), Some(1..4));
    assert_eq!(vocabulary.children(2), Some(6..8));
    assert_eq!(vocabulary.children(3), Some(8..8));
    assert_eq!(vocabulary.children(8), None);
    assert_eq!(vocabulary.median(7), Some(Descriptor::from_bytes(&[253; 32])));
    assert_eq!(vocabulary.weight(4), Some(9.95675));
    let words = [1, 3, 254, 170].map(|byte| Descriptor::from_bytes(&[byte; 32]));
    assert_eq!(vocabulary.words_of(&words), [4, 4, 6, 3]);
}

#[test]
fn text_to_binary_to_text_gives_equal_bytes() {
    let vocabulary = Vocabulary::from_text(&known()).unwrap();
    let binary = Vocabulary::from_bytes(vocabulary.as_bytes().to_vec()).unwrap();
    assert_eq!(binary.to_text(), known());
}

#[test]
fn a_trained_vocabulary_survives_text() {
    let vocabulary = small_vocabulary();
    let again = Vocabulary::from_text(&vocabulary.to_text()).unwrap();
    assert_eq!(again.to_text(), vocabulary.to_text());
    let image = &images(1, 200, 40, 3)[0];
    assert_eq!(again.transform(image, None), vocabulary.transform(image, None));
    // The text does not say what it was trained on.
    assert_eq!(again.origin().n_images, 0);
}

#[test]
fn other_orders_spaces_and_line_ends_are_the_same_tree() {
    // Breadth first across parents instead of DBoW2's order, which leaves the order of siblings as it is.
    let other = file(
        "10 6 0 0",
        &[
            (0, 0, 0, "0"),
            (0, 0, 255, "0"),
            (2, 1, 254, "1.5"),
            (0, 1, 170, "2.5"),
            (1, 1, 1, "9.95675"),
            (2, 1, 253, "0.000123457"),
            (1, 1, 2, "0"),
        ],
    );
    let expected = Vocabulary::from_text(&known()).unwrap();
    assert_eq!(Vocabulary::from_text(&other).unwrap(), expected);
    let spaced = format!("{}\n \n", known().replace(' ', "  ").replace('\n', " \r\n"));
    assert_eq!(Vocabulary::from_text(&spaced).unwrap(), expected);
    assert_eq!(Vocabulary::from_text(known().trim_end()).unwrap(), expected);
}

#[test]
fn heads_that_are_refused() {
    for (head, message) in [
        ("", "line 1: found the end of the line, expected branching from 2 to 1000"),
        ("k 6 0 0", "line 1: found \"k\", expected branching from 2 to 1000"),
        ("1 6 0 0", "line 1: found \"1\", expected branching from 2 to 1000"),
        ("10 17 0 0", "line 1: found \"17\", expected levels from 1 to 16"),
        ("10 6 1 0", "line 1: found \"1\", expected scoring 0 (L1)"),
        ("10 6 0 3", "line 1: found \"3\", expected weighting 0 (TF-IDF)"),
        ("10 6 0", "line 1: found the end of the line, expected weighting 0 (TF-IDF)"),
        ("10 6 0 0 0", "line 1: found \"0\", expected the end of the line"),
    ] {
        assert_eq!(error(&file(head, &[(0, 1, 0, "1")])), message);
    }
}

#[test]
fn lines_that_are_refused() {
    let with_line_4 = |line: &str| {
        let mut lines: Vec<String> = known().lines().map(str::to_string).collect();
        lines[3] = line.to_string();
        error(&lines.join("\n"))
    };
    let line = |parent: &str, leaf: &str, weight: &str| format!("{parent} {leaf} {} {weight}", bytes(170));
    for (line, message) in [
        (line("3", "1", "1"), "found \"3\", expected the number of an earlier node (parent)"),
        (line("-1", "1", "1"), "found \"-1\", expected the number of an earlier node (parent)"),
        (line("0", "2", "1"), "found \"2\", expected 0 or 1 (leaf)"),
        (line("0", "1", "-1"), "found \"-1\", expected a weight, not negative"),
        (line("0", "1", "nan"), "found \"nan\", expected a weight, not negative"),
        (line("0", "1", ""), "found the end of the line, expected a weight, not negative"),
        (line("0", "1", "1 2"), "found \"2\", expected the end of the line"),
        (line("0", "1", "1").replacen("170", "256", 1), "found \"256\", expected 32 descriptor bytes"),
        (line("0", "0", "1"), "found no leaf, expected children further down"),
    ] {
        assert_eq!(with_line_4(&line), format!("line 4: {message}"));
    }
    let childless = known().replacen("0 0 255", "0 1 255", 1).replacen("\n0 0 ", "\n0 1 ", 1);
    assert_eq!(error(&childless), "line 2: found a leaf, expected no children further down");
}

#[test]
fn trees_that_are_refused() {
    assert_eq!(error("10 6 0 0\n"), "invalid: the root has no children or some nodes no parent");
    let leaf = (0, 1, 0, "1");
    assert_eq!(error(&file("2 6 0 0", &[leaf; 3])), "invalid: a node has more than 2 children");
    let deep = file("10 1 0 0", &[(0, 0, 0, "0"), (1, 1, 0, "1")]);
    assert_eq!(error(&deep), "invalid: its nodes do not form a tree of 1 levels");
    assert!(matches!(Vocabulary::from_text(""), Err(FormatError::Line { line: 1, .. })));
}

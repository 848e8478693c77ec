//! Habits of another language that must not come back into help, messages, comments and documents.

use std::fs;
use std::path::Path;

use crate::architecture::all_rust_files;
use crate::documents::documents;
use crate::root;

/// Phrases that no native engineer writes, each with what to write instead.
const HABITS: &[(&str, &str)] = &[
    ("so many", "this many, every N-th"),
    ("nothing to do with", "unrelated"),
    ("goes on with", "continues with"),
    ("go on with", "continue with"),
    ("gone on with", "resumed"),
    ("looked at alone", "inspected"),
    ("as far as their", "in proportion to"),
    ("whoever is", "the one that is"),
    ("that is part of the program", "built-in"),
    ("does not read any more", "has stopped reading"),
    ("key-point", "keypoint"),
    ("key-frame", "keyframe"),
];

/// Beginnings of British words, in lower case.
const BRITISH: &[&str] = &[
    "colour",
    "centre",
    "grey",
    "metre",
    "optimis",
    "recognis",
    "initialis",
    "normalis",
    "generalis",
    "minimis",
    "neighbour",
    "behaviour",
    "labelled",
    "travelled",
    "licence",
];

/// Names that keep their spelling: keys of the configuration, and files.
const KEPT: &[&str] = &["depth_units_per_metre", "optimisation", "neighbours", "colour.onnx"];

/// Verbs after which "no" and a noun read like a translation: "X is no Y" for "X is not a Y".
const VERBS: &[&str] = &["is", "are", "was", "were"];

/// The words of a text, with continued strings and comments joined into one line.
fn joined(text: &str) -> String {
    let lines = text.lines().map(|line| {
        let line = line.trim_start();
        let comment = ["/// ", "//! ", "// "].iter().find_map(|mark| line.strip_prefix(mark));
        comment.unwrap_or(line).trim_end_matches('\\')
    });
    lines.collect::<Vec<_>>().join(" ")
}

/// "X is no Y", but not "there is no Y" and not "is no longer".
fn negated_nouns(text: &str) -> Vec<String> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let is_habit = |at: &[&str]| {
        VERBS.contains(&at[1])
            && at[2] == "no"
            && !at[0].to_lowercase().ends_with("there")
            && !["longer", "more", "fewer", "less"].iter().any(|word| at[3].starts_with(word))
    };
    words.windows(4).filter(|at| is_habit(at)).map(|at| at.join(" ")).collect()
}

/// Everything to mend in a text.
fn problems(text: &str) -> Vec<String> {
    let text = joined(text);
    let mut found: Vec<String> =
        negated_nouns(&text).into_iter().map(|words| format!("`{words}`: write `not a`")).collect();
    let mut plain = text.to_lowercase();
    for name in KEPT {
        plain = plain.replace(name, "");
    }
    for (habit, instead) in HABITS {
        if plain.contains(habit) {
            found.push(format!("`{habit}`: write `{instead}`"));
        }
    }
    found.extend(
        BRITISH
            .iter()
            .filter(|word| plain.contains(*word))
            .map(|word| format!("`{word}`: American spelling")),
    );
    found
}

fn check(path: &Path) {
    let found = problems(&fs::read_to_string(path).unwrap());
    assert!(found.is_empty(), "{}:\n{}", path.display(), found.join("\n"));
}

#[test]
fn sources_read_as_if_a_native_engineer_had_written_them() {
    // This file names the habits.
    for path in all_rust_files().iter().filter(|path| !path.ends_with("suite/english.rs")) {
        check(path);
    }
}

#[test]
fn documents_read_as_if_a_native_engineer_had_written_them() {
    for document in documents() {
        check(&root().join(document));
    }
}

#[test]
fn habits_are_found_and_plain_english_is_left_alone() {
    let count = |text: &str| problems(text).len();
    assert_eq!(count("run.json: is no journal, of grey images"), 2);
    assert_eq!(count("/// Only the first so\n    /// many key-frames."), 2);
    assert_eq!(count("\"the file is no \\\n    map\""), 1);
    assert_eq!(
        count("There is no map; it is no longer read, there were no loops. `weights.optimisation`"),
        0
    );
}

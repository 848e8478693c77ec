//! `--help` of each command: examples and exit codes are there, and docs/results.md says the same.

use std::path::Path;
use std::process::Command;

use super::support::{all_commands, dsslam, help};

/// Commands that `dsslam --help` may list.
const MOST_COMMANDS: usize = 10;

#[test]
fn every_command_tells_its_exit_codes() {
    for command in all_commands().iter().filter(|command| command.len() <= 1) {
        let text = help(command);
        assert!(text.contains("\nExit codes:\n  0  "), "{command:?}\n{text}");
    }
}

#[test]
fn the_documents_list_the_same_exit_codes() {
    let document = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/results.md");
    let document = std::fs::read_to_string(document).unwrap();
    let text = help(&[]);
    let codes = text.split("Exit codes:\n").nth(1).unwrap();
    assert!(codes.lines().count() >= 5, "{codes}");
    for line in codes.lines() {
        let (code, meaning) = line.trim().split_once(' ').unwrap();
        let row = format!("| {code} | {} |", meaning.trim());
        assert!(document.contains(&row), "docs/results.md lacks the row {row}");
    }
}

#[test]
fn the_default_configuration_passes_its_own_check() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("default.yaml");
    let (code, yaml) = dsslam(&["config", "default"]);
    assert_eq!(code, Some(0));
    std::fs::write(&file, &yaml).unwrap();
    assert_eq!(dsslam(&["config", "check", file.to_str().unwrap()]).0, Some(0));
    std::fs::write(&file, yaml + "\nunknown: 1\n").unwrap();
    let (code, text) = dsslam(&["config", "check", file.to_str().unwrap()]);
    assert_eq!(code, Some(2));
    assert!(text.contains("unknown: unknown key"), "{text}");
}

#[test]
fn keys_for_experts_are_listed_on_request_and_where_somebody_set_them() {
    let keys = |args: &[&str]| dsslam(&[&["config"], args].concat()).1;
    let (everyday, all) = (keys(&["default"]), keys(&["default", "--expert"]));
    assert!(everyday.starts_with("# Default configuration; --expert lists 22 further keys.\n"), "{everyday}");
    let n_keys = |yaml: &str| yaml.lines().filter(|line| line.contains("  # ")).count();
    assert_eq!(n_keys(&everyday) + 22, n_keys(&all));
    assert!(!everyday.contains("weights:") && all.contains("\n  loop_lag: 10  # "), "{everyday}{all}");
    let check = keys(&["check", "--set", "features.levels=5"]);
    assert!(check.contains("features.levels = 5") && !check.contains("features.subpixel"), "{check}");
    assert!(keys(&["check", "--expert"]).contains("features.subpixel = true"));
}

#[test]
fn no_arguments_and_unknown_commands_end_with_code_2() {
    assert_eq!(dsslam(&[]).0, Some(2));
    let (code, text) = dsslam(&["rum"]);
    assert!(code == Some(2) && text.contains("'run'"), "{text}");
}

#[test]
fn there_are_few_commands_and_the_old_names_say_where_they_went() {
    let top: Vec<_> = all_commands().iter().filter(|command| command.len() == 1).collect();
    assert!(top.len() <= MOST_COMMANDS, "{top:?}");
    for (old, new) in [
        ("features", "inspect features"),
        ("match", "inspect match"),
        ("stereo", "inspect stereo"),
        ("activation", "inspect activation"),
        ("vocab", "inspect vocab"),
        ("places", "eval places"),
        ("completions", "shell completions"),
        ("man", "shell man"),
    ] {
        let expected = format!("error: `dsslam {old}` is now `dsslam {new}`\n");
        assert_eq!(dsslam(&[old, "--frames", "3"]), (Some(2), expected));
        let path: Vec<String> = new.split(' ').map(str::to_owned).collect();
        assert!(all_commands().contains(&path), "{new}");
    }
}

#[test]
fn the_version_is_that_of_the_package() {
    assert_eq!(dsslam(&["--version"]), (Some(0), format!("dsslam {}\n", env!("CARGO_PKG_VERSION"))));
}

#[test]
fn a_reader_that_has_gone_away_is_not_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("trajectory.txt");
    let rows: Vec<String> = (0..20).map(|i| format!("{i} {i} {} 0 0 0 0 1", i * i)).collect();
    std::fs::write(&file, rows.join("\n")).unwrap();
    let file = file.to_str().unwrap();
    for args in [vec!["eval", "traj", file, file], vec!["config", "default"], vec!["--help"]] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = Command::new(env!("CARGO_BIN_EXE_dsslam")).args(&args).stdout(writer).output().unwrap();
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!((output.status.code(), errors.as_str()), (Some(0), ""), "{args:?}");
    }
}

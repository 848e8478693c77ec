//! Completions, manual pages, and what the program says of the machine.

use std::process::Command;

use serde_json::Value;

use super::support::{Call, all_commands, dsslam, ended};

#[test]
fn completions_know_every_command() {
    for shell in ["bash", "zsh", "fish"] {
        let (code, text) = dsslam(&["shell", "completions", shell]);
        assert_eq!(code, Some(0));
        for command in all_commands().iter().filter(|command| command.len() == 1) {
            assert!(text.contains(&command[0]), "{shell}: {command:?}");
        }
        assert!(text.contains("log-format"), "{shell}");
    }
}

#[test]
fn bash_accepts_its_completions() {
    let (_, text) = dsslam(&["shell", "completions", "bash"]);
    let script = format!("{text}\ncomplete -p dsslam");
    let Ok(output) = Command::new("bash").args(["-c", &script]).output() else {
        println!("skipped: bash is not on this machine");
        return;
    };
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success() && said.contains("_dsslam"), "{said}");
}

#[test]
fn every_command_has_a_manual_page_with_its_examples() {
    let folder = tempfile::tempdir().unwrap();
    let (code, text) = dsslam(&["shell", "man", folder.path().to_str().unwrap()]);
    assert_eq!(code, Some(0), "{text}");
    for command in all_commands() {
        let name = ["dsslam".to_owned()].iter().chain(command).cloned().collect::<Vec<_>>().join("-");
        let page = std::fs::read_to_string(folder.path().join(format!("{name}.1"))).unwrap();
        assert!(page.contains(".TH") && page.contains(".SH SYNOPSIS"), "{name}: {page}");
    }
    let page = std::fs::read_to_string(folder.path().join("dsslam-run.1")).unwrap();
    assert!(page.contains(".SH \"EXAMPLES\"\n.nf\n\\&  dsslam run kitti/sequences/06"), "{page}");
    assert!(page.contains(".SH \"EXIT CODES\""), "{page}");
    let (code, printed) = dsslam(&["shell", "man"]);
    assert_eq!(code, Some(0));
    assert_eq!(
        printed,
        std::fs::read_to_string(folder.path().join("dsslam.1")).unwrap().trim_end().to_owned() + "\n"
    );
}

#[test]
fn the_doctor_names_what_is_missing_and_how_to_get_it() {
    let folder = tempfile::tempdir().unwrap();
    let program = env!("CARGO_BIN_EXE_dsslam");
    let bare = |args: &[&str]| -> Call {
        let mut command = Command::new(program);
        command.args(args).env_clear().env("HOME", folder.path()).current_dir(folder.path());
        ended(&mut command)
    };
    let Call { code, stdout, .. } = bare(&["doctor"]);
    assert_eq!(code, Some(0), "optional items are not an error\n{stdout}");
    assert!(stdout.contains("vocabulary") && stdout.contains("DSSLAM_DATA is not set"), "{stdout}");
    let Call { code, stdout, .. } = bare(&["doctor", "--json"]);
    assert_eq!(code, Some(0));
    let findings: Vec<Value> = serde_json::from_str(&stdout).unwrap();
    let of = |name: &str| findings.iter().find(|finding| finding["name"] == name).unwrap();
    assert_eq!((&of("vocabulary")["state"], &of("vocabulary")["remedy"]), (&"ok".into(), &Value::Null));
    for finding in findings.iter().filter(|finding| finding["state"] == "optional") {
        assert!(finding["remedy"].as_str().is_some_and(|remedy| !remedy.is_empty()), "{finding}");
    }
}

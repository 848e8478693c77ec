//! Every example of every command's help is run, as it stands, by a shell.

use std::path::Path;
use std::process::Command;

use super::support::{Call, all_commands, ended, help, program_folder, sandbox};

/// Programs that a machine may lack; an example that says that it needs one is not held against the program.
const MAY_BE_MISSING: [&str; 2] = ["dsslam-rerun", "dsslam-video"];

/// The lines below `Examples:` that call the program.
fn examples(text: &str) -> Vec<String> {
    let Some((_, rest)) = text.split_once("Examples:\n") else { return Vec::new() };
    let block = rest.lines().take_while(|line| !line.trim().is_empty());
    block.filter_map(|line| line.strip_prefix("  ")).map(str::to_owned).collect()
}

/// The example with what would take minutes cut short, a sequence that sees places again where one is needed, a file in the place of a
/// viewer's window, and the sandbox in the place of `/tmp`.
fn shortened(example: &str, dir: &Path) -> String {
    const FRAMES: &str = "--frames 3";
    let mut words: Vec<&str> = example.split(' ').collect();
    if let Some(at) = words.iter().position(|word| *word == "--frames").filter(|_| renders(&words)) {
        words.splice(at..at + 2, [FRAMES]);
    } else if renders(&words) {
        words.insert(2, FRAMES);
    } else if words.get(2) == Some(&"places") {
        words.splice(3..4, ["revisited --gap 4"]);
    } else if words.get(1) == Some(&"view") && !words.contains(&"--save") {
        words.insert(2, "--save view.rrd");
    } else if let Some(at) = words.iter().position(|word| *word == "--rerun") {
        words[at] = "--rerun-save run.rrd";
    }
    words.join(" ").replace("/tmp/", &format!("{}/", dir.display()))
}

fn renders(words: &[&str]) -> bool {
    matches!(words.get(1), Some(&("demo" | "synth")))
}

/// Runs an example; returns whether it could be run on this machine.
fn works(example: &str, dir: &Path) -> bool {
    let path = std::env::join_paths(
        [program_folder()]
            .into_iter()
            .chain(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default())),
    );
    let mut shell = Command::new("sh");
    shell.args(["-e", "-c", &shortened(example, dir)]).current_dir(dir).env("PATH", path.unwrap());
    let Call { code, stdout, stderr } = ended(&mut shell);
    let lacks = MAY_BE_MISSING.iter().find(|name| code == Some(2) && stderr.contains(*name));
    if let Some(name) = lacks {
        println!("skipped: {name} is not on this machine: {example}");
        return false;
    }
    assert_eq!(code, Some(0), "{example}\n{stdout}{stderr}");
    true
}

#[test]
fn every_example_of_every_help_works() {
    let mut groups: Vec<Vec<String>> = Vec::new();
    for command in all_commands().iter().filter(|command| command.len() <= 1) {
        let below =
            all_commands().iter().filter(|c| command.is_empty() == c.is_empty() && c.starts_with(command));
        groups.push(below.flat_map(|command| examples(&help(command))).collect());
    }
    let n_examples = groups.iter().map(Vec::len).sum::<usize>();
    assert!(n_examples > 30, "only {n_examples} examples found");
    // Commands are independent of each other, but the examples of one may build on those before.
    let n_run: usize = std::thread::scope(|scope| {
        let run = |examples: Vec<String>| {
            let dir = sandbox();
            examples.iter().filter(|example| works(example, dir.path())).count()
        };
        let threads: Vec<_> = groups.into_iter().map(|examples| scope.spawn(move || run(examples))).collect();
        threads.into_iter().map(|thread| thread.join().expect("an example of the help works")).sum()
    });
    println!("{n_run} of {n_examples} examples were run");
    assert!(n_run > 30, "only {n_run} of {n_examples} examples could be run");
}

#[test]
fn every_command_has_an_example_in_its_help_or_in_that_above() {
    for command in all_commands() {
        let call = format!("dsslam {}", command.join(" "));
        let above = command.split_last().map_or(&[][..], |(_, above)| above);
        let known = [examples(&help(command)), examples(&help(above))].concat();
        assert!(known.iter().any(|example| example.starts_with(call.trim())), "no example of {call}");
    }
}

#[test]
fn long_examples_are_cut_short() {
    let dir = Path::new("/box");
    for (example, expected) in [
        ("dsslam demo", "dsslam demo --frames 3"),
        ("dsslam demo --frames 60 --out /tmp/demo", "dsslam demo --frames 3 --out /box/demo"),
        (
            "dsslam inspect match kitti --frames 0 3 -o m.png",
            "dsslam inspect match kitti --frames 0 3 -o m.png",
        ),
        ("dsslam run /tmp/town", "dsslam run /box/town"),
        ("dsslam view # the newest", "dsslam view --save view.rrd # the newest"),
        ("dsslam run kitti --rerun", "dsslam run kitti --rerun-save run.rrd"),
        ("dsslam eval places town --out /tmp/p", "dsslam eval places revisited --gap 4 --out /box/p"),
    ] {
        assert_eq!(shortened(example, dir), expected);
    }
}

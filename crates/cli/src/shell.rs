//! `dsslam shell completions` and `dsslam shell man`: what shells and `man` know of the program, made from its own command line.

use std::path::PathBuf;

use anyhow::Context;
use clap::{Args, Command, CommandFactory};
use clap_complete::Shell;
use clap_mangen::Man;

use crate::args::Cli;
use crate::console;
use crate::exit::{Exit, Failure, OrExit};

/// Arguments of `dsslam shell completions`.
#[derive(Debug, Args)]
pub(crate) struct CompletionsArgs {
    /// The shell.
    #[arg(value_enum, value_name = "SHELL")]
    shell: Shell,
}

/// Arguments of `dsslam shell man`.
#[derive(Debug, Args)]
pub(crate) struct ManArgs {
    /// Writes one page per command into this folder [default: prints the program's page].
    #[arg(value_name = "DIR")]
    dir: Option<PathBuf>,
}

/// Prints shell completions.
pub(crate) fn completions(args: &CompletionsArgs) -> Result<Exit, Failure> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "dsslam", &mut text);
    console::say(String::from_utf8_lossy(&text).trim_end());
    Ok(Exit::Done)
}

/// Prints or writes manual pages.
///
/// # Errors
/// A folder that cannot be written.
pub(crate) fn man(args: &ManArgs) -> Result<Exit, Failure> {
    let mut command = Cli::command();
    command.build();
    let Some(dir) = &args.dir else {
        console::say(String::from_utf8_lossy(&page(&command).or_output()?).trim_end());
        return Ok(Exit::Done);
    };
    io::create_output_folder(dir).or_output()?;
    let mut pages = Vec::new();
    collect(&command, &mut pages);
    for command in &pages {
        let name = format!("{}.1", page_name(command));
        io::write_atomic(&dir.join(name), &page(command).or_output()?).or_output()?;
    }
    console::say(format!("{} manual pages in {}", pages.len(), dir.display()));
    Ok(Exit::Done)
}

/// A command and all below it that are shown.
fn collect<'a>(command: &'a Command, pages: &mut Vec<&'a Command>) {
    pages.push(command);
    let shown = command.get_subcommands().filter(|c| !c.is_hide_set() && c.get_name() != "help");
    shown.for_each(|command| collect(command, pages));
}

/// `dsslam-eval-run`.
fn page_name(command: &Command) -> String {
    command.get_display_name().unwrap_or(command.get_name()).to_owned()
}

/// A page; what stands below the options keeps its lines.
fn page(command: &Command) -> anyhow::Result<Vec<u8>> {
    let extra = command.get_after_help().map(ToString::to_string).unwrap_or_default();
    let mut bytes = Vec::new();
    let man = Man::new(command.clone()).title(page_name(command));
    man.render_title(&mut bytes)
        .and_then(|()| man.render_name_section(&mut bytes))
        .and_then(|()| man.render_synopsis_section(&mut bytes))
        .and_then(|()| man.render_description_section(&mut bytes))
        .and_then(|()| if has_options(command) { man.render_options_section(&mut bytes) } else { Ok(()) })
        .and_then(
            |()| if has_commands(command) { man.render_subcommands_section(&mut bytes) } else { Ok(()) },
        )
        .with_context(|| page_name(command))?;
    bytes.extend(literally(&extra).into_bytes());
    Ok(bytes)
}

fn has_options(command: &Command) -> bool {
    command.get_arguments().any(|argument| !argument.is_hide_set())
}

fn has_commands(command: &Command) -> bool {
    command.get_subcommands().any(|command| !command.is_hide_set())
}

/// Verbatim text: each paragraph under its first line as a heading where that ends with a colon.
fn literally(text: &str) -> String {
    let mut roff = String::new();
    for paragraph in text.split("\n\n").filter(|paragraph| !paragraph.trim().is_empty()) {
        let (heading, body) = match paragraph.split_once('\n') {
            Some((first, rest)) if first.ends_with(':') => (first.trim_end_matches(':').to_uppercase(), rest),
            _ => ("NOTES".to_owned(), paragraph),
        };
        roff.push_str(&format!(".SH \"{heading}\"\n.nf\n"));
        for line in body.lines() {
            roff.push_str(&format!("\\&{}\n", line.replace('\\', "\\e").replace('-', "\\-")));
        }
        roff.push_str(".fi\n");
    }
    roff
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_has_a_page() {
        let mut command = Cli::command();
        command.build();
        let mut pages = Vec::new();
        collect(&command, &mut pages);
        let names: Vec<String> = pages.iter().map(|command| page_name(command)).collect();
        for name in ["dsslam", "dsslam-run", "dsslam-eval-traj", "dsslam-config-check", "dsslam-shell-man"] {
            assert!(names.iter().any(|n| n == name), "{name}: {names:?}");
        }
        assert!(names.iter().all(|name| !name.contains("help")), "{names:?}");
    }

    #[test]
    fn examples_keep_their_lines() {
        let roff = literally("Examples:\n  dsslam run a\n  dsslam run b --out c\\d\n\nA note\non two lines");
        let lines: Vec<&str> = roff.lines().collect();
        assert_eq!(
            lines[..4],
            [".SH \"EXAMPLES\"", ".nf", "\\&  dsslam run a", "\\&  dsslam run b \\-\\-out c\\ed"]
        );
        assert!(roff.contains(".SH \"NOTES\"\n.nf\n\\&A note\n\\&on two lines\n.fi\n"));
    }
}

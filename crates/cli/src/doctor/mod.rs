//! `dsslam doctor`: what is on this machine, what is missing, and how to get it.

mod checks;
mod probe;

use clap::Args;
use serde_json::{Value, json};

use crate::console;
use crate::exit::{Exit, Failure};

/// Arguments of `dsslam doctor`.
#[derive(Debug, Args)]
pub(crate) struct DoctorArgs {
    /// Prints the findings as JSON.
    #[arg(long)]
    json: bool,
}

/// What was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// There.
    Ok,
    /// Not there, and not needed by most commands.
    Optional,
    /// Not there, and needed.
    Missing,
}

/// One thing that was looked for.
#[derive(Clone, Debug)]
struct Finding {
    state: State,
    /// What was looked for.
    name: &'static str,
    /// What was found, or what it is needed for.
    found: String,
    /// How to get it; empty where nothing is missing.
    remedy: String,
}

impl State {
    fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Optional => "optional",
            Self::Missing => "MISSING",
        }
    }
}

impl Finding {
    fn ok(name: &'static str, found: impl Into<String>) -> Self {
        Self { state: State::Ok, name, found: found.into(), remedy: String::new() }
    }

    fn optional(name: &'static str, found: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { state: State::Optional, name, found: found.into(), remedy: remedy.into() }
    }

    fn missing(name: &'static str, found: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { state: State::Missing, name, found: found.into(), remedy: remedy.into() }
    }

    fn json(&self) -> Value {
        let remedy = Some(&self.remedy).filter(|remedy| !remedy.is_empty());
        json!({
            "name": self.name,
            "state": self.state.name().to_lowercase(),
            "found": self.found,
            "remedy": remedy,
        })
    }
}

/// Looks at everything and prints it. Missing optional items are not an error.
pub(crate) fn run(args: &DoctorArgs) -> Result<Exit, Failure> {
    let findings = checks::all();
    if args.json {
        let list: Vec<Value> = findings.iter().map(Finding::json).collect();
        console::say(format!("{:#}", Value::from(list)));
    } else {
        findings.iter().for_each(print);
        console::say(verdict(&findings));
    }
    let is_missing = findings.iter().any(|finding| finding.state == State::Missing);
    Ok(if is_missing { Exit::Input } else { Exit::Done })
}

fn print(finding: &Finding) {
    console::say(format!("{:<10}{:<22}{}", finding.state.name(), finding.name, finding.found));
    for line in finding.remedy.lines() {
        console::say(format!("{:<32}{line}", ""));
    }
}

fn verdict(findings: &[Finding]) -> String {
    let count = |state: State| findings.iter().filter(|finding| finding.state == state).count();
    match (count(State::Missing), count(State::Optional)) {
        (0, 0) => "everything found".to_owned(),
        (0, n) => format!("all required items found; optional items missing: {n}"),
        (n, _) => format!("required items missing: {n}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn optional_items_are_not_an_error() {
        let ok = Finding::ok("a", "there");
        let optional = Finding::optional("b", "for films", "buy it");
        let missing = Finding::missing("c", "for all", "make it");
        assert_eq!(verdict(std::slice::from_ref(&ok)), "everything found");
        assert_eq!(
            verdict(&[ok.clone(), optional.clone()]),
            "all required items found; optional items missing: 1"
        );
        assert_eq!(verdict(&[ok, optional, missing]), "required items missing: 1");
    }
}

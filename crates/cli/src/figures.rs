//! The figures that a run rests on, shown before its first frame; with `--strict` a doubt refuses the run.

use anyhow::anyhow;
use dsslam::{Figures, Session};

use crate::console::{self, Level, Message};
use crate::exit::{Failure, OrExit};

/// Gathers and shows the figures and the doubts.
///
/// # Errors
/// A doubt, where `is_strict`.
pub(crate) fn show(session: &Session, is_strict: bool) -> Result<Figures, Failure> {
    let figures = session.figures();
    for figure in &figures.lines {
        let message = Message::new(Level::Info, format!("{:<13}{}", figure.name, figure.text));
        console::note(message.event("figure").with("name", figure.name).with("text", figure.text.as_str()));
    }
    for doubt in &figures.doubts {
        console::note(console::warning(&doubt.text).event("doubt").with("rule", doubt.rule));
    }
    match figures.doubts.len() {
        n if n > 0 && is_strict => {
            let rules: Vec<&str> = figures.doubts.iter().map(|doubt| doubt.rule).collect();
            Err(anyhow!("refused by --strict, since these figures are doubtful: {}", rules.join(", ")))
                .or_input()
        }
        _ => Ok(figures),
    }
}

//! What the program says: results on standard output, everything else on standard error.
//!
//! A closed pipe (`dsslam run ... | head`) is not an error; colors appear only on a terminal and never with `NO_COLOR`; progress bars appear
//! only on a terminal. `--quiet`, `-v` and `--log-format` are set once, before the command begins.

use std::io::{ErrorKind, IsTerminal, Write};
use std::sync::OnceLock;

use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::{Map, Value};

/// Verbosity and format of the messages: options of every command.
#[derive(Clone, Copy, Debug, Default, Args)]
pub(crate) struct Voice {
    /// Suppresses everything on standard error except warnings and errors.
    #[arg(short, long, global = true, conflicts_with = "verbose", help_heading = "Messages")]
    quiet: bool,
    /// Reports more: keyframes and loops; given twice, every frame.
    #[arg(short, long, global = true, action = clap::ArgAction::Count, help_heading = "Messages")]
    verbose: u8,
    /// Format of the messages on standard error.
    #[arg(
        long,
        value_enum,
        global = true,
        default_value_t,
        value_name = "FORMAT",
        help_heading = "Messages"
    )]
    log_format: LogFormat,
}

/// Format of the messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum LogFormat {
    /// Plain text.
    #[default]
    Text,
    /// A JSON object per line.
    Json,
}

/// How much a message matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Level {
    /// What went wrong.
    Error,
    /// What the person should know.
    Warning,
    /// What is going on.
    Info,
    /// Said with `-v`.
    Detail,
    /// Said with `-vv`.
    Trace,
}

/// One message.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Message {
    /// How much it matters.
    pub(crate) level: Level,
    /// What it says.
    pub(crate) text: String,
    /// The same for programs: `event` and its values.
    pub(crate) fields: Map<String, Value>,
}

static VOICE: OnceLock<Voice> = OnceLock::new();
static UNSAID: OnceLock<String> = OnceLock::new();

/// Sets how the program speaks from now on; the first call counts.
pub(crate) fn set_voice(voice: Voice) {
    let _ = VOICE.set(voice);
}

fn voice() -> Voice {
    VOICE.get().copied().unwrap_or_default()
}

impl Voice {
    fn says(self, level: Level) -> bool {
        let most = match (self.quiet, self.verbose) {
            (true, _) => Level::Warning,
            (false, 0) => Level::Info,
            (false, 1) => Level::Detail,
            (false, _) => Level::Trace,
        };
        level <= most
    }
}

impl Level {
    fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Warning => "warning",
            Self::Info => "info",
            Self::Detail => "detail",
            Self::Trace => "trace",
        }
    }
}

impl Message {
    /// A message without values for programs.
    pub(crate) fn new(level: Level, text: impl Into<String>) -> Self {
        Self { level, text: text.into(), fields: Map::new() }
    }

    /// Names what happened, for programs.
    pub(crate) fn event(self, name: &str) -> Self {
        self.with("event", name)
    }

    /// Adds a value for programs.
    pub(crate) fn with(mut self, name: &str, value: impl Into<Value>) -> Self {
        self.fields.insert(name.to_owned(), value.into());
        self
    }

    fn line(&self, format: LogFormat) -> String {
        match format {
            LogFormat::Json => {
                let mut object = Map::new();
                object.insert("level".to_owned(), self.level.name().into());
                object.extend(self.fields.clone());
                object.insert("message".to_owned(), self.text.as_str().into());
                Value::Object(object).to_string()
            }
            LogFormat::Text => match self.level {
                Level::Error => format!("{} {}", paint("error:", "1;31"), self.text),
                Level::Warning => format!("{} {}", paint("warning:", "33"), self.text),
                _ => self.text.clone(),
            },
        }
    }
}

impl<T: Into<String>> From<T> for Message {
    fn from(text: T) -> Self {
        Self::new(Level::Info, text)
    }
}

/// Prints one line of results to standard output.
pub(crate) fn say(line: impl AsRef<str>) {
    let mut stdout = std::io::stdout().lock();
    match writeln!(stdout, "{}", line.as_ref()).and_then(|()| stdout.flush()) {
        // A reader that has gone away has seen what it wanted.
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            let _ = UNSAID.set(error.to_string());
        }
        _ => {}
    }
}

/// Why standard output did not take everything, such as a full disk; `None` if it did, or if its reader has gone away.
pub(crate) fn unsaid() -> Option<&'static str> {
    UNSAID.get().map(String::as_str)
}

/// Prints a message to standard error, if one of its level is wanted.
pub(crate) fn note(message: impl Into<Message>) {
    let (message, voice) = (message.into(), voice());
    if voice.says(message.level) {
        let _ = writeln!(std::io::stderr(), "{}", message.line(voice.log_format));
    }
}

/// A line that starts with `warning:`.
pub(crate) fn warning(text: impl Into<String>) -> Message {
    Message::new(Level::Warning, text)
}

/// A line that starts with `error:`.
pub(crate) fn error(text: impl Into<String>) -> Message {
    Message::new(Level::Error, text)
}

/// A progress bar on standard error: only on a terminal, and only where messages are for people.
pub(crate) fn bar(length: Option<u64>, template: &str) -> ProgressBar {
    let voice = voice();
    let is_shown = voice.says(Level::Info) && voice.log_format == LogFormat::Text;
    let target = if is_shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(length, target);
    let style = ProgressStyle::with_template(template);
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "));
    bar
}

/// `text` in the given ANSI style when standard error shows colors.
fn paint(text: &str, style: &str) -> String {
    if shows_colors() { format!("\x1b[{style}m{text}\x1b[0m") } else { text.to_owned() }
}

/// Whether standard error is a terminal that wants colors (<https://no-color.org>).
fn shows_colors() -> bool {
    let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    let dumb = std::env::var_os("TERM").is_some_and(|term| term == "dumb");
    std::io::stderr().is_terminal() && !set("NO_COLOR") && !dumb
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_say_how_much_is_said() {
        let voice = |quiet, verbose| Voice { quiet, verbose, log_format: LogFormat::Text };
        let said = |voice: Voice| {
            [Level::Error, Level::Warning, Level::Info, Level::Detail, Level::Trace]
                .into_iter()
                .take_while(|&level| voice.says(level))
                .count()
        };
        let counts = [voice(true, 0), voice(false, 0), voice(false, 1), voice(false, 2), voice(false, 9)];
        assert_eq!(counts.map(said), [2, 3, 4, 5, 5]);
    }

    #[test]
    fn a_json_line_is_one_object_with_level_and_message() {
        let message = warning("lost \"here\"\nand there").event("lost").with("frame", 7);
        let line = message.line(LogFormat::Json);
        assert!(!line.contains('\n'));
        let object: Value = serde_json::from_str(&line).unwrap();
        assert_eq!((&object["level"], &object["event"]), (&"warning".into(), &"lost".into()));
        assert_eq!((&object["frame"], &object["message"]), (&7.into(), &"lost \"here\"\nand there".into()));
    }
}

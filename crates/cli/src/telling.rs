//! Words of a run as messages of the program.

use runtime::{Weight, Words};

use crate::console::{Level, Message};

/// The message of what a run tells.
pub(crate) fn message(words: Words) -> Message {
    let level = match words.weight {
        Weight::Warning => Level::Warning,
        Weight::Info => Level::Info,
        Weight::Detail => Level::Detail,
        Weight::Trace => Level::Trace,
    };
    let message = Message::new(level, words.text).event(words.event);
    words.values.into_iter().fold(message, |message, (name, value)| message.with(name, value))
}

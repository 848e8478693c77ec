//! Tests of the program as a person at a shell meets it: help and its examples, messages, completions.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test stops at the first problem")]

mod suite {
    mod examples;
    mod help;
    mod messages;
    mod shell;
    mod stage;
    mod support;
}

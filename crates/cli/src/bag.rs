//! `dsslam bag info`: what a bag holds, and what a run would take of it.

use std::path::PathBuf;

use ::bag::{Bag, Topic, choose};
use clap::{Args, Subcommand};

use crate::console;
use crate::exit::{Exit, Failure, OrExit};

/// Arguments of `dsslam inspect bag`.
#[derive(Debug, Args)]
pub(crate) struct BagArgs {
    /// File (.bag, .db3, .mcap) or folder of a bag.
    #[arg(value_name = "BAG")]
    pub(crate) bag: PathBuf,
}

/// What `dsslam bag` can do.
#[derive(Debug, Subcommand)]
pub(crate) enum BagAction {
    /// Lists the topics of a bag and what a run takes of it.
    Info(BagArgs),
}

/// Prints the topics of a bag.
///
/// # Errors
/// A path that is not a bag.
pub(crate) fn info(args: &BagArgs) -> Result<Exit, Failure> {
    let bag = Bag::open(&args.bag, None).or_input()?;
    for remark in bag.remarks() {
        console::note(console::warning(remark));
    }
    let row = |cells: [&str; 5]| {
        let [name, kind, count, rate, form] = cells;
        let text = format!("{name:<44} {kind:<32} {count:>8} {rate:>9}  {form}");
        console::say(text.trim_end());
    };
    row(["topic", "type", "messages", "Hz", "images"]);
    for topic in bag.topics() {
        let rate = topic.rate_hz().map_or(String::new(), |rate| format!("{rate:.2}"));
        row([&topic.name, &topic.type_name, &topic.count.to_string(), &rate, &form(topic)]);
    }
    match choose(bag.path(), bag.topics(), None) {
        Ok(choice) => {
            let name = |topic: usize| bag.topics()[topic].name.as_str();
            let mut text = format!("dsslam run takes {}: left={}", choice.sensor(), name(choice.left));
            for (role, topic) in [("right", choice.right), ("depth", choice.depth)] {
                if let Some(topic) = topic {
                    text.push_str(&format!(",{role}={}", name(topic)));
                }
            }
            console::say(format!("\n{text}\n--topics takes others."));
        }
        Err(problem) => console::say(format!("\n{problem}")),
    }
    Ok(Exit::Done)
}

/// Encoding and size of images.
fn form(topic: &Topic) -> String {
    let encoding = topic.encoding.clone().unwrap_or_default();
    match topic.size {
        Some((width, height)) => format!("{encoding} {width}x{height}"),
        None => encoding,
    }
}

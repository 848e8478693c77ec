//! The figures that a run rests on, gathered before its first frame: shown one line each, and doubted by named rules.
//!
//! `facts` gathers what calibration, times and layout say, `sight` looks at a few frames, `lines` puts both into words, `rules` and
//! `image_rules` doubt them. Nothing here changes what a run computes.

mod facts;
mod image_rules;
mod lines;
mod rules;
mod sight;
#[cfg(test)]
mod tests;

pub(crate) use facts::Facts;

/// What a run rests on, and what of it is implausible.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Figures {
    /// Camera, lens, baseline or depth, images, times, layout, ground truth.
    pub lines: Vec<Figure>,
    /// In the order of the lines.
    pub doubts: Vec<Doubt>,
}

/// A figure in words.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// What it is about, in one word or two.
    pub name: &'static str,
    /// The numbers, with units.
    pub text: String,
}

/// A figure that is implausible.
#[derive(Clone, Debug, PartialEq)]
pub struct Doubt {
    /// Name of the rule, such as `field_of_view`; docs/figures.md lists all with their thresholds.
    pub rule: &'static str,
    /// What was found, what is usual, and what may be the cause.
    pub text: String,
}

fn doubt(rule: &'static str, text: String) -> Option<Doubt> {
    Some(Doubt { rule, text })
}

impl Figures {
    /// The figures of what was gathered.
    pub(crate) fn of(facts: &Facts) -> Self {
        let mut doubts = rules::doubts(facts);
        doubts.extend(image_rules::doubts(facts));
        Self { lines: lines::lines(facts), doubts }
    }
}

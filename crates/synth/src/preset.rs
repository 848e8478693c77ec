//! The kinds of worlds, and what each asks of street and traffic.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Kind of world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Preset {
    /// A closed course through a town with moderate traffic.
    Town,
    /// The town almost without moving cars.
    Quiet,
    /// The town with dense traffic: a bus or van close ahead, many oncoming and crossing cars.
    Busy,
    /// The town where we halt at crossings while trucks fill the view.
    Crossing,
    /// A long open street of repeated fronts that never comes back; `rounds` multiplies its length.
    Facades,
    /// An open street on which we roll along in a jam: vehicles close ahead and in the lane beside us.
    Jam,
    /// An open street on which lorries overtake us in pairs: one pulls in close ahead, one stays beside us.
    Lorry,
    /// An open street on which a column of lorries and buses drives beside us at a speed of its own, and one of them ahead.
    Column,
    /// The town where we halt at crossings and roll up to them while trams pass in both directions.
    Trams,
}

/// Vehicles that stay with us.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Company {
    /// None, or one ahead.
    None,
    /// A jam around us.
    Jam,
    /// Lorries that overtake.
    Lorries,
    /// A column in the next lane.
    Column,
}

/// How fast we drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pace {
    /// As fast as the town allows.
    Brisk,
    /// Stop and go.
    Crawl,
}

/// For what we halt at crossings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Halts {
    /// For nothing.
    None,
    /// For a truck, four times a round.
    Trucks,
    /// For trams, at each crossing.
    Trams,
}

/// Numbers behind a preset.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Settings {
    /// Mean way we drive between two oncoming vehicles, meters.
    pub(crate) oncoming_every_m: f64,
    /// Share of curb side slots with a parked car.
    pub(crate) parked: f64,
    /// Share of crossings where a car crosses before us.
    pub(crate) crossing: f64,
    /// Whether a vehicle drives ahead of us, and its least distance in seconds.
    pub(crate) leader_s: Option<f64>,
    /// For what we halt at crossings.
    pub(crate) halts: Halts,
    /// Fronts, trees and marks repeat regularly.
    pub(crate) regular: bool,
    /// The street is open.
    pub(crate) open: bool,
    /// Vehicles that stay with us.
    pub(crate) company: Company,
    /// How fast we drive at most.
    pub(crate) pace: Pace,
}

/// Name and description of each preset, in their order.
const WORDS: [[&str; 2]; Preset::ALL.len()] = [
    ["town", "A closed course through a town, with some traffic"],
    ["quiet", "The town, with hardly a moving car"],
    ["busy", "The town in dense traffic, a bus or a van close ahead"],
    ["crossing", "The town, halting at crossings while trucks fill the view"],
    ["facades", "An open street of fronts that look alike"],
    ["jam", "An open street in a jam, vehicles close ahead and in the next lane"],
    ["lorry", "An open street on which lorries overtake in pairs and pull in close ahead"],
    ["column", "An open street beside a column of lorries and buses, one of them ahead"],
    ["trams", "The town, halting at crossings while trams pass in both directions"],
];

impl Preset {
    /// All presets.
    pub const ALL: [Self; 9] = [
        Self::Town,
        Self::Quiet,
        Self::Busy,
        Self::Crossing,
        Self::Facades,
        Self::Jam,
        Self::Lorry,
        Self::Column,
        Self::Trams,
    ];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        WORDS[self as usize][0]
    }

    /// What it shows, in a few words.
    pub fn about(self) -> &'static str {
        WORDS[self as usize][1]
    }

    /// Whether the street never comes back, so that it is driven once.
    pub fn is_open(self) -> bool {
        self.settings().open
    }

    pub(crate) fn settings(self) -> Settings {
        let town = Settings {
            oncoming_every_m: 65.0,
            parked: 0.5,
            crossing: 0.6,
            leader_s: None,
            halts: Halts::None,
            regular: false,
            open: false,
            company: Company::None,
            pace: Pace::Brisk,
        };
        // A street without oncoming vehicles: the other lane is taken.
        let hemmed =
            Settings { oncoming_every_m: f64::INFINITY, crossing: 0.0, open: true, parked: 0.3, ..town };
        match self {
            Self::Town => Settings { leader_s: Some(2.6), ..town },
            Self::Quiet => Settings { oncoming_every_m: 400.0, parked: 0.35, crossing: 0.0, ..town },
            Self::Busy => {
                Settings { oncoming_every_m: 22.0, parked: 0.7, crossing: 1.0, leader_s: Some(0.7), ..town }
            }
            Self::Crossing => Settings { crossing: 1.0, halts: Halts::Trucks, ..town },
            Self::Facades => Settings {
                oncoming_every_m: 120.0,
                parked: 0.3,
                crossing: 0.0,
                regular: true,
                open: true,
                ..town
            },
            Self::Jam => Settings { company: Company::Jam, pace: Pace::Crawl, ..hemmed },
            Self::Lorry => Settings { company: Company::Lorries, ..hemmed },
            Self::Column => Settings { company: Company::Column, ..hemmed },
            Self::Trams => Settings { halts: Halts::Trams, ..town },
        }
    }
}

impl fmt::Display for Preset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Preset {
    type Err = String;

    /// # Errors
    /// Names what was given and the presets there are.
    fn from_str(text: &str) -> Result<Self, String> {
        let known = || Self::ALL.map(Self::name).join(", ");
        Self::ALL
            .into_iter()
            .find(|p| p.name() == text)
            .ok_or_else(|| format!("unknown preset '{text}'; there are: {}", known()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back_and_others_refused() {
        for preset in Preset::ALL {
            assert_eq!(preset.name().parse::<Preset>(), Ok(preset));
        }
        let error = "twon".parse::<Preset>().unwrap_err();
        assert_eq!(
            error,
            "unknown preset 'twon'; there are: town, quiet, busy, crossing, facades, jam, lorry, column, trams"
        );
    }
}

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
    /// Halts at crossings for trucks.
    pub(crate) truck_halts: bool,
    /// Fronts, trees and marks repeat regularly.
    pub(crate) regular: bool,
}

impl Preset {
    /// All presets.
    pub const ALL: [Self; 5] = [Self::Town, Self::Quiet, Self::Busy, Self::Crossing, Self::Facades];

    /// Name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Town => "town",
            Self::Quiet => "quiet",
            Self::Busy => "busy",
            Self::Crossing => "crossing",
            Self::Facades => "facades",
        }
    }

    pub(crate) fn settings(self) -> Settings {
        let town = Settings {
            oncoming_every_m: 65.0,
            parked: 0.5,
            crossing: 0.6,
            leader_s: None,
            truck_halts: false,
            regular: false,
        };
        match self {
            Self::Town => Settings { leader_s: Some(2.6), ..town },
            Self::Quiet => Settings { oncoming_every_m: 400.0, parked: 0.35, crossing: 0.0, ..town },
            Self::Busy => {
                Settings { oncoming_every_m: 22.0, parked: 0.7, crossing: 1.0, leader_s: Some(0.7), ..town }
            }
            Self::Crossing => Settings { crossing: 1.0, truck_halts: true, ..town },
            Self::Facades => {
                Settings { oncoming_every_m: 120.0, parked: 0.3, crossing: 0.0, regular: true, ..town }
            }
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
        assert_eq!(error, "unknown preset 'twon'; there are: town, quiet, busy, crossing, facades");
    }
}

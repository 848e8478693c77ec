//! Plans the drive: where it halts, for what, and for how long.

use crate::course::Course;
use crate::drive::{Drive, Stop};
use crate::layout::SideStreet;
use crate::preset::{Halts, Pace, Settings};
use crate::spot_turns::SpotTurns;
use crate::traffic::Halt;
use geometry::mix_seed;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Where we halt before a crossing's middle, meters, and for how long, seconds: for a truck, for trams.
const HALT_BEFORE_M: [f64; 2] = [10.0, 9.5];
const HALT_S: [f64; 2] = [6.5, 6.5];
/// How far before that we stop a first time for trams, meters, and for how long, seconds.
const ROLL_UP_M: f64 = 9.0;
const ROLL_UP_S: f64 = 1.0;
/// Halts per round for trucks.
const HALTS_PER_ROUND: usize = 4;
/// Way from one stop to the next in a jam, meters, and for how long we stand, seconds.
const JAM_WAY_M: [f64; 2] = [9.0, 22.0];
const JAM_STOP_S: [f64; 2] = [0.8, 2.5];

/// The drive, with halts before crossings where the preset wants them.
pub(crate) fn plan_drive(
    course: &Course,
    side_streets: &[SideStreet],
    settings: &Settings,
    length: f64,
    turns: &SpotTurns,
    seed: u64,
) -> (Drive, Vec<Halt>) {
    let crossings: Vec<usize> = (0..side_streets.len()).filter(|i| side_streets[*i].is_crossing()).collect();
    let (spacing, kind) = match settings.halts {
        Halts::Trams => (1, 1),
        _ => (crossings.len().div_ceil(HALTS_PER_ROUND).max(1), 0),
    };
    let mut stops: Vec<(usize, Stop)> = Vec::new();
    let mut start = 0.0;
    while settings.halts != Halts::None && start < length {
        for street in crossings.iter().step_by(spacing) {
            let s = start + side_streets[*street].s - HALT_BEFORE_M[kind];
            if s < length - 30.0 {
                stops.push((*street, Stop { s, seconds: HALT_S[kind] }));
            }
        }
        start += course.length;
    }
    let mut places: Vec<Stop> = stops.iter().map(|(_, stop)| *stop).collect();
    if settings.pace == Pace::Crawl {
        places.extend(jam_stops(length, seed));
    }
    if settings.halts == Halts::Trams {
        places.extend(stops.iter().map(|(_, stop)| Stop { s: stop.s - ROLL_UP_M, seconds: ROLL_UP_S }));
    }
    places.extend(turns.stop());
    let drive = Drive::new(course, length, settings.pace, &places, seed).turning(turns);
    let halts = stops
        .iter()
        .map(|(street, stop)| Halt { street: *street, time: drive.arrival(stop), seconds: stop.seconds })
        .collect();
    (drive, halts)
}

/// Where we stand in a jam.
fn jam_stops(length: f64, seed: u64) -> Vec<Stop> {
    let mut rng = ChaCha8Rng::seed_from_u64(mix_seed(seed, 0, 9));
    let (mut s, mut stops) = (12.0, Vec::new());
    while s < length - 10.0 {
        stops.push(Stop { s, seconds: rng.random_range(JAM_STOP_S[0]..JAM_STOP_S[1]) });
        s += rng.random_range(JAM_WAY_M[0]..JAM_WAY_M[1]);
    }
    stops
}

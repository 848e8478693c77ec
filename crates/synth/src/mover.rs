//! Vehicles that drive: where each is at any time.

use crate::course::Course;
use crate::drive::{Drive, LANE_M};
use crate::layout::SideStreet;
use crate::mesh::{Placement, V3};
use crate::noise::Wander;
use crate::vehicle_paint::Model;

/// Vehicles within this distance of us are drawn, meters along the course.
pub(crate) const VISIBLE_M: f64 = 170.0;

/// A kind of vehicle that can be placed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kind {
    pub(crate) mesh: u32,
    pub(crate) model: Model,
}

/// Something that drives.
#[derive(Clone, Debug)]
pub(crate) struct Mover {
    pub(crate) kind: Kind,
    pub(crate) gain: f64,
    pub(crate) path: Path,
}

#[derive(Clone, Debug)]
pub(crate) enum Path {
    /// Meets us at `s` (meters driven) at time `t`, coming with `speed`.
    Oncoming { s: f64, t: f64, speed: f64, lateral: f64 },
    /// Along a side street: at its middle at time `t`, `sign` +1 from left to right.
    Crossing { street: SideStreet, sign: f64, t: f64, speed: f64 },
    /// `gap_m` beyond where we shall be after `mean_s + headway(t)` seconds.
    Leader { headway: Wander, mean_s: f64, gap_m: f64 },
    /// In our direction, `start + speed t + sway(t)` meters along the course.
    Lane { start: f64, speed: f64, sway: Wander, lateral: f64 },
    /// Overtakes us, its middle beside us at time `beside`, stays with us when that is `ahead_m` before us, and leaves. It changes
    /// from the first of the `lanes` to the second meanwhile.
    Overtaking { beside: f64, ahead_m: f64, half_m: f64, lanes: [f64; 2] },
}

/// The near side of a side street, right-hand traffic, meters from its middle.
const NEAR_SIDE_M: f64 = 1.7;

/// How much faster a lorry is while it overtakes, m/s, for how long it stays with us, seconds, and how it leaves, m/s^2.
const OVERTAKING_SPEED: f64 = 2.2;
const STAYS_S: f64 = 8.0;
const LEAVING: f64 = 1.4;
/// Time in which it changes the lane and slows down to our speed, seconds.
const LANE_CHANGE_S: f64 = 2.4;

/// How far the middle of an overtaking vehicle is ahead of us `since` seconds after it was beside us, and how much of the change of
/// lanes is done.
fn overtaking(since: f64, ahead_m: f64) -> (f64, f64) {
    let slowing_m = 0.5 * OVERTAKING_SPEED * LANE_CHANGE_S;
    let arrived = since - (ahead_m - slowing_m) / OVERTAKING_SPEED;
    if arrived <= 0.0 {
        return (OVERTAKING_SPEED * since, 0.0);
    }
    let changed = (arrived / LANE_CHANGE_S).min(1.0);
    let leaving = (arrived - STAYS_S).max(0.0);
    let slowing = slowing_m * (1.0 - (1.0 - changed) * (1.0 - changed));
    let ahead = ahead_m - slowing_m + slowing + 0.5 * LEAVING * leaving * leaving;
    (ahead, changed * changed * (3.0 - 2.0 * changed))
}

impl Mover {
    /// Where it is at time `t`; `None` while it is out of sight.
    pub(crate) fn placement(&self, course: &Course, drive: &Drive, t: f64) -> Option<Placement> {
        match &self.path {
            Path::Oncoming { s, t: meet, speed, lateral } => {
                let here = s - speed * (t - meet);
                if (here - drive.driven(t)).abs() > VISIBLE_M {
                    return None;
                }
                let mut placement = course.at(here).beside(*lateral);
                placement.yaw += std::f64::consts::PI;
                Some(placement)
            }
            Path::Crossing {
                street: SideStreet { center, right, left_m, right_m, .. },
                sign,
                t: middle,
                speed,
            } => {
                let along = sign * speed * (t - middle);
                if along < -left_m || along > *right_m {
                    return None;
                }
                let dir = right * *sign;
                let own_right = V3::y().cross(&dir);
                let position = center + right * along + own_right * NEAR_SIDE_M;
                Some(Placement { position, yaw: dir.x.atan2(dir.z) })
            }
            Path::Leader { headway, mean_s, gap_m } => {
                let ahead = drive.driven(t + mean_s + headway.at(t)) + gap_m;
                let station = course.at(ahead);
                Some(station.beside(LANE_M))
            }
            Path::Lane { start, speed, sway, lateral } => {
                let here = start + speed * t + sway.at(t);
                ((here - drive.driven(t)).abs() < VISIBLE_M).then(|| course.at(here).beside(*lateral))
            }
            Path::Overtaking { beside, ahead_m, half_m, lanes: [from, to] } => {
                let (ahead, changed) = overtaking(t - beside, *ahead_m);
                let seen = (-2.0 * half_m - 5.0..VISIBLE_M).contains(&ahead);
                seen.then(|| course.at(drive.driven(t) + ahead).beside(from + (to - from) * changed))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_overtaking_lorry_comes_stays_and_leaves_without_a_jump() {
        for ahead_m in [3.6, 10.0] {
            let at = |k: i32| overtaking(0.1 * f64::from(k), ahead_m);
            assert_eq!(at(0), (0.0, 0.0));
            let mut stays = 0;
            for k in -100..200 {
                let ((here, changed), (next, later)) = (at(k), at(k + 1));
                assert!(next >= here - 1e-9 && next - here < 2.0, "{k}: {here} {next}");
                assert!((changed..=1.0).contains(&later) && later - changed < 0.1, "{k}: {changed} {later}");
                stays += i32::from((here - ahead_m).abs() < 0.1);
            }
            assert!((50..100).contains(&stays), "{stays} tenths of a second at {ahead_m} m");
        }
    }
}

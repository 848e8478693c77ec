//! How our vehicle drives the course: speed from the curvature, stops, lateral wander, the body's bounce; pose at any time.

use crate::course::Course;
use crate::mesh::V3;
use crate::noise::Wander;
use crate::preset::Pace;
use crate::spot_turns::SpotTurns;
use geometry::{SE3, SO3, Vec3};

/// Largest turning rate of the center line's heading, rad/s: 2.2 degrees per frame at 10 Hz.
const MAX_TURN_RATE: f64 = 0.385;
const MAX_SPEED: f64 = 9.8;
/// The same in a jam.
const CRAWL_SPEED: f64 = 2.7;
const ACCELERATION: f64 = 1.6;
const BRAKING: f64 = 2.2;
/// Camera height above the road, meters.
pub(crate) const CAMERA_HEIGHT_M: f64 = 1.65;
/// Our lane's middle, meters to the right of the center line.
pub(crate) const LANE_M: f64 = 1.65;
/// Distance between nodes of the speed profile, meters.
const NODE_M: f64 = 0.25;

/// A halt: place on the course (meters driven in all) and duration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stop {
    pub(crate) s: f64,
    pub(crate) seconds: f64,
}

/// The whole drive as a function of time.
#[derive(Clone, Debug)]
pub(crate) struct Drive {
    /// Speed at and time of arrival at each node, NODE_M apart.
    speed: Vec<f64>,
    arrival: Vec<f64>,
    /// Waiting time at each node.
    wait: Vec<f64>,
    /// Meters to drive.
    pub(crate) length: f64,
    lateral: Wander,
    per_round: Vec<f64>,
    round_length: f64,
    height: Wander,
    pitch: Wander,
    roll: Wander,
    /// When turns on the spot begin, seconds.
    turns: Option<(f64, SpotTurns)>,
}

impl Drive {
    /// Drives `length` meters of the course; `stops` sorted by place.
    pub(crate) fn new(course: &Course, length: f64, pace: Pace, stops: &[Stop], seed: u64) -> Self {
        let top = if pace == Pace::Crawl { CRAWL_SPEED } else { MAX_SPEED };
        let n = (length / NODE_M).ceil() as usize + 2;
        let cruise = Wander::new(1.0, &[1.0 / 97.0, 1.0 / 41.0], seed ^ 0x51);
        let mut speed: Vec<f64> = (0..n)
            .map(|i| {
                let s = i as f64 * NODE_M;
                let turning = MAX_TURN_RATE / course.at(s).curvature.abs().max(1e-6);
                (top + cruise.at(s)).min(turning)
            })
            .collect();
        let mut wait = vec![0.0; n];
        for stop in stops {
            let node = node_of(stop, n);
            (speed[node], wait[node]) = (0.0, stop.seconds);
        }
        limit_acceleration(&mut speed);
        let mut arrival = vec![0.0];
        for i in 1..n {
            let mean = 0.5 * (speed[i - 1] + speed[i]);
            arrival.push(arrival[i - 1] + wait[i - 1] + NODE_M / mean.max(1e-3));
        }
        let rounds = (length / course.length).ceil() as i32 + 1;
        let per_round =
            (0..=rounds).map(|r| 0.28 * f64::from(crate::noise::signed(r, 5, seed as u32))).collect();
        Self {
            speed,
            arrival,
            wait,
            length,
            lateral: Wander::new(0.16, &[1.0 / 83.0, 1.0 / 47.0], seed ^ 0x52),
            per_round,
            round_length: course.length,
            height: Wander::new(0.022, &[0.9, 1.7, 0.35], seed ^ 0x53),
            pitch: Wander::new(0.007, &[0.8, 1.45, 0.21], seed ^ 0x54),
            roll: Wander::new(0.006, &[0.6, 1.2, 0.17], seed ^ 0x55),
            turns: None,
        }
    }

    /// With turns on the spot, for which it makes a halt.
    pub(crate) fn turning(mut self, turns: &SpotTurns) -> Self {
        self.turns = turns.stop().map(|stop| (self.arrival(&stop), turns.clone()));
        self
    }

    /// Time at which the whole length is driven, seconds.
    pub(crate) fn duration(&self) -> f64 {
        self.time_at(self.length)
    }

    /// Meters driven at time `t`; constant acceleration between nodes. Before the start and after the end the speed stays.
    pub(crate) fn driven(&self, t: f64) -> f64 {
        let last = self.arrival.len() - 1;
        if t <= 0.0 {
            return t * self.speed[0];
        }
        if t >= self.arrival[last] {
            return last as f64 * NODE_M + (t - self.arrival[last]) * self.speed[last];
        }
        let i = self.arrival.partition_point(|a| *a <= t) - 1;
        let into = (t - self.arrival[i] - self.wait[i]).max(0.0);
        i as f64 * NODE_M + (self.speed[i] * into + 0.5 * self.acceleration(i) * into * into).min(NODE_M)
    }

    /// Acceleration between node `i` and the next.
    fn acceleration(&self, i: usize) -> f64 {
        (self.speed[i + 1].powi(2) - self.speed[i].powi(2)) / (2.0 * NODE_M)
    }

    /// Time at which `s` meters are driven, seconds; the first moment of a halt.
    pub(crate) fn time_at(&self, s: f64) -> f64 {
        let last = self.arrival.len() - 1;
        let x = (s / NODE_M).clamp(0.0, last as f64);
        let i = (x as usize).min(last - 1);
        let within = s.clamp(0.0, last as f64 * NODE_M) - i as f64 * NODE_M;
        if within == 0.0 {
            return self.arrival[i];
        }
        // within = v t + a t^2 / 2, solved for t without cancellation.
        let from = self.speed[i];
        let root = (from * from + 2.0 * self.acceleration(i) * within).max(0.0).sqrt();
        self.arrival[i] + self.wait[i] + 2.0 * within / (from + root).max(1e-6)
    }

    /// Time at which we come to a stop there, seconds.
    pub(crate) fn arrival(&self, stop: &Stop) -> f64 {
        self.arrival[node_of(stop, self.arrival.len())]
    }

    /// Offset from the center line at `s` meters driven: differs a little from round to round, without a step where a round ends.
    fn lateral(&self, s: f64) -> f64 {
        let x = (s / self.round_length).clamp(0.0, (self.per_round.len() - 2) as f64);
        let (round, within) = (x as usize, x.fract());
        // Changes sides over the first 6 % of a round.
        let blend = (within / 0.06).min(1.0);
        let blend = blend * blend * (3.0 - 2.0 * blend);
        let own = self.per_round[round];
        let previous = if round == 0 { own } else { self.per_round[round - 1] };
        LANE_M + self.lateral.at(s) + previous + (own - previous) * blend
    }

    /// Pose world_from_cam of the left camera at time `t`.
    pub(crate) fn pose(&self, course: &Course, t: f64) -> SE3 {
        let s = self.driven(t);
        let station = course.at(s);
        let slope = (self.lateral(s + 0.5) - self.lateral(s - 0.5)).atan();
        // A vehicle that stands does not bounce.
        let moving = (self.driven(t + 0.4) - self.driven(t - 0.4)).min(1.0);
        let up = CAMERA_HEIGHT_M + moving * self.height.at(t);
        let position = station.beside(self.lateral(s)).position - V3::y() * up;
        let aside = self.turns.as_ref().map_or(0.0, |(begin, turns)| turns.turned(t - begin));
        let turn = SO3::exp(&Vec3::new(0.0, station.heading + slope + aside, 0.0));
        let nod = SO3::exp(&Vec3::new(moving * self.pitch.at(t), 0.0, moving * self.roll.at(t)));
        SE3::new(turn * nod, position)
    }
}

/// The node at which a stop is made, of `n`.
fn node_of(stop: &Stop, n: usize) -> usize {
    ((stop.s / NODE_M).round() as usize).min(n - 1)
}

/// Lowers speeds until no two neighbors ask for more acceleration or braking than there is: v1^2 <= v0^2 + 2 a d.
fn limit_acceleration(speed: &mut [f64]) {
    let n = speed.len();
    for i in 1..n {
        speed[i] = speed[i].min((speed[i - 1].powi(2) + 2.0 * ACCELERATION * NODE_M).sqrt());
    }
    for i in (0..n - 1).rev() {
        speed[i] = speed[i].min((speed[i + 1].powi(2) + 2.0 * BRAKING * NODE_M).sqrt());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_and_speeds_stay_within_their_limits() {
        let course = Course::town(3);
        let drive = Drive::new(&course, course.length, Pace::Brisk, &[], 3);
        let frames = (drive.duration() * 10.0) as i32;
        assert!((900..1350).contains(&frames), "{frames}");
        let mut fastest: f64 = 0.0;
        for i in 0..frames - 1 {
            let (a, b) =
                (drive.pose(&course, f64::from(i) / 10.0), drive.pose(&course, f64::from(i + 1) / 10.0));
            let motion = a.inverse() * b;
            assert!(
                motion.rotation.angle().to_degrees() < 2.7,
                "frame {i}: {}",
                motion.rotation.angle().to_degrees()
            );
            fastest = fastest.max(motion.translation.norm() * 10.0);
        }
        assert!(fastest > 8.0 && fastest < 11.5, "{fastest}");
    }

    #[test]
    fn driven_and_time_at_are_inverse() {
        let course = Course::town(4);
        // Not a node's place: the halt is made at the nearest node.
        let stops = [Stop { s: 120.06, seconds: 5.0 }];
        let drive = Drive::new(&course, 300.0, Pace::Brisk, &stops, 4);
        for i in 1..290 {
            let s = f64::from(i) + 0.13;
            assert!((drive.driven(drive.time_at(s)) - s).abs() < 1e-6, "{s}");
        }
        let arrive = drive.arrival(&stops[0]);
        assert!((drive.driven(arrive + 0.5) - 120.0).abs() < 0.01);
        assert!((drive.driven(arrive + 4.9) - 120.0).abs() < 0.01);
        assert!(drive.driven(arrive + 7.0) > 121.0);
    }
}

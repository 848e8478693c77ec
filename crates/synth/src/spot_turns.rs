//! Turns on the spot: the vehicle stands, and the left camera turns about its own center before the drive goes on.

use crate::drive::Stop;

/// Mean turning rate, degrees per second: less than 3 degrees per frame at its fastest.
const RATE_DEG_S: f64 = 18.0;
/// Rest before the first turn and after each, seconds.
const REST_S: f64 = 0.8;

/// Where the camera stops and by how much it turns there, one turn after the other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SpotTurns {
    /// Way driven before, meters.
    pub after_m: f64,
    /// Degrees, positive to the right. The drive continues with the camera turned by their sum.
    pub by_deg: Vec<f64>,
}

impl SpotTurns {
    /// The halt that they need; `None` without a turn.
    pub(crate) fn stop(&self) -> Option<Stop> {
        let turning: f64 = self.by_deg.iter().map(|by| duration(*by) + REST_S).sum();
        (!self.by_deg.is_empty()).then_some(Stop { s: self.after_m, seconds: REST_S + turning })
    }

    /// How far the camera has turned `seconds` after the halt began, radians.
    pub(crate) fn turned(&self, seconds: f64) -> f64 {
        let mut left = seconds - REST_S;
        let mut turned = 0.0;
        for &by in &self.by_deg {
            let part = (left / duration(by)).clamp(0.0, 1.0);
            turned += by * part * part * (3.0 - 2.0 * part);
            left -= duration(by) + REST_S;
        }
        turned.to_radians()
    }
}

fn duration(by_deg: f64) -> f64 {
    (by_deg.abs() / RATE_DEG_S).max(0.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_turn_follows_the_other_and_their_sum_stays() {
        let turns = SpotTurns { after_m: 40.0, by_deg: vec![90.0, -180.0] };
        let stop = turns.stop().unwrap();
        assert!((stop.seconds - (5.0 + 10.0 + 3.0 * REST_S)).abs() < 1e-9);
        for (seconds, deg) in
            [(-3.0, 0.0), (REST_S, 0.0), (REST_S + 2.5, 45.0), (REST_S + 5.5, 90.0), (stop.seconds, -90.0)]
        {
            assert!((turns.turned(seconds) - f64::to_radians(deg)).abs() < 1e-9, "{seconds}");
        }
        let fastest =
            (0..1700).map(|i| f64::from(i) / 100.0).map(|s| turns.turned(s + 0.1) - turns.turned(s));
        assert!(fastest.fold(0.0, |a: f64, b| a.max(b.abs())) < f64::to_radians(2.75));
        assert!(SpotTurns::default().stop().is_none());
    }
}

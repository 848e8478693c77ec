//! The light of a drive: the sun, the sky, haze, and the contrast of the sensors. In a world that is relit each round after the first
//! has light of its own; nothing else of the world depends on it.

use crate::mesh::V3;
use geometry::mix_seed;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;

/// Share of a round over which light changes to that of the round.
const CHANGE: f64 = 0.06;
/// Gray value of haze at noon, times 256.
const HAZE: f32 = 210.0 * 256.0;

/// The light of a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Light {
    /// Direction towards the sun, of unit length.
    pub(crate) sun: V3,
    /// Light from all around, and the sun's part on a surface that faces it.
    pub(crate) ambient: f64,
    pub(crate) direct: f64,
    /// Factor on the brightness of the sky, and of the haze.
    pub(crate) sky: f64,
    /// Distance at which half of a color is haze, meters.
    pub(crate) haze_m: f64,
    /// Factor on exposure.
    pub(crate) exposure: f64,
    /// How far the sensors' curve is bent: positive makes dark darker and bright brighter.
    pub(crate) contrast: f64,
}

/// What haze does to what is seen through it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Haze {
    /// Distance at which half of a color is haze, meters.
    pub(crate) half_m: f32,
    /// Gray value times 256.
    pub(crate) tone: f32,
}

/// The light along a drive.
#[derive(Clone, Debug)]
pub(crate) struct Daylight {
    /// One per round.
    rounds: Vec<Light>,
    round_m: f64,
}

impl Light {
    /// That of the first round, and of all rounds of a world that is not relit: a hazy noon.
    pub(crate) fn noon() -> Self {
        Self {
            sun: V3::new(0.5, -0.75, -0.42).normalize(),
            ambient: 0.74,
            direct: 0.62,
            sky: 1.0,
            haze_m: 1000.0,
            exposure: 1.0,
            contrast: 0.0,
        }
    }

    /// That of a later round: alternating between a low, strong sun from another side and an overcast sky.
    fn of_round(seed: u64, round: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(mix_seed(seed, round, 15));
        let noon = Self::noon();
        let azimuth = noon.sun.z.atan2(noon.sun.x) + rng.random_range(0.6 * PI..1.4 * PI);
        let low = round % 2 == 1;
        let elevation: f64 = if low { rng.random_range(0.25..0.5) } else { 1.2 };
        let (level, up) = (elevation.cos(), elevation.sin());
        let between = |rng: &mut ChaCha8Rng, sunny: [f64; 2], overcast: [f64; 2]| {
            let [from, to] = if low { sunny } else { overcast };
            rng.random_range(from..to)
        };
        Self {
            sun: V3::new(level * azimuth.cos(), -up, level * azimuth.sin()),
            ambient: between(&mut rng, [0.46, 0.56], [0.92, 1.0]),
            direct: between(&mut rng, [0.85, 1.05], [0.05, 0.15]),
            sky: between(&mut rng, [0.8, 0.95], [0.88, 1.0]),
            haze_m: between(&mut rng, [900.0, 1500.0], [300.0, 500.0]),
            exposure: between(&mut rng, [0.8, 0.95], [0.75, 0.9]),
            contrast: between(&mut rng, [0.25, 0.45], [-0.4, -0.2]),
        }
    }

    pub(crate) fn haze(&self) -> Haze {
        Haze { half_m: self.haze_m as f32, tone: HAZE * self.sky as f32 }
    }

    /// Light between two.
    fn between(&self, other: &Self, share: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * share;
        Self {
            // Both suns are above the horizon, so that they never are opposite.
            sun: self.sun.lerp(&other.sun, share).normalize(),
            ambient: mix(self.ambient, other.ambient),
            direct: mix(self.direct, other.direct),
            sky: mix(self.sky, other.sky),
            haze_m: mix(self.haze_m, other.haze_m),
            exposure: mix(self.exposure, other.exposure),
            contrast: mix(self.contrast, other.contrast),
        }
    }
}

impl Daylight {
    /// The same light always.
    pub(crate) fn steady() -> Self {
        Self { rounds: vec![Light::noon()], round_m: 1.0 }
    }

    /// Other light in each round of `round_m` meters after the first.
    pub(crate) fn relit(seed: u64, rounds: u32, round_m: f64) -> Self {
        let later = (1..u64::from(rounds)).map(|round| Light::of_round(seed, round));
        Self { rounds: std::iter::once(Light::noon()).chain(later).collect(), round_m }
    }

    /// The light when `driven` meters are behind us. It changes while a round begins.
    pub(crate) fn at(&self, driven: f64) -> Light {
        let last = self.rounds.len() - 1;
        let round = ((driven / self.round_m).max(0.0) as usize).min(last);
        if round == 0 {
            return self.rounds[0];
        }
        let into = ((driven / self.round_m - round as f64) / CHANGE).clamp(0.0, 1.0);
        let share = into * into * (3.0 - 2.0 * into);
        if share >= 1.0 {
            self.rounds[round]
        } else {
            self.rounds[round - 1].between(&self.rounds[round], share)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_changes_without_a_step_and_only_while_a_round_begins() {
        let daylight = Daylight::relit(5, 3, 900.0);
        let numbers = |l: Light| {
            [l.sun.x, l.sun.y, l.sun.z, l.ambient, l.direct, l.sky, l.haze_m / 1000.0, l.exposure, l.contrast]
        };
        for i in 0..2800 {
            let (a, b) = (numbers(daylight.at(f64::from(i))), numbers(daylight.at(f64::from(i + 1))));
            let step = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(step < 0.12, "{i}: {step}");
            let changes = (900..=954).contains(&i) || (1800..=1854).contains(&i);
            assert!(changes || step < 1e-12, "{i}: {step}");
        }
        assert_eq!(daylight.at(-5.0), Light::noon());
        assert_ne!(daylight.at(1000.0), daylight.at(2000.0));
        assert_eq!(Daylight::steady().at(1e4), Light::noon());
    }

    #[test]
    fn every_sun_shines_from_above_with_unit_length() {
        for seed in 0..20 {
            let daylight = Daylight::relit(seed, 4, 1.0);
            for i in 0..400 {
                let sun = daylight.at(0.01 * f64::from(i)).sun;
                assert!((sun.norm() - 1.0).abs() < 1e-12 && sun.y < -0.1, "{seed} {i}: {sun}");
            }
        }
    }
}

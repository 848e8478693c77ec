//! From light to gray values: exposure that changes slowly, vignetting, noise that is new in every frame.

use crate::camera::{HEIGHT, WIDTH};
use crate::daylight::Light;
use crate::noise::Wander;
use geometry::mix_seed;
use rand::{RngCore, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Standard deviation of the noise in the dark, and what it gains up to white, gray levels.
const NOISE: f32 = 0.9;
const SHOT_NOISE: f32 = 0.9;
/// Standard deviation of the sum of four uniform bytes.
const FOUR_BYTES: f32 = 147.8;
/// Loss of light in the corners.
const VIGNETTE: f32 = 0.13;

/// The two cameras' sensors.
#[derive(Clone, Debug)]
pub(crate) struct Sensor {
    exposure: Wander,
    seed: u64,
}

/// One of the two cameras.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Eye {
    Left,
    Right,
}

/// A sensor at one moment, and the light it takes.
#[derive(Clone, Debug)]
pub(crate) struct Shot {
    gain: f32,
    contrast: f32,
    seed: u64,
    vignette: f32,
    pub(crate) light: Light,
}

impl Sensor {
    pub(crate) fn new(seed: u64) -> Self {
        Self { exposure: Wander::new(0.16, &[1.0 / 53.0, 1.0 / 23.0, 1.0 / 9.0], seed ^ 0xe7), seed }
    }

    /// Settings for frame `index` at time `t`; the two cameras differ by 1.5 %.
    pub(crate) fn shot(&self, eye: Eye, index: usize, t: f64, light: Light) -> Shot {
        let (own, purpose) = match eye {
            Eye::Left => (1.0, 11),
            Eye::Right => (1.015, 12),
        };
        Shot {
            gain: (own * (1.0 + self.exposure.at(t)) * light.exposure) as f32,
            contrast: light.contrast as f32,
            seed: mix_seed(self.seed, index as u64, purpose),
            vignette: VIGNETTE,
            light,
        }
    }
}

impl Shot {
    /// The shot of a tile of a larger picture: noise of its own, corners as bright as the middle.
    pub(crate) fn of_tile(&self, tile: usize) -> Self {
        Self { seed: mix_seed(self.seed, tile as u64, 14), vignette: 0.0, ..self.clone() }
    }

    /// Gray values of image row `y` from its tones (gray value times 256).
    pub(crate) fn expose(&self, y: usize, tones: &[u16], out: &mut [u8]) {
        let mut random = [0_u8; 4 * WIDTH];
        ChaCha8Rng::seed_from_u64(mix_seed(self.seed, y as u64, 13)).fill_bytes(&mut random);
        let (cx, cy) = (WIDTH as f32 / 2.0, HEIGHT as f32 / 2.0);
        let dy_sq = (y as f32 - cy).powi(2);
        for (x, ((out, tone), bytes)) in out.iter_mut().zip(tones).zip(random.chunks_exact(4)).enumerate() {
            let r_sq = ((x as f32 - cx).powi(2) + dy_sq) / (cx * cx + cy * cy);
            let light = f32::from(*tone) / 256.0 * self.gain * (1.0 - self.vignette * r_sq);
            // Rises with the light, for any contrast within -1..1; black stays, and so does middle gray.
            let light = light * (1.0 + self.contrast * (light / 255.0 - 0.5));
            let sum = u32::from(bytes[0]) + u32::from(bytes[1]) + u32::from(bytes[2]) + u32::from(bytes[3]);
            let sigma = NOISE + SHOT_NOISE * light / 255.0;
            *out = (light + sigma * (sum as f32 - 510.0) / FOUR_BYTES + 0.5) as u8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_its_size_and_is_new_in_each_frame_and_row() {
        let sensor = Sensor::new(4);
        let tones = [100 * 256_u16; WIDTH];
        let row = |index: usize, y: usize, eye: Eye| {
            let mut out = [0; WIDTH];
            sensor.shot(eye, index, 0.0, Light::noon()).expose(y, &tones, &mut out);
            out
        };
        let a = row(3, 188, Eye::Left);
        assert_eq!(a, row(3, 188, Eye::Left));
        for other in [row(4, 188, Eye::Left), row(3, 189, Eye::Left), row(3, 188, Eye::Right)] {
            assert_ne!(a, other);
        }
        let steps: Vec<f64> = a.windows(2).map(|w| f64::from(w[1]) - f64::from(w[0])).collect();
        let sigma = (steps.iter().map(|d| d * d).sum::<f64>() / steps.len() as f64 / 2.0).sqrt();
        assert!((0.8..2.2).contains(&sigma), "{sigma}");
    }
}

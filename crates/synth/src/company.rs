//! Vehicles that stay with us and fill much of the view: a jam, lorries that overtake, a column in the next lane.

use crate::drive::LANE_M;
use crate::mover::{Kind, Path, VISIBLE_M};
use crate::noise::Wander;
use crate::preset::Company;
use geometry::mix_seed;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The lane to the left of ours, meters to the right of the center line.
const NEXT_LANE_M: f64 = -1.5;
/// Clear road between two vehicles of a column, meters.
const BETWEEN_M: [f64; 2] = [2.0, 4.5];
/// Clear road before our camera behind the first vehicle of a jam, meters.
const JAM_GAP_M: f64 = 4.5;
/// By how many seconds each vehicle of a jam is ahead of the next.
const JAM_REACTION_S: f64 = 0.45;
/// Mean speed of the next lane in a jam, and how far it runs ahead of that or falls behind, meters.
const JAM_LANE_SPEED: f64 = 2.4;
const JAM_SWAY_M: f64 = 4.0;
/// Speed of a column, which is about as fast as we are, and its sway, meters.
const COLUMN_SPEED: [f64; 2] = [9.0, 10.4];
const COLUMN_SWAY_M: f64 = 1.5;
/// Distance to the vehicle ahead beside a column, seconds and meters.
const COLUMN_HEADWAY_S: f64 = 0.4;
const COLUMN_GAP_M: f64 = 4.5;
/// When the first lorry is beside us, the time from one to the next pair, and by how much the second follows, seconds.
const FIRST_LORRY_S: f64 = 4.0;
const LORRY_EVERY_S: [f64; 2] = [17.0, 20.0];
const SECOND_LORRY_S: f64 = 3.5;
/// Clear road between our camera and a lorry that has pulled in, and how far the second's rear stays behind our camera, meters.
const LORRY_GAP_M: f64 = 3.4;
const LORRY_BEHIND_M: f64 = 3.0;

/// The vehicles, whose kinds are chosen from `large` ones and `any`; `duration_s` is the length of our drive.
pub(crate) fn vehicles(
    company: Company,
    large: &[Kind],
    any: &[Kind],
    (duration_s, length_m): (f64, f64),
    seed: u64,
) -> Vec<(Kind, Path)> {
    let rng = ChaCha8Rng::seed_from_u64(mix_seed(seed, 0, 8));
    let mut planner = Planner { large, any, rng, seed };
    match company {
        Company::None => Vec::new(),
        Company::Jam => {
            let sway = Wander::new(JAM_SWAY_M, &[1.0 / 21.0, 1.0 / 13.0], seed ^ 0x1a);
            let lane = planner.column(JAM_LANE_SPEED, &sway, (duration_s, length_m));
            planner.queue().into_iter().chain(lane).collect()
        }
        Company::Lorries => planner.lorries(duration_s),
        Company::Column => {
            let sway = Wander::new(COLUMN_SWAY_M, &[1.0 / 29.0, 1.0 / 17.0], seed ^ 0x1b);
            let speed = planner.rng.random_range(COLUMN_SPEED[0]..COLUMN_SPEED[1]);
            let column = planner.column(speed, &sway, (duration_s, length_m));
            planner.leader().into_iter().chain(column).collect()
        }
    }
}

struct Planner<'a> {
    large: &'a [Kind],
    any: &'a [Kind],
    rng: ChaCha8Rng,
    seed: u64,
}

impl Planner<'_> {
    fn pick(&mut self, large: f64) -> Kind {
        let kinds = if self.rng.random_bool(large) { self.large } else { self.any };
        kinds[self.rng.random_range(0..kinds.len())]
    }

    fn gap(&mut self) -> f64 {
        self.rng.random_range(BETWEEN_M[0]..BETWEEN_M[1])
    }

    /// The vehicles before us in our own lane; the first is a large one.
    fn queue(&mut self) -> Vec<(Kind, Path)> {
        let (mut rear, mut queue) = (JAM_GAP_M, Vec::new());
        let mut place = 1.0;
        while rear < VISIBLE_M {
            let kind = self.pick(if queue.is_empty() { 1.0 } else { 0.4 });
            let length = kind.model.size().length;
            let headway = Wander::new(0.12, &[1.0 / 11.0, 1.0 / 7.0], self.seed ^ 0x1c);
            let path = Path::Leader { headway, mean_s: JAM_REACTION_S * place, gap_m: rear + 0.5 * length };
            queue.push((kind, path));
            rear += length + self.gap();
            place += 1.0;
        }
        queue
    }

    /// The vehicle before us beside a column.
    fn leader(&mut self) -> Option<(Kind, Path)> {
        let kind = self.pick(1.0);
        let headway = Wander::new(0.1, &[1.0 / 23.0, 1.0 / 9.0], self.seed ^ 0x1d);
        let gap_m = COLUMN_GAP_M + 0.5 * kind.model.size().length;
        Some((kind, Path::Leader { headway, mean_s: COLUMN_HEADWAY_S, gap_m }))
    }

    /// Vehicles nose to tail in the next lane, from beginning to end of our drive.
    fn column(&mut self, speed: f64, sway: &Wander, (duration_s, length_m): (f64, f64)) -> Vec<(Kind, Path)> {
        let slip = length_m - speed * duration_s;
        let (first, last) = (slip.min(0.0) - 40.0, slip.max(0.0) + VISIBLE_M);
        let (mut rear, mut column) = (first, Vec::new());
        while rear < last {
            let kind = self.pick(0.85);
            let length = kind.model.size().length;
            let path =
                Path::Lane { start: rear + 0.5 * length, speed, sway: sway.clone(), lateral: NEXT_LANE_M };
            column.push((kind, path));
            rear += length + self.gap();
        }
        column
    }

    /// Lorries that overtake us in pairs: the first pulls in before us, the second stays beside us.
    fn lorries(&mut self, duration_s: f64) -> Vec<(Kind, Path)> {
        let (mut beside, mut lorries) = (FIRST_LORRY_S, Vec::new());
        while beside < duration_s {
            for (after_s, to) in [(0.0, LANE_M), (SECOND_LORRY_S, NEXT_LANE_M)] {
                let kind = self.pick(1.0);
                let half_m = 0.5 * kind.model.size().length;
                let rear_m = if after_s > 0.0 { -LORRY_BEHIND_M } else { LORRY_GAP_M };
                let (lanes, beside) = ([NEXT_LANE_M, to], beside + after_s);
                lorries.push((kind, Path::Overtaking { beside, ahead_m: half_m + rear_m, half_m, lanes }));
            }
            beside += self.rng.random_range(LORRY_EVERY_S[0]..LORRY_EVERY_S[1]);
        }
        lorries
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vehicle_paint::Model;

    #[test]
    fn vehicles_of_a_lane_follow_each_other_without_touching_and_cover_the_whole_drive() {
        let large = [Kind { mesh: 0, model: Model::Lorry }, Kind { mesh: 1, model: Model::Bus }];
        let any = [Kind { mesh: 2, model: Model::Saloon }];
        for company in [Company::Jam, Company::Column] {
            let (duration_s, length_m) = (120.0, 600.0);
            let lane = vehicles(company, &large, &any, (duration_s, length_m), 3);
            let spans: Vec<[f64; 2]> = lane
                .iter()
                .filter_map(|(kind, path)| {
                    let Path::Lane { start, .. } = path else { return None };
                    let half = 0.5 * kind.model.size().length;
                    Some([start - half, start + half])
                })
                .collect();
            for pair in spans.windows(2) {
                let gap = pair[1][0] - pair[0][1];
                assert!((BETWEEN_M[0]..=BETWEEN_M[1]).contains(&gap), "{company:?}: {gap} m");
            }
            // Someone is beside us at the beginning and at the end.
            let Some((_, Path::Lane { speed, .. })) =
                lane.iter().find(|(_, p)| matches!(p, Path::Lane { .. }))
            else {
                panic!("{company:?}: nobody in the next lane")
            };
            for (t, driven) in [(0.0, 0.0), (duration_s, length_m)] {
                let beside = driven - speed * t;
                assert!(spans.iter().any(|[rear, front]| rear - 5.0 < beside && beside < front + 5.0));
            }
        }
        assert!(vehicles(Company::None, &large, &any, (120.0, 600.0), 3).is_empty());
    }
}

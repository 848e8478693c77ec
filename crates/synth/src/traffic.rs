//! Vehicles: parked ones, that partly change from round to round, and moving ones as functions of time.

use crate::company;
use crate::course::Course;
use crate::drive::{Drive, LANE_M};
use crate::layout::{ROAD_HALF_M, SIDE_HALF_M, SideStreet};
use crate::library::Common;
use crate::mesh::{Instance, Layer, Placement};
use crate::mover::{Kind, Mover, Path, VISIBLE_M};
use crate::noise::Wander;
use crate::preset::{Company, Halts, Settings};
use crate::town::{LABEL_MOVING, LABEL_PARKED, Scene};
use crate::vehicle;
use crate::vehicle_paint::Model;
use geometry::mix_seed;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Least distance from our camera to the tail of the vehicle ahead, were we to stand, meters.
const CLOSEST_M: f64 = 4.0;
/// Distance between two parking places, meters.
const SLOT_M: f64 = 6.25;
/// Speed of trams at a crossing, m/s.
const TRAM_SPEED: f64 = 4.2;
/// Direction of each tram at a crossing (1: from left to right), and when its middle is before us after we have halted, seconds.
const TRAMS: [(f64, f64); 3] = [(1.0, -4.0), (1.0, 2.6), (-1.0, 1.0)];
/// Share of parking places whose car changes from round to round.
const CHANGED: f64 = 0.4;

/// A parking place at the curb.
#[derive(Clone, Copy, Debug)]
struct Slot {
    s: f64,
    placement: Placement,
    changes: bool,
    seed: u64,
}

/// All vehicles of a world.
#[derive(Clone, Debug)]
pub(crate) struct Traffic {
    kinds: Vec<Kind>,
    slots: Vec<Slot>,
    movers: Vec<Mover>,
    parked: f64,
    course_length: f64,
    closed: bool,
}

/// Number of cars (hatchbacks and saloons), then vans, buses, trucks among the kinds.
const N_CARS: usize = 12;
const N_VANS: usize = 3;
const N_BUSES: usize = 2;
const N_TRUCKS: usize = 2;
/// Number of lorries and trams where a preset wants them.
const N_LORRIES: usize = 4;
const N_TRAMS: usize = 3;

impl Traffic {
    /// Fills the world with vehicles; `trucks` are the times at which we halt before crossings.
    pub(crate) fn new(world: &TrafficPlan<'_>, scene: &mut Scene, common: &Common, seed: u64) -> Self {
        let kinds = build_kinds(scene, common, world.settings, seed);
        let mut traffic = Self {
            kinds,
            slots: slots(world, seed),
            movers: Vec::new(),
            parked: world.settings.parked,
            course_length: world.course.length,
            closed: world.course.closed,
        };
        let mut rng = ChaCha8Rng::seed_from_u64(mix_seed(seed, 0, 3));
        if let Some(mean_s) = world.settings.leader_s {
            traffic.add_leader(mean_s, seed, &mut rng);
        }
        traffic.add_company(world, seed);
        traffic.add_halts(world);
        traffic.add_crossing(world, &mut rng);
        traffic.add_oncoming(world, &mut rng);
        traffic
    }

    fn car(&self, rng: &mut ChaCha8Rng) -> Kind {
        let vans = if rng.random_bool(0.15) { N_VANS } else { 0 };
        self.kinds[rng.random_range(0..N_CARS + vans)]
    }

    fn push(&mut self, kind: Kind, path: Path, rng: &mut ChaCha8Rng) {
        self.movers.push(Mover { kind, gain: rng.random_range(0.8..1.15), path });
    }

    fn add_leader(&mut self, mean_s: f64, seed: u64, rng: &mut ChaCha8Rng) {
        // Close followers keep their distance; others fall back out of sight from time to time.
        let (kind, swing) = if mean_s < 2.0 {
            (self.kinds[N_CARS + N_VANS + rng.random_range(0..N_BUSES)], 0.3)
        } else {
            (self.car(rng), 0.45 * mean_s)
        };
        let headway = Wander::new(swing, &[1.0 / 37.0, 1.0 / 19.0], seed ^ 0x1ead);
        let gap_m = 0.5 * kind.model.size().length + CLOSEST_M;
        self.push(kind, Path::Leader { headway, mean_s, gap_m }, rng);
    }

    /// Vehicles that stay with us.
    fn add_company(&mut self, world: &TrafficPlan<'_>, seed: u64) {
        let drive = (world.drive.duration(), world.drive.length);
        let large = &self.kinds[N_CARS + N_VANS..];
        let large: Vec<Kind> = match world.settings.company {
            Company::Lorries => large[N_BUSES + N_TRUCKS..].to_vec(),
            _ => large.to_vec(),
        };
        let any = &self.kinds[..N_CARS + N_VANS];
        for (kind, path) in company::vehicles(world.settings.company, &large, any, drive, seed) {
            self.movers.push(Mover { kind, gain: 1.0, path });
        }
    }

    /// What crosses before us at each halt: a truck, its middle before us at half time, or trams in both directions, of which the
    /// nearer track carries two that are coupled.
    fn add_halts(&mut self, world: &TrafficPlan<'_>) {
        let heavy = &self.kinds[N_CARS + N_VANS + N_BUSES..];
        for (i, halt) in world.halts.iter().enumerate() {
            let street = world.side_streets[halt.street];
            let mut cross = |kind: usize, sign, behind_s, speed| {
                let path = Path::Crossing { street, sign, t: halt.time + behind_s, speed };
                self.movers.push(Mover { kind: heavy[kind], gain: 1.0, path });
            };
            match world.settings.halts {
                Halts::None => {}
                Halts::Trucks => {
                    cross(i % N_TRUCKS, if i % 2 == 0 { 1.0 } else { -1.0 }, 0.5 * halt.seconds, 3.4);
                }
                Halts::Trams => {
                    for (k, (sign, behind_s)) in TRAMS.into_iter().enumerate() {
                        cross(N_TRUCKS + (i + k) % N_TRAMS, sign, behind_s, TRAM_SPEED);
                    }
                }
            }
        }
    }

    /// Cars that cross some 25 m before us, where they meet nobody.
    fn add_crossing(&mut self, world: &TrafficPlan<'_>, rng: &mut ChaCha8Rng) {
        let course = world.course;
        let mut round_start = 0.0;
        while round_start < world.drive.length {
            for (i, street) in
                world.side_streets.iter().enumerate().filter(|(_, street)| street.is_crossing())
            {
                let ahead = rng.random_range(20.0..32.0);
                let (sign, kind) = (if rng.random_bool(0.5) { 1.0 } else { -1.0 }, self.car(rng));
                let speed = rng.random_range(5.0..8.0);
                let meet = round_start + street.s - ahead;
                let halted = world.halts.iter().any(|halt| halt.street == i);
                if !rng.random_bool(world.settings.crossing)
                    || halted
                    || meet < 5.0
                    || meet > world.drive.length
                {
                    continue;
                }
                let t = world.drive.time_at(meet);
                let path = Path::Crossing { street: *street, sign, t, speed };
                let candidate = Mover { kind, gain: 1.0, path };
                if self.meets_nobody(&candidate, world, t) {
                    self.push(kind, candidate.path, rng);
                }
            }
            round_start += course.length;
        }
    }

    /// Cars on the other lane, one after another as we drive.
    fn add_oncoming(&mut self, world: &TrafficPlan<'_>, rng: &mut ChaCha8Rng) {
        let mut s = rng.random_range(0.2..1.0) * world.settings.oncoming_every_m;
        while s < world.drive.length + VISIBLE_M {
            let t = world.drive.time_at(s) + (s - world.drive.length).max(0.0) / 9.0;
            let kind = self.car(rng);
            let lateral = -LANE_M + rng.random_range(-0.2..0.15);
            let path = Path::Oncoming { s, t, speed: 8.5, lateral };
            let candidate = Mover { kind, gain: 1.0, path };
            if self.meets_nobody(&candidate, world, t) {
                self.push(kind, candidate.path, rng);
            }
            s += world.settings.oncoming_every_m * rng.random_range(0.55..1.45);
        }
    }

    /// Whether a new vehicle keeps clear of all others while it is near us.
    fn meets_nobody(&self, candidate: &Mover, world: &TrafficPlan<'_>, around: f64) -> bool {
        (-40..=40).all(|k| {
            let t = around + 0.4 * f64::from(k);
            let Some(mine) = candidate.placement(world.course, world.drive, t) else { return true };
            self.movers.iter().all(|other| {
                let Some(theirs) = other.placement(world.course, world.drive, t) else { return true };
                let reach = 0.5 * (candidate.kind.model.size().length + other.kind.model.size().length) + 0.8;
                // Side by side in opposite lanes is fine.
                let offset = theirs.position - mine.position;
                let (sin, cos) = mine.yaw.sin_cos();
                let (along, across) = (offset.x * sin + offset.z * cos, offset.x * cos - offset.z * sin);
                let parallel = (mine.yaw - theirs.yaw).sin().abs() < 0.5;
                along.abs() > reach || across.abs() > if parallel { 2.4 } else { reach }
            })
        })
    }

    /// The vehicles at time `t`, when `driven` meters are behind us.
    pub(crate) fn instances(&self, course: &Course, drive: &Drive, t: f64) -> Vec<Instance> {
        let driven = drive.driven(t);
        let vehicle = |kind: &Kind, placement: Placement, label: u8, gain: f64| Instance {
            mesh: kind.mesh,
            placement,
            layer: Layer::Object,
            label,
            gain,
        };
        let parked = self.slots.iter().filter_map(|slot| {
            let (kind, gain) = self.parked_in(slot, driven)?;
            Some(vehicle(&kind, slot.placement, LABEL_PARKED, gain))
        });
        let moving = self.movers.iter().filter_map(|mover| {
            Some(vehicle(&mover.kind, mover.placement(course, drive, t)?, LABEL_MOVING, mover.gain))
        });
        parked.chain(moving).collect()
    }

    /// Who stands in a slot now. Cars are exchanged while we are on the other side of the course.
    fn parked_in(&self, slot: &Slot, driven: f64) -> Option<(Kind, f64)> {
        let away = (driven - slot.s) / self.course_length;
        let version = if slot.changes && self.closed { (away + 0.5).floor().max(0.0) as u64 } else { 0 };
        let mut rng = ChaCha8Rng::seed_from_u64(mix_seed(slot.seed, version, 4));
        let kind = self.car(&mut rng);
        let gain = rng.random_range(0.8..1.15);
        rng.random_bool(self.parked).then_some((kind, gain))
    }
}

/// A halt of ours, for a truck to pass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Halt {
    /// Index of the side street.
    pub(crate) street: usize,
    /// Arrival, and how long we wait, seconds.
    pub(crate) time: f64,
    pub(crate) seconds: f64,
}

/// What traffic needs to know of the world.
pub(crate) struct TrafficPlan<'a> {
    pub(crate) course: &'a Course,
    pub(crate) drive: &'a Drive,
    pub(crate) side_streets: &'a [SideStreet],
    pub(crate) settings: &'a Settings,
    pub(crate) halts: &'a [Halt],
}

fn build_kinds(scene: &mut Scene, common: &Common, settings: &Settings, seed: u64) -> Vec<Kind> {
    let special = match (settings.company, settings.halts) {
        (_, Halts::Trams) => vec![Model::Tram; N_TRAMS],
        (Company::None, _) => Vec::new(),
        _ => vec![Model::Lorry; N_LORRIES],
    };
    let models = (0..N_CARS)
        .map(|i| if i % 2 == 0 { Model::Hatchback } else { Model::Saloon })
        .chain([Model::Van; N_VANS])
        .chain([Model::Bus; N_BUSES])
        .chain([Model::Truck; N_TRUCKS])
        .chain(special);
    models
        .enumerate()
        .map(|(i, model)| {
            let mesh = vehicle::build(model, &mut scene.recipes, common, mix_seed(seed, i as u64, 5) as u32);
            Kind { mesh: scene.mesh(mesh), model }
        })
        .collect()
}

/// Parking places on both sides, not in turns nor near side streets.
fn slots(world: &TrafficPlan<'_>, seed: u64) -> Vec<Slot> {
    let course = world.course;
    let mut rng = ChaCha8Rng::seed_from_u64(mix_seed(seed, 0, 6));
    let n = (course.length / SLOT_M) as usize;
    let mut slots = Vec::new();
    for i in 0..n {
        for side in [-1.0, 1.0] {
            let s = (i as f64 + 0.5) * SLOT_M + rng.random_range(-0.3..0.3);
            let lateral = side * (ROAD_HALF_M - 1.05 + rng.random_range(-0.15..0.1));
            let changes = rng.random_bool(CHANGED);
            let station = course.at(s);
            let near_street =
                world.side_streets.iter().any(|street| (street.s - s).abs() < SIDE_HALF_M + 10.0);
            if station.curvature.abs() > 0.02 || near_street {
                continue;
            }
            let mut placement = station.beside(lateral);
            placement.yaw +=
                rng.random_range(-0.02..0.02) + if side < 0.0 { std::f64::consts::PI } else { 0.0 };
            let seed = mix_seed(seed, 2 * i as u64 + u64::from(side > 0.0), 7);
            slots.push(Slot { s, placement, changes, seed });
        }
    }
    slots
}

//! A world with its drive: any frame, in any order, always the same bytes.

use crate::camera::{HEIGHT, View, WIDTH};
use crate::course::Course;
use crate::daylight::{Daylight, Light};
use crate::drive::Drive;
use crate::lens::{LensCamera, Redrawing};
use crate::library::{Common, Library};
use crate::mesh::{Instance, V3};
use crate::plan::plan_drive;
use crate::preset::Preset;
use crate::render::{self, Shapes};
use crate::sensor::{Eye, Sensor};
use crate::spot_turns::SpotTurns;
use crate::town::{self, Scene};
use crate::traffic::{Traffic, TrafficPlan};
use geometry::{GrayImage, Pinhole, Raster, SE3, StereoRig};

/// Frames per second.
pub const FRAME_RATE_HZ: f64 = 10.0;
/// Length of the open street per round, meters.
const STREET_M: f64 = 900.0;

/// The two images of a moment.
#[derive(Clone, Debug, PartialEq)]
pub struct StereoImages {
    /// Left camera.
    pub left: GrayImage,
    /// Right camera.
    pub right: GrayImage,
}

/// Images and ground truth of a moment.
#[derive(Clone, Debug, PartialEq)]
pub struct StereoFrame {
    /// Left camera.
    pub left: GrayImage,
    /// Right camera.
    pub right: GrayImage,
    /// Depth along the left camera's optical axis in meters; 0 in the sky.
    pub depth_m: Raster<f32>,
    /// What the left camera sees: [`LABEL_STATIC`](crate::LABEL_STATIC), [`LABEL_MOVING`](crate::LABEL_MOVING),
    /// [`LABEL_PARKED`](crate::LABEL_PARKED) or [`LABEL_SKY`](crate::LABEL_SKY).
    pub labels: Raster<u8>,
    /// Pose of the left camera in the frame of the first left camera.
    pub world_from_cam: SE3,
}

/// A street world and a drive through it.
#[derive(Debug)]
pub struct World {
    preset: Preset,
    seed: u64,
    rounds: u32,
    turns: SpotTurns,
    course: Course,
    drive: Drive,
    shapes: Shapes,
    still: Vec<Instance>,
    traffic: Traffic,
    sensor: Sensor,
    daylight: Daylight,
    relit: bool,
    first_from_world: SE3,
    n_frames: usize,
}

impl World {
    /// Lays out the world of a seed and bakes its textures (about a second). `rounds` (at least 1) is how often the closed course is
    /// driven; an open street becomes longer by `rounds`.
    pub fn new(preset: Preset, seed: u64, rounds: u32) -> Self {
        Self::turning(preset, seed, rounds, SpotTurns::default())
    }

    /// [`World::new`] with turns on the spot.
    pub fn turning(preset: Preset, seed: u64, rounds: u32, turns: SpotTurns) -> Self {
        let rounds = rounds.max(1);
        let settings = preset.settings();
        let street_m = STREET_M * f64::from(rounds);
        let course = if settings.open { Course::street(seed, street_m) } else { Course::town(seed) };
        let length = if course.closed { course.length * f64::from(rounds) } else { street_m };
        let side_streets = town::side_streets(&course, &settings, seed);
        let (drive, halts) = plan_drive(&course, &side_streets, &settings, length, &turns, seed);
        let mut scene = Scene::default();
        let common = Common::new(&mut scene.recipes, seed as u32);
        town::build(&course, &side_streets, &settings, &common, &mut scene, seed);
        let plan = TrafficPlan {
            course: &course,
            drive: &drive,
            side_streets: &side_streets,
            settings: &settings,
            halts: &halts,
        };
        let traffic = Traffic::new(&plan, &mut scene, &common, seed);
        let shapes = Shapes { library: Library::bake(&scene.recipes.list), meshes: scene.meshes };
        let n_frames = (drive.duration() * FRAME_RATE_HZ).floor() as usize + 1;
        let first_from_world = drive.pose(&course, 0.0).inverse();
        Self {
            preset,
            seed,
            rounds,
            turns,
            course,
            drive,
            shapes,
            still: scene.instances,
            traffic,
            sensor: Sensor::new(seed),
            daylight: Daylight::steady(),
            relit: false,
            first_from_world,
            n_frames,
        }
    }

    /// The same world in other light in each round after the first: alternating between a low, strong sun from
    /// another side with hard contrast, and an overcast, hazy sky; exposure differs, too. Geometry, vehicles, depth
    /// and labels stay as they are. A world whose course is open or driven once keeps its light.
    pub fn relit(self) -> Self {
        let rounds = if self.course.closed { self.rounds } else { 1 };
        Self { daylight: Daylight::relit(self.seed, rounds, self.course.length), relit: true, ..self }
    }

    /// Whether rounds after the first have light of their own.
    pub fn is_relit(&self) -> bool {
        self.relit
    }

    /// Kind of world.
    pub fn preset(&self) -> Preset {
        self.preset
    }

    /// The seed that everything follows from.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// How often the course is driven.
    pub fn rounds(&self) -> u32 {
        self.rounds
    }

    /// Turns on the spot.
    pub fn turns(&self) -> &SpotTurns {
        &self.turns
    }

    /// Number of frames of the whole drive, 10 per second.
    pub fn n_frames(&self) -> usize {
        self.n_frames
    }

    /// Length of one round (of the whole street, if it is open), meters.
    pub fn course_length_m(&self) -> f64 {
        self.course.length
    }

    /// Whether a round ends where it began.
    pub fn is_closed(&self) -> bool {
        self.course.closed
    }

    /// The camera pair: KITTI's focal length and image size, 0.54 m apart, no distortion.
    pub fn rig(&self) -> StereoRig {
        StereoRig {
            camera: Pinhole { fx: 707.0912, fy: 707.0912, cx: 601.8873, cy: 183.1104 },
            baseline_m: 0.54,
        }
    }

    /// Image width and height, pixels.
    pub fn image_size(&self) -> (usize, usize) {
        (WIDTH, HEIGHT)
    }

    /// Time of frame `i`, seconds.
    pub fn timestamp_s(&self, i: usize) -> f64 {
        i as f64 / FRAME_RATE_HZ
    }

    /// Pose of the left camera at frame `i` in the frame of the first left camera.
    pub fn world_from_cam(&self, i: usize) -> SE3 {
        (self.first_from_world * self.drive.pose(&self.course, self.timestamp_s(i))).normalized()
    }

    /// Images, depth, labels and pose of frame `i`; beyond the drive's end the vehicle goes on at its last speed.
    pub fn frame(&self, i: usize) -> StereoFrame {
        let moment = self.moment(i);
        let (left, right) = rayon::join(
            || {
                let shot = self.sensor.shot(Eye::Left, i, moment.t, moment.light);
                render::picture_and_truth(&moment.views[0], &self.shapes, &moment.instances, &shot)
            },
            || self.picture(&moment, Eye::Right, i),
        );
        StereoFrame {
            left: left.0,
            right,
            depth_m: left.1.depth_m,
            labels: left.1.labels,
            world_from_cam: self.world_from_cam(i),
        }
    }

    /// The images of [`World::frame`] alone, which is a little faster.
    pub fn images(&self, i: usize) -> StereoImages {
        let moment = self.moment(i);
        let (left, right) =
            rayon::join(|| self.picture(&moment, Eye::Left, i), || self.picture(&moment, Eye::Right, i));
        StereoImages { left, right }
    }

    /// The world as raw cameras with lenses see it.
    pub fn lens_rig(&self, cameras: &[LensCamera; 2]) -> LensRig<'_> {
        LensRig { world: self, redrawings: [0, 1].map(|i| Redrawing::new(&cameras[i])) }
    }

    fn picture(&self, moment: &Moment, eye: Eye, i: usize) -> GrayImage {
        let shot = self.sensor.shot(eye, i, moment.t, moment.light);
        let view = &moment.views[usize::from(eye == Eye::Right)];
        render::picture(view, &self.shapes, &moment.instances, &shot)
    }

    fn moment(&self, i: usize) -> Moment {
        let t = self.timestamp_s(i);
        let world_from_cam = self.drive.pose(&self.course, t);
        let rig = self.rig();
        let view = |offset: f64| View {
            rotation: world_from_cam.rotation.matrix().transpose(),
            center: world_from_cam * V3::new(offset, 0.0, 0.0),
            camera: rig.camera,
        };
        let mut instances = self.still.clone();
        instances.extend(self.traffic.instances(&self.course, &self.drive, t));
        let light = self.daylight.at(self.drive.driven(t));
        Moment { t, views: [view(0.0), view(rig.baseline_m)], instances, light }
    }
}

/// A pair of raw cameras in a world.
#[derive(Clone, Debug)]
pub struct LensRig<'a> {
    world: &'a World,
    redrawings: [Redrawing; 2],
}

impl LensRig<'_> {
    /// Left and right raw image of frame `i`.
    pub fn images(&self, i: usize) -> [GrayImage; 2] {
        let world = self.world;
        let moment = world.moment(i);
        let world_from_rig = world.drive.pose(&world.course, moment.t);
        let image = |eye: Eye| {
            let shot = world.sensor.shot(eye, i, moment.t, moment.light);
            self.redrawings[usize::from(eye == Eye::Right)].image(&world_from_rig, |view, tile| {
                let shot = shot.of_tile(tile);
                render::picture(view, &world.shapes, &moment.instances, &shot)
            })
        };
        let (left, right) = rayon::join(|| image(Eye::Left), || image(Eye::Right));
        [left, right]
    }
}

/// The world at the time of a frame.
struct Moment {
    t: f64,
    /// Left and right camera.
    views: [View; 2],
    instances: Vec<Instance>,
    light: Light,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::town::{LABEL_MOVING, LABEL_PARKED};

    #[test]
    fn we_drive_through_no_vehicle() {
        let several = [(Preset::Busy, 1), (Preset::Crossing, 1), (Preset::Town, 2), (Preset::Jam, 1)];
        let others = [Preset::Lorry, Preset::Column, Preset::Trams].map(|preset| (preset, 1));
        for (preset, rounds) in several.into_iter().chain(others) {
            let world = World::new(preset, 2, rounds);
            let vehicles = [LABEL_MOVING, LABEL_PARKED];
            for i in 0..world.n_frames() {
                let moment = world.moment(i);
                for vehicle in moment.instances.iter().filter(|v| vehicles.contains(&v.label)) {
                    let offset = moment.views[0].center - vehicle.placement.position;
                    let eye = vehicle.placement.rotation().transpose() * offset;
                    let mesh = &world.shapes.meshes[vehicle.mesh as usize];
                    let reach = mesh.vertices.iter().fold(V3::zeros(), |reach, v| reach.sup(&v.abs()));
                    assert!(
                        eye.x.abs() > reach.x + 0.4 || eye.z.abs() > reach.z + 0.4,
                        "{preset} frame {i}: {eye:?} within {reach:?}, label {}",
                        vehicle.label
                    );
                }
            }
        }
    }
}

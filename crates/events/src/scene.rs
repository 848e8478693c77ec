//! What the records of a stream add up to: the state of the run as a viewer shows it.

use std::collections::BTreeMap;

use geometry::{SE3, Vec3};

use crate::align::Alignment;
use crate::blocks::{Dirty, KEYFRAMES_PER_BLOCK, PATH_PER_BLOCK, POINTS_PER_BLOCK};
use crate::map_delta::{GoneKeyframe, KeyframeUpdate, MapDelta, PointUpdate};
use crate::record::{End, FrameRecord, FrameState, Record, Start};

/// A frame and where it is now.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedFrame {
    /// Number of the frame.
    pub index: u32,
    /// Its outcome.
    pub state: FrameState,
    /// Its pose in the map as it is known now; `None` without a pose of its own.
    pub world_from_cam: Option<SE3>,
    /// Root of the sub-map of the pose.
    pub submap: Option<u32>,
    /// The keyframe that the pose follows, the pose relative to it and the scale for which it holds.
    follows: Option<(u32, SE3, f64)>,
}

/// The state of a run.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    start: Option<Start>,
    /// True positions by frame.
    truth: BTreeMap<u32, Vec3>,
    frames: BTreeMap<u32, PlacedFrame>,
    keyframes: BTreeMap<u32, KeyframeUpdate>,
    points: BTreeMap<u32, PointUpdate>,
    /// Frames by the keyframe that they follow.
    followers: BTreeMap<u32, Vec<u32>>,
    dirty: Dirty,
}

impl Scene {
    /// Adds a record. Images, features and texts are not part of the state.
    pub fn apply(&mut self, record: &Record) {
        match record {
            Record::Start(start) => {
                self.truth = start.truth.iter().map(|t| (t.frame, Vec3::from(t.position))).collect();
                self.start = Some(start.clone());
            }
            Record::Frame(frame) => self.add_frame(frame),
            Record::Map(delta) => self.change_map(delta),
            Record::End(end) => self.take_final(end),
            Record::Features(_)
            | Record::Image(_)
            | Record::Activation(_)
            | Record::Stages { .. }
            | Record::Text(_) => {}
        }
    }

    /// What was going to be run.
    pub fn start(&self) -> Option<&Start> {
        self.start.as_ref()
    }

    /// A frame.
    pub fn frame(&self, index: u32) -> Option<&PlacedFrame> {
        self.frames.get(&index)
    }

    /// Number of the newest frame.
    pub fn newest_frame(&self) -> Option<u32> {
        self.frames.keys().next_back().copied()
    }

    /// All keyframes, by id.
    pub fn keyframes(&self) -> &BTreeMap<u32, KeyframeUpdate> {
        &self.keyframes
    }

    /// Number of points.
    pub fn n_points(&self) -> usize {
        self.points.len()
    }

    /// The points of a block, by id.
    pub fn points_in(&self, block: u32) -> impl Iterator<Item = &PointUpdate> {
        self.points.range(range(block, POINTS_PER_BLOCK)).map(|(_, point)| point)
    }

    /// The keyframes of a block, by id.
    pub fn keyframes_in(&self, block: u32) -> impl Iterator<Item = &KeyframeUpdate> {
        self.keyframes.range(range(block, KEYFRAMES_PER_BLOCK)).map(|(_, keyframe)| keyframe)
    }

    /// Ends of the edges from the keyframes of a block to older ones, camera centers in meters.
    pub fn edges_in(&self, block: u32, older: impl Fn(&KeyframeUpdate) -> &[u32]) -> Vec<[Vec3; 2]> {
        let mut edges = Vec::new();
        for keyframe in self.keyframes_in(block) {
            let others = older(keyframe).iter().filter_map(|id| self.keyframes.get(id));
            edges.extend(others.map(|other| [center(keyframe), center(other)]));
        }
        edges
    }

    /// The path through the frames of a block and on to the next block's first frame; gaps and changes of the sub-map divide
    /// it.
    pub fn path_in(&self, block: u32) -> Vec<Vec<Vec3>> {
        let first = block.saturating_mul(PATH_PER_BLOCK);
        let frames = self.frames.range(first..=first.saturating_add(PATH_PER_BLOCK)).map(|(_, frame)| frame);
        let mut strips: Vec<Vec<Vec3>> = Vec::new();
        let mut last_submap = None;
        for frame in frames {
            let Some(pose) = &frame.world_from_cam else {
                last_submap = None;
                continue;
            };
            match strips.last_mut() {
                Some(strip) if last_submap == Some(frame.submap) => strip.push(pose.translation),
                _ => strips.push(vec![pose.translation]),
            }
            last_submap = Some(frame.submap);
        }
        strips
    }

    /// The alignment of the truth with all frames that have a pose, as they are now.
    pub fn alignment(&self) -> Option<Alignment> {
        let pairs: Vec<(Vec3, Vec3)> = self.compared().map(|(_, truth, found)| (truth, found)).collect();
        Alignment::of(&pairs, self.start.as_ref().is_some_and(|start| start.sensor.is_scale_free()))
    }

    /// The true path in the map's coordinates; missing frames divide it.
    pub fn true_path(&self, alignment: &Alignment) -> Vec<Vec<Vec3>> {
        let mut strips: Vec<Vec<Vec3>> = Vec::new();
        let mut last = None;
        for (&frame, truth) in &self.truth {
            let place = alignment.apply(truth);
            match strips.last_mut() {
                Some(strip) if last == frame.checked_sub(1) => strip.push(place),
                _ => strips.push(vec![place]),
            }
            last = Some(frame);
        }
        strips
    }

    /// Distance of each frame with a pose from the truth, meters, by frame.
    pub fn errors_m(&self, alignment: &Alignment) -> Vec<(u32, f64)> {
        let unit = alignment.meters_per_unit();
        self.compared()
            .map(|(f, truth, found)| (f, (alignment.apply(&truth) - found).norm() * unit))
            .collect()
    }

    /// Distance of a frame from the truth, meters; `None` without pose or true position.
    pub fn error_m(&self, alignment: &Alignment, frame: u32) -> Option<f64> {
        let found = self.frames.get(&frame)?.world_from_cam.as_ref()?.translation;
        let truth = alignment.apply(self.truth.get(&frame)?);
        Some((truth - found).norm() * alignment.meters_per_unit())
    }

    /// What has to be redrawn since the last call.
    pub fn take_dirty(&mut self) -> Dirty {
        std::mem::take(&mut self.dirty)
    }

    /// Frames with a pose and a true position.
    fn compared(&self) -> impl Iterator<Item = (u32, Vec3, Vec3)> {
        self.frames.values().filter_map(|frame| {
            let found = frame.world_from_cam.as_ref()?.translation;
            Some((frame.index, *self.truth.get(&frame.index)?, found))
        })
    }

    fn add_frame(&mut self, record: &FrameRecord) {
        let pose = record.pose.filter(|p| p.world_from_cam.is_valid() && p.cam_from_keyframe.is_valid());
        let follows = pose.and_then(|p| Some((p.keyframe?, SE3::from(&p.cam_from_keyframe), p.scale)));
        let frame = PlacedFrame {
            index: record.index,
            state: record.state,
            world_from_cam: pose.map(|p| SE3::from(&p.world_from_cam)),
            submap: None,
            follows,
        };
        self.frames.insert(record.index, frame);
        if let Some((keyframe, ..)) = follows {
            self.followers.entry(keyframe).or_default().push(record.index);
            self.place(record.index);
        }
        self.dirty.frame(record.index);
    }

    fn change_map(&mut self, delta: &MapDelta) {
        for update in &delta.points {
            self.points.insert(update.id, *update);
            self.dirty.point(update.id);
        }
        for id in &delta.gone_points {
            self.points.remove(id);
            self.dirty.point(*id);
        }
        for update in delta.keyframes.iter().filter(|update| update.cam_from_world.is_valid()) {
            if self.keyframes.insert(update.id, update.clone()).is_none() {
                self.becomes_keyframe(update);
            }
            self.dirty.keyframe(update.id);
            self.place_followers(update.id);
        }
        for gone in delta.gone_keyframes.iter().filter(|gone| gone.gone_from_heir.is_valid()) {
            self.keyframes.remove(&gone.id);
            self.dirty.keyframe(gone.id);
            self.hand_over(gone);
        }
        self.mark_edges(delta);
    }

    /// The pose of a frame that became a keyframe is the keyframe's.
    fn becomes_keyframe(&mut self, keyframe: &KeyframeUpdate) {
        let Some(frame) = self.frames.get_mut(&keyframe.frame) else { return };
        if !matches!(frame.state, FrameState::Tracked) {
            return;
        }
        if let Some((old, ..)) = frame.follows.replace((keyframe.id, SE3::identity(), keyframe.scale)) {
            self.followers.entry(old).or_default().retain(|index| *index != keyframe.frame);
        }
        self.followers.entry(keyframe.id).or_default().push(keyframe.frame);
    }

    /// Frames that followed a keyframe which is gone follow its heir.
    fn hand_over(&mut self, gone: &GoneKeyframe) {
        let gone_from_heir = SE3::from(&gone.gone_from_heir);
        for index in self.followers.remove(&gone.id).unwrap_or_default() {
            let Some(frame) = self.frames.get_mut(&index) else { continue };
            let Some((_, mut cam_from_gone, scale)) = frame.follows else { continue };
            cam_from_gone.translation *= gone.scales[0] / scale;
            frame.follows = Some((gone.heir, (cam_from_gone * gone_from_heir).normalized(), gone.scales[1]));
            self.followers.entry(gone.heir).or_default().push(index);
            self.place(index);
        }
    }

    fn place_followers(&mut self, keyframe: u32) {
        for index in self.followers.get(&keyframe).cloned().unwrap_or_default() {
            self.place(index);
        }
    }

    /// Puts a frame where the keyframe that it follows says, if that is known.
    fn place(&mut self, index: u32) {
        let Some(frame) = self.frames.get_mut(&index) else { return };
        let Some((id, mut cam_from_keyframe, scale)) = frame.follows else { return };
        let Some(keyframe) = self.keyframes.get(&id) else { return };
        cam_from_keyframe.translation *= keyframe.scale / scale;
        let keyframe_from_world = SE3::from(&keyframe.cam_from_world);
        frame.world_from_cam = Some((cam_from_keyframe * keyframe_from_world).normalized().inverse());
        frame.submap = Some(keyframe.submap);
        self.dirty.frame(index);
    }

    /// Edges end at keyframes of other blocks, too.
    fn mark_edges(&mut self, delta: &MapDelta) {
        let mut moved: Vec<u32> = delta.keyframes.iter().map(|k| k.id).collect();
        moved.extend(delta.gone_keyframes.iter().map(|k| k.id));
        moved.sort_unstable();
        for keyframe in self.keyframes.values() {
            let mut older = keyframe.covisible.iter().chain(&keyframe.loops).chain(&keyframe.parent);
            if older.any(|id| moved.binary_search(id).is_ok()) {
                self.dirty.edges.insert(keyframe.id / KEYFRAMES_PER_BLOCK);
            }
        }
    }

    fn take_final(&mut self, end: &End) {
        for pose in end.trajectory.iter().filter(|pose| pose.world_from_cam.is_valid()) {
            let Some(frame) = self.frames.get_mut(&pose.frame) else { continue };
            frame.world_from_cam = Some(SE3::from(&pose.world_from_cam));
            frame.submap = pose.submap;
            frame.follows = None;
            self.dirty.frame(pose.frame);
        }
        self.followers.clear();
    }
}

fn range(block: u32, size: u32) -> std::ops::Range<u32> {
    let first = block.saturating_mul(size);
    first..first.saturating_add(size)
}

/// Camera center of a keyframe, meters.
fn center(keyframe: &KeyframeUpdate) -> Vec3 {
    SE3::from(&keyframe.cam_from_world).center()
}

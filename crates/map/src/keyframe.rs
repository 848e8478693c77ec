//! A frame that the map keeps, with its pose and its place in the graphs.

use std::sync::Arc;

use features::Frame;
use geometry::{SE3, Vec3};

use crate::{KeyframeId, PointId};

/// A keyframe: immutable features, a pose, and relations that only the map changes.
#[derive(Clone)]
pub struct Keyframe {
    /// Its name in the map.
    pub id: KeyframeId,
    /// The features; never change, but for their places when the camera is calibrated anew.
    pub frame: Arc<Frame>,
    /// Pose, meters, `point_cam = cam_from_world * point_world`.
    pub cam_from_world: SE3,
    /// Revision of the map that the insertion led to.
    pub inserted_at: u64,
    /// Product of the scales of all corrections since the insertion.
    pub(crate) scale: f64,
    /// Shared on its own, so that a change of a relation does not copy the table.
    pub(crate) points: Arc<Vec<Option<PointId>>>,
    pub(crate) covisible: Vec<(KeyframeId, u32)>,
    pub(crate) parent: Option<KeyframeId>,
    pub(crate) children: Vec<KeyframeId>,
    pub(crate) loop_edges: Vec<KeyframeId>,
}

impl Keyframe {
    pub(crate) fn new(id: KeyframeId, frame: Arc<Frame>, cam_from_world: SE3, inserted_at: u64) -> Self {
        let points = Arc::new(vec![None; frame.len()]);
        Keyframe {
            id,
            frame,
            cam_from_world,
            inserted_at,
            scale: 1.0,
            points,
            covisible: Vec::new(),
            parent: None,
            children: Vec::new(),
            loop_edges: Vec::new(),
        }
    }

    /// The point that each feature observes, by feature index.
    pub fn points(&self) -> &[Option<PointId>] {
        &self.points
    }

    /// The point that a feature observes; `None` also beyond the last feature.
    pub fn point_at(&self, feature: u32) -> Option<PointId> {
        self.points.get(feature as usize).copied().flatten()
    }

    /// Parent in the spanning tree; `None` for the root of a sub-map only.
    pub fn parent(&self) -> Option<KeyframeId> {
        self.parent
    }

    /// Children in the spanning tree, in order of their ids.
    pub fn children(&self) -> &[KeyframeId] {
        &self.children
    }

    /// Keyframes that a closed loop joins to this one, in order of their ids.
    pub fn loop_edges(&self) -> &[KeyframeId] {
        &self.loop_edges
    }

    /// Every keyframe that shares a point, with the number of shared points, the highest number first, ties by id.
    pub fn covisible(&self) -> &[(KeyframeId, u32)] {
        &self.covisible
    }

    /// The first `n` of [`covisible`](Self::covisible), or all if there are fewer.
    pub fn best_covisible(&self, n: usize) -> &[(KeyframeId, u32)] {
        &self.covisible[..n.min(self.covisible.len())]
    }

    /// Those of [`covisible`](Self::covisible) that share at least `weight` points.
    pub fn covisible_at_least(&self, weight: u32) -> &[(KeyframeId, u32)] {
        let n = self.covisible.partition_point(|&(_, w)| w >= weight);
        &self.covisible[..n]
    }

    /// Number of points shared with another keyframe, 0 if none.
    pub fn shared_points(&self, other: KeyframeId) -> u32 {
        self.covisible.iter().find(|(k, _)| *k == other).map_or(0, |(_, w)| *w)
    }

    /// Camera center in the world, meters.
    pub fn center(&self) -> Vec3 {
        self.cam_from_world.center()
    }

    pub(crate) fn set_point(&mut self, feature: u32, point: Option<PointId>) {
        Arc::make_mut(&mut self.points)[feature as usize] = point;
    }
}

/// Adds an id to a sorted list of ids, once.
pub(crate) fn insert_sorted(list: &mut Vec<KeyframeId>, id: KeyframeId) {
    if let Err(at) = list.binary_search(&id) {
        list.insert(at, id);
    }
}

/// Takes an id out of a sorted list of ids.
pub(crate) fn remove_sorted(list: &mut Vec<KeyframeId>, id: KeyframeId) {
    if let Ok(at) = list.binary_search(&id) {
        list.remove(at);
    }
}

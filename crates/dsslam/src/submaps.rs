//! Sub-maps of a run. Poses of different ones are in unrelated coordinate frames, so every result keeps them apart: files and figures of
//! the whole run are those of the largest one, and each of several has its own beside them.

use std::borrow::Cow;

use map::KeyframeId;
use runtime::FrameRecord;

use crate::trajectories::own_pose;

/// A sub-map, as the frames of a run know it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Submap {
    /// The root of its keyframes, which names it; `None` where frames do not tell.
    pub root: Option<KeyframeId>,
    /// Frames that have a pose in it.
    pub tracked: usize,
}

/// The sub-maps in which frames have a pose, the one with the most frames first, of equals the one that was seen first.
pub fn submaps(records: &[FrameRecord]) -> Vec<Submap> {
    let mut found: Vec<Submap> = Vec::new();
    for record in records.iter().filter(|record| own_pose(record).is_some()) {
        match found.iter_mut().find(|submap| submap.root == record.submap) {
            Some(submap) => submap.tracked += 1,
            None => found.push(Submap { root: record.submap, tracked: 1 }),
        }
    }
    found.sort_by_key(|submap| std::cmp::Reverse(submap.tracked));
    found
}

/// All frames of a run, with the poses of its largest sub-map only.
pub fn of_largest(records: &[FrameRecord]) -> Cow<'_, [FrameRecord]> {
    match submaps(records)[..] {
        [] | [_] => Cow::Borrowed(records),
        [largest, ..] => Cow::Owned(keep(records, largest)),
    }
}

/// The frames from the first to the last that have a pose in this sub-map, with the poses of this one only.
pub fn of_submap(records: &[FrameRecord], submap: Submap) -> Vec<FrameRecord> {
    let is_inside = |record: &FrameRecord| own_pose(record).is_some() && record.submap == submap.root;
    let first = records.iter().position(is_inside).unwrap_or(records.len());
    let end = records.iter().rposition(is_inside).map_or(first, |last| last + 1);
    keep(&records[first..end], submap)
}

fn keep(records: &[FrameRecord], submap: Submap) -> Vec<FrameRecord> {
    let kept = |record: &FrameRecord| FrameRecord {
        world_from_cam: record.world_from_cam.filter(|_| record.submap == submap.root),
        ..record.clone()
    };
    records.iter().map(kept).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trajectories::{pose_per_frame, tracked_poses};
    use geometry::{SE3, SO3, Vec3};
    use runtime::{FrameStatus, Unusable};

    /// Frames at x = their number, each in the sub-map of this root; `None`: dropped.
    fn records(roots: &[Option<u32>]) -> Vec<FrameRecord> {
        let record = |(index, root): (u32, &Option<u32>)| {
            let status = match root {
                Some(_) => FrameStatus::Tracked { inliers: 50 },
                None => FrameStatus::Dropped(Unusable::Skipped),
            };
            let x = f64::from(index);
            let pose = SE3::new(SO3::identity(), Vec3::new(x, 0.0, 0.0));
            FrameRecord { submap: root.map(KeyframeId), ..FrameRecord::new(index, x, status, Some(pose)) }
        };
        (0..).zip(roots).map(record).collect()
    }

    /// A covered camera started a new sub-map, which was glued to the last pose: the path went on, 13 m off.
    #[test]
    fn poses_of_different_sub_maps_never_stand_in_one_trajectory() {
        let all = records(&[Some(0), Some(0), None, Some(7), Some(7), Some(7), None, Some(0)]);
        let found = submaps(&all);
        let sizes: Vec<(u32, usize)> = found.iter().map(|s| (s.root.unwrap().0, s.tracked)).collect();
        assert_eq!(sizes, [(0, 3), (7, 3)], "of equals the first");
        let all = &all[..7];
        assert_eq!(submaps(all)[0].tracked, 3);
        let largest = of_largest(all);
        assert_eq!(largest.len(), all.len());
        let x =
            |t: io::Trajectory| t.poses.iter().map(|p| p.world_from_cam.translation.x).collect::<Vec<_>>();
        assert_eq!(x(tracked_poses(&largest)), [3.0, 4.0, 5.0]);
        assert_eq!(x(pose_per_frame(&largest)), [0.0, 0.0, 0.0, 3.0, 4.0, 5.0, 5.0], "a row per frame");
        let other = of_submap(all, submaps(all)[1]);
        assert_eq!(x(tracked_poses(&other)), [0.0, 1.0]);
        assert_eq!(other.len(), 2, "from its first to its last frame");
    }

    #[test]
    fn a_run_in_one_piece_stays_as_it_is() {
        let all = records(&[None, Some(3), Some(3), None]);
        assert!(matches!(of_largest(&all), Cow::Borrowed(_)));
        assert_eq!(submaps(&all).len(), 1);
        assert_eq!(submaps(&all[..1]), []);
    }
}

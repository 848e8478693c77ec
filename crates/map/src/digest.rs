//! `digest`: one number for the whole content of a map, to compare maps bit for bit.

use features::{Frame, Rig, ScaleLevels};
use geometry::{Distortion, Pinhole, SE3, Vec3};

use crate::ids::Id;
use crate::{ClosedLoop, Keyframe, KeyframeId, Map, MapPoint, PointId};

/// FNV-1a over 64-bit words, with a final shift so that high bits reach low ones.
struct Hasher(u64);

impl Hasher {
    fn word(&mut self, word: u64) {
        self.0 = (self.0 ^ word).wrapping_mul(0x0000_0100_0000_01b3);
        self.0 ^= self.0 >> 29;
    }

    fn float(&mut self, x: f64) {
        self.word(x.to_bits());
    }

    fn vector(&mut self, v: &Vec3) {
        v.iter().for_each(|&x| self.float(x));
    }

    fn pose(&mut self, pose: &SE3) {
        pose.rows_3x4().iter().for_each(|&x| self.float(x));
    }

    /// `None` and every id have words of their own.
    fn id<I: Id>(&mut self, id: Option<I>) {
        self.word(id.map_or(0, |i| i.index() as u64 + 1));
    }

    fn keyframe_ids(&mut self, ids: &[KeyframeId]) {
        self.word(ids.len() as u64);
        ids.iter().for_each(|&k| self.id(Some(k)));
    }

    fn floats(&mut self, values: &[f32]) {
        self.word(values.len() as u64);
        values.iter().for_each(|x| self.word(u64::from(x.to_bits())));
    }

    fn rig(&mut self, rig: &Rig) {
        let Pinhole { fx, fy, cx, cy } = rig.stereo.camera;
        let Distortion { k1, k2, p1, p2, k3 } = rig.distortion;
        [fx, fy, cx, cy, rig.stereo.baseline_m, k1, k2, p1, p2, k3].into_iter().for_each(|x| self.float(x));
        [rig.width, rig.height].into_iter().for_each(|side| self.word(side as u64));
    }

    fn frame(&mut self, frame: &Frame) {
        self.word(u64::from(frame.index));
        self.float(frame.timestamp_s);
        self.rig(&frame.rig);
        let ScaleLevels { factor, scales, sigma_sq, inv_sigma_sq } = &*frame.scales;
        self.float(f64::from(*factor));
        [scales, sigma_sq, inv_sigma_sq].into_iter().for_each(|v| self.floats(v));
        self.word(frame.len() as u64);
        for k in &frame.keypoints {
            let bits = [k.x, k.y, k.angle_deg, k.response].map(|x| u64::from(x.to_bits()));
            bits.into_iter().chain([u64::from(k.octave)]).for_each(|w| self.word(w));
        }
        frame.descriptors.iter().flat_map(|d| d.0).for_each(|w| self.word(w));
        [&frame.right_u, &frame.depth, &frame.activation, &frame.lasting]
            .into_iter()
            .for_each(|v| self.floats(v));
    }

    fn keyframe(&mut self, keyframe: &Keyframe) {
        self.id(Some(keyframe.id));
        self.frame(&keyframe.frame);
        self.pose(&keyframe.cam_from_world);
        self.float(keyframe.scale);
        keyframe.points().iter().for_each(|&p| self.id(p));
        self.word(keyframe.covisible().len() as u64);
        for &(k, weight) in keyframe.covisible() {
            self.id(Some(k));
            self.word(u64::from(weight));
        }
        self.id(keyframe.parent());
        self.keyframe_ids(keyframe.children());
        self.keyframe_ids(keyframe.loop_edges());
    }

    fn point(&mut self, point: &MapPoint) {
        self.id(Some(point.id));
        self.vector(&point.position);
        point.descriptor.0.iter().for_each(|&w| self.word(w));
        self.vector(&point.normal);
        self.float(point.min_distance_m);
        self.float(point.max_distance_m);
        self.id(Some(point.reference));
        self.id(Some(point.created_by));
        self.word(u64::from(point.seen));
        self.word(u64::from(point.found));
        self.word(u64::from(point.belief as u32));
        self.word(point.observations().len() as u64);
        for o in point.observations() {
            self.id(Some(o.keyframe));
            self.word(u64::from(o.feature));
        }
    }

    fn closed_loop(&mut self, closed: &ClosedLoop) {
        self.keyframe_ids(&[closed.matched, closed.keyframe, closed.next]);
        self.keyframe_ids(&closed.visit);
        self.keyframe_ids(&closed.near);
        self.word(closed.before.len() as u64);
        for (id, cam_from_world, scale) in &closed.before {
            self.id(Some(*id));
            self.pose(cam_from_world);
            self.float(*scale);
        }
    }
}

impl Map {
    /// A 64-bit hash of everything in the map but the revision numbers: equal maps have equal digests on every
    /// machine, and a difference in a single bit changes it (but for accidents of probability 2^-64).
    pub fn digest(&self) -> u64 {
        let mut h = Hasher(0xcbf2_9ce4_8422_2325);
        h.keyframe_ids(self.roots());
        h.id(Some(self.next_keyframe_id()));
        for i in 0..self.keyframes.len() {
            let id = KeyframeId::from_index(i);
            if let Some(keyframe) = self.keyframe(id) {
                h.keyframe(keyframe);
            } else if let Some(removed) = self.keyframes.forward(id) {
                h.id(Some(removed.parent));
                h.pose(&removed.removed_from_parent);
                h.float(removed.scale);
            } else {
                h.word(0);
            }
        }
        h.id(Some(self.next_point_id()));
        for i in 0..self.points.len() {
            let id = PointId::from_index(i);
            match self.point(id) {
                Some(point) => h.point(point),
                None => h.id(self.points.forward(id).copied()),
            }
        }
        self.loops.iter().for_each(|closed| h.closed_loop(closed));
        h.0
    }
}

//! Points of the map as a cloud, each as bright as it was in the newest image that showed it.

use bag::out::CloudPoint;
use map::{KeyframeId, Map, MapPoint, PointId};
use runtime::FrameDetails;

/// The brightness of a point that no image has shown.
const UNSEEN: u8 = 128;

/// Brightness by the ids of points.
#[derive(Debug, Default)]
pub(super) struct Shades(Vec<Option<u8>>);

impl Shades {
    /// Looks at the points that agree with the pose of a frame.
    pub(super) fn see(&mut self, details: &FrameDetails) {
        let Some(images) = &details.images else { return };
        for &(feature, PointId(id)) in &details.inliers {
            // Features are where they would be without the lens.
            let place = details.frame.rig.distort(&details.frame.pixel(feature as usize));
            let [x, y] = [place.x.round().max(0.0) as usize, place.y.round().max(0.0) as usize];
            let image = &images.image;
            if x >= image.width || y >= image.height {
                continue;
            }
            let id = id as usize;
            if self.0.len() <= id {
                self.0.resize(id + 1, None);
            }
            self.0[id] = Some(image.data[y * image.width + x]);
        }
    }

    /// The points of a sub-map, in the order of their ids.
    pub(super) fn cloud<'a>(
        &'a self,
        map: &'a Map,
        submap: Option<KeyframeId>,
    ) -> impl Iterator<Item = CloudPoint> + 'a {
        let is_inside = move |point: &&MapPoint| map.submap_of(point.reference) == submap;
        map.points().filter(is_inside).map(move |point| {
            let shade = self.0.get(point.id.0 as usize).copied().flatten().unwrap_or(UNSEEN);
            super::results::cloud_point(map, point, [shade; 3])
        })
    }
}

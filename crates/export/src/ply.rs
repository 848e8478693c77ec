//! Points as PLY (binary, little-endian), which every viewer of point clouds reads.

use draw::Color;
use geometry::Vec3;

use crate::scene::Scene;

/// The axes of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlyFrame {
    /// Those of the map: x right, y down, z forward at the first frame.
    Map,
    /// nerfstudio's, z up: (x, z, -y) of the map.
    ZUp,
}

impl PlyFrame {
    /// A position of the map in these axes.
    pub(crate) fn of(self, position: &Vec3) -> Vec3 {
        match self {
            Self::Map => *position,
            Self::ZUp => Vec3::new(position.x, position.z, -position.y),
        }
    }
}

/// The bytes of a PLY file: position in meters (32-bit), color, number of observations, error in pixels.
///
/// # Panics
/// When the number of colors is not that of the points.
pub fn ply(scene: &Scene, colors: &[Color], axes: PlyFrame) -> Vec<u8> {
    assert_eq!(scene.points.len(), colors.len(), "a color per point");
    let header = format!(
        "ply\nformat binary_little_endian 1.0\ncomment DSSLAM, meters\nelement vertex {}\n\
         property float x\nproperty float y\nproperty float z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\n\
         property ushort observations\nproperty float error_px\nend_header\n",
        scene.points.len()
    );
    let mut bytes = header.into_bytes();
    for (point, color) in scene.points.iter().zip(colors) {
        axes.of(&point.position).iter().for_each(|&value| bytes.extend((value as f32).to_le_bytes()));
        bytes.extend(color);
        bytes.extend(u16::try_from(point.track.len()).unwrap_or(u16::MAX).to_le_bytes());
        bytes.extend((point.error_px as f32).to_le_bytes());
    }
    bytes
}

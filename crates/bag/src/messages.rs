//! The messages that are read here.

use geometry::{SE3, SO3, Vec3};

use crate::wire::{Decoded, Decoder, Wire};

/// A `sensor_msgs/CameraInfo`.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraInfo {
    /// Width and height, pixels.
    pub size: (u32, u32),
    /// `plumb_bob`, `rational_polynomial`, `equidistant`.
    pub model: String,
    /// Coefficients of the distortion.
    pub d: Vec<f64>,
    /// Intrinsics of the raw image, row by row.
    pub k: [f64; 9],
    /// Rotation into the rectified camera, row by row.
    pub r: [f64; 9],
    /// Projection of the rectified camera, row by row.
    pub p: [f64; 12],
}

/// A pose of a child frame in a parent frame.
#[derive(Clone, Debug, PartialEq)]
pub struct StampedTransform {
    /// Nanoseconds.
    pub t_ns: i64,
    /// The frame that the pose is in.
    pub parent: String,
    /// The frame whose pose it is.
    pub child: String,
    /// The pose `parent_from_child`.
    pub pose: SE3,
}

/// A `sensor_msgs/Image`, its data borrowed.
pub(crate) struct RawImage<'a> {
    pub(crate) height: u32,
    pub(crate) width: u32,
    pub(crate) encoding: String,
    pub(crate) is_big_endian: bool,
    /// Bytes from a row to the next.
    pub(crate) step: u32,
    pub(crate) data: &'a [u8],
}

/// A `sensor_msgs/CompressedImage`, its data borrowed.
pub(crate) struct PackedImage<'a> {
    pub(crate) format: String,
    pub(crate) data: &'a [u8],
}

/// The stamp of a message that begins with a header, nanoseconds.
pub(crate) fn header_stamp(bytes: &[u8], wire: Wire) -> Decoded<i64> {
    Ok(Decoder::new(bytes, wire)?.header()?.0)
}

impl<'a> RawImage<'a> {
    pub(crate) fn of(bytes: &'a [u8], wire: Wire) -> Decoded<Self> {
        let mut of = Decoder::new(bytes, wire)?;
        of.header()?;
        let (height, width, encoding) = (of.u32()?, of.u32()?, of.text()?);
        let (is_big_endian, step) = (of.u8()? != 0, of.u32()?);
        Ok(RawImage { height, width, encoding, is_big_endian, step, data: of.bytes()? })
    }
}

impl<'a> PackedImage<'a> {
    pub(crate) fn of(bytes: &'a [u8], wire: Wire) -> Decoded<Self> {
        let mut of = Decoder::new(bytes, wire)?;
        of.header()?;
        Ok(PackedImage { format: of.text()?, data: of.bytes()? })
    }
}

impl CameraInfo {
    pub(crate) fn of(bytes: &[u8], wire: Wire) -> Decoded<Self> {
        let mut of = Decoder::new(bytes, wire)?;
        of.header()?;
        let (height, width, model) = (of.u32()?, of.u32()?, of.text()?);
        Ok(CameraInfo {
            size: (width, height),
            model,
            d: of.counted()?,
            k: of.numbers()?,
            r: of.numbers()?,
            p: of.numbers()?,
        })
    }
}

/// Position and rotation (x, y, z, w).
fn pose(of: &mut Decoder<'_>) -> Decoded<SE3> {
    let [x, y, z] = of.numbers()?;
    let [i, j, k, w]: [f64; 4] = of.numbers()?;
    let quaternion = nalgebra::Quaternion::new(w, i, j, k);
    if !(0.5..2.0).contains(&quaternion.norm()) || ![x, y, z].iter().all(|v| v.is_finite()) {
        return Err(format!("a pose with the quaternion {i} {j} {k} {w}"));
    }
    let rotation = SO3::from_quaternion(&geometry::Quaternion::from_quaternion(quaternion));
    Ok(SE3::new(rotation, Vec3::new(x, y, z)))
}

/// The pose of an Odometry or PoseStamped message; the child is empty where the message does not name it.
pub(crate) fn stamped_pose(bytes: &[u8], wire: Wire, has_child: bool) -> Decoded<StampedTransform> {
    transform(&mut Decoder::new(bytes, wire)?, has_child)
}

fn transform(of: &mut Decoder<'_>, has_child: bool) -> Decoded<StampedTransform> {
    let (t_ns, parent) = of.header()?;
    let child = if has_child { of.text()? } else { String::new() };
    Ok(StampedTransform { t_ns, parent, child, pose: pose(of)? })
}

/// The transforms of a TFMessage.
pub(crate) fn transforms(bytes: &[u8], wire: Wire) -> Decoded<Vec<StampedTransform>> {
    let mut of = Decoder::new(bytes, wire)?;
    let n = of.u32()?;
    (0..n).map(|_| transform(&mut of, true)).collect()
}

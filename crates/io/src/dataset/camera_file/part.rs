//! Parts that several formats share: intrinsics, image sizes, rigid motions, rates.

use geometry::{Mat3, Mat4, Pinhole, SE3, SO3, Vec3, Vec4};

use super::{DatasetError, FileCamera};
use crate::document::{Field, listed};
use crate::file::counted;
use crate::images::ImageSize;

pub(super) const SIZE: &str = "width and height in pixels, each from 1 to 65535";
pub(super) const FOCAL: &str = "a focal length above 0 px";
pub(super) const NUMBER: &str = "a number";
pub(super) const POSE: &str = "16 numbers (a rigid motion as a 4x4 matrix, row by row)";

/// Focal lengths and principal point out of a list of four; fy may be negative, as renderers have it whose y axis points up.
pub(super) fn pinhole(field: &Field<'_>, expected: &str) -> Result<Pinhole, DatasetError> {
    let [fx, fy, cx, cy] = field.exactly(expected)?;
    if fx > 0.0 && fy != 0.0 {
        return Ok(Pinhole { fx, fy, cx, cy });
    }
    Err(field.error(listed(&[fx, fy, cx, cy]), expected))
}

/// Focal lengths and principal point out of four fields.
pub(super) fn pinhole_of_fields([fx, fy, cx, cy]: [&Field<'_>; 4]) -> Result<Pinhole, DatasetError> {
    fx.need(FOCAL)?;
    let vertical = fy.number(FOCAL)?;
    if vertical == 0.0 {
        return Err(fy.wrong(FOCAL));
    }
    Ok(Pinhole { fx: fx.positive(FOCAL)?, fy: vertical, cx: cx.number(NUMBER)?, cy: cy.number(NUMBER)? })
}

/// Focal lengths and principal point of a 3x3 matrix without skew.
pub(super) fn pinhole_of_matrix(field: &Field<'_>) -> Result<Pinhole, DatasetError> {
    const EXPECTED: &str = "9 numbers (fx 0 cx 0 fy cy 0 0 1)";
    let matrix: [f64; 9] = field.exactly(EXPECTED)?;
    let [fx, skew, cx, zero, fy, cy, r0, r1, r2] = matrix;
    if fx > 0.0 && fy > 0.0 && [skew, zero, r0, r1] == [0.0; 4] && r2 == 1.0 {
        return Ok(Pinhole { fx, fy, cx, cy });
    }
    Err(field.error(listed(&matrix), EXPECTED))
}

/// Width and height out of a list.
pub(super) fn size(field: &Field<'_>) -> Result<ImageSize, DatasetError> {
    let [width, height] = field.exactly(SIZE)?;
    let fits = |side: f64| side.fract() == 0.0 && (1.0..=65535.0).contains(&side);
    if fits(width) && fits(height) {
        return Ok(ImageSize { width: width as usize, height: height as usize });
    }
    Err(field.error(listed(&[width, height]), SIZE))
}

/// Width and height out of two fields, if they are there.
pub(super) fn size_of_fields(
    width: &Field<'_>,
    height: &Field<'_>,
) -> Result<Option<ImageSize>, DatasetError> {
    if !width.is_there() && !height.is_there() {
        return Ok(None);
    }
    let side = |field: &Field<'_>| {
        const EXPECTED: &str = "pixels, from 1 to 65535";
        let value = field.number(EXPECTED)?;
        let fits = value.fract() == 0.0 && (1.0..=65535.0).contains(&value);
        if fits { Ok(value as usize) } else { Err(field.wrong(EXPECTED)) }
    };
    Ok(Some(ImageSize { width: side(width)?, height: side(height)? }))
}

/// A rigid motion out of 12 or 16 numbers, row by row; its rotation is made exact.
pub(super) fn rigid(field: &Field<'_>, expected: &str) -> Result<SE3, DatasetError> {
    let mut data = field.numbers(expected)?;
    if data.len() == 12 {
        data.extend([0.0, 0.0, 0.0, 1.0]);
    }
    if data.len() != 16 {
        return Err(field.error(counted(data.len(), "number"), expected));
    }
    let m = Mat4::from_row_slice(&data);
    let last = (m.row(3) - Vec4::w().transpose()).amax();
    let rotation = m.fixed_view::<3, 3>(0, 0).into_owned();
    motion(field, &rotation, m.fixed_view::<3, 1>(0, 3).into_owned(), last, expected)
}

/// A rotation matrix, row by row, made exact.
pub(super) fn rotation(field: &Field<'_>) -> Result<SO3, DatasetError> {
    const EXPECTED: &str = "9 numbers (a rotation, row by row)";
    let rows: [f64; 9] = field.exactly(EXPECTED)?;
    motion(field, &Mat3::from_row_slice(&rows), Vec3::zeros(), 0.0, EXPECTED).map(|pose| pose.rotation)
}

fn motion(
    field: &Field<'_>,
    given: &Mat3,
    translation: Vec3,
    off: f64,
    expected: &str,
) -> Result<SE3, DatasetError> {
    /// Files keep four digits or more; a larger deviation is not due to rounding.
    const TOLERANCE: f64 = 0.01;
    let rotation = SO3::from_matrix(given);
    let deviation = (rotation.matrix() - given).amax().max(off);
    if deviation > TOLERANCE {
        let found = format!("a matrix that is {deviation:.3} from a rigid motion");
        return Err(field.error(found, expected));
    }
    Ok(SE3::new(rotation, translation))
}

/// Numbers of fields; 0 where there is none.
pub(super) fn or_zero<const N: usize>(fields: [Field<'_>; N]) -> Result<[f64; N], DatasetError> {
    let mut numbers = [0.0; N];
    for (number, field) in numbers.iter_mut().zip(&fields) {
        *number = field.optional(NUMBER)?.unwrap_or(0.0);
    }
    Ok(numbers)
}

/// Images per second, if the field is there.
pub(super) fn rate(field: &Field<'_>) -> Result<Option<f64>, DatasetError> {
    field.if_there(|field| field.positive("images per second, above 0"))
}

/// Value of a depth image at one meter, if the field is there. Programs that compute with meters write 1 or its inverse.
pub(super) fn depth_units(field: &Field<'_>) -> Result<Option<f64>, DatasetError> {
    field.if_there(|field| field.positive("the value of a depth image at one meter, above 0"))
}

/// The right camera of a pair that OpenCV has rectified: x_rect = R x for each camera, and the right projection matrix, whose fourth
/// number is minus the focal length times the baseline.
pub(super) fn place_right(
    left_turn: SO3,
    right: &mut FileCamera,
    right_turn: SO3,
    right_projection: &Field<'_>,
) -> Result<(), DatasetError> {
    const EXPECTED: &str = "12 numbers (fx' 0 cx' Tx 0 fy' cy' Ty 0 0 1 0) with Tx below 0";
    let p: [f64; 12] = right_projection.exactly(EXPECTED)?;
    if !(p[0] > 0.0 && p[3] < 0.0) {
        return Err(right_projection.error(format!("fx' = {} and Tx = {}", p[0], p[3]), EXPECTED));
    }
    // The rectified right camera stands at -Tx / fx' on the x axis of the rectified left one.
    let left_from_right = SE3::new(left_turn.inverse(), Vec3::zeros())
        * SE3::new(SO3::identity(), Vec3::new(-p[3] / p[0], 0.0, 0.0))
        * SE3::new(right_turn, Vec3::zeros());
    right.body_from_cam = left_from_right;
    Ok(())
}

//! OpenCV's camera models and stereo rectification, for comparison.

use geometry::{CameraModel, Distortion, GrayImage, KannalaBrandt, Mat3, Rational, SE3, SO3, Vec2, Vec3};
use opencv::core::{self, Mat, Point2d, Point3d, Rect, Size, Vector};
use opencv::prelude::*;
use opencv::{Result, calib3d, imgproc};

/// What OpenCV's `stereoRectify` returns.
#[derive(Clone, Debug)]
pub(crate) struct Rectification {
    /// Turn of the first camera (`R1`).
    pub(crate) rectified_from_left: Mat3,
    /// Turn of the second camera (`R2`).
    pub(crate) rectified_from_right: Mat3,
    /// Projection matrix of the first rectified camera, row by row (`P1`).
    pub(crate) left: [f64; 12],
    /// Projection matrix of the second rectified camera, row by row (`P2`).
    pub(crate) right: [f64; 12],
}

/// `stereoRectify` with zero disparity and alpha 0 for images of `(width, height)` pixels.
pub(crate) fn stereo_rectify(
    left: &CameraModel,
    right: &CameraModel,
    (width, height): (usize, usize),
    right_from_left: &SE3,
) -> Result<Rectification> {
    let size = Size::new(i32::try_from(width)?, i32::try_from(height)?);
    let [mut r1, mut r2, mut p1, mut p2, mut q] = std::array::from_fn(|_| Mat::default());
    let (mut roi1, mut roi2) = (Rect::default(), Rect::default());
    calib3d::stereo_rectify(
        &camera_matrix(left)?,
        &coefficients(left)?,
        &camera_matrix(right)?,
        &coefficients(right)?,
        size,
        &matrix(right_from_left.rotation.matrix())?,
        &Mat::from_slice_2d(&right_from_left.translation.as_slice().chunks(1).collect::<Vec<_>>())?,
        &mut r1,
        &mut r2,
        &mut p1,
        &mut p2,
        &mut q,
        calib3d::CALIB_ZERO_DISPARITY,
        0.0,
        Size::default(),
        Some(&mut roi1),
        Some(&mut roi2),
    )?;
    let turn = |m: &Mat| -> Result<Mat3> { Ok(Mat3::from_row_slice(m.data_typed::<f64>()?)) };
    let rows = |m: &Mat| -> Result<[f64; 12]> {
        let values = m.data_typed::<f64>()?;
        Ok(std::array::from_fn(|i| values[i]))
    };
    Ok(Rectification {
        rectified_from_left: turn(&r1)?,
        rectified_from_right: turn(&r2)?,
        left: rows(&p1)?,
        right: rows(&p2)?,
    })
}

/// The raw pixels of points in camera coordinates.
pub(crate) fn project(model: &CameraModel, points_cam: &[Vec3]) -> Result<Vec<Vec2>> {
    let points: Vector<Point3d> = points_cam.iter().map(|p| Point3d::new(p.x, p.y, p.z)).collect();
    let zero = Mat::zeros(3, 1, core::CV_64F)?.to_mat()?;
    let (camera, lens) = (camera_matrix(model)?, coefficients(model)?);
    let mut pixels = Vector::<Point2d>::new();
    let mut jacobian = Mat::default();
    match model {
        CameraModel::Pinhole { .. } | CameraModel::Rational(_) => {
            calib3d::project_points(&points, &zero, &zero, &camera, &lens, &mut pixels, &mut jacobian, 0.0)?;
        }
        CameraModel::KannalaBrandt(_) => {
            calib3d::fisheye_project_points_vec(
                &points,
                &mut pixels,
                &zero,
                &zero,
                &camera,
                &lens,
                0.0,
                &mut jacobian,
            )?;
        }
    }
    Ok(pixels.iter().map(|p| Vec2::new(p.x, p.y)).collect())
}

/// The maps of `initUndistortRectifyMap`: for each pixel of the target the x and the y of its source, row by row.
pub(crate) fn rectify_maps(
    model: &CameraModel,
    rectified_from_cam: &SO3,
    target: &geometry::Pinhole,
    (width, height): (usize, usize),
) -> Result<[Vec<f32>; 2]> {
    let size = Size::new(i32::try_from(width)?, i32::try_from(height)?);
    let (camera, lens) = (camera_matrix(model)?, coefficients(model)?);
    let (turn, target) = (matrix(rectified_from_cam.matrix())?, matrix(&target.matrix())?);
    let (mut x, mut y) = (Mat::default(), Mat::default());
    match model {
        CameraModel::Pinhole { .. } | CameraModel::Rational(_) => calib3d::init_undistort_rectify_map(
            &camera,
            &lens,
            &turn,
            &target,
            size,
            core::CV_32FC1,
            &mut x,
            &mut y,
        )?,
        CameraModel::KannalaBrandt(_) => calib3d::fisheye_init_undistort_rectify_map(
            &camera,
            &lens,
            &turn,
            &target,
            size,
            core::CV_32FC1,
            &mut x,
            &mut y,
        )?,
    }
    Ok([x.data_typed::<f32>()?.to_vec(), y.data_typed::<f32>()?.to_vec()])
}

/// OpenCV's bilinear `remap` with black outside; the maps have one entry per pixel of the target.
pub(crate) fn remap(
    image: &GrayImage,
    maps: &[Vec<f32>; 2],
    (width, height): (usize, usize),
) -> Result<GrayImage> {
    let (rows, cols) = (i32::try_from(height)?, i32::try_from(width)?);
    let x = Mat::new_rows_cols_with_data(rows, cols, &maps[0])?;
    let y = Mat::new_rows_cols_with_data(rows, cols, &maps[1])?;
    let mut target = Mat::default();
    imgproc::remap(
        &Mat::new_rows_cols_with_data(
            i32::try_from(image.height)?,
            i32::try_from(image.width)?,
            &image.data,
        )?,
        &mut target,
        &x,
        &y,
        imgproc::INTER_LINEAR,
        core::BORDER_CONSTANT,
        core::Scalar::default(),
    )?;
    Ok(GrayImage { width, height, data: target.data_bytes()?.to_vec() })
}

fn matrix(m: &Mat3) -> Result<Mat> {
    let rows: Vec<Vec<f64>> = m.row_iter().map(|row| row.iter().copied().collect()).collect();
    Mat::from_slice_2d(&rows)
}

fn camera_matrix(model: &CameraModel) -> Result<Mat> {
    matrix(&model.pinhole().matrix())
}

/// The lens in OpenCV's order: k1 k2 p1 p2 k3, or k1 k2 k3 k4 of a fisheye.
fn coefficients(model: &CameraModel) -> Result<Mat> {
    match *model {
        CameraModel::Pinhole { distortion: Distortion { k1, k2, p1, p2, k3 }, .. } => {
            Mat::from_slice_2d(&[[k1, k2, p1, p2, k3]])
        }
        CameraModel::KannalaBrandt(KannalaBrandt { k1, k2, k3, k4, .. }) => {
            Mat::from_slice_2d(&[[k1], [k2], [k3], [k4]])
        }
        CameraModel::Rational(Rational {
            upper: Distortion { k1, k2, p1, p2, k3 },
            lower: [k4, k5, k6],
            ..
        }) => Mat::from_slice_2d(&[[k1, k2, p1, p2, k3, k4, k5, k6]]),
    }
}

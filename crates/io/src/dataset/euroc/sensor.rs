//! `sensor.yaml` of an EuRoC camera: resolution, intrinsics, lens, pose in the body.

use std::path::{Path, PathBuf};

use geometry::{CameraModel, Distortion, KannalaBrandt, Pinhole, SE3, SO3};
use serde::Deserialize;
use serde_saphyr::Spanned;

use super::super::{DatasetError, RawCamera};
use crate::file::{TextFile, counted, shown};
use crate::images::ImageSize;

const LENSES: &str = "radial-tangential, equidistant or none";

/// The fields of the file that are read; all are needed.
#[derive(Deserialize)]
struct Document {
    #[serde(rename = "T_BS")]
    pose: Option<Spanned<Pose>>,
    resolution: Option<Spanned<Vec<u64>>>,
    camera_model: Option<Spanned<String>>,
    intrinsics: Option<Spanned<Vec<f64>>>,
    distortion_model: Option<Spanned<String>>,
    distortion_coefficients: Option<Spanned<Vec<f64>>>,
}

/// A 4 by 4 matrix, row by row.
#[derive(Deserialize)]
struct Pose {
    data: Vec<f64>,
}

/// Makes errors of one file.
struct Fields {
    path: PathBuf,
}

/// Reads the camera of a `sensor.yaml`.
///
/// # Errors
/// [`DatasetError`] naming the field, what was found and what was expected.
pub(super) fn read(path: &Path) -> Result<RawCamera, DatasetError> {
    let file = TextFile::read(path, "the calibration of a camera (EuRoC)")?;
    let document: Document = serde_saphyr::from_str(file.text()).map_err(|error| {
        let line = error.location().map_or(0, |location| location.line());
        let message = error.without_snippet().to_string();
        DatasetError::Yaml { path: path.to_path_buf(), line, message }
    })?;
    let fields = Fields { path: path.to_path_buf() };
    let camera_model = fields.need("camera_model", document.camera_model, "pinhole")?;
    if camera_model.value != "pinhole" {
        return Err(fields.wrong("camera_model", &camera_model, shown(&camera_model.value), "pinhole"));
    }
    let [fx, fy, cx, cy] =
        fields.numbers("intrinsics", document.intrinsics, "4 numbers (fu, fv, cu, cv in pixels)", |v| {
            v[0] > 0.0 && v[1] > 0.0
        })?;
    let lens = fields.need("distortion_model", document.distortion_model, LENSES)?;
    let coefficients = document.distortion_coefficients;
    Ok(RawCamera {
        model: fields.model(Pinhole { fx, fy, cx, cy }, &lens, coefficients)?,
        size: fields.size(document.resolution)?,
        body_from_cam: fields.pose(document.pose)?,
    })
}

impl Fields {
    /// The error of a field, with its line where it is there.
    fn error(&self, field: &str, line: Option<u64>, found: String, expected: &str) -> DatasetError {
        DatasetError::Field {
            path: self.path.clone(),
            line: line.map_or_else(String::new, |line| format!(":{line}")),
            field: field.to_string(),
            found,
            expected: expected.to_string(),
        }
    }

    fn wrong<T>(&self, field: &str, value: &Spanned<T>, found: String, expected: &str) -> DatasetError {
        self.error(field, Some(value.referenced.line()), found, expected)
    }

    fn need<T>(&self, field: &str, value: Option<T>, expected: &str) -> Result<T, DatasetError> {
        value.ok_or_else(|| self.error(field, None, "nothing".to_string(), expected))
    }

    /// A list of `N` finite numbers that is valid.
    fn numbers<const N: usize>(
        &self,
        field: &str,
        value: Option<Spanned<Vec<f64>>>,
        expected: &str,
        is_valid: impl Fn(&[f64; N]) -> bool,
    ) -> Result<[f64; N], DatasetError> {
        let value = self.need(field, value, expected)?;
        let Ok(numbers) = <[f64; N]>::try_from(value.value.as_slice()) else {
            return Err(self.wrong(field, &value, counted(value.value.len(), "number"), expected));
        };
        let finite = numbers.iter().all(|v| v.is_finite());
        let found = format!("{numbers:?}");
        if finite && is_valid(&numbers) {
            Ok(numbers)
        } else {
            Err(self.wrong(field, &value, found, expected))
        }
    }

    fn model(
        &self,
        camera: Pinhole,
        lens: &Spanned<String>,
        coefficients: Option<Spanned<Vec<f64>>>,
    ) -> Result<CameraModel, DatasetError> {
        const FIELD: &str = "distortion_coefficients";
        match lens.value.as_str() {
            "radial-tangential" | "radtan" => {
                let third = coefficients.as_ref().filter(|c| c.value.len() == 5).map(|c| c.value[4]);
                let four = coefficients.map(|mut c| {
                    if third.is_some() {
                        c.value.truncate(4);
                    }
                    c
                });
                let [k1, k2, p1, p2] =
                    self.numbers(FIELD, four, "4 or 5 finite numbers (k1, k2, p1, p2, k3)", |_| {
                        third.is_none_or(f64::is_finite)
                    })?;
                Ok(CameraModel::Pinhole {
                    camera,
                    distortion: Distortion { k1, k2, p1, p2, k3: third.unwrap_or(0.0) },
                })
            }
            "equidistant" => {
                let [k1, k2, k3, k4] =
                    self.numbers(FIELD, coefficients, "4 finite numbers (k1, k2, k3, k4)", |_| true)?;
                Ok(CameraModel::KannalaBrandt(KannalaBrandt { camera, k1, k2, k3, k4 }))
            }
            "none" => Ok(CameraModel::Pinhole { camera, distortion: Distortion::default() }),
            other => Err(self.wrong("distortion_model", lens, shown(other), LENSES)),
        }
    }

    fn size(&self, resolution: Option<Spanned<Vec<u64>>>) -> Result<ImageSize, DatasetError> {
        const EXPECTED: &str = "width and height in pixels, each from 1 to 65535";
        let value = self.need("resolution", resolution, EXPECTED)?;
        match value.value[..] {
            [width @ 1..=65535, height @ 1..=65535] => {
                Ok(ImageSize { width: width as usize, height: height as usize })
            }
            _ => Err(self.wrong("resolution", &value, format!("{:?}", value.value), EXPECTED)),
        }
    }

    /// `T_BS`, whose rotation is made exact.
    fn pose(&self, pose: Option<Spanned<Pose>>) -> Result<SE3, DatasetError> {
        /// Files keep four digits or more; a wider deviation is no rounding.
        const TOLERANCE: f64 = 0.01;
        const EXPECTED: &str = "16 numbers (a rigid motion as a 4x4 matrix, row by row)";
        let pose = self.need("T_BS", pose, EXPECTED)?;
        let data = &pose.value.data;
        if data.len() != 16 {
            return Err(self.wrong("T_BS", &pose, counted(data.len(), "number"), EXPECTED));
        }
        if !data.iter().all(|v| v.is_finite()) {
            return Err(self.wrong("T_BS", &pose, "a number that is not finite".to_string(), EXPECTED));
        }
        let m = geometry::Mat4::from_row_slice(data);
        let given = m.fixed_view::<3, 3>(0, 0).into_owned();
        let deviation = (SO3::from_matrix(&given).matrix() - given).amax();
        let last = m.row(3) - geometry::Vec4::w().transpose();
        if deviation > TOLERANCE || last.amax() > TOLERANCE {
            let found = format!("a matrix that is {:.3} from a rigid motion", deviation.max(last.amax()));
            return Err(self.wrong("T_BS", &pose, found, EXPECTED));
        }
        Ok(SE3::new(SO3::from_matrix(&given), m.fixed_view::<3, 1>(0, 3).into_owned()))
    }
}

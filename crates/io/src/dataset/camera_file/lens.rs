//! Lens models under the names that they have in calibration files.

use geometry::{CameraModel, Distortion, KannalaBrandt, Pinhole, Rational};

use super::DatasetError;
use crate::document::Field;
use crate::file::{counted, shown};

/// What is read, for messages.
pub(super) const MODELS: &str = "pinhole-radtan (also radtan, radial-tangential, plumb_bob, opencv), rational_polynomial, \
                                 kannala-brandt (also equidistant, fisheye, opencv_fisheye) or none";

const RADTAN: &str = "4 or 5 finite numbers (k1, k2, p1, p2, k3), or 8 (also k4, k5, k6)";
const FISHEYE: &str = "4 finite numbers (k1, k2, k3, k4)";

/// The kinds of lens.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Lens {
    /// No distortion; coefficients must be 0 or missing.
    None,
    /// A pinhole: with the coefficients that are there, if there are any.
    Pinhole,
    /// Radial and tangential; eight coefficients make it rational.
    Radtan,
    /// Kannala and Brandt.
    Fisheye,
}

/// The kind of lens that a name stands for.
pub(super) fn named(name: &str) -> Option<Lens> {
    let plain: String = name.to_ascii_lowercase().replace(['_', ' '], "-");
    let plain = plain.strip_prefix("pinhole-").unwrap_or(&plain);
    Some(match plain {
        "none" | "rectified" | "no-distortion" | "distortion.none" => Lens::None,
        "pinhole" | "perspective" | "" => Lens::Pinhole,
        "radtan"
        | "radtan4"
        | "radtan5"
        | "radtan8"
        | "radial-tangential"
        | "radialtangential"
        | "plumb-bob"
        | "opencv"
        | "brown"
        | "brown-conrady"
        | "distortion.brown-conrady"
        | "rational-polynomial"
        | "rational"
        | "full-opencv"
        | "standard" => Lens::Radtan,
        "kannala-brandt"
        | "kannalabrandt"
        | "kannala-brandt4"
        | "kannala-brandt8"
        | "kannalabrandt8"
        | "equidistant"
        | "equi"
        | "equi4"
        | "fisheye"
        | "opencv-fisheye"
        | "kb4"
        | "kb8"
        | "distortion.kannala-brandt4" => Lens::Fisheye,
        _ => return None,
    })
}

/// The kind of lens that a field names, if it is there.
///
/// # Errors
/// [`DatasetError`] for an unknown name.
pub(super) fn in_field(name: &Field<'_>) -> Result<Option<Lens>, DatasetError> {
    if !name.is_there() {
        return Ok(None);
    }
    let word = name.text(MODELS)?;
    named(word).map(Some).ok_or_else(|| name.error(shown(word), MODELS))
}

/// The camera of a lens that is called by `name` and has these coefficients.
///
/// # Errors
/// [`DatasetError`] for an unknown name, and for coefficients that it does not have.
pub(super) fn model(
    camera: Pinhole,
    name: &Field<'_>,
    coefficients: &Field<'_>,
) -> Result<CameraModel, DatasetError> {
    name.need(MODELS)?;
    of(camera, in_field(name)?.unwrap_or(Lens::None), coefficients)
}

/// The camera of a known lens.
///
/// # Errors
/// [`DatasetError`] for coefficients that it does not have.
pub(super) fn of(camera: Pinhole, lens: Lens, coefficients: &Field<'_>) -> Result<CameraModel, DatasetError> {
    let ideal = CameraModel::Pinhole { camera, distortion: Distortion::default() };
    match lens {
        Lens::Pinhole | Lens::None if !coefficients.is_there() => Ok(ideal),
        Lens::None => {
            let given = coefficients.numbers("nothing, since the model is none")?;
            if given.iter().all(|&k| k == 0.0) {
                return Ok(ideal);
            }
            let found = counted(given.len(), "number");
            Err(coefficients.error(found, "nothing, since the model is none"))
        }
        Lens::Pinhole | Lens::Radtan => {
            let given = coefficients.numbers(RADTAN)?;
            radtan(camera, &given).ok_or_else(|| coefficients.error(counted(given.len(), "number"), RADTAN))
        }
        Lens::Fisheye => {
            let given = coefficients.numbers(FISHEYE)?;
            fisheye(camera, &given).ok_or_else(|| coefficients.error(counted(given.len(), "number"), FISHEYE))
        }
    }
}

/// OpenCV's order `k1, k2, p1, p2, k3, k4, k5, k6`; further terms (thin prism, tilt) only where they are 0, and no number at all
/// for no lens.
pub(super) fn radtan(camera: Pinhole, given: &[f64]) -> Option<CameraModel> {
    let is_complete = matches!(given.len(), 0 | 4 | 5 | 8 | 12 | 14);
    if !is_complete || given.iter().skip(8).any(|&k| k != 0.0) {
        return None;
    }
    let k = |i: usize| given.get(i).copied().unwrap_or(0.0);
    let upper = Distortion { k1: k(0), k2: k(1), p1: k(2), p2: k(3), k3: k(4) };
    let lower = [k(5), k(6), k(7)];
    Some(if lower == [0.0; 3] {
        CameraModel::Pinhole { camera, distortion: upper }
    } else {
        CameraModel::Rational(Rational { camera, upper, lower })
    })
}

/// Four numbers; some programs write a fifth that is 0.
pub(super) fn fisheye(camera: Pinhole, given: &[f64]) -> Option<CameraModel> {
    let &[k1, k2, k3, k4, ref rest @ ..] = given else { return None };
    let model = CameraModel::KannalaBrandt(KannalaBrandt { camera, k1, k2, k3, k4 });
    (rest.len() < 2 && rest.iter().all(|&k| k == 0.0)).then_some(model)
}

//! BoofCV's `stereo_params.xml`: two pinholes with radial (and tangential) distortion, and the way from right to left.

use geometry::{CameraModel, Distortion, Mat3, Pinhole, SE3, SO3, Vec3};
use roxmltree::{Document, Node};

use super::super::{DatasetError, RawCamera};
use super::CameraFile;
use crate::file::{FileError, TextFile, counted, shown};
use crate::images::ImageSize;

/// The outermost element of the file.
const ROOT: &str = "boofcv.struct.calib.StereoParameters";

/// A piece of the file.
#[derive(Clone, Copy)]
struct Element<'a> {
    file: &'a TextFile,
    node: Node<'a, 'a>,
}

/// Reads a stereo calibration of BoofCV.
///
/// # Errors
/// [`DatasetError`] naming the line, what was found and what was expected.
pub(super) fn read(file: &TextFile) -> Result<CameraFile, DatasetError> {
    let line = |line: u32, found: String, expected: &str| FileError::Line {
        path: file.path.clone(),
        line: line as usize,
        found,
        expected: expected.to_string(),
    };
    let document = Document::parse(file.text())
        .map_err(|error| line(error.pos().row, format!("invalid XML ({error})"), "a calibration in XML"))?;
    let root = Element { file, node: document.root_element() };
    if root.node.tag_name().name() != ROOT {
        return Err(root.error(format!("<{}>", root.node.tag_name().name()), &format!("<{ROOT}>")).into());
    }
    let left = root.child("left")?.camera()?;
    let right = root.child("right")?.camera()?;
    let left_from_right = root.child("rightToLeft")?.motion()?;
    let right = RawCamera { body_from_cam: left_from_right, ..right };
    Ok(CameraFile {
        path: file.path.clone(),
        cameras: vec![left, right],
        frame_rate_hz: None,
        right_fields: ("right", "rightToLeft"),
    })
}

impl<'a> Element<'a> {
    fn error(&self, found: String, expected: &str) -> FileError {
        FileError::Line {
            path: self.file.path.clone(),
            line: self.node.document().text_pos_at(self.node.range().start).row as usize,
            found,
            expected: expected.to_string(),
        }
    }

    fn find(&self, name: &str) -> Option<Self> {
        let node = self.node.children().find(|child| child.has_tag_name(name))?;
        Some(Self { node, ..*self })
    }

    fn child(&self, name: &str) -> Result<Self, FileError> {
        let parent = self.node.tag_name().name();
        self.find(name).ok_or_else(|| self.error(format!("no <{name}> in <{parent}>"), "one"))
    }

    fn number(&self) -> Result<f64, FileError> {
        let text = self.node.text().unwrap_or("").trim();
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(self.error(format!("{} in <{}>", shown(text), self.node.tag_name().name()), "a number")),
        }
    }

    fn value(&self, name: &str) -> Result<f64, FileError> {
        self.child(name)?.number()
    }

    /// The value of a child that may be missing.
    fn value_or_zero(&self, name: &str) -> Result<f64, FileError> {
        self.find(name).map_or(Ok(0.0), |child| child.number())
    }

    /// The numbers in `<double>` elements.
    fn numbers(&self) -> Result<Vec<f64>, FileError> {
        let doubles = self.node.children().filter(|child| child.has_tag_name("double"));
        doubles.map(|node| Self { node, ..*self }.number()).collect()
    }

    fn camera(&self) -> Result<RawCamera, FileError> {
        let side = |name: &str| -> Result<usize, FileError> {
            let element = self.child(name)?;
            let value = element.number()?;
            let fits = value.fract() == 0.0 && (1.0..=65535.0).contains(&value);
            fits.then_some(value as usize)
                .ok_or_else(|| element.error(format!("{name} {value}"), "pixels, from 1 to 65535"))
        };
        let focal = |name: &str| -> Result<f64, FileError> {
            let element = self.child(name)?;
            let value = element.number()?;
            let expected = "a focal length above 0 px";
            if value > 0.0 { Ok(value) } else { Err(element.error(format!("{name} {value}"), expected)) }
        };
        if self.value_or_zero("skew")? != 0.0 {
            return Err(self.child("skew")?.error("a skew".to_string(), "0"));
        }
        let camera =
            Pinhole { fx: focal("fx")?, fy: focal("fy")?, cx: self.value("cx")?, cy: self.value("cy")? };
        let radial = self.find("radial").map_or(Ok(Vec::new()), |element| element.numbers())?;
        if radial.len() > 3 {
            let element = self.child("radial")?;
            return Err(element.error(counted(radial.len(), "radial coefficient"), "at most 3"));
        }
        let k = |i: usize| radial.get(i).copied().unwrap_or(0.0);
        let distortion = Distortion {
            k1: k(0),
            k2: k(1),
            p1: self.value_or_zero("t1")?,
            p2: self.value_or_zero("t2")?,
            k3: k(2),
        };
        let size = ImageSize { width: side("width")?, height: side("height")? };
        let model = CameraModel::Pinhole { camera, distortion };
        Ok(RawCamera { model, size, body_from_cam: SE3::identity() })
    }

    /// A rotation, row by row, and a translation.
    fn motion(&self) -> Result<SE3, FileError> {
        /// As for the matrices of other calibration files.
        const TOLERANCE: f64 = 0.01;
        let element = self.child("r")?.child("data")?;
        let rows = element.numbers()?;
        if rows.len() != 9 {
            return Err(element.error(counted(rows.len(), "number"), "9 numbers (a rotation, row by row)"));
        }
        let given = Mat3::from_row_slice(&rows);
        let rotation = SO3::from_matrix(&given);
        let deviation = (rotation.matrix() - given).amax();
        if deviation > TOLERANCE {
            let found = format!("a matrix that is {deviation:.3} from a rotation");
            return Err(element.error(found, "a rotation, row by row"));
        }
        let t = self.child("t")?;
        Ok(SE3::new(rotation, Vec3::new(t.value("x")?, t.value("y")?, t.value("z")?)))
    }
}

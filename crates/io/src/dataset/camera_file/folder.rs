//! A folder in the place of a calibration file: that of a EuRoC recording, whose two cameras have a file each, or one with a calibration
//! under its usual name.

use std::path::Path;

use super::{CameraFile, DatasetError, find, read_calibration};

/// Reads the calibration of a folder: `cam0/sensor.yaml`, with `cam1/sensor.yaml` where it is there, in the folder or in its `mav0`.
///
/// # Errors
/// [`DatasetError`] for a folder without one, and for a file that cannot be read.
pub(super) fn read(folder: &Path) -> Result<CameraFile, DatasetError> {
    let roots = [folder.join("mav0"), folder.to_path_buf()];
    let [left, right] = ["cam0/sensor.yaml", "cam1/sensor.yaml"];
    let Some(root) = roots.into_iter().find(|root| root.join(left).is_file()) else {
        return match find(folder) {
            Some(file) => read_calibration(&file),
            None => Err(DatasetError::unexpected(
                folder,
                "a folder without a calibration",
                format!("one of these calibrations: a file, or a folder with {left} and {right}"),
            )),
        };
    };
    let mut cameras = read_calibration(&root.join(left))?;
    if root.join(right).is_file() {
        cameras.cameras.extend(read_calibration(&root.join(right))?.cameras);
        cameras.right_fields = ("resolution", "T_BS");
    }
    Ok(cameras)
}

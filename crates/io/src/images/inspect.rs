//! A look at the headers of a sequence's images before the run: what will be done to them, and what cannot be used at all.

use image::ColorType;

use super::decode::kind;
use super::depth::{Form, UNITS_OF_METERS, form};
use super::{ImageError, image_size};
use crate::dataset::{FrameSource, Sequence};

/// Tells of 16-bit images, sets the scale of depth in meters, and refuses depth images that cannot be used: where neither those of
/// the first nor of the last frame with images can be.
///
/// # Errors
/// [`ImageError`] of the first depth image.
pub(crate) fn inspect(sequence: &mut Sequence) -> Result<(), ImageError> {
    let readable = |frame: &&FrameSource| image_size(&frame.left).is_ok();
    let (first, last) = (sequence.frames.iter().find(readable), sequence.frames.iter().rfind(readable));
    let Some((first, last)) = first.zip(last) else { return Ok(()) };
    if let Ok((_, ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16)) =
        kind(&first.left)
    {
        sequence.warnings.push(format!(
            "{}: 16 bits per channel, which are reduced to 8 (from 12 bits where no value needs more)",
            first.left.display()
        ));
    }
    let Some(found) = depth_of(first).or_else(|_| depth_of(last)).or_else(|_| depth_of(first))? else {
        return Ok(());
    };
    if found == Form::Meters {
        sequence.depth_units_per_metre = Some(UNITS_OF_METERS);
        sequence
            .warnings
            .push(format!("{}: depth in meters", first.depth.as_deref().unwrap_or(&first.left).display()));
    }
    Ok(())
}

/// The form of a frame's depth image, if it has one that is there; its size must be that of the color image.
fn depth_of(frame: &FrameSource) -> Result<Option<Form>, ImageError> {
    let Some(path) = &frame.depth else { return Ok(None) };
    let (size, form) = match form(path) {
        // A missing file is a matter of its frame.
        Err(ImageError::Missing { .. }) => return Ok(None),
        found => found?,
    };
    let expected = image_size(&frame.left)?;
    if size == expected {
        return Ok(Some(form));
    }
    let because = format!("as {}; depth must be registered to the color image", frame.left.display());
    Err(ImageError::wrong_size(path, size, expected, &because))
}

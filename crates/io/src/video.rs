//! Videos as streams of raw images (YUV4MPEG2, "Y4M"): a line that describes the stream, then each frame with a line before it. A
//! program that decodes other formats writes such a stream into a pipe; with a last line `XEND ...` it may say why it ends.

use std::io::{BufRead, Read};

use geometry::GrayImage;

use crate::file::shown;
use crate::images::ImageSize;

const MAGIC: &str = "YUV4MPEG2";
const EXPECTED: &str =
    "a line such as `YUV4MPEG2 W640 H480 F30:1 Cmono` (width, height, frame rate; C: mono, 420, 422 or 444)";
/// Neither line is longer in any stream that a program writes.
const LONGEST_LINE: u64 = 512;
/// A broken line must not make the program ask for more memory than there is.
const LONGEST_SIDE_PX: usize = 16_384;

/// Why a stream gives no (further) frame.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum VideoError {
    /// It does not begin as a stream should.
    #[error("{name}: found {found}, expected {EXPECTED}")]
    Header {
        /// The stream.
        name: String,
        /// Its first line.
        found: String,
    },
    /// The next frame does not begin as a frame should.
    #[error("{name}: found {found} at the start of frame {frame}, expected a line with FRAME")]
    FrameLine {
        /// The stream.
        name: String,
        /// Number of the frame, from 0.
        frame: usize,
        /// What stands there.
        found: String,
    },
    /// The stream ends within a frame.
    #[error("{name}: ends in the middle of frame {frame}: found {found} of {expected} bytes")]
    EndsInFrame {
        /// The stream.
        name: String,
        /// Number of the frame, from 0.
        frame: usize,
        /// Bytes that are there.
        found: usize,
        /// Bytes of a frame.
        expected: usize,
    },
    /// The program that writes the stream says why it ends.
    #[error("{name}: ends {reason}")]
    Told {
        /// The stream.
        name: String,
        /// Where and why, in the program's words.
        reason: String,
    },
    /// The operating system failed to read it.
    #[error("{name}: frame {frame} cannot be read: {reason}")]
    Unreadable {
        /// The stream.
        name: String,
        /// Number of the frame, from 0.
        frame: usize,
        /// The reason given by the operating system.
        reason: String,
    },
}

/// What the first line of a stream tells.
#[derive(Clone, Debug, PartialEq)]
pub struct VideoHeader {
    /// Size of all frames.
    pub size: ImageSize,
    /// Frames per second, where the stream tells.
    pub frame_rate_hz: Option<f64>,
    /// Bytes of color behind the gray values of a frame.
    color_bytes: usize,
}

/// One frame.
#[derive(Clone, Debug, PartialEq)]
pub struct VideoFrame {
    /// Gray values.
    pub image: GrayImage,
    /// Seconds, where the frame tells (`XT`, DSSLAM's own).
    pub timestamp_s: Option<f64>,
}

/// Takes frames from a stream, one after another.
#[derive(Debug)]
pub struct VideoReader<R> {
    stream: R,
    name: String,
    header: VideoHeader,
    next: usize,
}

impl<R: BufRead> VideoReader<R> {
    /// Reads the first line of a stream, which errors call `name`.
    ///
    /// # Errors
    /// [`VideoError::Header`].
    pub fn new(mut stream: R, name: &str) -> Result<Self, VideoError> {
        let refused = |found: String| VideoError::Header { name: name.to_string(), found };
        let line = read_line(&mut stream).map_err(|error| refused(error.to_string()))?;
        let Some(line) = line else { return Err(refused("no data".to_string())) };
        let text = String::from_utf8_lossy(&line).trim_end().to_string();
        let header = parse_header(&text).ok_or_else(|| refused(shown(&text)))?;
        Ok(Self { stream, name: name.to_string(), header, next: 0 })
    }

    /// What the first line told.
    pub fn header(&self) -> &VideoHeader {
        &self.header
    }

    /// The next frame, `None` at the end.
    ///
    /// # Errors
    /// [`VideoError`] naming the frame; after one the stream is of no use.
    pub fn next_frame(&mut self) -> Result<Option<VideoFrame>, VideoError> {
        let (name, frame) = (self.name.clone(), self.next);
        let unreadable = |error: std::io::Error| VideoError::Unreadable {
            name: name.clone(),
            frame,
            reason: error.to_string(),
        };
        let Some(line) = read_line(&mut self.stream).map_err(unreadable)? else { return Ok(None) };
        let text = String::from_utf8_lossy(&line).trim_end().to_string();
        let mut fields = text.split(' ');
        let ImageSize { width, height } = self.header.size;
        let expected = width * height + self.header.color_bytes;
        if let Some(reason) = text.strip_prefix("XEND ") {
            return Err(VideoError::Told { name, reason: reason.to_string() });
        }
        if fields.next() != Some("FRAME") || !line.ends_with(b"\n") {
            let ends = !line.ends_with(b"\n") && b"FRAME".starts_with(&line[..line.len().min(5)]);
            return Err(match ends {
                true => VideoError::EndsInFrame { name, frame, found: 0, expected },
                false => VideoError::FrameLine { name, frame, found: shown(&text) },
            });
        }
        let timestamp_s = fields.filter_map(|field| field.strip_prefix("XT")?.parse().ok()).next();
        let mut data = Vec::with_capacity(expected);
        let bytes = (&mut self.stream).take(expected as u64).read_to_end(&mut data);
        let found = bytes.map_err(unreadable)?;
        if found < expected {
            return Err(VideoError::EndsInFrame { name, frame, found, expected });
        }
        data.truncate(width * height);
        self.next += 1;
        Ok(Some(VideoFrame { image: GrayImage { width, height, data }, timestamp_s }))
    }
}

/// A line with its end; without it when it is too long or the stream ends; `None` at the end of the stream.
fn read_line(stream: &mut impl BufRead) -> std::io::Result<Option<Vec<u8>>> {
    let mut line = Vec::new();
    stream.take(LONGEST_LINE).read_until(b'\n', &mut line)?;
    Ok(Some(line).filter(|line| !line.is_empty()))
}

fn parse_header(line: &str) -> Option<VideoHeader> {
    let mut fields = line.split(' ');
    if fields.next() != Some(MAGIC) {
        return None;
    }
    let (mut width, mut height, mut frame_rate_hz, mut color) = (None, None, None, "420");
    for field in fields.filter(|field| !field.is_empty()) {
        let (tag, value) = field.split_at_checked(1)?;
        match tag {
            "W" => width = Some(value.parse::<usize>().ok()?),
            "H" => height = Some(value.parse::<usize>().ok()?),
            "F" => frame_rate_hz = parse_rate(value)?,
            "C" => color = value,
            _ => {}
        }
    }
    let size = ImageSize { width: width?, height: height? };
    let fits = |side: usize| (1..=LONGEST_SIDE_PX).contains(&side);
    if !fits(size.width) || !fits(size.height) {
        return None;
    }
    let (half_width, half_height) = (size.width.div_ceil(2), size.height.div_ceil(2));
    // 420 has variants that differ in where color is sampled; more than 8 bits are written as `420p10` and the like.
    let color_bytes = match color {
        "mono" => 0,
        "420" | "420jpeg" | "420mpeg2" | "420paldv" => 2 * half_width * half_height,
        "422" => 2 * half_width * size.height,
        "444" => 2 * size.width * size.height,
        _ => return None,
    };
    Some(VideoHeader { size, frame_rate_hz, color_bytes })
}

/// A rate `30000:1001`; `0:0` stands for an unknown one.
fn parse_rate(value: &str) -> Option<Option<f64>> {
    let (numerator, denominator) = value.split_once(':')?;
    let (numerator, denominator): (u32, u32) = (numerator.parse().ok()?, denominator.parse().ok()?);
    let known = numerator > 0 && denominator > 0;
    Some(known.then(|| f64::from(numerator) / f64::from(denominator)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reader(stream: &[u8]) -> Result<VideoReader<&[u8]>, VideoError> {
        VideoReader::new(stream, "clip.y4m")
    }

    fn stream(header: &str, frames: &[&[u8]]) -> Vec<u8> {
        let mut stream = format!("{header}\n").into_bytes();
        frames.iter().for_each(|frame| stream.extend_from_slice(frame));
        stream
    }

    #[test]
    fn gray_frames_with_and_without_times() {
        let frames: [&[u8]; 2] = [b"FRAME XT0.25\nabcdef", b"FRAME\nghi\njk"];
        let stream = stream("YUV4MPEG2 W3 H2 F30000:1001 Ip A1:1 Cmono XN7", &frames);
        let mut reader = reader(&stream).unwrap();
        let header = reader.header().clone();
        assert_eq!(header.size.to_string(), "3x2");
        assert!((header.frame_rate_hz.unwrap() - 29.97).abs() < 1e-3);
        let first = reader.next_frame().unwrap().unwrap();
        assert_eq!((first.timestamp_s, first.image.at(0, 1)), (Some(0.25), b'd'));
        let second = reader.next_frame().unwrap().unwrap();
        assert_eq!((second.timestamp_s, &second.image.data[..]), (None, &b"ghi\njk"[..]));
        assert_eq!(reader.next_frame(), Ok(None));
    }

    #[test]
    fn color_is_skipped() {
        for (color, n_bytes) in [("C420jpeg", 4), ("C422", 8), ("C444", 12), ("", 4)] {
            let frame =
                [&b"FRAME\nabcdef"[..], &vec![0; n_bytes], &b"FRAME\nABCDEF"[..], &vec![0; n_bytes]].concat();
            let stream = stream(&format!("YUV4MPEG2 W3 H2 F0:0 {color}"), &[&frame]);
            let mut reader = reader(&stream).unwrap();
            assert_eq!(reader.header().frame_rate_hz, None);
            reader.next_frame().unwrap();
            assert_eq!(reader.next_frame().unwrap().unwrap().image.data, b"ABCDEF", "{color}");
            assert_eq!(reader.next_frame(), Ok(None));
        }
    }

    #[test]
    fn a_stream_that_ends_in_the_middle_of_a_frame() {
        let whole = stream("YUV4MPEG2 W3 H2 Cmono", &[b"FRAME\nabcdef", b"FRAME\nghijkl"]);
        let header = whole.iter().position(|&b| b == b'\n').unwrap() + 1;
        for cut in header..whole.len() {
            let mut reader = reader(&whole[..cut]).unwrap();
            let mut frames = 0;
            let end = loop {
                match reader.next_frame() {
                    Ok(Some(_)) => frames += 1,
                    other => break other,
                }
            };
            // A frame has 12 bytes, of which 6 are its line.
            let at = cut - header;
            assert_eq!(frames, at / 12);
            if at % 12 == 0 {
                assert_eq!(end, Ok(None));
            } else {
                let found = (at % 12).saturating_sub(6);
                assert_eq!(
                    end.unwrap_err().to_string(),
                    format!("clip.y4m: ends in the middle of frame {frames}: found {found} of 6 bytes")
                );
            }
        }
    }

    #[test]
    fn the_program_that_writes_may_say_why_it_ends() {
        let told = stream("YUV4MPEG2 W3 H2 Cmono", &[b"XEND in the middle of frame 0: too short\n"]);
        let error = reader(&told).unwrap().next_frame().unwrap_err();
        assert_eq!(error.to_string(), "clip.y4m: ends in the middle of frame 0: too short");
    }

    #[test]
    fn what_is_no_stream() {
        const EXPECTED: &str = "expected a line such as `YUV4MPEG2 W640 H480 F30:1 Cmono` (width, height, frame rate; \
             C: mono, 420, 422 or 444)";
        for (bytes, found) in [
            (&b""[..], "no data"),
            (b"hello\n", "`hello`"),
            (b"YUV4MPEG2 W3\n", "`YUV4MPEG2 W3`"),
            (b"YUV4MPEG2 W3 H0 Cmono\n", "`YUV4MPEG2 W3 H0 Cmono`"),
            (b"YUV4MPEG2 W3 H2 C420p10\n", "`YUV4MPEG2 W3 H2 C420p10`"),
        ] {
            assert_eq!(
                reader(bytes).unwrap_err().to_string(),
                format!("clip.y4m: found {found}, {EXPECTED}")
            );
        }
        let broken = stream("YUV4MPEG2 W3 H2 Cmono", &[b"FRAME\nabcdef", b"FROM\nghijkl"]);
        let mut reader = reader(&broken).unwrap();
        reader.next_frame().unwrap();
        assert_eq!(
            reader.next_frame().unwrap_err().to_string(),
            "clip.y4m: found `FROM` at the start of frame 1, expected a line with FRAME"
        );
    }
}

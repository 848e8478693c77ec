//! Videos and cameras: `.y4m` files are read as they are, everything else through a program that decodes it into a pipe.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use io::{OpenOptions, Video, VideoReader, open_video};

use crate::Error;
use crate::programs::{find_program, shield};

/// The program that comes with DSSLAM (`./install.sh --video`); it is looked for beside this one, then in the PATH.
pub(crate) const HELPER: &str = "dsslam-video";
/// What is taken where it is missing.
pub(crate) const FFMPEG: &str = "ffmpeg";

/// Endings of the names of videos.
const ENDINGS: [&str; 11] = ["y4m", "mp4", "m4v", "mov", "avi", "mkv", "webm", "mpg", "mpeg", "ts", "wmv"];

/// A stream of frames, and the program that writes it.
pub(crate) struct Stream {
    /// Takes the frames.
    pub(crate) reader: VideoReader<Box<dyn BufRead + Send>>,
    decoder: Option<Child>,
}

/// A video or a camera that has been opened.
pub(crate) struct Opened {
    /// Cameras and sensor.
    pub(crate) video: Video,
    /// File or device.
    pub(crate) path: PathBuf,
    /// Frames that have not been read yet.
    pub(crate) stream: Stream,
    /// Frames per second, for frames that do not tell their time.
    pub(crate) frame_rate_hz: f64,
}

/// Whether a path is that of a file whose name ends as those of videos do.
pub(crate) fn is_video(path: &Path) -> bool {
    let ending = path.extension().map(|extension| extension.to_ascii_lowercase());
    path.is_file() && ending.is_some_and(|ending| ENDINGS.iter().any(|known| ending == *known))
}

/// Whether a path is that of a device such as `/dev/video0`.
pub fn is_camera(path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        std::fs::metadata(path).is_ok_and(|data| data.file_type().is_char_device())
    }
    #[cfg(not(unix))]
    false
}

impl Opened {
    /// Opens a video file or a camera.
    ///
    /// # Errors
    /// A file that is not a video, a missing decoder, a calibration that does not fit.
    pub(crate) fn new(path: &Path, options: &OpenOptions) -> Result<Self, Error> {
        let stream = Stream::open(path)?;
        let header = stream.reader.header().clone();
        let mut video = open_video(path, header.size, options)?;
        let rate = header.frame_rate_hz.or(video.sequence.frame_rate_hz);
        video.sequence.frame_rate_hz = rate;
        let frame_rate_hz = rate.unwrap_or(options.frame_rate_hz);
        Ok(Self { video, path: path.to_path_buf(), stream, frame_rate_hz })
    }
}

impl Stream {
    /// Starts to read a file or a camera.
    ///
    /// # Errors
    /// A file that cannot be read, that is not a video, or a missing decoder.
    pub(crate) fn open(path: &Path) -> Result<Self, Error> {
        let name = path.display().to_string();
        let is_raw = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("y4m"));
        let unreadable = |reason: std::io::Error| Error::unreadable(path, &reason);
        if !is_camera(path) {
            io::check_file(path).map_err(unreadable)?;
        }
        let file = File::open(path).map_err(unreadable)?;
        if is_raw {
            let stream: Box<dyn BufRead + Send> = Box::new(BufReader::new(file));
            return Ok(Self { reader: VideoReader::new(stream, &name)?, decoder: None });
        }
        drop(file);
        let (program, mut command) = decoder(path)?;
        // Ctrl-C is for this program, which then ends the decoder.
        let started = shield(&mut command).stdin(Stdio::null()).stdout(Stdio::piped()).spawn();
        let failed = |reason: &str| Error::Decoder { program: program.clone(), reason: reason.to_owned() };
        let mut child = started.map_err(|reason| failed(&reason.to_string()))?;
        let pipe = child.stdout.take().ok_or_else(|| failed("it has no output"))?;
        let stream: Box<dyn BufRead + Send> = Box::new(BufReader::with_capacity(1 << 16, pipe));
        match VideoReader::new(stream, &name) {
            Ok(reader) => Ok(Self { reader, decoder: Some(child) }),
            Err(problem) => {
                end(&mut child);
                Err(Error::Undecodable { program, problem })
            }
        }
    }
}

/// A decoder whose frames are no longer needed is terminated.
impl Drop for Stream {
    fn drop(&mut self) {
        self.decoder.iter_mut().for_each(end);
    }
}

/// Ends a program and waits until it is gone; one that has ended by itself stays so.
fn end(child: &mut Child) {
    let _ = child.kill();
    let _ = child.wait();
}

/// The program that decodes a file, with its arguments.
fn decoder(path: &Path) -> Result<(PathBuf, Command), Error> {
    if let Some(program) = find_program(HELPER) {
        let mut command = Command::new(&program);
        command.arg(path);
        return Ok((program, command));
    }
    let Some(program) = find_program(FFMPEG) else {
        return Err(Error::NoDecoder { path: path.to_path_buf() });
    };
    let mut command = Command::new(&program);
    command.args(["-v", "error", "-nostdin"]);
    if is_camera(path) {
        command.args(["-f", "v4l2"]);
    }
    command.arg("-i").arg(path).args(["-f", "yuv4mpegpipe", "-pix_fmt", "gray", "-strict", "-1", "-"]);
    Ok((program, command))
}

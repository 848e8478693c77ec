//! `dsslam-video`: decodes a video, or reads a camera, and writes gray frames as a YUV4MPEG2 stream to standard output, where `dsslam`
//! takes them. A separate program, so that nothing else has to load the hundreds of libraries that OpenCV's decoders need.
#![allow(clippy::print_stderr, reason = "a program tells what went wrong")]

use std::io::{ErrorKind, Write};
use std::process::ExitCode;

use opencv::core::Mat;
use opencv::prelude::*;
use opencv::videoio::{self, VideoCapture};
use opencv::{Result, imgproc};

/// Frames that a container may announce too many: some know their length in seconds only.
const ANNOUNCED_TOLERANCE: f64 = 0.02;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [source] = &arguments[..] else {
        eprintln!("usage: dsslam-video FILE|DEVICE > stream.y4m");
        return ExitCode::from(2);
    };
    match copy(source, &mut std::io::stdout().lock()) {
        Ok(()) => ExitCode::SUCCESS,
        // Nobody reads any more.
        Err(Failure::Write(error)) if error.kind() == ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(Failure::Write(error)) => {
            eprintln!("dsslam-video: cannot write: {error}");
            ExitCode::from(3)
        }
        Err(Failure::Decode(reason)) => {
            eprintln!("dsslam-video: {source}: {reason}");
            ExitCode::from(1)
        }
    }
}

enum Failure {
    Decode(String),
    Write(std::io::Error),
}

impl From<opencv::Error> for Failure {
    fn from(error: opencv::Error) -> Self {
        Self::Decode(error.to_string())
    }
}

impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Self {
        Self::Write(error)
    }
}

/// Copies all frames. A text file opens as a video, too: only a first frame proves that it is one.
fn copy(source: &str, out: &mut impl Write) -> std::result::Result<(), Failure> {
    opencv::core::set_num_threads(1)?;
    let mut capture = VideoCapture::from_file(source, videoio::CAP_ANY)?;
    let mut frame = Mat::default();
    if !capture.is_opened()? || !next(&mut capture, &mut frame)? {
        return Err(Failure::Decode("no frame can be decoded, expected a video or a camera".to_string()));
    }
    let rate_hz = capture.get(videoio::CAP_PROP_FPS)?;
    let announced = capture.get(videoio::CAP_PROP_FRAME_COUNT)?;
    let is_camera = source.starts_with("/dev/");
    let rate = if rate_hz.is_finite() && rate_hz > 0.0 { (rate_hz * 1000.0).round() as u32 } else { 0 };
    let (width, height) = (frame.cols(), frame.rows());
    write!(out, "YUV4MPEG2 W{width} H{height} F{rate}:{} Ip A1:1 Cmono", if rate > 0 { 1000 } else { 0 })?;
    if !is_camera && announced > 0.0 {
        write!(out, " XN{announced:.0}")?;
    }
    writeln!(out)?;
    let clock = Clock::start();
    let (mut gray, mut n) = (Mat::default(), 0_u32);
    loop {
        if (frame.cols(), frame.rows()) != (width, height) {
            let (w, h) = (frame.cols(), frame.rows());
            writeln!(out, "XEND at frame {n}: its size is {w}x{h}, not {width}x{height} as before")?;
            return Ok(());
        }
        to_gray(&frame, &mut gray)?;
        // A file's frames come at its rate; those of a camera when it delivers them.
        if is_camera {
            writeln!(out, "FRAME XT{:.6}", clock.seconds())?
        } else {
            writeln!(out, "FRAME")?
        }
        out.write_all(gray.data_bytes()?)?;
        n += 1;
        if !next(&mut capture, &mut frame)? {
            break;
        }
    }
    if !is_camera && f64::from(n) < announced * (1.0 - ANNOUNCED_TOLERANCE) - 1.0 {
        writeln!(out, "XEND in the middle of frame {n}: the file announces {announced:.0} frames")?;
    }
    Ok(out.flush()?)
}

fn next(capture: &mut VideoCapture, frame: &mut Mat) -> Result<bool> {
    Ok(capture.read(frame)? && !frame.empty())
}

/// Gray values without gaps between the rows.
fn to_gray(frame: &Mat, gray: &mut Mat) -> Result<()> {
    match frame.channels() {
        1 => frame.copy_to(gray),
        4 => imgproc::cvt_color(frame, gray, imgproc::COLOR_BGRA2GRAY, 0),
        _ => imgproc::cvt_color(frame, gray, imgproc::COLOR_BGR2GRAY, 0),
    }
}

/// Time since the first frame.
struct Clock(std::time::Instant);

impl Clock {
    #[allow(clippy::disallowed_methods, reason = "a camera's frames are stamped when they come")]
    fn start() -> Self {
        Self(std::time::Instant::now())
    }

    fn seconds(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}

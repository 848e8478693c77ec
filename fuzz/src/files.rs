//! Targets of one file each. Checksums of damaged files are put right, so that what lies behind them is reached.

use std::cell::RefCell;
use std::fs;
use std::path::Path;

use sha2::{Digest, Sha256};

use super::said;

thread_local! {
    /// A folder in memory, where the system has one.
    static FOLDER: RefCell<Option<tempfile::TempDir>> = const { RefCell::new(None) };
}

/// Calls `read` with the path of a folder of this thread's own.
pub(super) fn in_folder(read: impl FnOnce(&Path) -> String) -> String {
    FOLDER.with_borrow_mut(|folder| {
        let folder = folder.get_or_insert_with(|| {
            let memory = Path::new("/dev/shm");
            let parent = if memory.is_dir() { memory.to_path_buf() } else { std::env::temp_dir() };
            tempfile::tempdir_in(parent).expect("a folder for inputs")
        });
        read(folder.path())
    })
}

fn in_file(name: &str, bytes: &[u8], read: impl FnOnce(&Path) -> String) -> String {
    in_folder(|folder| {
        let path = folder.join(name);
        fs::write(&path, bytes).expect("an input is written");
        read(&path)
    })
}

pub(super) fn images(bytes: &[u8]) -> String {
    let bytes = with_png_checksums(bytes);
    in_file("image.png", &bytes, |path| {
        let size = said(io::image_size(path));
        let color = said(io::load_rgb(path));
        format!("{size}; {}; {color}; {}", said(io::load_gray(path)), said(io::load_depth(path)))
    })
}

/// Makes the checksum of each chunk of a PNG right.
fn with_png_checksums(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    if !bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
        return bytes;
    }
    let mut at = 8;
    while let Some(length) = u32_be(&bytes, at) {
        let end = at + 8 + length as usize;
        if end + 4 > bytes.len() {
            break;
        }
        let checksum = crc32fast::hash(&bytes[at + 4..end]);
        bytes[end..end + 4].copy_from_slice(&checksum.to_be_bytes());
        at = end + 4;
    }
    bytes
}

fn u32_be(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_be_bytes(bytes.get(at..at + 4)?.try_into().ok()?))
}

fn u32_le(bytes: &[u8], at: usize) -> Option<u32> {
    u32_be(bytes, at).map(u32::swap_bytes)
}

/// Names that tell something of the format, chosen by the first byte.
const CALIBRATIONS: [&str; 6] =
    ["calibration.yaml", "sensor.yaml", "stereo.xml", "camera.json", "cameras.txt", "calib.txt"];

pub(super) fn calibrations(bytes: &[u8]) -> String {
    let (kind, bytes) = bytes.split_first().unwrap_or((&0, &[]));
    let name = CALIBRATIONS[usize::from(*kind) % CALIBRATIONS.len()];
    in_file(name, bytes, |path| {
        let stereo = said(io::open_cameras(path, Some(io::Sensor::Stereo)));
        let printed = said(io::read_calibration(path).map(|file| file.to_yaml()));
        format!("{}; {stereo}; {printed}", said(io::open_cameras(path, None)))
    })
}

pub(super) fn trajectories(bytes: &[u8]) -> String {
    in_file("trajectory.txt", bytes, |path| {
        let read = io::read_trajectory(path, None);
        said(read.map(|file| file.at_frames(&[1.0, 1.5], 0)))
    })
}

pub(super) fn configurations(bytes: &[u8]) -> String {
    in_file("config.yaml", bytes, |path| said(dsslam::Config::load(Some(path), &[])))
}

pub(super) fn journals(bytes: &[u8]) -> String {
    said(runtime::Journal::from_json(bytes))
}

pub(super) fn videos(bytes: &[u8]) -> String {
    let mut reader = match io::VideoReader::new(bytes, "video") {
        Err(error) => return error.to_string(),
        Ok(reader) => reader,
    };
    loop {
        match reader.next_frame() {
            Ok(Some(_)) => {}
            Ok(None) => return "ended".to_owned(),
            Err(error) => return error.to_string(),
        }
    }
}

/// Bytes of a map's header, and those of them that its checksum covers.
const HEADER: usize = 40;
const CHECKED: usize = 32;
const SEAL: usize = 32;

/// A map file, both checksums put right.
pub(super) fn maps(bytes: &[u8]) -> String {
    let mut bytes = bytes.to_vec();
    if bytes.len() >= HEADER + SEAL {
        let end = bytes.len() - SEAL;
        let head = Sha256::digest(&bytes[..CHECKED]);
        bytes[CHECKED..HEADER].copy_from_slice(&head[..HEADER - CHECKED]);
        let seal = Sha256::digest(&bytes[..end]);
        bytes[end..].copy_from_slice(&seal);
    }
    said(map::file::decode(&bytes))
}

/// The records of a map in a file that is right otherwise.
pub(super) fn map_records(bytes: &[u8]) -> String {
    let info = b"{}";
    let stored = zstd::bulk::compress(bytes, 1).expect("memory");
    let mut file = b"DSMAP\0\r\n".to_vec();
    file.extend(map::file::FORMAT_VERSION.to_le_bytes());
    file.extend((info.len() as u32).to_le_bytes());
    file.extend((stored.len() as u64).to_le_bytes());
    file.extend((bytes.len() as u64).to_le_bytes());
    file.extend([0; HEADER - CHECKED]);
    file.extend(info);
    file.extend(stored);
    file.extend([0; SEAL]);
    maps(&file)
}

/// A vocabulary as text, or in our own format with its length and checksum put right.
pub(super) fn vocabularies(bytes: &[u8]) -> String {
    let mut bytes = bytes.to_vec();
    if bytes.starts_with(b"\x89DSBOW") && bytes.len() >= 24 {
        let length = (bytes.len() as u64).to_le_bytes();
        bytes[16..24].copy_from_slice(&length);
        let mut hasher = crc32fast::Hasher::new();
        hasher.update(&bytes[..12]);
        hasher.update(&bytes[16..]);
        bytes[12..16].copy_from_slice(&hasher.finalize().to_le_bytes());
        return said(bow::Vocabulary::from_bytes(bytes));
    }
    said(bow::Vocabulary::from_text(&String::from_utf8_lossy(&bytes)))
}

/// A stream of events, the checksum of each record put right.
pub(super) fn events(bytes: &[u8]) -> String {
    let mut bytes = bytes.to_vec();
    let mut at = 12;
    while let Some(length) = u32_le(&bytes, at) {
        let end = at + 8 + length as usize;
        if end > bytes.len() {
            break;
        }
        let checksum = crc32fast::hash(&bytes[at + 8..end]).to_le_bytes();
        bytes[at + 4..at + 8].copy_from_slice(&checksum);
        at = end;
    }
    read_events(&bytes)
}

/// The content of a single record.
pub(super) fn event_records(bytes: &[u8]) -> String {
    let mut file = b"DSEVENTS".to_vec();
    file.extend(events::VERSION.to_le_bytes());
    file.extend((bytes.len() as u32 + 1).to_le_bytes());
    let payload = [&[0], bytes].concat();
    file.extend(crc32fast::hash(&payload).to_le_bytes());
    file.extend(payload);
    read_events(&file)
}

fn read_events(bytes: &[u8]) -> String {
    let mut reader = match events::StreamReader::new(bytes) {
        Err(error) => return error.to_string(),
        Ok(reader) => reader,
    };
    let mut scene = events::Scene::default();
    loop {
        match reader.next_record() {
            Ok(Some(record)) => scene.apply(&record),
            Ok(None) => return format!("{:?}", reader.ending()),
            Err(error) => return error.to_string(),
        }
    }
}

//! Seeds of the targets: small inputs that are right, made by the program's own writers.

use std::fs;
use std::path::Path;

use dsslam::{Camera, Config, Slam, synth};
use geometry::{DepthImage, GrayImage};

use super::cameras;

fn texts(texts: &[&str]) -> Vec<Vec<u8>> {
    texts.iter().map(|text| text.as_bytes().to_vec()).collect()
}

/// The bytes that a writer leaves in a file of this name.
pub(super) fn written(name: &str, write: impl FnOnce(&Path)) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    write(&path);
    fs::read(path).expect("what was written")
}

/// All formats, 8 and 16 bits, gray and color, depth in meters.
pub fn images() -> Vec<Vec<u8>> {
    use image::ImageFormat::{Bmp, Jpeg, Png, Pnm, Tiff, WebP};
    let gray = GrayImage::from_fn(12, 9, |x, y| (x * 20 + y) as u8);
    let depth = DepthImage::from_fn(7, 5, |x, y| (x * 5000 + y) as u16);
    let color = image::RgbaImage::from_fn(9, 7, |x, y| image::Rgba([x as u8 * 20, y as u8 * 30, 90, 200]));
    let color = image::DynamicImage::ImageRgba8(color);
    let coded = |image: &image::DynamicImage, format| {
        let mut bytes = std::io::Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).expect("memory");
        bytes.into_inner()
    };
    let deep = image::DynamicImage::ImageLuma16(color.to_luma16());
    let meters: Vec<u8> = (0..30).flat_map(|i| (0.25 * i as f32).to_le_bytes()).collect();
    let numpy = |header: &str, values: &[u8]| {
        let length = (header.len() as u16).to_le_bytes();
        [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), values].concat()
    };
    let shape = "{'descr': '<f4', 'fortran_order': False, 'shape': (5, 6), }\n";
    let all = [(&color, Png), (&deep, Png), (&deep, Pnm), (&deep, Tiff), (&color, WebP)];
    let rgb = image::DynamicImage::ImageRgb8(color.to_rgb8());
    let opaque = [(&rgb, Bmp), (&rgb, Pnm), (&rgb, Tiff), (&rgb, Jpeg)];
    let mut seeds: Vec<Vec<u8>> =
        all.iter().chain(&opaque).map(|(image, format)| coded(image, *format)).collect();
    seeds.extend([
        written("a.png", |path| io::save_png_gray(path, &gray).expect("a file")),
        written("a.png", |path| io::save_png_depth(path, &depth).expect("a file")),
        io::preview(&gray, 12).map(|preview| preview.jpeg).unwrap_or_default(),
        numpy(shape, &meters),
        float_tiff(&meters),
        b"P5 3 2 255\n123456".to_vec(),
        b"P4 8 2\n12".to_vec(),
        b"P2\n# a comment\n3 2\n255\n1 2 3\n4 5 6\n".to_vec(),
        b"BM".to_vec(),
    ]);
    seeds
}

/// A TIFF of 6 x 5 32-bit floats.
fn float_tiff(values: &[u8]) -> Vec<u8> {
    const N_TAGS: u16 = 10;
    let data_at = 8 + 2 + 12 * u32::from(N_TAGS) + 4;
    // Width, height, bits, packing, meaning, place, samples, rows, bytes, kind of number.
    let tags: [(u16, u32); N_TAGS as usize] = [
        (256, 6),
        (257, 5),
        (258, 32),
        (259, 1),
        (262, 1),
        (273, data_at),
        (277, 1),
        (278, 5),
        (279, values.len() as u32),
        (339, 3),
    ];
    let mut bytes = b"II*\0\x08\0\0\0".to_vec();
    bytes.extend(N_TAGS.to_le_bytes());
    for (tag, value) in tags {
        bytes.extend(tag.to_le_bytes());
        bytes.extend([4, 0, 1, 0, 0, 0]);
        bytes.extend(value.to_le_bytes());
    }
    bytes.extend([0; 4]);
    bytes.extend(values);
    bytes
}

/// A byte for the name, then the text.
pub fn calibrations() -> Vec<Vec<u8>> {
    cameras::all().iter().map(|(kind, text)| [&[*kind], text.as_bytes()].concat()).collect()
}

/// All formats.
pub fn trajectories() -> Vec<Vec<u8>> {
    texts(&[
        "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0.5 0 1 0 0 0 0 1 1\n",
        "0 1 0 0 0 0 1 0 0 0 0 1 0\n5 1 0 0 0.5 0 1 0 0 0 0 1 1\n",
        "# seconds x y z qx qy qz qw\n1.0 0.5 0.5 0.5 0 0 0 1\n1.1 0.5 0.6 0.5 0 0.6 0 0.8\n",
        "#timestamp, p_x\n1000000000,0.1,0.2,0.3,1,0,0,0\n1100000000,0.1,0.2,0.3,0.8,0,0.6,0\n",
        "ts (ns),tx,ty,tz,qx,qy,qz,qw\n1000000000,0.1,0.2,0.3,0,0,0,1\n1100000000,0.1,0.2,0.3,0,0.6,0,0.8\n",
        "1.5 1 0 0 0 0 1 0 0 0 0 1 0\n1.75 1 0 0 0.5 0 1 0 0 0 0 1 1\n",
        "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1\n",
        "3 1 0 0 7 0 1 0 0 0 0 1 0 0 0 0 1\n5 1 0 0 7 0 1 0 0 0 0 1 0 0 0 0 1\n",
        "0.5 0.5 0.5 0 0 0 1\n0.5 0.6 0.5 0 0.6 0 0.8\n",
    ])
}

/// The defaults, and a short one.
pub fn configurations() -> Vec<Vec<u8>> {
    let whole = Config::default().to_yaml().into_bytes();
    let short = "camera:\n  fx: 517.3\n  fy: 516.5\n  cx: 318.6\n  cy: 255.3\n  fps: 30\nfeatures: {keep: 1000}\nseed: 3\n";
    vec![whole, short.as_bytes().to_vec()]
}

/// `key=value`, one a line.
pub fn overrides() -> Vec<Vec<u8>> {
    texts(&[
        "camera.fx=500\ncamera.fy=5e2\nseed=7\n",
        "features.selection=response\nloops.enabled=false\ninput.mask=a b.png",
    ])
}

/// A map of two frames with few features, and the journal of the run that made it.
fn map_and_journal() -> (Vec<u8>, Vec<u8>) {
    let world = synth::World::new(synth::Preset::Town, 1, 1);
    let (width, height) = world.image_size();
    let sets =
        ["features.keep=120", "tracking.init_min_features=20", "loops.enabled=false"].map(str::to_owned);
    let config = Config::load(None, &sets).expect("a configuration");
    let mut slam = Slam::new(&config, Camera::stereo(world.rig(), width, height)).expect("a camera");
    for i in [0, 3] {
        let images = world.images(i);
        slam.track(i as i64 * 100_000_000, (&images.left, &images.right)).expect("a frame");
    }
    let done = slam.finish().expect("a run");
    let map = written("a.dsmap", |path| drop(done.save_map(path).expect("a file")));
    (map, done.outcome.journal.to_json())
}

/// An empty map and a small one.
pub fn maps() -> Vec<Vec<u8>> {
    vec![map::file::encode(&map::Map::new(), &map::MapFileInfo::default()), map_and_journal().0]
}

/// Their records, unpacked.
pub fn map_records() -> Vec<Vec<u8>> {
    let records = |file: Vec<u8>| {
        let info = u32::from_le_bytes(file[12..16].try_into().expect("4 bytes")) as usize;
        let unpacked = u64::from_le_bytes(file[24..32].try_into().expect("8 bytes")) as usize;
        zstd::bulk::decompress(&file[40 + info..file.len() - 32], unpacked).expect("a whole map")
    };
    maps().into_iter().map(records).collect()
}

/// Text, and our own format made of it.
pub fn vocabularies() -> Vec<Vec<u8>> {
    let leaf = |parent: u32, value: u32| {
        let bytes: Vec<String> = (0..32).map(|i| ((value * 37 + i) % 256).to_string()).collect();
        format!("{parent} {} {} 0.5\n", u8::from(parent > 0), bytes.join(" "))
    };
    let nodes: String =
        [(0, 1), (0, 2), (1, 3), (1, 4), (2, 5), (2, 6)].iter().map(|&(p, v)| leaf(p, v)).collect();
    let text = format!("2 2 0 0\n{nodes}");
    let own = bow::Vocabulary::from_text(&text).expect("a vocabulary").as_bytes().to_vec();
    vec![text.into_bytes(), own]
}

fn records() -> Vec<events::Record> {
    let start = events::Start {
        program_version: "1".to_owned(),
        sequence: "s".to_owned(),
        sensor: io::Sensor::Stereo,
        camera: events::Camera { focal: [30.0; 2], center: [20.0; 2], size: [40, 40] },
        n_frames: 2,
        truth: vec![events::TruePosition { frame: 0, position: [0.0, 1.0, 2.0] }],
    };
    let text = events::Text { frame: Some(1), level: events::Level::Info, text: "text ".repeat(80) };
    let end = events::End { trajectory: Vec::new(), summary: "| |".to_owned(), left_out: 0 };
    vec![
        events::Record::Start(start),
        events::Record::Text(text),
        events::Record::Stages {
            frame: 1,
            stages: vec![events::StageTime { name: "track".to_owned(), ms: 2.0 }],
        },
        events::Record::End(end),
    ]
}

/// A short stream.
pub fn events() -> Vec<Vec<u8>> {
    let mut stream = Vec::new();
    let mut writer = events::StreamWriter::new(&mut stream).expect("memory");
    records().iter().for_each(|record| writer.write(record).expect("memory"));
    vec![stream]
}

/// The content of its records, and of the changes of a map.
pub fn event_records() -> Vec<Vec<u8>> {
    let (map, _) = map::file::decode(&map_and_journal().0).expect("a map");
    let delta = events::DeltaTracker::new(events::DeltaOptions::default()).finish(&map, 3);
    let all = records().into_iter().chain([events::Record::Map(delta)]);
    // A stream of one record: its content begins behind the header, the prefix and the byte of packing.
    let content = |record: events::Record| {
        let mut stream = Vec::new();
        let mut writer = events::StreamWriter::new(&mut stream).expect("memory");
        writer.write(&record).expect("memory");
        let body = &stream[21..];
        if stream[20] == 0 { body.to_vec() } else { zstd::stream::decode_all(body).expect("a packed record") }
    };
    all.map(content).collect()
}

/// The journal of a run.
pub fn journals() -> Vec<Vec<u8>> {
    vec![map_and_journal().1]
}

/// Two frames of a raw video.
pub fn videos() -> Vec<Vec<u8>> {
    let frame = [b"FRAME\n".to_vec(), (0..24).collect()].concat();
    vec![[b"YUV4MPEG2 W4 H4 F30:1 Ip A1:1 C420jpeg\n".to_vec(), frame.clone(), frame].concat()]
}

/// Arguments, one a line.
pub fn command_lines() -> Vec<Vec<u8>> {
    texts(&[
        "run\nkitti/06\n--config\nkitti\n--set\ncamera.fps=5\n--max-frames\n10\n--lengths\n1,2\n--strict",
        "eval\ntraj\na.txt\nb.txt\n--align\nsim3\n--tolerance\n0.02",
        "synth\nout\n--preset\ntown\n--frames\n3\n--lens\nfisheye",
        "-vv\n--log-format\njson\ninspect\nfeatures\na.png\n-o\nb.png",
    ])
}

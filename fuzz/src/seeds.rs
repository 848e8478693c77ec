//! Seeds of the targets: small inputs that are right, made by the program's own writers.

use std::fs;
use std::path::Path;

use dsslam::{Camera, Config, Slam, synth};
use geometry::{DepthImage, GrayImage};

use super::folders::{LAYOUTS, SEPARATOR};

fn texts(texts: &[&str]) -> Vec<Vec<u8>> {
    texts.iter().map(|text| text.as_bytes().to_vec()).collect()
}

/// The bytes that a writer leaves in a file of this name.
fn written(name: &str, write: impl FnOnce(&Path)) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    write(&path);
    fs::read(path).expect("what was written")
}

/// PNG in 8 and 16 bits, JPEG.
pub fn images() -> Vec<Vec<u8>> {
    let gray = GrayImage::from_fn(12, 9, |x, y| (x * 20 + y) as u8);
    let depth = DepthImage::from_fn(7, 5, |x, y| (x * 5000 + y) as u16);
    vec![
        written("a.png", |path| io::save_png_gray(path, &gray).expect("a file")),
        written("a.png", |path| io::save_png_depth(path, &depth).expect("a file")),
        io::preview(&gray, 12).map(|preview| preview.jpeg).unwrap_or_default(),
        b"P5 3 2 255\n123456".to_vec(),
        b"BM".to_vec(),
    ]
}

const OWN: &str = "fps: 30\ncameras:\n  - model: pinhole-radtan\n    resolution: [64, 48]\n    intrinsics: [45.8, 45.7, 32.5, 23.5]\n    distortion: [-0.28, 0.07, 0.0, 0.0]\n  - model: none\n    resolution: [64, 48]\n    intrinsics: [45.7, 45.6, 31.2, 24.0]\nright_from_left:\n  - [1, 0, 0, -0.11]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n";
const SENSOR: &str = "T_BS:\n  cols: 4\n  rows: 4\n  data: [1.0, 0.0, 0.0, 0.1, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]\nresolution: [40, 40]\ncamera_model: pinhole\nintrinsics: [30.0, 30.0, 20.0, 20.0]\ndistortion_model: radial-tangential\ndistortion_coefficients: [0.1, 0.0, 0.0, 0.0]\n";
const KITTI: &str = "P0: 70 0 20 0 0 70 20 0 0 0 1 0\nP1: 70 0 20 -38 0 70 20 0 0 0 1 0\n";
const XML: &str = "<?xml version=\"1.0\"?><boofcv.struct.calib.StereoParameters><left><width>64</width><height>48</height><fx>45</fx><fy>45</fy><skew>0</skew><cx>32</cx><cy>24</cy><radial><double>-0.3</double><double>0.1</double></radial><t1>0</t1><t2>0</t2></left><right><width>64</width><height>48</height><fx>45</fx><fy>45</fy><skew>0</skew><cx>32</cx><cy>24</cy></right><rightToLeft><r><numRows>3</numRows><data><double>1</double><double>0</double><double>0</double><double>0</double><double>1</double><double>0</double><double>0</double><double>0</double><double>1</double></data></r><t><x>0.1</x><y>0</y><z>0</z></t></rightToLeft></boofcv.struct.calib.StereoParameters>";
const SETTINGS: &str = "%YAML:1.0\n---\nCamera.type: \"PinHole\"\nCamera.fx: 458.6\nCamera.fy: 457.2\nCamera.cx: 367.2\nCamera.cy: 248.3\nCamera.k1: -0.28\nCamera.width: 752\nCamera.height: 480\nCamera.fps: 20.0\nCamera.bf: 47.9\nT: !!opencv-matrix\n   rows: 1\n   cols: 2\n   dt: d\n   data: [1., 2.]\n";
const CAMCHAIN: &str = "cam0:\n  camera_model: pinhole\n  intrinsics: [461.6, 460.3, 362.7, 246.0]\n  distortion_model: radtan\n  distortion_coeffs: [-0.27, 0.06, 0.0, 0.0]\n  resolution: [752, 480]\n  rostopic: /cam0\ncam1:\n  T_cn_cnm1:\n  - [1.0, 0.0, 0.0, -0.11]\n  - [0.0, 1.0, 0.0, 0.0]\n  - [0.0, 0.0, 1.0, 0.0]\n  - [0.0, 0.0, 0.0, 1.0]\n  camera_model: pinhole\n  intrinsics: [460.2, 458.8, 356.4, 239.9]\n  distortion_model: radtan\n  distortion_coeffs: [-0.27, 0.06, 0.0, 0.0]\n  resolution: [752, 480]\n";
const INFO: &str = "image_width: 640\nimage_height: 480\ncamera_name: left\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: [430.2, 0.0, 306.7, 0.0, 430.5, 227.2, 0.0, 0.0, 1.0]\ndistortion_model: plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [-0.33, 0.12, 0.0, 0.0, 0.0]\n";
const JSON: &str = "{\"fl_x\": 500.0, \"fl_y\": 500.0, \"cx\": 320.0, \"cy\": 240.0, \"w\": 640, \"h\": 480, \"k1\": 0.1, \"camera_model\": \"OPENCV\", \"frames\": []}";
const COLMAP: &str =
    "# Camera list\n1 PINHOLE 640 480 500 500 320 240\n2 OPENCV 640 480 500 500 320 240 0.1 0.0 0.0 0.0\n";

/// A byte for the name, then the text.
pub fn calibrations() -> Vec<Vec<u8>> {
    let all = [
        (0, OWN),
        (1, SENSOR),
        (2, XML),
        (5, KITTI),
        (0, SETTINGS),
        (0, CAMCHAIN),
        (0, INFO),
        (3, JSON),
        (4, COLMAP),
    ];
    all.iter().map(|(kind, text)| [&[*kind], text.as_bytes()].concat()).collect()
}

/// A byte for the layout, then its texts.
pub fn layouts() -> Vec<Vec<u8>> {
    let tum = "1.0 0.5 0.5 0.5 0 0 0 1\n1.1 0.5 0.6 0.5 0 0 0 1\n";
    let csv = "#timestamp, p_x\n1000000000,0.1,0.2,0.3,1,0,0,0,0,0,0\n1100000000,0.1,0.2,0.3,1,0,0,0,0,0,0\n";
    let contents: [&[&str]; 4] = [
        &["0.0\n0.1\n", KITTI, "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 1\n"],
        &["# color\n1.0 rgb/0.png\n", "1.01 depth/0.png\n", tum],
        &["#timestamp [ns],filename\n1000000000,1000000000.png\n", SENSOR, csv],
        &["0.5\n", OWN, tum],
    ];
    assert_eq!(contents.len(), LAYOUTS.len());
    let join = |(kind, texts): (u8, &&[&str])| {
        let texts: Vec<&[u8]> = texts.iter().map(|text| text.as_bytes()).collect();
        [&[kind], &texts.join(&SEPARATOR)[..]].concat()
    };
    (0..).zip(&contents).map(join).collect()
}

/// All formats.
pub fn trajectories() -> Vec<Vec<u8>> {
    texts(&[
        "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0.5 0 1 0 0 0 0 1 1\n",
        "0 1 0 0 0 0 1 0 0 0 0 1 0\n5 1 0 0 0.5 0 1 0 0 0 0 1 1\n",
        "# seconds x y z qx qy qz qw\n1.0 0.5 0.5 0.5 0 0 0 1\n1.1 0.5 0.6 0.5 0 0.6 0 0.8\n",
        "#timestamp, p_x\n1000000000,0.1,0.2,0.3,1,0,0,0\n1100000000,0.1,0.2,0.3,0.8,0,0.6,0\n",
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

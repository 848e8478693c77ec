//! Pushed images: the bits of a run on the same frames, refusals that change nothing, masks, views, threads, maps that go on.
#![allow(clippy::unwrap_used, reason = "a test stops at the first problem")]

use std::sync::LazyLock;

use dsslam::{
    Camera, Config, DepthView, Distortion, Error, Finished, FrameProblem, ImageView, Images, Schedule,
    Sensor, Session, SessionOptions, Silent, Slam, SlamOptions,
};
use geometry::{DepthImage, GrayImage};
use synth::{Preset, World};

const N_FRAMES: usize = 12;

/// A rendered drive.
struct Drive {
    left: Vec<GrayImage>,
    right: Vec<GrayImage>,
    /// In meters, and as 16 bits with 128 per meter.
    meters: Vec<Vec<f32>>,
    depth: Vec<DepthImage>,
}

fn new_world() -> World {
    World::new(Preset::Town, 1, 1)
}

fn world() -> &'static World {
    static WORLD: LazyLock<World> = LazyLock::new(new_world);
    &WORLD
}

/// 128 per meter; 0 where it is too far.
fn units(meters: f32) -> u16 {
    let units = (f64::from(meters) * 128.0).round();
    if units < 65_536.0 { units as u16 } else { 0 }
}

static DRIVE: LazyLock<Drive> = LazyLock::new(|| {
    let frames: Vec<_> = (0..N_FRAMES).map(|i| world().frame(i)).collect();
    Drive {
        left: frames.iter().map(|frame| frame.left.clone()).collect(),
        right: frames.iter().map(|frame| frame.right.clone()).collect(),
        meters: frames.iter().map(|frame| frame.depth_m.data.clone()).collect(),
        depth: frames
            .iter()
            .map(|frame| {
                DepthImage::from_fn(frame.left.width, frame.left.height, |x, y| units(frame.depth_m.at(x, y)))
            })
            .collect(),
    }
});

fn camera() -> Camera {
    let (width, height) = world().image_size();
    Camera::stereo(world().rig(), width, height)
}

fn config(overrides: &[&str]) -> Config {
    let overrides: Vec<String> = overrides.iter().map(|s| (*s).to_owned()).collect();
    Config::load(None, &overrides).unwrap()
}

fn time_ns(i: usize) -> i64 {
    i as i64 * 100_000_000
}

/// Pushes the stereo frames.
fn push(slam: &mut Slam) {
    for i in 0..N_FRAMES {
        slam.track(time_ns(i), (&DRIVE.left[i], &DRIVE.right[i])).unwrap();
    }
}

/// A number for the map, and the trajectory.
fn results(slam: Slam) -> (u64, io::Trajectory) {
    let done = slam.finish().unwrap();
    (done.outcome.map.digest(), done.trajectory())
}

fn of_schedule(schedule: Schedule) -> SlamOptions {
    let mut options = SlamOptions::default();
    options.schedule = Some(schedule);
    options
}

#[test]
fn pushed_frames_give_the_bits_of_a_run() {
    for set in ["input.scale=1", "input.scale=0.5", "input.sensor=mono"] {
        let config = config(&[set]);
        let mut options = SessionOptions::default();
        options.input.max_frames = Some(N_FRAMES);
        let session = Session::rendered(new_world(), &config, &options).unwrap();
        let run = session.run(&mut Silent).unwrap();
        let expected = (run.outcome.map.digest(), run.trajectory());
        assert!(expected.1.poses.len() > N_FRAMES - 3);
        for schedule in [Schedule::Sequential, Schedule::Lockstep] {
            let camera = Camera::of(session.input());
            let mut slam = Slam::with(&config, camera, &of_schedule(schedule)).unwrap();
            let mut n_keyframes = 0;
            for i in 0..N_FRAMES {
                let (left, right) = (&DRIVE.left[i], &DRIVE.right[i]);
                let images = if set.ends_with("mono") { left.into() } else { Images::from((left, right)) };
                let seen = slam.track(time_ns(i), images).unwrap();
                assert_eq!(seen.index, i as u32);
                n_keyframes += usize::from(seen.keyframe.is_some());
            }
            assert!(n_keyframes > 1, "{set}");
            assert_eq!(results(slam), expected, "{set} {schedule:?}");
        }
    }
}

#[test]
fn live_answers_each_frame() {
    for realtime in [false, true] {
        let options = of_schedule(Schedule::Live { realtime });
        let mut slam = Slam::with(&config(&["input.scale=0.5"]), camera(), &options).unwrap();
        push(&mut slam);
        assert_eq!(slam.finish().unwrap().trajectory().poses.len(), N_FRAMES);
    }
}

#[test]
fn what_does_not_fit_is_refused_and_changes_nothing() {
    let config = config(&["input.scale=0.5"]);
    let mut slam = Slam::new(&config, camera()).unwrap();
    let (left, right) = (&DRIVE.left[0], &DRIVE.right[0]);
    let small = GrayImage::new(40, 30, 255);
    let (width, height) = (left.width, left.height);
    let short = ImageView::gray(&left.data[1..], width, height);
    let view = ImageView::from(right);
    let depth = &DRIVE.depth[0];
    let mut refused = |t_ns: i64, images: Images<'_>| match slam.track(t_ns, images) {
        Err(Error::Frame { problem, .. }) => problem.to_string(),
        other => panic!("{other:?}"),
    };
    for (images, expected) in [
        (
            Images::from((&small, right)),
            "found 40x30 pixels in the left image, expected 1241x376 as the camera has",
        ),
        (
            Images::from((left, &small)),
            "found 40x30 pixels in the right image, expected 1241x376 as the camera has",
        ),
        (left.into(), "found no right image, expected one with sensor stereo"),
        ((left, depth).into(), "found no right image, expected one with sensor stereo"),
        (
            (short, view).into(),
            "found 466615 values in the left image, expected at least 466616 with a stride of 1241",
        ),
        (
            Images::from((left, right)).with_mask(&small),
            "found 40x30 pixels in the mask image, expected 1241x376 as the camera has",
        ),
    ] {
        assert_eq!(refused(-5, images), expected);
    }
    let error = slam.track(0, (left, right)).and_then(|_| slam.track(0, (left, right))).unwrap_err();
    assert!(matches!(error, Error::Frame { t_ns: 0, problem: FrameProblem::Time { last_ns: 0 } }), "{error}");
    assert_eq!(error.to_string(), "the frame at 0 ns: expected a time after that of the last frame, 0 ns");
    for i in 1..N_FRAMES {
        slam.track(time_ns(i), (&DRIVE.left[i], &DRIVE.right[i])).unwrap();
    }
    let mut clean = Slam::new(&config, camera()).unwrap();
    push(&mut clean);
    assert_eq!(results(slam), results(clean));
}

#[test]
fn color_and_strides_give_the_bits_of_packed_gray() {
    let config = config(&["input.scale=0.5"]);
    let mut plain = Slam::new(&config, camera()).unwrap();
    push(&mut plain);
    // Three equal channels, rows with 13 bytes behind them.
    let padded = |image: &GrayImage| -> Vec<u8> {
        let row = |y| image.row(y).iter().flat_map(|&v| [v; 3]).chain([77; 13]).collect::<Vec<u8>>();
        (0..image.height).flat_map(row).collect()
    };
    let mut strided = Slam::new(&config, camera()).unwrap();
    for i in 0..N_FRAMES {
        let (left, right) = (padded(&DRIVE.left[i]), padded(&DRIVE.right[i]));
        let (width, height) = (DRIVE.left[i].width, DRIVE.left[i].height);
        let stride = 3 * width + 13;
        let images = (
            ImageView::rgb(&left, width, height).with_stride(stride),
            ImageView::bgr(&right, width, height).with_stride(stride),
        );
        strided.track(time_ns(i), images).unwrap();
    }
    assert_eq!(results(strided), results(plain));
}

#[test]
fn no_feature_is_taken_where_the_mask_is_0() {
    let config = config(&["input.scale=0.5"]);
    let (left, right) = (&DRIVE.left[0], &DRIVE.right[0]);
    let features = |mask: &GrayImage| {
        let mut slam = Slam::new(&config, camera()).unwrap();
        slam.track(0, Images::from((left, right)).with_mask(mask)).unwrap();
        // The mask is that of one frame.
        let unmasked = slam.track(1, (left, right)).unwrap().features;
        assert_eq!(slam.track(2, (left, right)).unwrap().features, unmasked);
        slam.track(3, Images::from((left, right)).with_mask(mask)).unwrap().features
    };
    let of = |value: u8| features(&GrayImage::from_fn(left.width, left.height, |_, _| value));
    let half = features(&GrayImage::from_fn(left.width, left.height, |x, _| if x < 620 { 255 } else { 0 }));
    assert_eq!(of(0), 0);
    assert!(half > 0 && half < of(255), "{half} of {}", of(255));
}

#[test]
fn a_reset_gives_the_bits_of_a_new_one() {
    let config = config(&["input.scale=0.5"]);
    for schedule in [Schedule::Sequential, Schedule::Lockstep] {
        let mut slam = Slam::with(&config, camera(), &of_schedule(schedule)).unwrap();
        slam.track(5_000_000_000, (&DRIVE.left[7], &DRIVE.right[7])).unwrap();
        slam.reset().unwrap();
        push(&mut slam);
        let mut new = Slam::with(&config, camera(), &of_schedule(schedule)).unwrap();
        push(&mut new);
        assert_eq!(results(slam), results(new));
    }
}

#[test]
fn two_run_beside_each_other() {
    let config = config(&["input.scale=0.5"]);
    let run = || {
        let mut slam = Slam::new(&config, camera()).unwrap();
        push(&mut slam);
        results(slam)
    };
    let [a, b] = std::thread::scope(|scope| {
        [scope.spawn(run), scope.spawn(run)].map(|thread| thread.join().expect("no panic"))
    });
    assert_eq!(a, b);
    assert_eq!(a, run());
}

#[test]
fn a_saved_map_is_gone_on_with_or_localized_in() {
    let config = config(&["input.scale=0.5"]);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("town.dsmap");
    let mut slam = Slam::new(&config, camera()).unwrap();
    for i in 0..4 {
        slam.track(time_ns(i), (&DRIVE.left[i], &DRIVE.right[i])).unwrap();
    }
    let first = slam.finish().unwrap();
    first.save_map(&file).unwrap();
    for localize_only in [false, true] {
        let mut options = SlamOptions::default();
        (options.start_map, options.localize_only) = (Some(file.clone()), localize_only);
        let mut slam = Slam::with(&config, camera(), &options).unwrap();
        push(&mut slam);
        let done = slam.finish().unwrap();
        assert!(!done.trajectory().poses.is_empty(), "it found its place");
        let size = |finished: &Finished| finished.outcome.map.n_keyframes();
        assert_eq!(size(&done) == size(&first), localize_only, "new keyframes only if it is to go on");
    }
    let (width, height) = world().image_size();
    let mono = Camera::mono(world().rig().camera, Distortion::default(), width, height);
    let mut options = SlamOptions::default();
    options.start_map = Some(file.clone());
    let error = Slam::with(&config, mono, &options).unwrap_err().to_string();
    let expected = format!("{}: the map was made with sensor stereo, this run has mono", file.display());
    assert_eq!(error, expected);
}

/// EuRoC's stamps have 19 digits, of which a double holds 16: also those of a map that was saved, loaded and resumed.
#[test]
fn stamps_out_equal_stamps_in() {
    let config = config(&["input.scale=0.5"]);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("town.dsmap");
    let run = |options: &SlamOptions, first_ns: i64, n: usize| {
        let mut slam = Slam::with(&config, camera(), options).unwrap();
        let stamps: Vec<i64> = (0..n).map(|i| first_ns + time_ns(i)).collect();
        for (i, &t_ns) in stamps.iter().enumerate() {
            slam.track(t_ns, (&DRIVE.left[i], &DRIVE.right[i])).unwrap();
        }
        (slam.finish().unwrap(), stamps)
    };
    let written = |done: &Finished| -> Vec<i64> {
        let csv = folder.path().join("poses.csv");
        io::write_euroc_at(&csv, &done.trajectory(), &done.clock).unwrap();
        let text = std::fs::read_to_string(csv).unwrap();
        text.lines().skip(1).map(|line| line.split(',').next().unwrap().parse().unwrap()).collect()
    };
    let of_map = || {
        let (map, info) = map::file::decode(&std::fs::read(&file).unwrap()).unwrap();
        let clock = io::Clock::of_stamps(info.stamps_ns.into_iter());
        map.keyframes().map(|k| clock.nanoseconds(k.frame.timestamp_s)).collect::<Vec<i64>>()
    };
    let (done, stamps) = run(&SlamOptions::default(), 1_403_636_579_763_555_584, 4);
    assert_eq!(written(&done), stamps);
    done.save_map(&file).unwrap();
    let saved = of_map();
    assert!(!saved.is_empty() && saved.iter().all(|ns| stamps.contains(ns)), "{saved:?}");
    let mut options = SlamOptions::default();
    options.start_map = Some(file.clone());
    let (done, later) = run(&options, 1_403_636_579_763_555_584 + 9_000_000_007, DRIVE.left.len());
    done.save_map(&file).unwrap();
    let saved = of_map();
    assert!(saved.iter().any(|ns| later.contains(ns)), "it goes on");
    assert!(saved.iter().all(|ns| stamps.contains(ns) || later.contains(ns)), "{saved:?}");
}

#[test]
fn depth_in_meters_and_in_units_of_its_own_is_that_of_the_configuration() {
    let config = config(&["camera.depth_units_per_metre=128"]);
    let (width, height) = world().image_size();
    let run = |push: &dyn Fn(&mut Slam, usize)| {
        let camera = Camera::rgbd(world().rig(), Distortion::default(), width, height);
        assert_eq!(camera.sensor(), Sensor::Rgbd);
        let mut slam = Slam::new(&config, camera).unwrap();
        (0..4).for_each(|i| push(&mut slam, i));
        let (digest, trajectory) = results(slam);
        assert_eq!(trajectory.poses.len(), 4);
        digest
    };
    let expected = run(&|slam, i| {
        slam.track(time_ns(i), (&DRIVE.left[i], &DRIVE.depth[i])).unwrap();
    });
    let meters = run(&|slam, i| {
        let depth = DepthView::meters(&DRIVE.meters[i], width, height);
        slam.track(time_ns(i), (ImageView::from(&DRIVE.left[i]), depth)).unwrap();
    });
    assert_eq!(meters, expected);
    // Half the units, in rows with a gap.
    let halves = run(&|slam, i| {
        let row = |y| DRIVE.depth[i].row(y).iter().map(|v| v / 2).chain([9]).collect::<Vec<u16>>();
        let rows: Vec<u16> = (0..height).flat_map(row).collect();
        let depth = DepthView::u16_with_units(&rows, width, height, 64.0).with_stride(width + 1);
        slam.track(time_ns(i), (ImageView::from(&DRIVE.left[i]), depth)).unwrap();
    });
    assert_ne!(halves, expected, "coarser, but depth");
}

//! The event stream of a run: what it tells adds up to the run's results, and whatever its reader does, the run is the same.

use std::io::{self, Write};
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};

use events::{Camera, Ending, Record, Scene, Start, StreamReader};
use runtime::{EventStream, RunOutcome, Schedule, StreamOptions, StreamReport, run};

use crate::schedules::{bits, in_turn, revisit, setup};

/// Bytes that a test looks at afterwards.
#[derive(Clone, Default)]
struct Bytes(Arc<Mutex<Vec<u8>>>);

impl Write for Bytes {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap().extend(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn start() -> Start {
    Start {
        program_version: "0".to_owned(),
        sequence: "revisit".to_owned(),
        sensor: geometry::Sensor::Stereo,
        camera: Camera { focal: [300.0; 2], center: [300.0, 90.0], size: [600, 180] },
        n_frames: revisit().len() as u32,
        truth: Vec::new(),
    }
}

/// The drive with a stream; `after` is called when the run is over and the stream is not.
fn streamed(
    schedule: Schedule,
    target: impl Write + Send + 'static,
    options: StreamOptions,
    after: impl FnOnce(),
) -> (RunOutcome, StreamReport) {
    let mut stream = EventStream::start(Box::new(target), start(), options).unwrap();
    let outcome = run(revisit(), &setup(schedule), &mut stream, &AtomicBool::new(false)).unwrap();
    after();
    let report = stream.finish(&outcome, "numbers".to_owned());
    (outcome, report)
}

fn records(bytes: &Bytes) -> Vec<Record> {
    let bytes = bytes.0.lock().unwrap();
    let mut reader = StreamReader::new(&bytes[..]).unwrap();
    let mut records = Vec::new();
    while let Some(record) = reader.next_record().unwrap() {
        records.push(record);
    }
    assert_eq!(reader.ending(), Some(Ending::Whole));
    records
}

/// Largest distance of a frame's place in the scene from that in the results, meters.
fn largest_gap(scene: &Scene, outcome: &RunOutcome) -> f64 {
    let gap = |frame: &runtime::FrameRecord| {
        let shown = scene.frame(frame.index).unwrap().world_from_cam;
        match frame.world_from_cam.filter(|_| frame.status.has_pose()) {
            Some(pose) => (pose.translation - shown.unwrap().translation).norm(),
            None => f64::from(u8::from(shown.is_some())),
        }
    };
    outcome.frames.iter().map(gap).fold(0.0, f64::max)
}

#[test]
fn a_watched_run_has_the_same_bits_and_the_stream_adds_up_to_its_results() {
    for schedule in [Schedule::Sequential, Schedule::Lockstep] {
        let bytes = Bytes::default();
        let options = StreamOptions { image_every: 4, image_width: 320, ..StreamOptions::default() };
        let (outcome, report) = streamed(schedule, bytes.clone(), options, || {});
        assert_eq!(bits(&outcome), bits(in_turn()), "{schedule:?}");
        assert_eq!(report.broken, None);
        assert_eq!(report.n_bytes, bytes.0.lock().unwrap().len() as u64);
        let records = records(&bytes);
        assert!(matches!(records.first(), Some(Record::Start(_))));
        let (Some(Record::End(end)), rest) = (records.last(), &records[..records.len() - 1]) else {
            panic!("no end");
        };
        let mut scene = Scene::default();
        rest.iter().for_each(|record| scene.apply(record));
        // Only by the keyframes that the frames follow, through a loop, a joined sub-map and a global bundle adjustment.
        let gap = largest_gap(&scene, &outcome);
        assert!(gap < 1e-6, "{schedule:?}: {gap} m");
        assert_eq!(
            (scene.keyframes().len(), scene.n_points()),
            (outcome.map.n_keyframes(), outcome.map.n_points())
        );
        scene.apply(&Record::End(end.clone()));
        assert!(largest_gap(&scene, &outcome) < 1e-9);
        assert_eq!(end.summary, "numbers");
        let closed =
            |r: &Record| matches!(r, Record::Text(t) if t.text.contains("closed, joining two sub-maps"));
        assert!(records.iter().any(closed), "the loop is told");
    }
}

#[test]
fn features_and_images_come_with_their_frames() {
    let bytes = Bytes::default();
    let options = StreamOptions { image_every: 4, image_width: 320, ..StreamOptions::default() };
    let (_, report) = streamed(Schedule::Sequential, bytes.clone(), options, || {});
    let records = records(&bytes);
    let frames = records.iter().filter(|r| matches!(r, Record::Frame(_))).count();
    assert_eq!(frames, revisit().len());
    let (mut images, mut tracked, mut last) = (0, 0, None);
    for record in &records {
        match record {
            Record::Frame(frame) => last = Some(frame.clone()),
            Record::Image(image) => {
                images += 1;
                assert!(image.frame.is_multiple_of(4));
                assert!(image.size[0] <= 320 && image.jpeg.starts_with(&[0xff, 0xd8]), "{:?}", image.size);
            }
            Record::Features(features) => {
                let frame = last.as_ref().filter(|frame| frame.index == features.frame).unwrap();
                let of = |state| features.states.iter().filter(|s| **s == state).count() as u32;
                let [good, bad] = [events::FeatureState::Tracked, events::FeatureState::Outlier].map(of);
                assert_eq!(features.pixels.len() as u32, frame.counts.features);
                assert_eq!(
                    (good, good + bad),
                    (frame.counts.inliers, frame.counts.matches),
                    "{}",
                    frame.index
                );
                tracked += good;
            }
            _ => {}
        }
    }
    // In turn every fourth frame is written unless the writer was behind, which is counted.
    assert!(images + report.left_out as usize >= revisit().len() / 4, "{images} images, {report:?}");
    assert!(tracked > 0, "some features are tracked");
}

/// A target that takes this many bytes and then fails.
struct Broken(usize);

impl Write for Broken {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.0 == 0 {
            return Err(io::ErrorKind::BrokenPipe.into());
        }
        let n = bytes.len().min(self.0);
        self.0 -= n;
        Ok(n)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_reader_that_goes_away_does_not_change_the_run() {
    for room in [0, 20, 200_000] {
        let (outcome, report) = streamed(Schedule::Lockstep, Broken(room), StreamOptions::default(), || {});
        assert_eq!(bits(&outcome), bits(in_turn()));
        assert!(report.broken.as_ref().is_some_and(|reason| reason.contains("broken pipe")), "{report:?}");
        assert!(report.left_out > 0);
    }
}

/// A target that takes nothing before it is allowed to.
struct Closed(Option<Receiver<()>>, Bytes);

impl Write for Closed {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if let Some(gate) = self.0.take() {
            gate.recv().unwrap();
        }
        self.1.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_run_never_waits_for_its_reader() {
    let bytes = Bytes::default();
    let (open, gate): (Sender<()>, _) = channel();
    let target = Closed(Some(gate), bytes.clone());
    // The gate opens when the run is over: a run that waited for the reader would wait for ever.
    let few = StreamOptions { max_waiting: 32, ..StreamOptions::default() };
    let (outcome, report) = streamed(Schedule::Lockstep, target, few, || open.send(()).unwrap());
    assert_eq!(bits(&outcome), bits(in_turn()));
    assert!(report.left_out > 0 && report.broken.is_none(), "{report:?}");
    let records = records(&bytes);
    let frames = records.iter().filter(|r| matches!(r, Record::Frame(_))).count();
    assert_eq!(frames, revisit().len(), "poses wait for the reader");
    let mut scene = Scene::default();
    records.iter().for_each(|record| scene.apply(record));
    assert_eq!(scene.n_points(), outcome.map.n_points(), "so does the newest state of the map");
}

#[test]
fn a_stream_is_bounded() {
    let bytes = Bytes::default();
    let options = StreamOptions { max_bytes: 60_000, ..StreamOptions::default() };
    let (_, report) = streamed(Schedule::Lockstep, bytes.clone(), options, || {});
    assert!(report.n_bytes < 150_000 && report.left_out > 0, "{report:?}");
    let records = records(&bytes);
    assert!(matches!(records.last(), Some(Record::End(_))));
    let full = |r: &Record| matches!(r, Record::Text(t) if t.text.starts_with("the event stream is full"));
    assert!(records.iter().any(full), "it says so");
}

//! The sequential schedule: tracking and mapping of one frame are done before the next frame is looked at.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use features::{Frame, FrameBuilder};
use io::LoadedFrame;
use slam::{Mapper, OffsetEstimate, TrackState, TrackStats, Tracked, Tracker, estimate_disparity_offset};

use crate::events::{Event, Observer, Silent};
use crate::feed::FrameFeed;
use crate::prefetch::{Fetched, with_prefetch};
use crate::record::{FrameRecord, FrameStatus, RelativePose, RunError, RunOutcome};
use crate::setup::{Sensor, Setup};
use crate::timings::{Stopwatch, Timings};

/// Runs over all frames of `feed`, or until `stop` becomes true; what was computed until then is returned.
///
/// # Errors
/// If the feed is empty or the decoding thread cannot be started.
pub fn run(
    feed: &dyn FrameFeed,
    setup: &Setup,
    observer: &mut dyn Observer,
    stop: &AtomicBool,
) -> Result<RunOutcome, RunError> {
    if feed.is_empty() {
        return Err(RunError::NoFrames);
    }
    let calibration = calibrate(feed, setup, observer, stop)?;
    let disparity_offset_px =
        setup.disparity_offset_px + calibration.map_or(0.0, |estimate| estimate.offset_px);
    observer.event(&Event::Started { frames: feed.len() });
    let mut outcome = with_prefetch(feed, feed.len(), |frames| {
        let mut run = Run::new(setup, disparity_offset_px);
        for fetched in frames {
            run.step(fetched, observer);
            if stop.load(Ordering::Relaxed) {
                break;
            }
        }
        let interrupted = run.records.len() < feed.len();
        run.finish(interrupted)
    })?;
    outcome.calibration = calibration;
    Ok(outcome)
}

/// A first pass over the first frames whose only result is the disparity offset.
fn calibrate(
    feed: &dyn FrameFeed,
    setup: &Setup,
    observer: &mut dyn Observer,
    stop: &AtomicBool,
) -> Result<Option<OffsetEstimate>, RunError> {
    let frames = setup.calibration_frames.min(feed.len());
    if frames == 0 || setup.sensor != Sensor::Stereo {
        return Ok(None);
    }
    let estimate = with_prefetch(feed, frames, |fetched| {
        let mut run = Run::new(setup, setup.disparity_offset_px);
        for (done, fetched) in fetched.into_iter().enumerate() {
            if stop.load(Ordering::Relaxed) {
                return None;
            }
            run.step(fetched, &mut Silent);
            observer.event(&Event::Calibrating { done: done + 1, frames });
        }
        estimate_disparity_offset(&run.mapper.world().map)
    })?;
    observer.event(&Event::Calibrated { estimate });
    Ok(estimate)
}

/// The state of a run between two frames.
struct Run<'a> {
    setup: &'a Setup,
    disparity_offset_px: f64,
    builder: FrameBuilder,
    tracker: Tracker,
    mapper: Mapper,
    records: Vec<FrameRecord>,
    /// Parallel to `records`.
    relative: Vec<Option<RelativePose>>,
    timings: Timings,
}

impl<'a> Run<'a> {
    fn new(setup: &'a Setup, disparity_offset_px: f64) -> Self {
        Run {
            setup,
            disparity_offset_px,
            builder: FrameBuilder::new(
                setup.rig.clone(),
                setup.extractor.clone(),
                setup.stereo.clone(),
                setup.depth.clone(),
            )
            .with_disparity_offset(disparity_offset_px),
            tracker: Tracker::new(setup.slam.clone()),
            mapper: Mapper::new(setup.slam.clone(), slam::World::default()),
            records: Vec::new(),
            relative: Vec::new(),
            timings: Timings::default(),
        }
    }

    fn step(&mut self, fetched: Fetched, observer: &mut dyn Observer) {
        let mut watch = Stopwatch::new(fetched.info.index);
        watch.add("decode", fetched.decode_ms);
        let images = fetched.images.and_then(|images| usable(images, self.setup));
        let (status, relative) = match images {
            Err(reason) => {
                let status = FrameStatus::Dropped(reason);
                self.report_frame(fetched.info.index, &status, None, 0.0, observer);
                (status, self.relative.last().cloned().flatten())
            }
            Ok(images) => {
                let (frame, tracked) = watch.time("track", |watch| {
                    let frame = watch.time("extract", |_| {
                        Arc::new(build(&mut self.builder, self.setup.sensor, fetched.info, &images))
                    });
                    let tracked = self.tracker.track(&frame, self.mapper.world(), true, watch);
                    (frame, tracked)
                });
                drop(images);
                let track_ms = watch.last("track");
                let status = status_of(&tracked);
                let relative = self.map_frame(&tracked, &mut watch, observer);
                self.report_frame(
                    fetched.info.index,
                    &status,
                    Some((&frame, tracked.stats)),
                    track_ms,
                    observer,
                );
                (status, relative)
            }
        };
        self.records.push(FrameRecord {
            index: fetched.info.index,
            timestamp_s: fetched.info.timestamp_s,
            status,
            world_from_cam: None,
        });
        self.relative.push(relative);
        self.timings.rows.push(watch.finish());
    }

    /// Hands what tracking found to mapping; returns the frame's pose relative to a keyframe.
    fn map_frame(
        &mut self,
        tracked: &Tracked,
        watch: &mut Stopwatch,
        observer: &mut dyn Observer,
    ) -> Option<RelativePose> {
        self.mapper.count(&tracked.counts);
        let mut relative = tracked
            .reference
            .map(|reference| RelativePose { reference, cam_from_reference: tracked.cam_from_reference });
        if let Some(request) = &tracked.keyframe {
            watch.time("map", |watch| {
                let Some(id) = self.mapper.insert(request, watch) else { return };
                relative =
                    Some(RelativePose { reference: id, cam_from_reference: geometry::SE3::identity() });
                let report = self.mapper.refine(id, watch);
                let frame = request.frame.index;
                observer.event(&Event::Keyframe { id, frame, reason: request.reason, report });
            });
        }
        relative
    }

    fn report_frame(
        &self,
        index: u32,
        status: &FrameStatus,
        seen: Option<(&Frame, TrackStats)>,
        track_ms: f64,
        observer: &mut dyn Observer,
    ) {
        let (features, with_depth, stats) = seen.map_or((0, 0, TrackStats::default()), |(frame, stats)| {
            (frame.len(), (0..frame.len()).filter(|&i| frame.has_depth(i)).count(), stats)
        });
        let (keyframes, points) = (self.mapper.world().map.n_keyframes(), self.mapper.world().map.n_points());
        observer.event(&Event::Frame {
            index,
            status,
            stats,
            features,
            with_depth,
            keyframes,
            points,
            track_ms,
        });
    }

    /// Re-expresses every frame in the final map.
    fn finish(mut self, interrupted: bool) -> RunOutcome {
        let map = self.mapper.into_world().map;
        for (record, relative) in self.records.iter_mut().zip(&self.relative) {
            record.world_from_cam = relative.as_ref().and_then(|relative| relative.world_from_cam(&map));
        }
        RunOutcome {
            frames: self.records,
            map,
            disparity_offset_px: self.disparity_offset_px,
            calibration: None,
            timings: self.timings,
            interrupted,
        }
    }
}

fn status_of(tracked: &Tracked) -> FrameStatus {
    match tracked.state {
        TrackState::NotReady(reason) => FrameStatus::NotReady(reason),
        TrackState::Started | TrackState::Tracked => FrameStatus::Tracked { inliers: tracked.stats.inliers },
        TrackState::Lost(reason) => FrameStatus::Lost(reason),
    }
}

/// Whether the images fit the camera and each other.
fn usable(images: LoadedFrame, setup: &Setup) -> Result<LoadedFrame, String> {
    let expected = (setup.rig.width, setup.rig.height);
    let check = |name: &str, width: usize, height: usize| {
        if (width, height) == expected {
            return Ok(());
        }
        Err(format!(
            "the {name} image is {width} x {height} pixels, expected {} x {}",
            expected.0, expected.1
        ))
    };
    check("left", images.left.width, images.left.height)?;
    match setup.sensor {
        Sensor::Stereo => {
            let right = images.right.as_ref().ok_or("there is no right image")?;
            check("right", right.width, right.height)?;
        }
        Sensor::Rgbd => {
            let depth = images.depth.as_ref().ok_or("there is no depth image")?;
            check("depth", depth.width, depth.height)?;
        }
    }
    Ok(images)
}

fn build(builder: &mut FrameBuilder, sensor: Sensor, info: crate::FrameInfo, images: &LoadedFrame) -> Frame {
    match (sensor, &images.right, &images.depth) {
        (Sensor::Stereo, Some(right), _) => builder.stereo(info.index, info.timestamp_s, &images.left, right),
        (Sensor::Rgbd, _, Some(depth)) => builder.rgbd(info.index, info.timestamp_s, &images.left, depth),
        _ => builder.mono(info.index, info.timestamp_s, &images.left),
    }
}

//! Shows a stream, one record after another.

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use draw::gradient;
use events::{
    ActivationMap, Alignment, Features, FrameRecord, FrameState, Image, Level, Record, Scene, StageTime,
    Start, Text,
};
use geometry::SE3;
use rerun::blueprint::BlueprintActivation;
use rerun::{
    EncodedImage, Pinhole, Points2D, Radius, RecordingStream, RecordingStreamResult, TextDocument, TextLog,
    TextLogLevel, Transform3D, ViewCoordinates,
};

use crate::colors::{color, of_state};
use crate::draw::Drawer;
use crate::input::Reader;
use crate::layout::{self, Views, layout};
use crate::plots::Plots;

/// Frames between two alignments of the true path with the path so far.
const ALIGN_EVERY: u32 = 10;
/// Depth of the image in space as a multiple of the depth of keyframes' frusta.
const IMAGE_DEPTH: f64 = 3.0;
/// The same in the map's unit before there are keyframes to derive it from.
const FIRST_IMAGE_DEPTH: f64 = 1.5;
/// Opacity of the activation map over the image.
const OVERLAY_OPACITY: f32 = 0.45;

/// Shows everything until the stream ends.
///
/// # Errors
/// A damaged stream, after everything before the damage has been shown; those of the recording.
pub(crate) fn all(reader: &mut Reader, to: &RecordingStream) -> Result<()> {
    let mut show = Show {
        to,
        scene: Scene::default(),
        drawer: Drawer::default(),
        begin_s: None,
        times: BTreeMap::new(),
        image: [1.0; 2],
        image_size: [1; 2],
        image_depth: FIRST_IMAGE_DEPTH,
        alignment: None,
        plots: Plots::default(),
        views: Views::WithoutImage,
    };
    to.log_static(layout::WORLD, &ViewCoordinates::RIGHT_HAND_Y_DOWN())?;
    while let Some(record) = reader.next_record()? {
        show.record(&record).context("the recording")?;
    }
    Ok(())
}

/// The state of a show.
struct Show<'a> {
    to: &'a RecordingStream,
    scene: Scene,
    drawer: Drawer,
    /// Time of the first frame, seconds.
    begin_s: Option<f64>,
    /// Seconds since the first frame, by frame.
    times: BTreeMap<u32, f64>,
    /// Pixels of the shown image per pixel of the full one, in x and y.
    image: [f32; 2],
    /// Width and height of the shown image.
    image_size: [u32; 2],
    /// Depth of the image in space, in the map's unit.
    image_depth: f64,
    alignment: Option<Alignment>,
    plots: Plots,
    /// The views as they are laid out.
    views: Views,
}

impl Show<'_> {
    fn record(&mut self, record: &Record) -> RecordingStreamResult<()> {
        self.scene.apply(record);
        match record {
            Record::Start(start) => self.start(start),
            Record::Frame(frame) => self.frame(frame),
            Record::Features(features) => self.features(features),
            Record::Image(image) => self.show_image(image),
            Record::Activation(map) => self.activation(map),
            Record::Map(delta) => {
                self.at(delta.frame);
                self.drawer.draw(&mut self.scene, self.to)?;
                self.fit_image()?;
                self.map_size()
            }
            Record::Stages { frame, stages } => {
                self.at(*frame);
                self.stages(stages)
            }
            Record::Text(text) => self.text(text),
            Record::End(end) => {
                self.at(self.scene.newest_frame().unwrap_or(0));
                self.align()?;
                self.drawer.draw(&mut self.scene, self.to)?;
                self.errors()?;
                self.to.log(layout::SUMMARY, &TextDocument::from_markdown(end.summary.clone()))
            }
        }
    }

    /// What is logged from now on belongs to this frame.
    fn at(&self, frame: u32) {
        self.to.set_time_sequence(layout::FRAME, i64::from(frame));
        let known = self.times.get(&frame).or_else(|| self.times.range(..frame).next_back().map(|(_, t)| t));
        self.to.set_duration_secs(layout::TIME, known.copied().unwrap_or(0.0));
    }

    fn start(&mut self, start: &Start) -> RecordingStreamResult<()> {
        self.to.send_recording_name(format!("{} ({})", start.sequence, start.sensor))?;
        self.pinhole(start.camera.size)
    }

    /// The camera for an image of this size.
    fn pinhole(&mut self, size: [u32; 2]) -> RecordingStreamResult<()> {
        let Some(camera) = self.scene.start().map(|start| start.camera) else { return Ok(()) };
        self.image_size = size;
        self.image = [0, 1].map(|i| size[i] as f32 / camera.size[i].max(1) as f32);
        let [sx, sy] = self.image;
        let [fx, fy] = camera.focal.map(|f| f as f32);
        let [cx, cy] = camera.center.map(|c| c as f32);
        let columns = [[fx * sx, 0.0, 0.0], [0.0, fy * sy, 0.0], [cx * sx, cy * sy, 1.0]];
        let pinhole = Pinhole::new(columns).with_resolution([size[0] as f32, size[1] as f32]);
        self.to.log_static(layout::IMAGE, &pinhole.with_image_plane_distance(self.image_depth as f32))
    }

    /// Scales the image in space to fit the keyframes: a street needs another size than a desk.
    fn fit_image(&mut self) -> RecordingStreamResult<()> {
        match self.drawer.frustum_depth().map(|depth| IMAGE_DEPTH * depth) {
            Some(depth) if depth != self.image_depth => {
                self.image_depth = depth;
                self.pinhole(self.image_size)
            }
            _ => Ok(()),
        }
    }

    fn frame(&mut self, frame: &FrameRecord) -> RecordingStreamResult<()> {
        let begin_s = *self.begin_s.get_or_insert(frame.timestamp_s);
        self.times.insert(frame.index, frame.timestamp_s - begin_s);
        self.at(frame.index);
        if let Some(pose) = self.scene.frame(frame.index).and_then(|placed| placed.world_from_cam) {
            self.to.log(layout::CAMERA, &transform(&pose))?;
        }
        self.stages(&frame.stages)?;
        if frame.state != FrameState::Dropped {
            let c = &frame.counts;
            let counts = [
                ("features", c.features),
                ("with_depth", c.with_depth),
                ("visible", c.visible),
                ("matches", c.matches),
                ("inliers", c.inliers),
            ];
            for (name, count) in counts {
                self.plot(layout::COUNTS, name, f64::from(count))?;
            }
        }
        if let Some(trust) = &frame.trust {
            self.plot(layout::QUALITY, "quality", f64::from(trust.quality))?;
            if let Some([m, deg]) = trust.sigma {
                self.plot(layout::SIGMA, "position_m", f64::from(m))?;
                self.plot(layout::SIGMA, "rotation_deg", f64::from(deg))?;
            }
        }
        if frame.index.is_multiple_of(ALIGN_EVERY) || self.alignment.is_none() {
            self.align()?;
        }
        self.error_of(frame.index)?;
        self.drawer.draw(&mut self.scene, self.to)
    }

    fn stages(&mut self, stages: &[StageTime]) -> RecordingStreamResult<()> {
        stages.iter().try_for_each(|stage| self.plot(layout::TIMES, &stage.name, f64::from(stage.ms)))
    }

    fn plot(&mut self, plot: &'static str, name: &str, value: f64) -> RecordingStreamResult<()> {
        self.plots.add(plot, name, value, self.to)
    }

    fn map_size(&mut self) -> RecordingStreamResult<()> {
        let keyframes = self.scene.keyframes();
        let submaps = keyframes.values().filter(|k| k.parent.is_none()).count();
        let sizes = [("keyframes", keyframes.len()), ("points", self.scene.n_points()), ("submaps", submaps)];
        sizes.iter().try_for_each(|(name, n)| self.plot(layout::MAP_SIZE, name, *n as f64))
    }

    fn features(&self, features: &Features) -> RecordingStreamResult<()> {
        self.at(features.frame);
        let [sx, sy] = self.image;
        let at: Vec<[f32; 2]> = features.pixels.iter().map(|[x, y]| [x * sx, y * sy]).collect();
        let colors = features.states.iter().map(|state| color(of_state(*state)));
        let points = Points2D::new(at.clone()).with_colors(colors);
        self.to.log(layout::FEATURES, &points.with_radii([Radius::new_ui_points(1.5)]))?;
        if features.activations.iter().all(|a| *a == u8::MAX) {
            return Ok(());
        }
        let colors = features.activations.iter().map(|a| color(gradient(f64::from(*a) / 255.0)));
        let points = Points2D::new(at).with_colors(colors);
        self.to.log(layout::FEATURE_ACTIVATION, &points.with_radii([Radius::new_ui_points(3.0)]))
    }

    /// Rebuilds the views if there is something to show that has no view yet.
    fn lay_out(&mut self, views: Views) -> RecordingStreamResult<()> {
        if views <= self.views {
            return Ok(());
        }
        self.views = views;
        layout(views).send(self.to, BlueprintActivation::default())
    }

    fn show_image(&mut self, image: &Image) -> RecordingStreamResult<()> {
        self.lay_out(Views::WithImage)?;
        if image.size != self.image_size {
            self.pinhole(image.size)?;
        }
        self.at(image.frame);
        let encoded = EncodedImage::from_file_contents(image.jpeg.clone());
        self.to.log(layout::IMAGE, &encoded.with_draw_order(-20.0_f32))
    }

    /// The activation map in colors over the image, in the image's size.
    fn activation(&mut self, map: &ActivationMap) -> RecordingStreamResult<()> {
        self.lay_out(Views::WithActivation)?;
        self.at(map.frame);
        let [width, height] = self.image_size;
        let of = |x: u32, y: u32| {
            let column = u64::from(x) * u64::from(map.size[0]) / u64::from(width.max(1));
            let row = u64::from(y) * u64::from(map.size[1]) / u64::from(height.max(1));
            let at = usize::try_from(row * u64::from(map.size[0]) + column).ok();
            at.and_then(|at| map.values.get(at)).copied().unwrap_or(0)
        };
        let pixels: Vec<u8> = (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .flat_map(|(x, y)| gradient(f64::from(of(x, y)) / 255.0))
            .collect();
        let overlay = rerun::Image::from_rgb24(pixels, [width, height]).with_opacity(OVERLAY_OPACITY);
        self.to.log(layout::ACTIVATION, &overlay.with_draw_order(-10.0_f32))
    }

    fn text(&self, text: &Text) -> RecordingStreamResult<()> {
        self.at(text.frame.or(self.scene.newest_frame()).unwrap_or(0));
        let level = match text.level {
            Level::Info => TextLogLevel::INFO,
            Level::Warning => TextLogLevel::WARN,
        };
        self.to.log(layout::LOG, &TextLog::new(text.text.as_str()).with_level(level))
    }

    /// Lays the true path onto the path so far.
    fn align(&mut self) -> RecordingStreamResult<()> {
        self.alignment = self.scene.alignment();
        match &self.alignment {
            Some(alignment) => self.drawer.truth(&self.scene, alignment, self.to),
            None => Ok(()),
        }
    }

    /// The error of a frame as it looks now.
    fn error_of(&mut self, frame: u32) -> RecordingStreamResult<()> {
        match self.alignment.as_ref().and_then(|alignment| self.scene.error_m(alignment, frame)) {
            Some(error) => self.plot(layout::ERRORS, layout::ERROR, error),
            None => Ok(()),
        }
    }

    /// The errors of all frames in the final map.
    fn errors(&mut self) -> RecordingStreamResult<()> {
        let Some(alignment) = self.alignment else { return Ok(()) };
        for (frame, error) in self.scene.errors_m(&alignment) {
            self.at(frame);
            self.plot(layout::ERRORS, layout::FINAL_ERROR, error)?;
        }
        self.at(self.scene.newest_frame().unwrap_or(0));
        Ok(())
    }
}

/// The camera in the world.
fn transform(world_from_cam: &SE3) -> Transform3D {
    let (m, t) = (world_from_cam.rotation.matrix(), world_from_cam.translation);
    let column = |c: usize| [m[(0, c)] as f32, m[(1, c)] as f32, m[(2, c)] as f32];
    let translation = [t.x as f32, t.y as f32, t.z as f32];
    Transform3D::from_translation_mat3x3(translation, [column(0), column(1), column(2)])
}

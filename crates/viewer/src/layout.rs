//! Names of what is shown, and how the views are laid out, so that the default view needs no setup.

use rerun::blueprint::components::{PanelState, PlayState};
use rerun::blueprint::{
    Blueprint, BlueprintPanel, ContainerLike, Horizontal, SelectionPanel, Spatial2DView, Spatial3DView, Tabs,
    TextDocumentView, TextLogView, TimePanel, TimeSeriesView, Vertical,
};

/// The time line of frame numbers.
pub(crate) const FRAME: &str = "frame";
/// The time line of seconds since the first frame.
pub(crate) const TIME: &str = "time";

/// Everything in space.
pub(crate) const WORLD: &str = "world";
/// The camera as it is now.
pub(crate) const CAMERA: &str = "world/camera";
/// Its image.
pub(crate) const IMAGE: &str = "world/camera/image";
/// Features colored by their tracking outcome.
pub(crate) const FEATURES: &str = "world/camera/image/features";
/// Features colored by activation.
pub(crate) const FEATURE_ACTIVATION: &str = "world/camera/image/feature_activation";
/// The activation map as an overlay.
pub(crate) const ACTIVATION: &str = "world/camera/image/activation";
/// Map points, in blocks.
pub(crate) const POINTS: &str = "world/points";
/// Keyframes, in blocks.
pub(crate) const KEYFRAMES: &str = "world/keyframes";
/// Covisibility edges, in blocks.
pub(crate) const COVISIBILITY: &str = "world/covisibility";
/// Loop edges, in blocks.
pub(crate) const LOOPS: &str = "world/loops";
/// The path so far, in blocks.
pub(crate) const TRAJECTORY: &str = "world/trajectory";
/// The true path.
pub(crate) const TRUTH: &str = "world/ground_truth";
/// Where each sub-map begins.
pub(crate) const SUBMAPS: &str = "world/submaps";
/// Times of stages, milliseconds.
pub(crate) const TIMES: &str = "plots/times_ms";
/// Counts of tracking.
pub(crate) const COUNTS: &str = "plots/counts";
/// How far poses are to be trusted.
pub(crate) const QUALITY: &str = "plots/quality";
/// Largest standard deviations of poses.
pub(crate) const SIGMA: &str = "plots/sigma";
/// Size of the map.
pub(crate) const MAP_SIZE: &str = "plots/map";
/// Distances from the truth, meters.
pub(crate) const ERRORS: &str = "plots/error_m";
/// As it looked when the frame was new.
pub(crate) const ERROR: &str = "when_new";
/// In the final map.
pub(crate) const FINAL_ERROR: &str = "final";
/// The log.
pub(crate) const LOG: &str = "log";
/// The numbers of the run.
pub(crate) const SUMMARY: &str = "summary";

/// Stages whose times are shown at first; the others are steps of these.
const STAGES: [&str; 5] = ["decode", "extract", "track", "map", "loop"];

/// Which views there are; each adds one to those before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Views {
    /// Those of every stream.
    WithoutImage,
    /// Also the image.
    WithImage,
    /// Also the image under its activation.
    WithActivation,
}

/// The views: space and the times of stages on the left; images, counts and texts on the right.
pub(crate) fn layout(views: Views) -> Blueprint {
    let space = Spatial3DView::new("map and trajectory: points from violet (move) to yellow (stand)")
        .with_origin(WORLD)
        .with_contents([
            "+ $origin/**".to_owned(),
            format!("- {FEATURE_ACTIVATION}"),
            format!("- {ACTIVATION}"),
        ]);
    let left = Vertical::new([ContainerLike::from(space), times().into()]).with_row_shares([3.0, 1.0]);
    let mut side: Vec<ContainerLike> = Vec::new();
    if views >= Views::WithImage {
        side.push(image().into());
    }
    if views >= Views::WithActivation {
        side.push(activation().into());
    }
    side.extend([counts().into(), texts(views).into()]);
    let right = Vertical::new(side);
    let root = Horizontal::new([ContainerLike::from(left), right.into()]).with_column_shares([3.0, 2.0]);
    Blueprint::new(root)
        .with_auto_views(false)
        .with_blueprint_panel(BlueprintPanel::from_state(PanelState::Collapsed))
        .with_selection_panel(SelectionPanel::from_state(PanelState::Collapsed))
        .with_time_panel(
            TimePanel::new()
                .with_state(PanelState::Collapsed)
                .with_timeline(FRAME)
                .with_play_state(PlayState::Following),
        )
}

/// The image with features in the colors of what tracking made of them.
fn image() -> Spatial2DView {
    Spatial2DView::new("image: tracked green, new blue, outliers red").with_origin(IMAGE).with_contents([
        "+ $origin/**".to_owned(),
        format!("- {FEATURE_ACTIVATION}"),
        format!("- {ACTIVATION}"),
    ])
}

/// The image under its activation, with features in the colors of theirs.
fn activation() -> Spatial2DView {
    Spatial2DView::new("activation: from violet (moves) to yellow (trusted)")
        .with_origin(IMAGE)
        .with_contents(["+ $origin/**".to_owned(), format!("- {FEATURES}")])
}

fn times() -> Tabs {
    let stages = STAGES.map(|stage| format!("+ $origin/{stage}"));
    let others = STAGES.map(|stage| format!("- $origin/{stage}"));
    let steps = std::iter::once("+ $origin/**".to_owned()).chain(others);
    Tabs::new([
        ContainerLike::from(
            TimeSeriesView::new("times of stages [ms]").with_origin(TIMES).with_contents(stages),
        ),
        TimeSeriesView::new("of their steps [ms]").with_origin(TIMES).with_contents(steps).into(),
    ])
}

fn counts() -> Tabs {
    Tabs::new([
        ContainerLike::from(TimeSeriesView::new("counts").with_origin(COUNTS)),
        TimeSeriesView::new("map size").with_origin(MAP_SIZE).into(),
        TimeSeriesView::new("error [m]").with_origin(ERRORS).into(),
        TimeSeriesView::new("quality").with_origin(QUALITY).into(),
        TimeSeriesView::new("largest sigma").with_origin(SIGMA).into(),
    ])
}

/// The log first, but of a stream without images, which is made out of a run's files and has no log, the summary.
fn texts(views: Views) -> Tabs {
    let mut texts = [
        ContainerLike::from(TextLogView::new("log").with_origin(LOG)),
        TextDocumentView::new("summary").with_origin(SUMMARY).into(),
    ];
    if views == Views::WithoutImage {
        texts.reverse();
    }
    Tabs::new(texts)
}

/// The name of a block of something; names sort like the blocks.
pub(crate) fn block(of: &str, block: u32) -> String {
    format!("{of}/{block:05}")
}

//! Names of what is shown, and how the views are laid out, so that a first look needs no click.

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
/// Features coloured by what tracking made of them.
pub(crate) const FEATURES: &str = "world/camera/image/features";
/// Features coloured by activation.
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
/// Size of the map.
pub(crate) const MAP_SIZE: &str = "plots/map";
/// Distance from the truth as it looked when the frame was new.
pub(crate) const ERROR: &str = "plots/error/when_new_m";
/// Distance from the truth in the final map.
pub(crate) const FINAL_ERROR: &str = "plots/error/final_m";
/// The log.
pub(crate) const LOG: &str = "log";
/// The numbers of the run.
pub(crate) const SUMMARY: &str = "summary";

/// The views: space on the left; image, plots and texts on the right.
pub(crate) fn layout() -> Blueprint {
    let space = Spatial3DView::new("map and trajectory").with_origin(WORLD);
    let image = Spatial2DView::new("image").with_origin(IMAGE);
    let plots = Tabs::new([
        ContainerLike::from(TimeSeriesView::new("stage times [ms]").with_origin(TIMES)),
        TimeSeriesView::new("map size").with_origin(MAP_SIZE).into(),
    ]);
    let counts = Tabs::new([
        ContainerLike::from(TimeSeriesView::new("counts").with_origin(COUNTS)),
        TimeSeriesView::new("error [m]").with_origin("plots/error").into(),
    ]);
    let texts = Tabs::new([
        ContainerLike::from(TextLogView::new("log").with_origin(LOG)),
        TextDocumentView::new("summary").with_origin(SUMMARY).into(),
    ]);
    let side = Vertical::new([ContainerLike::from(image), plots.into(), counts.into(), texts.into()])
        .with_row_shares([3.0, 2.0, 2.0, 2.0]);
    let root = Horizontal::new([ContainerLike::from(space), side.into()]).with_column_shares([3.0, 2.0]);
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

/// The name of a block of something; names sort like the blocks.
pub(crate) fn block(of: &str, block: u32) -> String {
    format!("{of}/{block:05}")
}

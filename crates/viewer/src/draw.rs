//! Draws what has changed in the scene: points, keyframes, edges, the path, the true path.

use events::{Alignment, KeyframeUpdate, PointUpdate, Scene};
use geometry::{SE3, Vec3, median};
use rerun::{Color, LineStrips3D, Points3D, Radius, RecordingStream, RecordingStreamResult};

use crate::colors::{self, color, in_space, of_submap};
use crate::layout::{self, block};

/// Depth of a keyframe's frustum as a share of the median distance between neighbors on the path.
const FRUSTUM_SHARE: f64 = 0.6;
/// Points farther from all cameras than this multiple of that distance are not drawn: the view shows everything that there is, and a
/// few points at the horizon would make the rest tiny.
const REACH: f64 = 60.0;
/// The true path is redrawn when the alignment moves it by this share of its extent.
const TRUTH_MOVED_SHARE: f64 = 0.003;

/// Draws scenes; knows what is drawn.
#[derive(Debug, Default)]
pub(crate) struct Drawer {
    /// The true path as it is drawn.
    truth: Vec<Vec<Vec3>>,
    /// Roots of the sub-maps that are drawn.
    roots: Vec<u32>,
    /// Depth of frusta, in the map's unit; fixed with the first keyframes.
    frustum: Option<f64>,
    /// Whether points have activations other than full trust.
    has_activation: bool,
}

impl Drawer {
    /// Draws everything that has changed since the last call.
    ///
    /// # Errors
    /// Those of the recording.
    pub(crate) fn draw(&mut self, scene: &mut Scene, to: &RecordingStream) -> RecordingStreamResult<()> {
        let dirty = scene.take_dirty();
        let reach = if dirty.points.is_empty() { None } else { Reach::of(scene) };
        for &b in &dirty.points {
            self.points(scene, b, reach.as_ref(), to)?;
        }
        if !dirty.keyframes.is_empty() {
            self.submaps(scene, to)?;
        }
        for &b in &dirty.keyframes {
            self.keyframes(scene, b, to)?;
        }
        for &b in &dirty.edges {
            let radius = Radius::new_ui_points(0.5);
            let edges = strips(scene.edges_in(b, |k| &k.covisible));
            let [r, g, blue, a] = colors::COVISIBILITY;
            let faint = Color::from_unmultiplied_rgba(r, g, blue, a);
            to.log(block(layout::COVISIBILITY, b), &lines(edges, faint, radius))?;
            let loops = strips(scene.edges_in(b, |k| &k.loops));
            to.log(block(layout::LOOPS, b), &lines(loops, color(colors::LOOP), Radius::new_ui_points(3.0)))?;
        }
        for &b in &dirty.path {
            let path = scene.path_in(b).iter().map(|strip| flat(strip)).collect();
            let radius = Radius::new_ui_points(2.5);
            to.log(block(layout::TRAJECTORY, b), &lines(path, color(colors::TRAJECTORY), radius))?;
        }
        Ok(())
    }

    /// Draws the true path if the alignment has moved it visibly.
    ///
    /// # Errors
    /// Those of the recording.
    pub(crate) fn truth(
        &mut self,
        scene: &Scene,
        alignment: &Alignment,
        to: &RecordingStream,
    ) -> RecordingStreamResult<()> {
        let path = scene.true_path(alignment);
        if has_moved(&self.truth, &path) {
            let strips = path.iter().map(|strip| flat(strip)).collect();
            to.log(layout::TRUTH, &lines(strips, color(colors::TRUTH), Radius::new_ui_points(1.2)))?;
            self.truth = path;
        }
        Ok(())
    }

    /// Depth of the frusta of keyframes, in the map's unit; `None` before there are enough keyframes to derive it from.
    pub(crate) fn frustum_depth(&self) -> Option<f64> {
        self.frustum
    }

    fn points(
        &mut self,
        scene: &Scene,
        b: u32,
        reach: Option<&Reach>,
        to: &RecordingStream,
    ) -> RecordingStreamResult<()> {
        let n_frames = scene.start().map_or(1, |start| start.n_frames).max(1);
        self.has_activation |= scene.points_in(b).any(|point| point.activation < u8::MAX);
        let color = |point: &PointUpdate| {
            let share = if self.has_activation {
                f64::from(point.activation) / 255.0
            } else {
                f64::from(point.born) / f64::from(n_frames)
            };
            color(in_space(share))
        };
        let drawn =
            || scene.points_in(b).filter(|point| reach.is_none_or(|reach| reach.has(&point.position)));
        let points = Points3D::new(drawn().map(|point| point.position))
            .with_colors(drawn().map(color))
            .with_radii([Radius::new_ui_points(1.2)]);
        to.log(block(layout::POINTS, b), &points)
    }

    fn keyframes(&mut self, scene: &Scene, b: u32, to: &RecordingStream) -> RecordingStreamResult<()> {
        let depth = match self.frustum {
            Some(depth) => depth,
            None => {
                let depth = frustum_depth(scene);
                if scene.keyframes().len() > 3 {
                    self.frustum = Some(depth);
                }
                depth
            }
        };
        let corners = frustum_corners(scene, depth);
        let frusta: Vec<Vec<[f32; 3]>> = scene.keyframes_in(b).map(|k| frustum(k, &corners)).collect();
        let colors = scene.keyframes_in(b).map(|k| color(of_submap(k.submap)));
        let keyframes =
            LineStrips3D::new(frusta).with_colors(colors).with_radii([Radius::new_ui_points(0.6)]);
        to.log(block(layout::KEYFRAMES, b), &keyframes)
    }

    /// A label at the root of each sub-map, when there is another set of them.
    fn submaps(&mut self, scene: &Scene, to: &RecordingStream) -> RecordingStreamResult<()> {
        let roots: Vec<&KeyframeUpdate> = scene.keyframes().values().filter(|k| k.parent.is_none()).collect();
        let ids: Vec<u32> = roots.iter().map(|k| k.id).collect();
        if ids == self.roots {
            return Ok(());
        }
        let centers = roots.iter().map(|k| point(&SE3::from(&k.cam_from_world).center()));
        let labels = Points3D::new(centers)
            .with_labels(ids.iter().map(|id| format!("sub-map K{id}")))
            .with_colors(ids.iter().map(|id| color(of_submap(*id))))
            .with_radii([Radius::new_ui_points(4.0)]);
        to.log(layout::SUBMAPS, &labels)?;
        self.roots = ids;
        Ok(())
    }
}

/// Lines in one color.
fn lines(strips: Vec<Vec<[f32; 3]>>, color: Color, radius: Radius) -> LineStrips3D {
    LineStrips3D::new(strips).with_colors([color]).with_radii([radius])
}

fn strips(edges: Vec<[Vec3; 2]>) -> Vec<Vec<[f32; 3]>> {
    edges.iter().map(|edge| flat(edge)).collect()
}

fn flat(strip: &[Vec3]) -> Vec<[f32; 3]> {
    strip.iter().map(point).collect()
}

fn point(p: &Vec3) -> [f32; 3] {
    [p.x as f32, p.y as f32, p.z as f32]
}

/// How far the cameras see what is drawn: the box around the keyframes, and more.
struct Reach {
    least: Vec3,
    most: Vec3,
}

impl Reach {
    /// `None` before there are keyframes apart from each other.
    fn of(scene: &Scene) -> Option<Self> {
        let centers = centers(scene);
        let margin = Vec3::repeat(REACH * median_gap(&centers)?);
        let first = *centers.first()?;
        let least = centers.iter().fold(first, |least, c| least.inf(c));
        let most = centers.iter().fold(first, |most, c| most.sup(c));
        Some(Self { least: least - margin, most: most + margin })
    }

    fn has(&self, position: &[f32; 3]) -> bool {
        (0..3).all(|i| (self.least[i]..=self.most[i]).contains(&f64::from(position[i])))
    }
}

/// Where the keyframes were taken.
fn centers(scene: &Scene) -> Vec<Vec3> {
    scene.keyframes().values().map(|k| SE3::from(&k.cam_from_world).center()).collect()
}

/// The median distance between keyframes that follow each other.
fn median_gap(centers: &[Vec3]) -> Option<f64> {
    let mut gaps: Vec<f64> = centers.windows(2).map(|pair| (pair[1] - pair[0]).norm()).collect();
    median(&mut gaps).filter(|gap| *gap > 0.0)
}

/// The median distance decides how large frusta are.
fn frustum_depth(scene: &Scene) -> f64 {
    FRUSTUM_SHARE * median_gap(&centers(scene)).unwrap_or(0.5)
}

/// Corners of the image at a depth in the camera's coordinates, around it.
fn frustum_corners(scene: &Scene, depth: f64) -> [Vec3; 4] {
    let (focal, center, size) = scene
        .start()
        .map_or(([1.0; 2], [0.5; 2], [1; 2]), |s| (s.camera.focal, s.camera.center, s.camera.size));
    let at = |u: f64, v: f64| {
        Vec3::new((u - center[0]) / focal[0] * depth, (v - center[1]) / focal[1] * depth, depth)
    };
    let (w, h) = (f64::from(size[0]), f64::from(size[1]));
    [at(0.0, 0.0), at(w, 0.0), at(w, h), at(0.0, h)]
}

/// One line along all edges of a keyframe's frustum.
fn frustum(keyframe: &KeyframeUpdate, corners: &[Vec3; 4]) -> Vec<[f32; 3]> {
    let world_from_cam = SE3::from(&keyframe.cam_from_world).inverse();
    let [a, b, c, d] = corners.map(|corner| point(&(world_from_cam * corner)));
    let tip = point(&world_from_cam.translation);
    vec![tip, a, b, tip, c, d, tip, d, a, b, c]
}

/// Whether a path is visibly elsewhere.
fn has_moved(drawn: &[Vec<Vec3>], path: &[Vec<Vec3>]) -> bool {
    let points = || path.iter().flatten();
    if drawn.iter().map(Vec::len).ne(path.iter().map(Vec::len)) {
        return true;
    }
    let Some(first) = points().next() else { return false };
    let extent = points().map(|p| (p - first).norm()).fold(0.0, f64::max);
    let moved = drawn.iter().flatten().zip(points()).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    moved > TRUTH_MOVED_SHARE * extent
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_drawn_anew_only_when_it_moved_visibly() {
        let path = |x: f64| vec![vec![Vec3::new(x, 0.0, 0.0), Vec3::new(x, 100.0, 0.0)]];
        assert!(has_moved(&[], &path(0.0)));
        assert!(!has_moved(&path(0.0), &path(0.1)));
        assert!(has_moved(&path(0.0), &path(1.0)));
        assert!(!has_moved(&[], &[]));
    }

    #[test]
    fn points_at_the_horizon_are_out_of_reach() {
        let keyframe = |id: u32, z: f64| KeyframeUpdate {
            id,
            frame: id,
            cam_from_world: (&SE3::new(geometry::SO3::identity(), Vec3::new(0.0, 0.0, -z))).into(),
            scale: 1.0,
            submap: 0,
            parent: None,
            covisible: Vec::new(),
            loops: Vec::new(),
        };
        let mut scene = Scene::default();
        assert!(Reach::of(&scene).is_none());
        let keyframes = vec![keyframe(0, 0.0), keyframe(1, 1.0), keyframe(2, 2.0)];
        scene.apply(&events::Record::Map(events::MapDelta { keyframes, ..Default::default() }));
        let reach = Reach::of(&scene).expect("keyframes are a meter apart");
        assert!(reach.has(&[0.0, -10.0, 61.0]) && !reach.has(&[0.0, -10.0, 63.0]));
        assert!(reach.has(&[-59.0, 0.0, 0.0]) && !reach.has(&[-61.0, 0.0, 0.0]));
    }
}

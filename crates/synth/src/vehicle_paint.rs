//! Paints the faces of vehicles: doors, lamps, grilles, plates, windows with reflections, lettering on trucks.

use crate::canvas::{Canvas, Rect};
use crate::noise::{octaves, unit};
use crate::texture::Texture;

/// What kind of vehicle a face belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Model {
    Hatchback,
    Saloon,
    Van,
    Bus,
    Truck,
    Lorry,
    Tram,
}

/// A face of a vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// Flank without the upper windows, front to the left.
    Flank,
    /// Row of side windows, front to the left.
    Windows,
    Front,
    Rear,
    /// Windscreen or rear window.
    Glass,
    /// Bonnet and roof.
    Sheet,
    Wheel,
    /// Flank of a box body or a bus.
    Box,
    /// Rear doors of a box body.
    Doors,
    /// Flank of a tram: several cars.
    Cars,
}

impl Part {
    /// Texels in x and y.
    pub(crate) fn texels(self) -> [usize; 2] {
        match self {
            Self::Flank => [256, 64],
            Self::Windows => [256, 64],
            Self::Front | Self::Rear | Self::Glass | Self::Sheet => [128, 64],
            Self::Wheel => [64, 64],
            Self::Box => [512, 256],
            Self::Doors => [256, 256],
            Self::Cars => [1024, 128],
        }
    }
}

/// Paints a face; the canvas measures 1 x 1 whatever the face's true size.
pub(crate) fn bake(part: Part, model: Model, seed: u32) -> Texture {
    let [w, h] = part.texels();
    let r = |k: i32| unit(k, 9, seed);
    // Light, dark and silver vehicles in about equal numbers.
    let tone = match (r(0) * 3.0) as u32 {
        0 => 40.0 + 25.0 * r(1),
        1 => 105.0 + 45.0 * r(1),
        _ => 185.0 + 40.0 * r(1),
    };
    let mut canvas = Canvas::new(w, h, [1.0, 1.0], tone);
    // Reflections of the street in the paint.
    canvas.shade(|x, y, g| {
        g + 12.0 * octaves(4.0 * x, 9.0 * y, [64, 64], 4, 0.65, seed ^ 0x17) - 18.0 * (y - 0.4)
    });
    match part {
        Part::Flank => flank(&mut canvas, tone, model),
        Part::Windows => windows(&mut canvas, tone, seed),
        Part::Front => front(&mut canvas, tone, seed),
        Part::Rear => rear(&mut canvas, tone, model, seed),
        Part::Glass => glass(&mut canvas, seed),
        Part::Sheet => sheet(&mut canvas, tone),
        Part::Wheel => wheel(&mut canvas, seed),
        Part::Box => box_side(&mut canvas, tone, model, seed),
        Part::Doors => doors(&mut canvas, tone, seed),
        Part::Cars => cars(&mut canvas, tone, seed),
    }
    canvas.roughen(0.12, 3, 0.7, 4.0, seed ^ 0x5);
    canvas.into_texture()
}

fn flank(canvas: &mut Canvas, tone: f32, model: Model) {
    canvas.paint(Rect::new(0.0, 0.0, 1.0, 0.1), 0.6, |_, _| (tone * 1.5).min(250.0));
    canvas.paint(Rect::new(0.0, 0.35, 1.0, 0.05), 0.7, |_, _| tone * 0.62);
    canvas.fill(Rect::new(0.0, 0.84, 1.0, 0.16), 30.0);
    let doors: &[f32] = if model == Model::Van { &[0.28, 0.46, 0.75] } else { &[0.31, 0.53, 0.74] };
    for x in doors {
        canvas.fill(Rect::new(*x, 0.02, 0.006, 0.82), tone * 0.35);
    }
    for x in &doors[1..] {
        canvas.fill(Rect::new(x - 0.055, 0.2, 0.04, 0.06), (tone * 0.5 + 110.0).min(235.0));
    }
    canvas.fill(Rect::new(0.30, 0.5, 0.45, 0.06), tone * 0.45);
    // Lamps that reach round the corners.
    canvas.fill(Rect::new(0.0, 0.12, 0.045, 0.25), 235.0);
    canvas.fill(Rect::new(0.965, 0.1, 0.035, 0.35), 75.0);
    for x in [0.18, 0.81] {
        canvas.ellipse([x, 0.98], [0.098, 0.62], 18.0);
    }
}

fn windows(canvas: &mut Canvas, tone: f32, seed: u32) {
    let pane = |x: f32, y: f32| {
        38.0 + 26.0 * octaves(6.0 * x, 3.0 * y, [64, 64], 4, 0.6, seed ^ 0x71) + 35.0 * (0.4 - y).max(0.0)
    };
    for (x, w) in [(0.12, 0.32), (0.47, 0.26), (0.76, 0.15)] {
        canvas.fill(Rect::new(x - 0.012, 0.08, w + 0.024, 0.84), 20.0);
        canvas.paint(Rect::new(x, 0.13, w, 0.76), 1.0, pane);
    }
    canvas.fill(Rect::new(0.0, 0.94, 1.0, 0.06), tone * 0.5);
    // Head rests seen through the glass.
    for x in [0.3, 0.6] {
        canvas.ellipse([x, 0.55], [0.03, 0.2], 18.0);
    }
}

fn front(canvas: &mut Canvas, tone: f32, seed: u32) {
    for x in [0.03, 0.79] {
        canvas.fill(Rect::new(x, 0.18, 0.18, 0.2), 60.0);
        canvas.fill(Rect::new(x + 0.015, 0.2, 0.15, 0.16), 215.0);
        canvas.ellipse([x + 0.09, 0.28], [0.045, 0.075], 250.0);
        canvas.ellipse([x + 0.09, 0.28], [0.02, 0.035], 90.0);
    }
    canvas.fill(Rect::new(0.26, 0.2, 0.48, 0.22), 25.0);
    let bars = 3 + (unit(1, 1, seed) * 4.0) as i32;
    for i in 0..bars {
        canvas.fill(Rect::new(0.27, 0.22 + 0.2 * i as f32 / bars as f32, 0.46, 0.02), 150.0);
    }
    canvas.ellipse([0.5, 0.28], [0.035, 0.06], 230.0);
    canvas.fill(Rect::new(0.1, 0.7, 0.8, 0.2), 24.0);
    canvas.fill(Rect::new(0.0, 0.5, 1.0, 0.02), tone * 0.5);
    plate(canvas, Rect::new(0.35, 0.56, 0.3, 0.13), seed);
}

fn plate(canvas: &mut Canvas, rect: Rect, seed: u32) {
    canvas.fill(rect, 25.0);
    canvas.fill(Rect::new(rect.x + 0.006, rect.y + 0.012, rect.w - 0.012, rect.h - 0.024), 240.0);
    let text = Rect::new(rect.x + 0.02, rect.y + 0.02, rect.w - 0.04, rect.h);
    canvas.letters(text, 0.05, 25.0, seed ^ 0x99);
}

fn rear(canvas: &mut Canvas, tone: f32, model: Model, seed: u32) {
    let lamp_h = if model == Model::Van { 0.5 } else { 0.26 };
    for x in [0.02, 0.81] {
        canvas.fill(Rect::new(x, 0.12, 0.17, lamp_h), 60.0);
        canvas.fill(Rect::new(x + 0.02, 0.15, 0.06, lamp_h - 0.08), 190.0);
        canvas.fill(Rect::new(x + 0.1, 0.15, 0.05, 0.4 * lamp_h), 110.0);
    }
    canvas.frame(Rect::new(0.2, -0.1, 0.6, 0.7), 0.012, tone * 0.4);
    canvas.ellipse([0.5, 0.1], [0.03, 0.05], 225.0);
    canvas.letters(Rect::new(0.22, 0.06, 0.16, 0.08), 0.05, (tone + 110.0) % 250.0, seed);
    plate(canvas, Rect::new(0.35, 0.3, 0.3, 0.14), seed);
    canvas.fill(Rect::new(0.04, 0.66, 0.92, 0.03), tone * 0.5);
    canvas.fill(Rect::new(0.0, 0.82, 1.0, 0.18), 28.0);
    canvas.fill(Rect::new(0.08, 0.72, 0.1, 0.05), 90.0);
    canvas.fill(Rect::new(0.82, 0.72, 0.1, 0.05), 90.0);
}

fn glass(canvas: &mut Canvas, seed: u32) {
    let r = |k: i32| unit(k, 4, seed);
    canvas.shade(|x, y, _| {
        let cloud = octaves(3.0 * x, 3.0 * y, [64, 64], 5, 0.62, seed ^ 0x2f);
        52.0 + 30.0 * cloud + 60.0 * (0.45 - y).max(0.0) + if cloud > 0.35 { 16.0 } else { 0.0 }
    });
    canvas.frame(Rect::new(0.0, 0.0, 1.0, 1.0), 0.035, 22.0);
    for x in [0.27, 0.73] {
        canvas.ellipse([x, 0.55], [0.07, 0.16], 20.0);
    }
    canvas.fill(Rect::new(0.44, 0.05, 0.12, 0.1), 25.0);
    canvas.fill(Rect::new(0.06 + 0.1 * r(0), 0.75, 0.08, 0.1), 215.0);
    canvas.fill(Rect::new(0.1, 0.9, 0.8, 0.025), 18.0);
}

fn sheet(canvas: &mut Canvas, tone: f32) {
    for x in [0.2, 0.8] {
        canvas.fill(Rect::new(x - 0.01, 0.0, 0.02, 1.0), tone * 0.75);
    }
    canvas.paint(Rect::new(0.3, 0.0, 0.4, 1.0), 0.5, |_, _| (tone * 1.25).min(250.0));
    canvas.frame(Rect::new(0.0, 0.0, 1.0, 1.0), 0.02, tone * 0.5);
}

fn wheel(canvas: &mut Canvas, seed: u32) {
    canvas.shade(|_, _, _| 24.0);
    canvas.ellipse([0.5, 0.5], [0.34, 0.34], 165.0);
    canvas.ellipse([0.5, 0.5], [0.29, 0.29], 70.0);
    let spokes = 5 + (unit(3, 3, seed) * 3.0) as i32;
    for i in 0..spokes * 8 {
        let angle = (i / 8) as f32 * std::f32::consts::TAU / spokes as f32;
        let along = 0.04 + 0.03 * (i % 8) as f32;
        canvas.ellipse([0.5 + along * angle.cos(), 0.5 + along * angle.sin()], [0.035, 0.035], 185.0);
    }
    canvas.ellipse([0.5, 0.5], [0.06, 0.06], 220.0);
}

/// Letters and stripes on a box body; windows and doors on a bus.
fn box_side(canvas: &mut Canvas, tone: f32, model: Model, seed: u32) {
    let r = |k: i32| unit(k, 6, seed);
    let contrast = if tone > 128.0 { 40.0 } else { 225.0 };
    if model == Model::Bus {
        canvas.fill(Rect::new(0.01, 0.13, 0.98, 0.42), 20.0);
        for i in 0..8 {
            let x = 0.02 + 0.121 * i as f32;
            let pane = |u: f32, v: f32| 50.0 + 30.0 * octaves(9.0 * u, 5.0 * v, [64, 64], 4, 0.6, seed ^ i);
            canvas.paint(Rect::new(x, 0.15, 0.112, 0.38), 1.0, pane);
            canvas.ellipse([x + 0.03, 0.47], [0.014, 0.06], 95.0);
        }
        canvas.letters(Rect::new(0.08, 0.6, 0.8, 0.2), 0.1, contrast, seed);
        for x in [0.05, 0.45] {
            canvas.frame(Rect::new(x, 0.12, 0.09, 0.82), 0.006, 30.0);
        }
    } else {
        for i in 0..24 {
            canvas.paint(Rect::new(i as f32 / 24.0, 0.0, 0.006, 1.0), 0.6, |_, _| tone * 0.6);
        }
        canvas.paint(Rect::new(0.0, 0.1 + 0.5 * r(0), 1.0, 0.12), 0.8, |_, _| contrast);
        canvas.letters(Rect::new(0.06, 0.2, 0.88, 0.42), 0.13 + 0.12 * r(1), contrast, seed);
        canvas.letters(Rect::new(0.1, 0.7, 0.5, 0.15), 0.045, contrast, seed ^ 3);
        for k in 0..8 {
            let at = |j: i32| unit(k, 10 + j, seed);
            let shape = Rect::new(0.9 * at(0), 0.85 * at(1), 0.02 + 0.1 * at(2), 0.03 + 0.2 * at(3));
            canvas.fill(shape, 30.0 + 200.0 * at(4));
        }
        canvas.roughen(0.2, 5, 0.7, 9.0, seed ^ 8);
    }
    canvas.frame(Rect::new(0.0, 0.0, 1.0, 1.0), 0.012, tone * 0.45);
    canvas.fill(Rect::new(0.0, 0.94, 1.0, 0.06), 35.0);
}

/// Two doors with bars, lettering, lamps below.
fn doors(canvas: &mut Canvas, tone: f32, seed: u32) {
    let r = |k: i32| unit(k, 8, seed);
    let contrast = if tone > 128.0 { 40.0 } else { 225.0 };
    canvas.paint(Rect::new(0.0, 0.1 + 0.4 * r(0), 1.0, 0.15), 0.8, |_, _| contrast);
    canvas.letters(Rect::new(0.08, 0.12, 0.84, 0.3), 0.14, contrast, seed);
    canvas.letters(Rect::new(0.1, 0.5, 0.8, 0.2), 0.06, contrast, seed ^ 5);
    canvas.fill(Rect::new(0.495, 0.02, 0.01, 0.83), 25.0);
    for x in [0.14, 0.36, 0.62, 0.84] {
        canvas.paint(Rect::new(x, 0.02, 0.014, 0.83), 0.8, |_, _| 150.0);
        canvas.fill(Rect::new(x - 0.02, 0.6, 0.054, 0.03), 60.0);
    }
    for k in 0..6 {
        let at = |j: i32| unit(k, 20 + j, seed);
        let sticker =
            Rect::new(0.05 + 0.85 * at(0), 0.05 + 0.75 * at(1), 0.03 + 0.05 * at(2), 0.03 + 0.05 * at(3));
        canvas.fill(sticker, 30.0 + 200.0 * at(4));
    }
    canvas.frame(Rect::new(0.0, 0.0, 1.0, 0.86), 0.012, tone * 0.45);
    canvas.fill(Rect::new(0.0, 0.86, 1.0, 0.14), 28.0);
    for x in [0.04, 0.82] {
        canvas.fill(Rect::new(x, 0.88, 0.14, 0.06), 170.0);
        canvas.fill(Rect::new(x + 0.05, 0.885, 0.03, 0.05), 235.0);
    }
    plate(canvas, Rect::new(0.36, 0.88, 0.28, 0.08), seed);
}

/// Windows and doors in a row, a stripe, lettering, joints between the cars.
fn cars(canvas: &mut Canvas, tone: f32, seed: u32) {
    let contrast = if tone > 128.0 { 40.0 } else { 225.0 };
    canvas.paint(Rect::new(0.0, 0.62, 1.0, 0.09), 0.9, |_, _| contrast);
    canvas.fill(Rect::new(0.01, 0.14, 0.98, 0.4), 22.0);
    for i in 0..20 {
        let x = 0.014 + 0.0487 * i as f32;
        let pane = |u: f32, v: f32| 48.0 + 34.0 * octaves(20.0 * u, 5.0 * v, [64, 64], 4, 0.6, seed ^ i);
        canvas.paint(Rect::new(x, 0.16, 0.044, 0.36), 1.0, pane);
        canvas.ellipse([x + 0.012, 0.46], [0.005, 0.06], 95.0);
        if i % 4 == 2 {
            canvas.fill(Rect::new(x, 0.12, 0.042, 0.78), tone * 0.7);
            canvas.paint(Rect::new(x + 0.004, 0.17, 0.015, 0.6), 1.0, pane);
            canvas.paint(Rect::new(x + 0.023, 0.17, 0.015, 0.6), 1.0, pane);
        }
    }
    canvas.letters(Rect::new(0.05, 0.74, 0.9, 0.12), 0.09, contrast, seed);
    for x in [0.33, 0.66] {
        canvas.fill(Rect::new(x - 0.006, 0.0, 0.012, 1.0), 30.0);
    }
    canvas.frame(Rect::new(0.0, 0.0, 1.0, 1.0), 0.01, tone * 0.45);
    canvas.fill(Rect::new(0.0, 0.92, 1.0, 0.08), 32.0);
}

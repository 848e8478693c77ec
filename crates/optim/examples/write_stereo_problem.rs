//! Writes the problem of `tests/stereo_reference.rs` as text for `tests/reference/stereo_scipy.py`.

#[path = "../tests/common/mod.rs"]
mod common;

use std::fmt::Write;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: write_stereo_problem FILE")?;
    let problem = common::reference_problem();
    let c = &problem.rig.camera;
    let mut text = format!("{:e} {:e} {:e} {:e} {:e}\n", c.fx, c.fy, c.cx, c.cy, problem.rig.bf());
    writeln!(text, "{} {} {}", problem.cameras.len(), problem.points.len(), problem.observations.len())?;
    for (camera, fixed) in problem.cameras.iter().zip(&problem.fixed) {
        let (m, t) = (camera.rotation.matrix(), camera.translation);
        write!(text, "{}", u8::from(*fixed))?;
        for row in 0..3 {
            for column in 0..3 {
                write!(text, " {:e}", m[(row, column)])?;
            }
        }
        writeln!(text, " {:e} {:e} {:e}", t.x, t.y, t.z)?;
    }
    for p in &problem.points {
        writeln!(text, "{:e} {:e} {:e}", p.x, p.y, p.z)?;
    }
    for o in &problem.observations {
        let (u, v) = (o.pixel.x, o.pixel.y);
        writeln!(text, "{} {} {u:e} {v:e} {:e} {:e}", o.camera, o.point, o.right_u, o.inv_sigma_sq)?;
    }
    std::fs::write(path, text)?;
    Ok(())
}

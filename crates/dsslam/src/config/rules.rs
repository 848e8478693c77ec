//! Rules that tie several keys together.

use io::Problem;

use super::Config;

/// All rules that a configuration breaks.
pub(super) fn check(config: &Config) -> Vec<Problem> {
    let mut problems = Vec::new();
    let features = &config.features;
    if features.fast_minimum > features.fast_initial {
        problems.push(Problem::new(
            config.provenance("features.fast_minimum"),
            "features.fast_minimum",
            features.fast_minimum,
            &format!("at most features.fast_initial = {}", features.fast_initial),
        ));
    }
    problems.extend(check_camera(config));
    problems
}

/// A camera is given whole or not at all.
fn check_camera(config: &Config) -> Vec<Problem> {
    let camera = &config.camera;
    let groups: [&[(&str, bool)]; 2] = [
        &[
            ("camera.fx", camera.fx.is_some()),
            ("camera.fy", camera.fy.is_some()),
            ("camera.cx", camera.cx.is_some()),
            ("camera.cy", camera.cy.is_some()),
        ],
        &[("camera.width", camera.width.is_some()), ("camera.height", camera.height.is_some())],
    ];
    let mut problems = Vec::new();
    for group in groups {
        let Some(&(given, _)) = group.iter().find(|(_, is_given)| *is_given) else {
            continue;
        };
        for &(missing, _) in group.iter().filter(|(_, is_given)| !is_given) {
            let expected = format!("a value, since {given} is given");
            problems.push(Problem::new(config.provenance(given), missing, "nothing", &expected));
        }
    }
    problems
}

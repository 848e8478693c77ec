//! Every key: it has a field, a default within its range, and a place in its section.

use dsslam::{Config, SCHEMA};
use serde_json::Value as Json;

/// The default of a key as JSON; `None` where the structure has no such field.
fn default(key: &str) -> Option<Json> {
    let tree = serde_json::to_value(Config::default()).unwrap();
    tree.pointer(&format!("/{}", key.replace('.', "/"))).cloned()
}

#[test]
fn every_key_has_a_field_whose_default_lies_in_its_range() {
    let defaults = Config::default();
    assert_eq!(Config::load(None, &[]).unwrap(), defaults);
    for (position, entry) in SCHEMA.iter().enumerate() {
        let key = entry.key;
        assert!(!entry.help.is_empty() && !entry.help.contains('\n'), "{key}");
        assert!(SCHEMA[..position].iter().all(|other| other.key != key), "{key} occurs twice");
        let value = default(key).unwrap_or_else(|| panic!("{key} has no field"));
        assert_eq!(value.is_null(), entry.is_optional, "{key} is absent by default");
        if let Some(text) =
            value.as_str().map(str::to_owned).or((!value.is_null()).then(|| value.to_string()))
        {
            // Given by hand, it is accepted and changes nothing.
            let given = Config::load(None, &[format!("{key}={text}")]).unwrap();
            assert_eq!(
                serde_json::to_value(given).unwrap(),
                serde_json::to_value(&defaults).unwrap(),
                "{key}"
            );
        }
    }
}

#[test]
fn every_key_reaches_its_field() {
    for entry in SCHEMA.iter() {
        let given = other_value(entry);
        let overrides = [&companions(entry.key)[..], &[format!("{}={given}", entry.key)]].concat();
        let config = Config::load(None, &overrides).unwrap();
        let tree = serde_json::to_value(&config).unwrap();
        let found = tree.pointer(&format!("/{}", entry.key.replace('.', "/"))).unwrap();
        let found = found.as_str().map_or(found.to_string(), str::to_owned);
        assert!(found == given || found.parse::<f64>().ok() == given.parse().ok(), "{}: {found}", entry.key);
        assert_ne!(default(entry.key).unwrap().to_string().trim_matches('"'), found, "{}", entry.key);
    }
}

/// What has to be given with a key: a camera is given whole or not at all, and the thresholds keep their order.
fn companions(key: &str) -> Vec<String> {
    let camera = ["camera.fx", "camera.fy", "camera.cx", "camera.cy", "camera.width", "camera.height"];
    match key {
        "features.fast_initial" => vec!["features.fast_minimum=1".to_owned()],
        key if camera.contains(&key) => {
            camera.iter().filter(|other| **other != key).map(|other| format!("{other}=16")).collect()
        }
        _ => Vec::new(),
    }
}

/// A value that the key takes and that is not its default.
fn other_value(entry: &settings::Entry) -> String {
    use settings::Kind;
    let default = default(entry.key).unwrap();
    let candidates: Vec<String> = match entry.kind {
        Kind::Integer { least, .. } => vec![least.to_string(), (least + 1).to_string()],
        Kind::Real(range) => {
            let low = if range.low.is_finite() { range.low } else { -1.0 };
            let high = if range.high.is_finite() { range.high } else { low + 3.0 };
            vec![(0.25 * low + 0.75 * high).to_string()]
        }
        Kind::Flag => vec!["true".to_owned(), "false".to_owned()],
        Kind::Choice(words) => words.iter().map(|word| (*word).to_owned()).collect(),
        Kind::File => vec!["mask.png".to_owned()],
    };
    let is_other = |text: &String| *text != default.to_string().trim_matches('"');
    candidates.into_iter().find(is_other).unwrap()
}

#[test]
fn sections_stand_together() {
    let mut sections: Vec<&str> = SCHEMA.iter().map(settings::Entry::section).collect();
    sections.dedup();
    let n_runs = sections.len();
    sections.sort_unstable();
    sections.dedup();
    assert_eq!(n_runs, sections.len(), "a section is torn apart");
}

#[test]
fn experts_have_keys_of_their_own() {
    let expert: Vec<&str> = SCHEMA.iter().filter(|entry| entry.is_expert).map(|entry| entry.key).collect();
    assert_eq!(expert.len(), 22, "{expert:?}");
    assert!(expert.contains(&"mapping.local_ba_first_iterations") && !expert.contains(&"features.keep"));
}

#[test]
fn what_is_said_twice_is_said_alike() {
    let config = Config::default();
    assert_eq!(config.camera.depth_units_per_metre, features::DepthConfig::default().units_per_meter);
    let options = io::OpenOptions::default();
    assert_eq!(options.association_tolerance_s, config.input.association_tolerance_s);
    assert_eq!(options.frame_rate_hz, config.camera.fps);
}

#[test]
fn a_whole_number_may_be_written_in_any_way() {
    for text in ["500", "500.0", "5e2", "5.0E+2"] {
        let config = Config::load(None, &[format!("features.keep={text}")]).unwrap();
        assert_eq!(config.features.keep, 500, "{text}");
    }
    assert!(Config::load(None, &["features.keep=500.5".to_owned()]).is_err());
}

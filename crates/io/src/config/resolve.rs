//! From given keys and values to the checked, typed configuration.

use std::collections::BTreeMap;

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value as Json;
use settings::Entry;

use super::origins::Origins;
use super::problem::{ConfigErrors, Problem, Provenance};
use super::source::Given;
use super::suggest;
use crate::document::Value;

/// Checks everything given, then fills the typed structure; `problems` are those of reading.
pub(super) fn resolve<T: Default + Serialize + DeserializeOwned>(
    keys: &[Entry],
    from_file: &[Given],
    from_overrides: &[Given],
    mut problems: Vec<Problem>,
) -> Result<(T, Origins), ConfigErrors> {
    problems.extend(repeated(from_file));
    let mut origins = Origins::default();
    let mut current = |given: &Given| match renamed(given) {
        Some(now) => {
            origins
                .note_renamed(format!("{}: {} is now {} = {}", given.place, given.key, now.key, now.value));
            now
        }
        None => given.clone(),
    };
    let given: Vec<Given> = from_file.iter().chain(from_overrides).map(&mut current).collect();
    let mut chosen: BTreeMap<&str, &Given> = BTreeMap::new();
    for given in &given {
        match check(keys, given) {
            Ok(Some(entry)) => {
                chosen.insert(entry.key, given);
            }
            Ok(None) => {}
            Err(problem) => problems.push(problem),
        }
    }
    if !problems.is_empty() {
        return Err(ConfigErrors(problems));
    }
    for (key, given) in &chosen {
        origins.set(key, given.place.clone());
    }
    Ok((build(keys, &chosen)?, origins))
}

/// What took the place of a key of older configurations, with its value.
fn renamed(given: &Given) -> Option<Given> {
    match (given.key.as_str(), &given.value) {
        (RENAMED, Value::Integer(frames)) => Some(Given {
            key: "mapping.refine_calibration".to_owned(),
            value: Value::Flag(*frames > 0),
            place: given.place.clone(),
        }),
        _ => None,
    }
}

/// A key of older configurations, and what is said of values that cannot be taken over.
const RENAMED: &str = "stereo.calibration_frames";
const GONE: &str =
    "this key is gone: the calibration is refined within the run (mapping.refine_calibration), leave it out";

/// The entry that a given value sets; `None` for a section that is empty.
fn check<'a>(keys: &'a [Entry], given: &Given) -> Result<Option<&'a Entry>, Problem> {
    if let Some(entry) = keys.iter().find(|entry| entry.key == given.key) {
        return if given.value.is_accepted_by(entry) {
            Ok(Some(entry))
        } else {
            Err(Problem::new(&given.place, &given.key, &given.value, &entry.expectation()))
        };
    }
    let names: Vec<&str> =
        keys.iter().filter(|entry| entry.section() == given.key).map(Entry::name).collect();
    if !names.is_empty() {
        if given.value == Value::Nothing {
            return Ok(None);
        }
        let expected = format!("a section with keys {}", names.join(", "));
        return Err(Problem::new(&given.place, &given.key, &given.value, &expected));
    }
    let inside = |entry: &&Entry| given.key.starts_with(&format!("{}.", entry.key));
    if let Some(entry) = keys.iter().find(inside) {
        return Err(Problem::new(&given.place, entry.key, "a section", &entry.expectation()));
    }
    let message = match suggest::find_nearest(&given.key, keys.iter().map(|entry| entry.key)) {
        _ if given.key == RENAMED => GONE.to_owned(),
        Some(nearest) => format!("unknown key, did you mean {nearest}?"),
        None => "unknown key".to_string(),
    };
    Err(Problem { place: given.place.clone(), key: given.key.clone(), message })
}

/// Keys that a file gives twice in different spellings (`a.b: 1` and `a: {b: 1}`).
fn repeated(from_file: &[Given]) -> Vec<Problem> {
    let mut seen: BTreeMap<&str, &Given> = BTreeMap::new();
    let mut problems = Vec::new();
    for given in from_file {
        if let Some(first) = seen.insert(&given.key, given) {
            let message = format!("given twice, first at {}", first.place);
            problems.push(Problem { place: given.place.clone(), key: given.key.clone(), message });
        }
    }
    problems
}

/// The defaults with the chosen values over them.
fn build<T: Default + Serialize + DeserializeOwned>(
    keys: &[Entry],
    chosen: &BTreeMap<&str, &Given>,
) -> Result<T, ConfigErrors> {
    let disagreement = |reason: String| {
        let message = format!("the table of keys and the typed structure disagree: {reason}");
        ConfigErrors(vec![Problem { place: Provenance::Default, key: String::new(), message }])
    };
    let mut tree = serde_json::to_value(T::default()).map_err(|error| disagreement(error.to_string()))?;
    for (key, given) in chosen {
        let field = tree.pointer_mut(&format!("/{}", key.replace('.', "/")));
        *field.ok_or_else(|| disagreement(format!("no field for {key}")))? = {
            let entry = keys.iter().find(|entry| entry.key == *key);
            Json::from(&entry.map_or_else(|| given.value.clone(), |entry| given.value.for_entry(entry)))
        };
    }
    serde_json::from_value(tree).map_err(|error| disagreement(error.to_string()))
}

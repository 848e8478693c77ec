//! From given keys and values to the checked, typed configuration.

use std::collections::BTreeMap;

use serde_json::{Map, Value as Json};

use super::problem::{ConfigErrors, Problem, Provenance};
use super::schema::{Entry, Value};
use super::source::Given;
use super::table::SCHEMA;
use super::{Config, rules, suggest};

/// Checks everything given, then fills the typed structure; `problems` are those of reading.
pub(super) fn resolve(
    from_file: &[Given],
    from_overrides: &[Given],
    mut problems: Vec<Problem>,
) -> Result<Config, ConfigErrors> {
    problems.extend(repeated(from_file));
    let mut chosen: BTreeMap<&str, &Given> = BTreeMap::new();
    for given in from_file.iter().chain(from_overrides) {
        match check(given) {
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
    let mut config = build(&chosen)?;
    config.provenance = chosen.iter().map(|(&key, given)| (key.to_string(), given.place.clone())).collect();
    let problems = rules::check(&config);
    if problems.is_empty() { Ok(config) } else { Err(ConfigErrors(problems)) }
}

/// The entry that a given value sets; `None` for a section that is empty.
fn check(given: &Given) -> Result<Option<&'static Entry>, Problem> {
    if let Some(entry) = SCHEMA.iter().find(|entry| entry.key == given.key) {
        return if entry.accepts(&given.value) {
            Ok(Some(entry))
        } else {
            Err(Problem::new(&given.place, &given.key, &given.value, &entry.expectation()))
        };
    }
    let names: Vec<&str> =
        SCHEMA.iter().filter(|entry| entry.section() == given.key).map(Entry::name).collect();
    if !names.is_empty() {
        if given.value == Value::Nothing {
            return Ok(None);
        }
        let expected = format!("a section with keys {}", names.join(", "));
        return Err(Problem::new(&given.place, &given.key, &given.value, &expected));
    }
    let inside = |entry: &&Entry| given.key.starts_with(&format!("{}.", entry.key));
    if let Some(entry) = SCHEMA.iter().find(inside) {
        return Err(Problem::new(&given.place, entry.key, "a section", &entry.expectation()));
    }
    let message = match suggest::find_nearest(&given.key, SCHEMA.iter().map(|entry| entry.key)) {
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

/// Fills the typed structure with chosen values and defaults.
fn build(chosen: &BTreeMap<&str, &Given>) -> Result<Config, ConfigErrors> {
    let mut root = Map::new();
    for entry in SCHEMA {
        let value = match (chosen.get(entry.key), entry.default) {
            (Some(given), _) => given.value.clone(),
            (None, Some(default)) => default.into(),
            (None, None) => Value::Nothing,
        };
        let json = to_json(value);
        if entry.section().is_empty() {
            root.insert(entry.name().to_string(), json);
        } else if let Json::Object(section) =
            root.entry(entry.section()).or_insert_with(|| Json::Object(Map::new()))
        {
            section.insert(entry.name().to_string(), json);
        }
    }
    serde_json::from_value(Json::Object(root)).map_err(|error| {
        let message = format!("the table of keys and the typed structure disagree: {error}");
        ConfigErrors(vec![Problem { place: Provenance::Default, key: String::new(), message }])
    })
}

fn to_json(value: Value) -> Json {
    match value {
        Value::Nothing => Json::Null,
        Value::Flag(flag) => Json::Bool(flag),
        Value::Integer(integer) => Json::from(integer),
        Value::Real(real) => Json::from(real),
        Value::Text(text) => Json::String(text),
    }
}

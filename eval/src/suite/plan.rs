//! The suite file: what is to be run. Everything is checked before the first run.

use std::fmt;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use geometry::Sensor;
use io::Variant;
use serde::{Deserialize, Serialize};

use crate::drift::KITTI_LENGTHS_M;

/// A suite with all paths resolved; stored in the results folder, so that tables and plots need nothing else.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Name of the suite.
    pub name: String,
    /// Which published baselines stand beside the results (`kitti`, `euroc`, `tum-rgbd`), if any.
    pub dataset: Option<String>,
    /// Sequences, in the order of the tables' rows.
    pub sequences: Vec<SequencePlan>,
    /// Each sequence without a variant of its own is run in these, as a sequence of its own with the variant behind its name.
    #[serde(default)]
    pub variants: Vec<String>,
    /// Configurations, in the order of the tables' columns.
    pub configurations: Vec<Configuration>,
    /// How often each run is repeated.
    #[serde(default = "one")]
    pub repeats: u32,
    /// A run that takes longer is stopped and counts as failed, seconds.
    pub timeout_s: Option<f64>,
    /// Segment lengths of t_rel and r_rel, meters.
    #[serde(default = "kitti_lengths")]
    pub lengths_m: Vec<f64>,
}

/// One sequence of a suite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SequencePlan {
    /// Name, as the baselines know it ("00").
    pub name: String,
    /// Folder of the images.
    pub path: PathBuf,
    /// Ground truth of the dataset's body (KITTI: camera 0); by default what the program finds beside the images.
    pub ground_truth: Option<PathBuf>,
    /// Stops after this many frames.
    pub max_frames: Option<u32>,
    /// Which images are used, whatever the configuration says.
    pub sensor: Option<Sensor>,
    /// Runs on this variant of the first `max_frames` frames.
    pub variant: Option<String>,
    /// Absolute trajectory error of another program on these very frames, meters.
    pub reference_ate_m: Option<f64>,
    /// `choosing`: constants may be chosen on it; `judging`: only the outcome is judged on it.
    pub purpose: Option<String>,
}

/// One configuration of a suite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Configuration {
    /// Name, a column of the tables.
    pub name: String,
    /// Configuration file of the program.
    pub config: Option<PathBuf>,
    /// Overrides, `key=value`.
    #[serde(default)]
    pub set: Vec<String>,
    /// Which images are used; by default what the sequence offers.
    pub sensor: Option<Sensor>,
}

/// Names one run: sequence, configuration, repeat (from 1).
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct RunId {
    /// Name of the sequence.
    pub sequence: String,
    /// Name of the configuration.
    pub configuration: String,
    /// Number of the repeat, from 1.
    pub repeat: u32,
}

impl fmt::Display for RunId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}/{}", self.sequence, self.configuration, self.repeat)
    }
}

impl RunId {
    /// The run's folder below the results folder.
    pub fn folder(&self, results: &Path) -> PathBuf {
        results.join(&self.sequence).join(&self.configuration).join(self.repeat.to_string())
    }
}

fn one() -> u32 {
    1
}

fn kitti_lengths() -> Vec<f64> {
    KITTI_LENGTHS_M.to_vec()
}

impl Plan {
    /// All runs, configuration by configuration within a sequence.
    pub fn runs(&self) -> Vec<RunId> {
        let mut runs = Vec::new();
        for sequence in &self.sequences {
            for configuration in &self.configurations {
                for repeat in 1..=self.repeats {
                    runs.push(RunId {
                        sequence: sequence.name.clone(),
                        configuration: configuration.name.clone(),
                        repeat,
                    });
                }
            }
        }
        runs
    }

    /// The sequence of that name.
    pub fn sequence(&self, name: &str) -> Option<&SequencePlan> {
        self.sequences.iter().find(|s| s.name == name)
    }

    /// The configuration of that name.
    pub fn configuration(&self, name: &str) -> Option<&Configuration> {
        self.configurations.iter().find(|c| c.name == name)
    }

    /// Runs each sequence that has no variant of its own in these.
    ///
    /// # Errors
    /// A word that is not a variant, or a variant that occurs twice.
    pub fn vary(&mut self, variants: &[String]) -> Result<()> {
        if variants.is_empty() {
            return Ok(());
        }
        let in_all = |sequence: &SequencePlan| -> Vec<SequencePlan> {
            if sequence.variant.is_some() {
                return vec![sequence.clone()];
            }
            let of = |variant: &String| match variant.as_str() {
                "plain" => sequence.clone(),
                word => SequencePlan {
                    name: format!("{}.{word}", sequence.name),
                    variant: Some(word.to_owned()),
                    reference_ate_m: None,
                    ..sequence.clone()
                },
            };
            variants.iter().map(of).collect()
        };
        self.sequences = self.sequences.iter().flat_map(in_all).collect();
        self.check()
    }

    fn check(&self) -> Result<()> {
        ensure!(!self.sequences.is_empty(), "sequences: the list is empty");
        for sequence in &self.sequences {
            let variant = sequence.variant.as_deref().map(str::parse::<Variant>).transpose();
            variant.with_context(|| format!("sequence {}", sequence.name))?;
            let purpose = sequence.purpose.as_deref();
            ensure!(
                purpose.is_none_or(|purpose| ["choosing", "judging"].contains(&purpose)),
                "sequence {}: purpose: found '{}', expected choosing or judging",
                sequence.name,
                purpose.unwrap_or_default()
            );
        }
        ensure!(!self.configurations.is_empty(), "configurations: the list is empty");
        ensure!(self.repeats >= 1, "repeats: found 0, expected at least 1");
        check_names("sequences", self.sequences.iter().map(|s| s.name.as_str()))?;
        check_names("configurations", self.configurations.iter().map(|c| c.name.as_str()))?;
        for length in &self.lengths_m {
            ensure!(
                length.is_finite() && *length > 0.0,
                "lengths_m: found {length}, expected positive meters"
            );
        }
        for configuration in &self.configurations {
            if let Some(bad) = configuration.set.iter().find(|s| !s.contains('=')) {
                bail!("set: found '{bad}', expected key=value");
            }
        }
        if let Some(timeout) = self.timeout_s {
            ensure!(timeout > 0.0, "timeout_s: found {timeout}, expected a positive number");
        }
        Ok(())
    }
}

/// Names become folders: letters, digits, `-`, `_` and `.`, and no name twice.
fn check_names<'a>(what: &str, names: impl Iterator<Item = &'a str>) -> Result<()> {
    let mut seen: Vec<&str> = Vec::new();
    for name in names {
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
        ensure!(
            !name.is_empty() && name.chars().all(is_plain) && !name.starts_with('.'),
            "{what}: the name '{name}' may only contain letters, digits, '-', '_' and '.'"
        );
        ensure!(!seen.contains(&name), "{what}: the name '{name}' occurs twice");
        seen.push(name);
    }
    Ok(())
}

/// Reads a suite file (YAML). Relative paths start at its folder; `${NAME}` is replaced from the environment.
///
/// # Errors
/// The file cannot be read or parsed, a name is unusable, a variable is not set, or a folder or file is missing.
pub fn read_plan(path: &Path) -> Result<Plan> {
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let folder = path.canonicalize().ok().and_then(|p| p.parent().map(Path::to_owned)).unwrap_or_default();
    let plan = parse(&text, &folder, |name| std::env::var(name).ok());
    plan.with_context(|| format!("{}", path.display()))
}

/// Parses and resolves a suite; `variable` looks up `${NAME}`.
fn parse(text: &str, folder: &Path, variable: impl Fn(&str) -> Option<String>) -> Result<Plan> {
    let mut plan: Plan = serde_saphyr::from_str(text)?;
    let variants = std::mem::take(&mut plan.variants);
    plan.check()?;
    plan.vary(&variants)?;
    let resolve = |path: &Path| -> Result<PathBuf> {
        let path = folder.join(expand(&path.to_string_lossy(), &variable)?);
        path.canonicalize().with_context(|| format!("{}", path.display()))
    };
    for sequence in &mut plan.sequences {
        let place = format!("sequence {}", sequence.name);
        sequence.path = resolve(&sequence.path).with_context(|| place.clone())?;
        let named = sequence.ground_truth.as_deref();
        sequence.ground_truth = named.map(resolve).transpose().with_context(|| place)?;
    }
    for configuration in &mut plan.configurations {
        if let Some(config) = &configuration.config {
            let place = format!("configuration {}", configuration.name);
            configuration.config = Some(resolve(config).with_context(|| place)?);
        }
    }
    Ok(plan)
}

fn expand(text: &str, variable: &impl Fn(&str) -> Option<String>) -> Result<String> {
    let mut result = String::new();
    let mut rest = text;
    while let Some(start) = rest.find("${") {
        let Some(end) = rest[start..].find('}') else { bail!("'{text}': '${{' without '}}'") };
        let name = &rest[start + 2..start + end];
        let Some(value) = variable(name) else { bail!("'{text}': the variable {name} is not set") };
        result.push_str(&rest[..start]);
        result.push_str(&value);
        rest = &rest[start + end + 1..];
    }
    Ok(result + rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str) -> String {
        let folder = std::env::temp_dir();
        format!("{:#}", parse(text, &folder, |_| None).unwrap_err())
    }

    #[test]
    fn paths_are_resolved_and_runs_listed() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().canonicalize().unwrap();
        std::fs::create_dir_all(root.join("sequences/00")).unwrap();
        std::fs::write(root.join("truth.txt"), "").unwrap();
        let text = "name: a\nsequences:\n  - {name: '00', path: '${ROOT}/sequences/00', ground_truth: '${ROOT}/truth.txt'}\n\
                    configurations:\n  - {name: x}\n  - {name: y, set: [a.b=1]}\nrepeats: 2\n";
        let lookup = |name: &str| (name == "ROOT").then(|| root.to_string_lossy().into_owned());
        let plan = parse(text, Path::new("/"), lookup).unwrap();
        assert_eq!(plan.sequences[0].ground_truth, Some(root.join("truth.txt")));
        let runs: Vec<String> = plan.runs().iter().map(RunId::to_string).collect();
        assert_eq!(runs, ["00/x/1", "00/x/2", "00/y/1", "00/y/2"]);
        assert_eq!(plan.lengths_m, KITTI_LENGTHS_M);
    }

    #[test]
    fn variants_become_sequences_of_their_own() {
        let text = "name: a\nsequences:\n  - {name: s, path: ., reference_ate_m: 1.0}\n  - {name: t, path: ., variant: mirrored}\n\
                    configurations: [{name: x}]\nvariants: [plain, reversed, every2]\n";
        let plan = parse(text, &std::env::temp_dir(), |_| None).unwrap();
        let names: Vec<&str> = plan.sequences.iter().map(|s| s.name.as_str()).collect();
        assert_eq!(names, ["s", "s.reversed", "s.every2", "t"]);
        assert_eq!((plan.sequences[1].reference_ate_m, plan.sequences[0].reference_ate_m), (None, Some(1.0)));
        assert_eq!(plan.sequences[2].variant.as_deref(), Some("every2"));
    }

    #[test]
    fn messages() {
        let rest = "configurations: [{name: x}]\n";
        assert_eq!(message(&format!("name: a\nsequences: []\n{rest}")), "sequences: the list is empty");
        let twice = format!("name: a\nsequences: [{{name: s, path: .}}, {{name: s, path: .}}]\n{rest}");
        assert_eq!(message(&twice), "sequences: the name 's' occurs twice");
        let slash = format!("name: a\nsequences: [{{name: ../s, path: .}}]\n{rest}");
        assert_eq!(
            message(&slash),
            "sequences: the name '../s' may only contain letters, digits, '-', '_' and '.'"
        );
        let unset = format!("name: a\nsequences: [{{name: s, path: '${{NOPE}}/s'}}]\n{rest}");
        assert_eq!(message(&unset), "sequence s: '${NOPE}/s': the variable NOPE is not set");
        let missing = format!("name: a\nsequences: [{{name: s, path: not-there}}]\n{rest}");
        assert!(message(&missing).starts_with("sequence s: "), "{}", message(&missing));
        assert!(message(&missing).contains("not-there: No such file"), "{}", message(&missing));
        let typo = "name: a\nsequences: [{name: s, path: .}]\nconfigurations: [{name: x, confg: y}]\n";
        assert!(message(typo).contains("confg"), "{}", message(typo));
        let variant = format!("name: a\nsequences: [{{name: s, path: ., variant: up}}]\n{rest}");
        assert!(
            message(&variant).starts_with("sequence s: variant: found 'up', expected"),
            "{}",
            message(&variant)
        );
        let purpose = format!("name: a\nsequences: [{{name: s, path: ., purpose: x}}]\n{rest}");
        assert_eq!(message(&purpose), "sequence s: purpose: found 'x', expected choosing or judging");
        let set = "name: a\nsequences: [{name: s, path: .}]\nconfigurations: [{name: x, set: [abc]}]\n";
        assert_eq!(message(set), "set: found 'abc', expected key=value");
    }
}

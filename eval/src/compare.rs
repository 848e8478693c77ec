//! Paired comparison over many cases: how often one is better than the other, by which ratio, and whether that could be chance.

use std::collections::BTreeMap;

use crate::baseline::Metric;
use crate::statistics::median;
use crate::suite::{Results, SequencePlan};
use crate::table::{Cell, Row, Table, value};

/// Errors of one against another's on the same cases.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Cases in which the error is smaller.
    pub better: usize,
    /// Cases in which it is larger.
    pub worse: usize,
    /// Median of the ratios of the errors.
    pub median_ratio: f64,
    /// Mean of the ratios.
    pub mean_ratio: f64,
    /// Probability of so uneven a split, or a more uneven one, if both were equally good (two-sided sign test).
    pub p_value: f64,
}

impl Comparison {
    /// Of pairs (error, error of the other); `None` without a pair.
    pub fn of(pairs: &[(f64, f64)]) -> Option<Self> {
        let ratios: Vec<f64> = pairs.iter().map(|(ours, other)| ours / other).collect();
        let better = pairs.iter().filter(|(ours, other)| ours < other).count();
        let worse = pairs.iter().filter(|(ours, other)| ours > other).count();
        Some(Self {
            better,
            worse,
            median_ratio: median(&ratios)?,
            mean_ratio: ratios.iter().sum::<f64>() / ratios.len() as f64,
            p_value: sign_test(better, worse),
        })
    }
}

/// Two-sided sign test of a split of cases into two kinds; ties do not count.
fn sign_test(better: usize, worse: usize) -> f64 {
    let n = better + worse;
    // Binomial probabilities of 0, 1, ... of n, one from another.
    let mut probability = 0.5_f64.powi(n as i32);
    let mut tail = 0.0;
    for k in 0..=better.min(worse) {
        tail += probability;
        probability *= (n - k) as f64 / (k + 1) as f64;
    }
    (2.0 * tail).min(1.0)
}

/// Median ATE of the repeats of a case, meters.
fn ate(results: &Results, case: &str, configuration: &str) -> Option<f64> {
    let runs = results.repeats(case, configuration);
    median(&runs.iter().filter_map(|run| value(run, Metric::AteRmseM)).collect::<Vec<_>>())
}

/// ATE of every case beside its reference, with keyframes and frames without a pose; below, over all cases that are for choosing and
/// for judging: median and mean of the ratios, and how many are below 1.
pub fn cases_table(results: &Results) -> Table {
    let plan = &results.plan;
    let names: Vec<&str> = plan.configurations.iter().map(|c| c.name.as_str()).collect();
    let mut rows: Vec<Row> = plan.sequences.iter().map(|case| case_row(results, case, &names)).collect();
    let purposes = [("all", None), ("for choosing", Some("choosing")), ("for judging", Some("judging"))];
    let mut n_summary_rows = 0;
    for (label, purpose) in purposes {
        let cases = || {
            let fits = move |case: &&SequencePlan| purpose.is_none() || case.purpose.as_deref() == purpose;
            plan.sequences.iter().filter(fits)
        };
        if cases().all(|case| case.reference_ate_m.is_none()) {
            continue;
        }
        let summary = |name: &&str| {
            let pairs: Vec<(f64, f64)> =
                cases().filter_map(|c| Some((ate(results, &c.name, name)?, c.reference_ate_m?))).collect();
            Cell::text(Comparison::of(&pairs).map_or_else(|| "-".to_owned(), |c| in_words(&c)))
        };
        let cells = std::iter::once(Cell::text("")).chain(names.iter().map(summary)).collect();
        rows.push(Row { name: label.to_owned(), cells });
        n_summary_rows += 1;
    }
    Table {
        title: format!("{}: ATE [m], ratio to the reference, keyframes", plan.name),
        corner: "case".to_owned(),
        columns: std::iter::once("reference").chain(names).map(str::to_owned).collect(),
        rows,
        n_summary_rows,
        notes: vec!["-N: frames without a pose of their own".to_owned()],
    }
}

fn case_row(results: &Results, case: &SequencePlan, configurations: &[&str]) -> Row {
    let reference = case.reference_ate_m;
    let cell = |name: &&str| {
        let Some(error) = ate(results, &case.name, name) else { return Cell::text("no figure") };
        let mut text = format!("{error:.3}");
        if let Some(reference) = reference {
            text += &format!(" {:.2}", error / reference);
        }
        let runs = results.repeats(&case.name, name);
        if let Some(summary) = runs.first().and_then(|run| run.summary.as_ref()) {
            text += &format!(" {}", summary.keyframes.unwrap_or_default());
            let without = summary.n_without_pose();
            text += &if without > 0 { format!(" -{without}") } else { String::new() };
        }
        Cell { text, value: Some(error), ..Cell::default() }
    };
    let cells = std::iter::once(Cell::number(reference, 3)).chain(configurations.iter().map(cell));
    Row { name: case.name.clone(), cells: cells.collect() }
}

/// Median and range of the ATE over the variants of each sequence (its name up to the first dot), and how many there are.
pub fn spread_table(results: &Results) -> Table {
    let plan = &results.plan;
    let mut groups: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for case in &plan.sequences {
        let base = case.name.split('.').next().unwrap_or(&case.name);
        groups.entry(base).or_default().push(&case.name);
    }
    let row = |(base, cases): (&str, Vec<&str>)| {
        let cell = |configuration: &crate::suite::Configuration| {
            let errors: Vec<f64> =
                cases.iter().filter_map(|case| ate(results, case, &configuration.name)).collect();
            let Some(middle) = median(&errors) else { return Cell::text("no figure") };
            let low = errors.iter().copied().fold(f64::INFINITY, f64::min);
            let high = errors.iter().copied().fold(0.0, f64::max);
            let text = format!("{middle:.3} [{low:.3}-{high:.3}] of {}", errors.len());
            Cell { text, value: Some(middle), ..Cell::default() }
        };
        Row { name: base.to_owned(), cells: plan.configurations.iter().map(cell).collect() }
    };
    Table {
        title: format!("{}: ATE [m] over the variants of each sequence, median [range]", plan.name),
        corner: "sequence".to_owned(),
        columns: plan.configurations.iter().map(|c| c.name.clone()).collect(),
        rows: groups.into_iter().map(row).collect(),
        n_summary_rows: 0,
        notes: Vec::new(),
    }
}

/// Each configuration against the same one of `before`, or, without it, against the first of its own suite.
pub fn pairs_table(results: &Results, before: Option<&Results>) -> Table {
    let plan = &results.plan;
    let first = plan.configurations.first().map_or("", |c| c.name.as_str());
    let mut rows = Vec::new();
    for configuration in plan.configurations.iter().map(|c| c.name.as_str()) {
        let (other, other_name) = before.map_or((results, first), |before| (before, configuration));
        if before.is_none() && configuration == first {
            continue;
        }
        for purpose in [None, Some("choosing"), Some("judging")] {
            let cases =
                plan.sequences.iter().filter(|c| purpose.is_none() || c.purpose.as_deref() == purpose);
            let pairs: Vec<(f64, f64)> = cases
                .filter_map(|c| {
                    Some((ate(results, &c.name, configuration)?, ate(other, &c.name, other_name)?))
                })
                .collect();
            let Some(compared) = Comparison::of(&pairs) else { continue };
            let against = if before.is_some() { "before" } else { other_name };
            let name = format!("{configuration} against {against}, {}", purpose.unwrap_or("all"));
            rows.push(Row { name, cells: vec![Cell::text(in_words(&compared))] });
        }
    }
    Table {
        title: format!("{}: paired comparison of the ATE", plan.name),
        corner: "pair".to_owned(),
        columns: vec!["ratios".to_owned()],
        rows,
        n_summary_rows: 0,
        notes: vec!["p: two-sided sign test".to_owned()],
    }
}

fn in_words(c: &Comparison) -> String {
    format!(
        "median {:.3}, mean {:.3}, better {} worse {}, p {:.3}",
        c.median_ratio, c.mean_ratio, c.better, c.worse, c.p_value
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sign_test_has_its_known_values() {
        assert_eq!(sign_test(0, 0), 1.0);
        assert!((sign_test(5, 0) - 0.0625).abs() < 1e-15);
        assert!((sign_test(1, 8) - 0.0390625).abs() < 1e-12);
        assert!((sign_test(8, 1) - sign_test(1, 8)).abs() < 1e-15);
        assert_eq!(sign_test(4, 4), 1.0);
    }

    #[test]
    fn pairs_are_counted_and_their_ratios_summarized() {
        let c = Comparison::of(&[(1.0, 2.0), (3.0, 2.0), (2.0, 2.0), (0.5, 2.0)]).unwrap();
        assert_eq!((c.better, c.worse), (2, 1));
        assert!((c.median_ratio - 0.75).abs() < 1e-15 && (c.mean_ratio - 0.8125).abs() < 1e-15);
        assert_eq!(Comparison::of(&[]), None);
    }
}

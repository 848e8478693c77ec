//! `dsslam eval run`, `table`, `plot`: a suite from its file to its report.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::Args;

use super::out::say;
use crate::baseline::{Baseline, Metric, read_baselines};
use crate::compare::{cases_table, pairs_table, spread_table};
use crate::figures::result_figures;
use crate::plot;
use crate::report::html_report;
use crate::suite::{Event, Results, RunOptions, RunRecord, RunState, job_lines, read_plan, run_suite};
use crate::table::{Table, metric_table, runs_csv, runs_table};

/// Arguments of `dsslam eval run`.
#[derive(Debug, Args)]
pub struct RunArgs {
    /// The suite.
    #[arg(value_name = "SUITE.yaml")]
    suite: PathBuf,
    /// Results folder [default: results/<name of the suite>].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Number of parallel runs.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: u16,
    /// The dsslam program [default: this one].
    #[arg(long, value_name = "FILE")]
    program: Option<PathBuf>,
    /// Repeats runs that failed.
    #[arg(long)]
    retry_failed: bool,
    /// Only runs whose name begins with this: SEQUENCE, SEQUENCE/CONFIGURATION or SEQUENCE/CONFIGURATION/REPEAT.
    #[arg(long, value_name = "RUN")]
    only: Option<String>,
    /// Runs the sequences in these variants, and names them SEQUENCE.VARIANT; plain is the sequence as it is.
    #[arg(long, value_name = "V,V,...", value_delimiter = ',')]
    variants: Vec<String>,
    /// Writes one shell command per run into this file, without running anything.
    #[arg(long, value_name = "FILE")]
    jobs_file: Option<PathBuf>,
}

/// Arguments of `dsslam eval table` and `dsslam eval plot`.
#[derive(Debug, Args)]
pub struct ResultsArgs {
    /// Results folder of `dsslam eval run`.
    #[arg(value_name = "RESULTS")]
    results: PathBuf,
    /// Output folder; by default RESULTS/tables or RESULTS/plots.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// More baselines: a folder with YAML files.
    #[arg(long, value_name = "DIR")]
    baselines: Option<PathBuf>,
}

/// Arguments of `dsslam eval compare`.
#[derive(Debug, Args)]
pub struct CompareArgs {
    /// Results folder of `dsslam eval run`.
    #[arg(value_name = "RESULTS")]
    results: PathBuf,
    /// Results folder of the same suite by an earlier program.
    #[arg(long, value_name = "RESULTS")]
    before: Option<PathBuf>,
}

pub(super) fn compare(args: &CompareArgs) -> Result<()> {
    let results = Results::read(&args.results)?;
    let before = args.before.as_deref().map(Results::read).transpose()?;
    let tables = [cases_table(&results), spread_table(&results), pairs_table(&results, before.as_ref())];
    for table in tables.iter().filter(|table| !table.rows.is_empty()) {
        say(table.to_terminal())?;
    }
    Ok(())
}

impl ResultsArgs {
    /// What is in the results folder, what stands beside it, and the output folder, which by default has this name.
    fn open(&self, name: &str) -> Result<(Results, Vec<Baseline>, PathBuf)> {
        let results = Results::read(&self.results)?;
        let baselines = read_baselines(self.baselines.as_deref())?;
        let folder = self.out.clone().unwrap_or_else(|| self.results.join(name));
        std::fs::create_dir_all(&folder).with_context(|| format!("cannot create {}", folder.display()))?;
        Ok((results, baselines, folder))
    }
}

pub(super) fn run(args: &RunArgs) -> Result<()> {
    let mut plan = read_plan(&args.suite)?;
    plan.vary(&args.variants).context("--variants")?;
    let this_program = std::env::current_exe().context("the path of this program is unknown")?;
    let program = args.program.clone().unwrap_or_else(|| this_program.clone());
    let results = args.out.clone().unwrap_or_else(|| Path::new("results").join(&plan.name));
    let options = RunOptions {
        program,
        results: std::path::absolute(results)?,
        jobs: usize::from(args.jobs),
        retry_failed: args.retry_failed,
        only: args.only.clone(),
    };
    if let Some(file) = &args.jobs_file {
        let mut lines = job_lines(&plan, &std::path::absolute(&args.suite)?, &this_program, &options)?;
        if !args.variants.is_empty() {
            lines.iter_mut().for_each(|line| *line += &format!(" --variants {}", args.variants.join(",")));
        }
        write(file, &(lines.join("\n") + "\n"))?;
        say(format!("{} commands in {}", lines.len(), file.display()))?;
        return Ok(());
    }
    let records = run_suite(&plan, &options, &print_event)?;
    let n_failed = records.iter().filter(|r| r.state != RunState::Done).count();
    say(format!(
        "{} of {} runs have a result in {}",
        records.len() - n_failed,
        records.len(),
        options.results.display()
    ))?;
    if n_failed > 0 {
        bail!(
            "{n_failed} of {} runs failed; each folder holds a log.txt; --retry-failed repeats them",
            records.len()
        );
    }
    Ok(())
}

fn print_event(event: Event<'_>) {
    let line = match event {
        Event::Skipped(record) => format!("{}: {} before", record.id, ending(record)),
        Event::Started(id) => format!("{id}: started"),
        Event::Ended(record) => format!("{}: {} in {:.1} s", record.id, ending(record), record.wall_s),
    };
    // A suite goes on when nobody can read its progress; the records are in the results folder.
    let _ = say(line);
}

fn ending(record: &RunRecord) -> String {
    match (&record.state, &record.evaluation_problem) {
        (RunState::Failed { reason }, _) => format!("failed ({reason})"),
        (RunState::Done, Some(problem)) => format!("done, but cannot be evaluated ({problem}),"),
        (RunState::Done, None) => "done".to_owned(),
    }
}

pub(super) fn table(args: &ResultsArgs) -> Result<()> {
    let (results, baselines, folder) = args.open("tables")?;
    let mut tables: Vec<(&str, Table)> = Metric::ALL
        .into_iter()
        .filter_map(|metric| Some((metric.file_name(), metric_table(&results, &baselines, metric)?)))
        .collect();
    tables.push(("runs", runs_table(&results)));
    let mut markdown = String::new();
    for (name, table) in &tables {
        say(table.to_terminal())?;
        markdown += &format!("{}\n", table.to_markdown());
        write(&folder.join(format!("{name}.csv")), &table.to_csv())?;
        write(&folder.join(format!("{name}.tex")), &table.to_latex())?;
        write(&folder.join(format!("{name}.txt")), &table.to_terminal())?;
    }
    write(&folder.join("tables.md"), &markdown)?;
    write(&folder.join("all_runs.csv"), &runs_csv(&results))?;
    say(format!("written: {}", folder.display()))?;
    Ok(())
}

pub(super) fn plot(args: &ResultsArgs) -> Result<()> {
    let (results, baselines, folder) = args.open("plots")?;
    let (figures, problems) = result_figures(&results, &baselines);
    for figure in &figures {
        plot::save(&folder, &figure.name, &figure.figure)?;
        say(format!("{}.png, .svg: {}", figure.name, figure.caption))?;
    }
    for problem in &problems {
        say(format!("not drawn: {problem}"))?;
    }
    let report = folder.join("report.html");
    write(&report, &html_report(&results, &baselines, &figures, &problems)?)?;
    say(format!("written: {}, with {} figures beside it", report.display(), figures.len()))?;
    Ok(())
}

fn write(path: &Path, text: &str) -> Result<()> {
    std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}

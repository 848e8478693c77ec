//! `dsslam eval places`: recognizes places with 500 features of three selections, as the DSFeat paper's second table does. For
//! each frame the most familiar and the most similar earlier ones are retrieved, and the one with which most matches agree is the
//! answer; the mean epipolar error of the RANSAC inliers between both, or their number, is its score, and a threshold on it
//! gives the precision-recall curve.

mod args;
mod selections;
mod sight;
mod truth;
mod verify;
mod write;
mod xfeat;

use std::path::Path;

use anyhow::{Context, Result};
use eval::{Detection, LoopTruth, PrecisionRecallCurve, precision_recall};
use io::open_sequence;

use crate::console;
use args::Selection;
use selections::Describer;
use sight::{Memory, Sight};
use verify::{Evidence, best};

pub(crate) use args::PlacesArgs;

/// What was retrieved for one query by one selection.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Answer {
    /// Position of the query in the sequence.
    query: usize,
    /// Position of the retrieved frame.
    retrieved: usize,
    /// What geometry says; `None` where no motion explains enough matches.
    evidence: Option<Evidence>,
    is_correct: bool,
}

/// All answers of a selection and their curves.
#[derive(Clone, Debug)]
struct Outcome {
    selection: Selection,
    answers: Vec<Answer>,
    /// Scored by the mean epipolar error of the inliers.
    by_error: PrecisionRecallCurve,
    /// Scored by the number of inliers.
    by_inliers: PrecisionRecallCurve,
}

impl Outcome {
    /// Queries for which a frame of the same place was retrieved.
    fn n_right(&self) -> usize {
        self.answers.iter().filter(|a| a.is_correct).count()
    }
}

/// Recognizes, scores and writes; returns the report.
///
/// # Errors
/// A configuration that is wrong, a sequence without ground truth or revisits, a network that cannot be used, a folder that cannot
/// be written.
pub(crate) fn run(args: &PlacesArgs) -> Result<String> {
    let config = args.settings.load()?;
    let sequence = open_sequence(&args.sequence, None)?;
    let selections = args.selections();
    let truth = truth::of(&sequence, args)?;
    let mut describer = Describer::new(args, &config, &selections)?;
    io::create_output_folder(&args.out)?;
    let images: Vec<&Path> =
        sequence.frames.iter().step_by(args.every as usize).map(|frame| frame.left.as_path()).collect();
    let answers = recognize(&images, &truth, (args.min_gap(), args.single), &mut describer)?;
    let outcomes: Vec<Outcome> = selections
        .iter()
        .zip(answers)
        .map(|(&selection, answers)| outcome(selection, answers, &truth))
        .collect::<Result<_>>()?;
    write::files(&args.out, &sequence.name, &outcomes, &truth)?;
    Ok(write::report(&outcomes, &truth, &args.out))
}

/// The answers of each selection to each frame.
fn recognize(
    images: &[&Path],
    truth: &LoopTruth,
    (min_gap, single): (usize, bool),
    describer: &mut Describer,
) -> Result<Vec<Vec<Answer>>> {
    let n_selections = describer.selections.len();
    let mut memories: Vec<Memory> = (0..n_selections).map(|_| Memory::default()).collect();
    let mut sights: Vec<Vec<Sight>> = vec![Vec::new(); n_selections];
    let mut answers: Vec<Vec<Answer>> = vec![Vec::new(); n_selections];
    let bar = console::bar(Some(images.len() as u64), "{bar:24} {pos}/{len} frames");
    for (query, image) in images.iter().enumerate() {
        let image = io::load_gray(image)?;
        let described = describer.describe(&image).with_context(|| format!("frame {query}"))?;
        for (i, sight) in described.into_iter().enumerate() {
            if let Some(old) = query.checked_sub(min_gap) {
                memories[i].add(old, &sights[i][old])?;
            }
            let candidates = memories[i].candidates(&sight, single);
            if let Some((retrieved, evidence)) = best(&sight, &candidates, &sights[i], query as u64) {
                let is_correct = truth.is_correct(query, retrieved);
                answers[i].push(Answer { query, retrieved, evidence, is_correct });
            }
            sights[i].push(sight);
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(answers)
}

/// Curves of the answers that geometry supports.
fn outcome(selection: Selection, answers: Vec<Answer>, truth: &LoopTruth) -> Result<Outcome> {
    let curve = |score: &dyn Fn(Evidence) -> f64| {
        let detection = |a: &Answer| Some(Detection { score: score(a.evidence?), is_correct: a.is_correct });
        let detections: Vec<Detection> = answers.iter().filter_map(detection).collect();
        if detections.is_empty() {
            return Ok(PrecisionRecallCurve {
                n_events: truth.n_queries(),
                ..PrecisionRecallCurve::default()
            });
        }
        precision_recall(&detections, truth.n_queries()).with_context(|| format!("selection {selection}"))
    };
    let by_error = curve(&|e| e.mean_error_px)?;
    let by_inliers = curve(&|e| -(e.n_inliers as f64))?;
    Ok(Outcome { selection, answers, by_error, by_inliers })
}

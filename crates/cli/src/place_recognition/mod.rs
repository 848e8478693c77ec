//! `dsslam places`: recognises places with 500 features of three selections, as the DSFeat paper's second table does. For
//! each frame the most similar earlier one is retrieved; the mean epipolar error of the RANSAC inliers between both is its
//! score, and a threshold on it that rises gives the precision-recall curve.

mod selections;
mod sight;
mod truth;
mod verify;
mod write;

use std::path::Path;

use anyhow::Context;
use eval::{Detection, LoopTruth, PrecisionRecallCurve, precision_recall};
use io::open_sequence;

use crate::args::{PlaceSelection, PlacesArgs};
use crate::console;
use crate::exit::{Exit, Failure, OrExit};
use selections::Describer;
use sight::{Memory, Sight};
use verify::{Evidence, evidence};

/// What was retrieved for one query by one selection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Answer {
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
pub(crate) struct Outcome {
    selection: PlaceSelection,
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

/// Recognises, scores, writes and prints.
///
/// # Errors
/// A sequence without ground truth or revisits, a network that cannot be used, a folder that cannot be written.
pub(crate) fn run(args: &PlacesArgs) -> Result<Exit, Failure> {
    let config = args.settings.load().or_input()?;
    let sequence = open_sequence(&args.sequence, None).or_input()?;
    let selections: Vec<PlaceSelection> =
        if args.selection.is_empty() { PlaceSelection::ALL.to_vec() } else { args.selection.clone() };
    let truth = truth::of(&sequence, args).or_input()?;
    let vocabulary = dsslam::vocabulary(args.vocab.as_deref()).or_input()?;
    let mut describer = Describer::new(args, &config, &selections, vocabulary).or_input()?;
    io::create_output_folder(&args.out).or_output()?;
    let images: Vec<&Path> =
        sequence.frames.iter().step_by(args.every as usize).map(|frame| frame.left.as_path()).collect();
    let answers = recognise(&images, &truth, args.min_gap(), &selections, &mut describer)?;
    let outcomes: Vec<Outcome> = selections
        .iter()
        .zip(answers)
        .map(|(&selection, answers)| outcome(selection, answers, &truth))
        .collect::<anyhow::Result<_>>()
        .or_input()?;
    write::files(&args.out, &sequence.name, &outcomes, &truth).or_output()?;
    console::say(write::report(&outcomes, &truth, &args.out).trim_end());
    Ok(Exit::Done)
}

/// The answers of each selection to each frame.
fn recognise(
    images: &[&Path],
    truth: &LoopTruth,
    min_gap: usize,
    selections: &[PlaceSelection],
    describer: &mut Describer,
) -> Result<Vec<Vec<Answer>>, Failure> {
    let bar = console::bar(Some(images.len() as u64), "{bar:24} {pos}/{len} frames");
    let mut memories: Vec<Memory> = selections.iter().map(|_| Memory::default()).collect();
    let mut sights: Vec<Vec<Sight>> = selections.iter().map(|_| Vec::new()).collect();
    let mut answers: Vec<Vec<Answer>> = selections.iter().map(|_| Vec::new()).collect();
    for (query, image) in images.iter().enumerate() {
        let image = io::load_gray(image).or_input()?;
        let described = describer.describe(&image).with_context(|| format!("frame {query}")).or_input()?;
        for (i, sight) in described.into_iter().enumerate() {
            if let Some(old) = query.checked_sub(min_gap) {
                memories[i].add(old, &sights[i][old]).or_input()?;
            }
            if let Some(retrieved) = memories[i].most_similar(&sight) {
                let evidence = evidence(&sight, &sights[i][retrieved], query as u64);
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

/// The curve of a selection none of whose answers geometry supports.
fn nothing_found(n_events: usize) -> PrecisionRecallCurve {
    PrecisionRecallCurve {
        points: Vec::new(),
        auc: 0.0,
        recall_at_full_precision: 0.0,
        n_detections: 0,
        n_events,
    }
}

/// Curves of the answers that geometry supports.
fn outcome(selection: PlaceSelection, answers: Vec<Answer>, truth: &LoopTruth) -> anyhow::Result<Outcome> {
    let curve = |score: &dyn Fn(Evidence) -> f64| {
        let detection = |a: &Answer| Some(Detection { score: score(a.evidence?), is_correct: a.is_correct });
        let detections: Vec<Detection> = answers.iter().filter_map(detection).collect();
        if detections.is_empty() {
            return Ok(nothing_found(truth.n_queries()));
        }
        precision_recall(&detections, truth.n_queries()).with_context(|| format!("selection {selection}"))
    };
    let by_error = curve(&|e| e.mean_error_px)?;
    let by_inliers = curve(&|e| -(e.n_inliers as f64))?;
    Ok(Outcome { selection, answers, by_error, by_inliers })
}

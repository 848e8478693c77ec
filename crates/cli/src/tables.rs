//! The tables of a run: the outcome of each frame, the loops that were verified, the time of each stage.

use eval::table::csv_field;
use geometry::PoseCovariance;
use runtime::{FrameRecord, LoopRecord, LoopResult, Timings};
use slam::Assessment;

/// `frames.csv`: a row per frame. Frames with equal `submap` have poses in one coordinate frame; it is the keyframe that
/// the sub-map grew from. The covariance is the upper triangle, row by row, in the axes of the camera.
pub(crate) fn frames_csv(records: &[FrameRecord], clock: &io::Clock) -> String {
    let mut text =
        String::from("frame,timestamp_s,state,submap,inliers,reason,quality,quality_reasons,residual_px");
    PoseCovariance::names().for_each(|name| text.push_str(&format!(",cov_{name}")));
    text.push('\n');
    for record in records {
        let inliers = record.status.inliers().map_or(String::new(), |inliers| inliers.to_string());
        let reason = record.status.reason().unwrap_or_default();
        let submap = record.submap.map_or(String::new(), |root| root.to_string());
        let stamp = clock.stamp(record.timestamp_s).to_string();
        text.push_str(&format!(
            "{},{},{},{submap},{inliers},{}",
            record.index,
            // All digits that say something; there is always a point.
            stamp.trim_end_matches('0').trim_end_matches('.'),
            record.status.state().key(),
            csv_field(&reason)
        ));
        push_assessment(&mut text, &record.assessment);
        text.push('\n');
    }
    text
}

/// The cells that say how far a frame is to be trusted, each with a comma in front; all digits are kept.
fn push_assessment(text: &mut String, assessment: &Assessment) {
    let reasons: Vec<&str> = assessment.reasons.iter().map(|reason| reason.key()).collect();
    let residual_px = assessment.residual_px.map_or(String::new(), |px| px.to_string());
    text.push_str(&format!(",{},{},{residual_px}", assessment.quality, reasons.join(";")));
    match &assessment.covariance {
        Some(covariance) => covariance.triangle().iter().for_each(|v| text.push_str(&format!(",{v:e}"))),
        None => text.push_str(&",".repeat(PoseCovariance::N)),
    }
}

/// `loops.csv`: a row per loop that was looked at closely.
pub(crate) fn loops_csv(loops: &[LoopRecord]) -> String {
    let mut text =
        String::from("frame,matched_frame,result,inliers,moved_m,turned_deg,joins_submaps,reason\n");
    for record in loops {
        let (result, numbers, reason) = match &record.result {
            LoopResult::Closed { inliers, moved_m, turned_deg, joined } => {
                ("closed", format!("{inliers},{moved_m:.4},{turned_deg:.4},{joined}"), String::new())
            }
            LoopResult::Rejected(reason) => ("rejected", ",,,".to_owned(), csv_field(reason)),
            LoopResult::Refused(reason) => ("refused", ",,,".to_owned(), csv_field(reason)),
            LoopResult::TakenBack { by } => {
                let reason = format!("the loop from frame {by} contradicts it");
                ("taken back", ",,,".to_owned(), reason)
            }
        };
        let (frame, matched) = (record.frame, record.matched_frame);
        text.push_str(&format!("{frame},{matched},{result},{numbers},{reason}\n"));
    }
    text
}

/// `timings.csv`: a row per frame, a column per stage, milliseconds; empty where a stage did not run.
pub(crate) fn timings_csv(timings: &Timings) -> String {
    let stages = timings.stages();
    let mut text = format!("frame,{}\n", stages.join(","));
    for row in &timings.rows {
        let cell = |stage: &&str| {
            let times: Vec<f64> =
                row.stages.iter().filter(|(name, _)| name == stage).map(|(_, ms)| *ms).collect();
            if times.is_empty() { String::new() } else { format!("{:.3}", times.iter().sum::<f64>()) }
        };
        let cells: Vec<String> = stages.iter().map(cell).collect();
        text.push_str(&format!("{},{}\n", row.index, cells.join(",")));
    }
    text
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use geometry::{SE3, SO3, Vec3};
    use map::KeyframeId;
    use runtime::{FrameStatus, FrameTimings, Unusable};
    use slam::QualityReason;

    /// A frame at x = `x` meters, or a dropped one.
    pub(crate) fn record(index: u32, x: Option<f64>) -> FrameRecord {
        let world_from_cam = x.map(|x| SE3::new(SO3::identity(), Vec3::new(x, 0.0, 0.0)));
        let status = match x {
            Some(_) => FrameStatus::Tracked { inliers: 100 },
            None => FrameStatus::Dropped(Unusable::Missing("left")),
        };
        FrameRecord::new(index, f64::from(index) * 0.1, status, world_from_cam)
    }

    #[test]
    fn each_frame_says_its_sub_map_or_why_it_has_none() {
        let mut records = [record(3, Some(0.0)), record(4, None)];
        records[0].submap = Some(KeyframeId(7));
        records[1].status = FrameStatus::Dropped(
            io::ImageError::Unreadable { path: "a.png".into(), reason: "\"no\", thanks".to_owned() }.into(),
        );
        let (root, empty) = (KeyframeId(7).to_string(), ",".repeat(PoseCovariance::N));
        let text = frames_csv(&records, &io::Clock::default());
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[1], format!("3,0.3,tracked,{root},100,,0,,{empty}"));
        assert_eq!(
            lines[2],
            format!("4,0.4,dropped,,,\"a.png: cannot be read: \"\"no\"\", thanks\",0,,{empty}")
        );
        assert!(lines[0].starts_with("frame,timestamp_s,state,submap,inliers,reason,quality,"));
        assert!(lines[0].ends_with(",cov_ryrz,cov_rzrz"));
        assert_eq!(lines[0].split(',').count(), lines[1].split(',').count());
    }

    #[test]
    fn every_digit_of_a_covariance_is_written() {
        let triangle =
            std::array::from_fn(|i| if [0, 6, 11, 15, 18, 20].contains(&i) { 1.0 / 3.0 } else { 1e-4 });
        let mut record = record(3, Some(0.0));
        record.assessment = Assessment {
            covariance: PoseCovariance::of_triangle(&triangle),
            residual_px: Some(0.5),
            quality: 0.25,
            reasons: vec![QualityReason::FewInliers, QualityReason::MostlyFar],
        };
        let text = frames_csv(&[record], &io::Clock::default());
        let cells: Vec<&str> = text.lines().nth(1).unwrap().split(',').collect();
        assert_eq!(cells[6..9], ["0.25", "few_inliers;mostly_far", "0.5"]);
        let read: Vec<f64> = cells[9..].iter().map(|cell| cell.parse().unwrap()).collect();
        assert_eq!(read, triangle);
    }

    #[test]
    fn closed_and_rejected_loops_have_the_same_columns() {
        let of = |result| LoopRecord {
            frame: 90,
            keyframe: KeyframeId(30),
            matched_frame: 2,
            matched: KeyframeId(1),
            result,
        };
        let closed = LoopResult::Closed { inliers: 80, moved_m: 1.25, turned_deg: 0.5, joined: false };
        let text = loops_csv(&[of(closed), of(LoopResult::Rejected("too far, by 9 m".to_owned()))]);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[1], "90,2,closed,80,1.2500,0.5000,false,");
        assert_eq!(lines[2], "90,2,rejected,,,,,\"too far, by 9 m\"");
        assert_eq!(lines[0].split(',').count(), lines[1].split(',').count());
        let text = loops_csv(&[of(LoopResult::TakenBack { by: 140 })]);
        assert!(text.ends_with("\n90,2,taken back,,,,,the loop from frame 140 contradicts it\n"), "{text}");
    }

    #[test]
    fn a_stage_that_ran_twice_is_summed_and_one_that_did_not_is_empty() {
        let rows = vec![
            FrameTimings { index: 7, stages: vec![("extract", 2.0), ("track", 3.0)] },
            FrameTimings { index: 8, stages: vec![("track", 1.25), ("fuse", 0.5), ("fuse", 0.25)] },
        ];
        assert_eq!(
            timings_csv(&Timings { rows }),
            "frame,extract,track,fuse\n7,2.000,3.000,\n8,,1.250,0.750\n"
        );
    }
}

//! Files of place-recognition answers: `# events N`, then `score,correct` a line (score: smaller is better; correct: 0 or 1).

use std::path::Path;

use anyhow::{Context, Result, bail, ensure};

use crate::precision_recall::Detection;

/// Reads the detections and the number of loop events of a file.
///
/// # Errors
/// The file cannot be read, has no `# events N` line, or a row is not `score,correct`; the message names file and line.
pub fn read_detections(path: &Path) -> Result<(Vec<Detection>, usize)> {
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    parse(&text).with_context(|| format!("{}", path.display()))
}

/// The text of a file of detections.
pub fn detections_csv(detections: &[Detection], n_events: usize) -> String {
    let mut text = format!("# events {n_events}\nscore,correct\n");
    for d in detections {
        text += &format!("{},{}\n", d.score, u8::from(d.is_correct));
    }
    text
}

fn parse(text: &str) -> Result<(Vec<Detection>, usize)> {
    let mut n_events = None;
    let mut detections = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let (number, line) = (i + 1, line.trim());
        if let Some(comment) = line.strip_prefix('#') {
            if let Some(n) = comment.trim().strip_prefix("events") {
                n_events = Some(
                    n.trim()
                        .parse()
                        .with_context(|| format!("line {number}: found '{line}', expected '# events N'"))?,
                );
            }
        } else if !line.is_empty() && line != "score,correct" {
            let Some((score, correct)) = line.split_once(',') else {
                bail!("line {number}: found '{line}', expected 'score,correct'");
            };
            let score = score
                .trim()
                .parse()
                .with_context(|| format!("line {number}: found '{score}', expected a score"))?;
            let is_correct = match correct.trim() {
                "1" => true,
                "0" => false,
                other => bail!("line {number}: found '{other}', expected 0 or 1"),
            };
            detections.push(Detection { score, is_correct });
        }
    }
    ensure!(n_events.is_some(), "no line '# events N' with the number of loop events");
    Ok((detections, n_events.unwrap_or_default()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_again() {
        let list = [Detection { score: 0.5, is_correct: true }, Detection { score: 1.25, is_correct: false }];
        assert_eq!(parse(&detections_csv(&list, 7)).unwrap(), (list.to_vec(), 7));
    }

    #[test]
    fn messages() {
        let message = |text: &str| format!("{:#}", parse(text).unwrap_err());
        assert_eq!(message("1,1\n"), "no line '# events N' with the number of loop events");
        assert_eq!(message("# events 3\n1;1\n"), "line 2: found '1;1', expected 'score,correct'");
        assert_eq!(message("# events 3\n1,2\n"), "line 2: found '2', expected 0 or 1");
        assert!(
            message("# events many\n").starts_with("line 1: found '# events many', expected '# events N'")
        );
    }
}

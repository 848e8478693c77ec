//! Tables of a suite's results beside published baselines, as text, Markdown, CSV and LaTeX.

mod build;
mod render;
mod runs;

pub(crate) use build::value;
pub use build::{baselines_for, metric_table};
pub use render::csv_field;
pub(crate) use render::escape;
pub use runs::{runs_csv, runs_table};

/// A table that can be rendered in every format.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Title.
    pub title: String,
    /// Head of the first column.
    pub corner: String,
    /// Heads of the other columns.
    pub columns: Vec<String>,
    /// Rows, each as long as `columns`.
    pub rows: Vec<Row>,
    /// Rows at the end that summarize the others (mean, pooled); set apart by a line.
    pub n_summary_rows: usize,
    /// Notes below: lost frames, failures, sources.
    pub notes: Vec<String>,
}

/// One row.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// First column.
    pub name: String,
    /// The other columns.
    pub cells: Vec<Cell>,
}

/// One cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cell {
    /// What is printed.
    pub text: String,
    /// The number behind it, in full precision, for CSV.
    pub value: Option<f64>,
    /// Best of its row: printed bold.
    pub is_best: bool,
    /// Frames were lost: printed with a dagger, explained in the notes.
    pub has_lost_frames: bool,
}

impl Cell {
    /// A cell without a number.
    pub fn text(text: impl Into<String>) -> Cell {
        Cell { text: text.into(), ..Cell::default() }
    }

    /// A number with `digits` decimals; a dash when there is none.
    pub fn number(value: Option<f64>, digits: usize) -> Cell {
        let text = value.map_or_else(|| "-".to_owned(), |v| format!("{v:.digits$}"));
        Cell { text, value, ..Cell::default() }
    }
}

//! A table as terminal text, Markdown, CSV, LaTeX and HTML.

use super::{Cell, Row, Table};

const DAGGER: &str = "\u{2020}";

impl Table {
    /// Aligned columns for a terminal; the best of a row has a star.
    pub fn to_terminal(&self) -> String {
        let shown = |cell: &Cell| {
            let best = if cell.is_best { "*" } else { "" };
            format!("{}{}{best}", cell.text, dagger(cell))
        };
        let lines = self.lines(shown);
        let widths: Vec<usize> = (0..lines[0].len())
            .map(|c| lines.iter().map(|line| line[c].chars().count()).max().unwrap_or(0))
            .collect();
        let rule = "-".repeat(widths.iter().sum::<usize>() + 2 * (widths.len() - 1));
        let mut text = format!("{}\n", self.title);
        for (i, line) in lines.iter().enumerate() {
            if i == 1 || (self.n_summary_rows > 0 && i == lines.len() - self.n_summary_rows) {
                text += &format!("{rule}\n");
            }
            let cells: Vec<String> = line
                .iter()
                .zip(&widths)
                .enumerate()
                .map(
                    |(c, (cell, &width))| {
                        if c == 0 { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
                    },
                )
                .collect();
            text += &format!("{}\n", cells.join("  ").trim_end());
        }
        self.notes.iter().for_each(|note| text += &format!("  {note}\n"));
        text
    }

    /// A pipe table; the best of a row is bold.
    pub fn to_markdown(&self) -> String {
        let bold = |cell: &Cell| {
            let text = format!("{}{}", cell.text, dagger(cell));
            if cell.is_best { format!("**{text}**") } else { text }
        };
        let lines = self.lines(bold);
        let row = |line: &Vec<String>| {
            let cells: Vec<String> = line.iter().map(|cell| cell.replace('|', "\\|")).collect();
            format!("| {} |\n", cells.join(" | "))
        };
        let mut text =
            format!("### {}\n\n{}|---|{}\n", self.title, row(&lines[0]), "---:|".repeat(self.columns.len()));
        lines[1..].iter().for_each(|line| text += &row(line));
        if !self.notes.is_empty() {
            text.push('\n');
            self.notes.iter().for_each(|note| text += &format!("- {note}\n"));
        }
        text
    }

    /// Comma separated; numbers in full precision, without marks and notes.
    pub fn to_csv(&self) -> String {
        let full = |cell: &Cell| cell.value.map_or_else(|| cell.text.clone(), |v| v.to_string());
        let mut text = String::new();
        for line in self.lines(full) {
            let cells: Vec<String> = line.iter().map(|cell| csv_field(cell)).collect();
            text += &format!("{}\n", cells.join(","));
        }
        text
    }

    /// A `tabular` with `booktabs` rules; the best of a row is bold.
    pub fn to_latex(&self) -> String {
        let bold = |cell: &Cell| {
            let mark = if cell.has_lost_frames { "$^\\dagger$" } else { "" };
            let text = format!("{}{mark}", latex(&cell.text));
            if cell.is_best { format!("\\textbf{{{text}}}") } else { text }
        };
        let heads: Vec<String> = self.columns.iter().map(|c| latex(c)).collect();
        let mut text =
            format!("% {}\n\\begin{{tabular}}{{l{}}}\n\\toprule\n", self.title, "r".repeat(heads.len()));
        text += &format!("{} & {} \\\\\n\\midrule\n", latex(&self.corner), heads.join(" & "));
        for (i, row) in self.rows.iter().enumerate() {
            if self.n_summary_rows > 0 && i == self.rows.len() - self.n_summary_rows {
                text += "\\midrule\n";
            }
            let cells: Vec<String> = row.cells.iter().map(bold).collect();
            text += &format!("{} & {} \\\\\n", latex(&row.name), cells.join(" & "));
        }
        text += "\\bottomrule\n\\end{tabular}\n";
        self.notes.iter().for_each(|note| text += &format!("% {note}\n"));
        text
    }

    /// A table element with its notes.
    pub fn to_html(&self) -> String {
        let mut text = format!("<h3>{}</h3>\n<div class=\"scroll\"><table>\n<tr>", escape(&self.title));
        let heads = std::iter::once(&self.corner).chain(&self.columns);
        heads.for_each(|head| text += &format!("<th>{}</th>", escape(head)));
        text += "</tr>\n";
        for (i, row) in self.rows.iter().enumerate() {
            let class = if i + self.n_summary_rows >= self.rows.len() { " class=\"summary\"" } else { "" };
            text += &format!("<tr{class}><th>{}</th>", escape(&row.name));
            for cell in &row.cells {
                let class = if cell.is_best { " class=\"best\"" } else { "" };
                text += &format!("<td{class}>{}{}</td>", escape(&cell.text), dagger(cell));
            }
            text += "</tr>\n";
        }
        text += "</table></div>\n";
        if !self.notes.is_empty() {
            text += "<ul>\n";
            self.notes.iter().for_each(|note| text += &format!("<li>{}</li>\n", escape(note)));
            text += "</ul>\n";
        }
        text
    }

    /// Head and rows as texts.
    fn lines(&self, shown: impl Fn(&Cell) -> String) -> Vec<Vec<String>> {
        let head = std::iter::once(self.corner.clone()).chain(self.columns.iter().cloned()).collect();
        let row = |row: &Row| std::iter::once(row.name.clone()).chain(row.cells.iter().map(&shown)).collect();
        std::iter::once(head).chain(self.rows.iter().map(row)).collect()
    }
}

fn dagger(cell: &Cell) -> &'static str {
    if cell.has_lost_frames { DAGGER } else { "" }
}

/// A text as a cell of a table: in quotes if it holds a comma, a quote or the end of a line (RFC 4180).
pub fn csv_field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

/// Escapes LaTeX's special characters.
fn latex(text: &str) -> String {
    let mut result = String::new();
    for c in text.chars() {
        match c {
            '%' | '_' | '&' | '#' | '$' | '{' | '}' => {
                result.push('\\');
                result.push(c);
            }
            _ => result.push(c),
        }
    }
    result
}

/// Escapes HTML's special characters.
pub(crate) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let best = Cell { is_best: true, has_lost_frames: true, ..Cell::number(Some(0.123456), 3) };
        Table {
            title: "t_rel [%]".to_owned(),
            corner: "sequence".to_owned(),
            columns: vec!["a_b".to_owned(), "x, y".to_owned()],
            rows: vec![
                Row { name: "00".to_owned(), cells: vec![best, Cell::number(Some(2.0), 3)] },
                Row { name: "mean".to_owned(), cells: vec![Cell::text("failed"), Cell::number(None, 3)] },
            ],
            n_summary_rows: 1,
            notes: vec!["\u{2020} lost".to_owned()],
        }
    }

    #[test]
    fn terminal() {
        let expected = "t_rel [%]\n\
                        sequence      a_b   x, y\n\
                        ------------------------\n\
                        00        0.123\u{2020}*  2.000\n\
                        ------------------------\n\
                        mean       failed      -\n\
                        \x20 \u{2020} lost\n";
        assert_eq!(table().to_terminal(), expected);
    }

    #[test]
    fn markdown() {
        let expected = "### t_rel [%]\n\n| sequence | a_b | x, y |\n|---|---:|---:|\n\
                        | 00 | **0.123\u{2020}** | 2.000 |\n| mean | failed | - |\n\n- \u{2020} lost\n";
        assert_eq!(table().to_markdown(), expected);
    }

    #[test]
    fn csv_has_full_precision() {
        assert_eq!(table().to_csv(), "sequence,a_b,\"x, y\"\n00,0.123456,2\nmean,failed,-\n");
    }

    #[test]
    fn latex_escapes() {
        let text = table().to_latex();
        assert!(text.contains(
            "sequence & a\\_b & x, y \\\\\n\\midrule\n00 & \\textbf{0.123$^\\dagger$} & 2.000 \\\\\n"
        ));
        assert!(text.ends_with("\\bottomrule\n\\end{tabular}\n% \u{2020} lost\n"));
    }

    #[test]
    fn html_escapes() {
        let mut table = table();
        table.title = "a < b & c".to_owned();
        assert!(table.to_html().starts_with("<h3>a &lt; b &amp; c</h3>"));
    }
}

//! ORB-SLAM2's text format of DBoW2 vocabularies.
//!
//! The first line holds branching, levels, scoring (0: L1) and weighting (0: TF-IDF). Each further line is a node, numbered
//! from 1 (the root, 0, has none): its parent, whether it is a leaf, the 32 bytes of its median, its weight.

use crate::error::FormatError;
use crate::kernels::Bits;
use crate::vocabulary::{Origin, Tables, Vocabulary};
use features::Descriptor;
use std::fmt::Write;
use std::ops::Range;
use std::str::{FromStr, SplitAsciiWhitespace};

/// Whether the bytes begin as the text format does: with a digit.
pub(crate) fn is_text(bytes: &[u8]) -> bool {
    bytes.trim_ascii_start().first().is_some_and(u8::is_ascii_digit)
}

/// A line of the file.
struct Node {
    line: usize,
    parent: u32,
    is_leaf: bool,
    median: Bits,
    weight: f32,
}

impl Vocabulary {
    /// Reads ORB-SLAM2's text format; nodes are renumbered breadth first, the order of siblings is kept.
    ///
    /// # Errors
    /// [`FormatError::Line`] for the first line that is wrong, [`FormatError::Invalid`] when the nodes form no tree.
    pub fn from_text(text: &str) -> Result<Self, FormatError> {
        let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line));
        let (number, head) = lines.next().unwrap_or((1, ""));
        let (branching, levels) = parse_head(&mut Fields::new(number, head))?;
        let mut nodes = Vec::new();
        for (number, line) in lines.filter(|(_, line)| !line.trim_ascii().is_empty()) {
            nodes.push(parse_node(&mut Fields::new(number, line), nodes.len() as u32 + 1)?);
        }
        Self::from_tables(&breadth_first(&nodes, branching, levels)?)
    }

    /// Writes ORB-SLAM2's text format, in the order of DBoW2: the children of a node, then what is below each of them.
    ///
    /// Equal to the text that the vocabulary was read from, if that has this order, single spaces and weights of up to six
    /// digits.
    pub fn to_text(&self) -> String {
        let mut text = format!("{} {} 0 0\n", self.branching(), self.levels());
        text.reserve(self.n_nodes() as usize * 130);
        // Sibling groups still to be written, the next one last, with the parent's number in the text.
        let mut pending = vec![(0, self.tree().children(0))];
        let mut written = 0;
        while let Some((parent, siblings)) = pending.pop() {
            let mut below = Vec::new();
            for node in siblings {
                written += 1;
                let children = self.tree().children(node);
                self.write_node(&mut text, parent, node, children.is_empty());
                if !children.is_empty() {
                    below.push((written, children));
                }
            }
            pending.extend(below.into_iter().rev());
        }
        text
    }

    fn write_node(&self, text: &mut String, parent: u32, node: usize, is_leaf: bool) {
        // Writing to a string cannot fail.
        let _ = write!(text, "{parent} {}", u8::from(is_leaf));
        for byte in Descriptor(self.tree().medians[node]).to_bytes() {
            let _ = write!(text, " {byte}");
        }
        let _ = writeln!(text, " {}", self.tree().weights[node]);
    }
}

fn parse_head(fields: &mut Fields<'_>) -> Result<(u32, u32), FormatError> {
    let branching = fields.number("branching from 2 to 1000", |k: &u32| (2..=1000).contains(k))?;
    let levels = fields.number("levels from 1 to 16", |l: &u32| (1..=16).contains(l))?;
    fields.number("scoring 0 (L1)", |&scoring: &u32| scoring == 0)?;
    fields.number("weighting 0 (TF-IDF)", |&weighting: &u32| weighting == 0)?;
    fields.end()?;
    Ok((branching, levels))
}

fn parse_node(fields: &mut Fields<'_>, node: u32) -> Result<Node, FormatError> {
    let parent = fields.number("the number of an earlier node (parent)", |&parent: &u32| parent < node)?;
    let is_leaf = fields.number("0 or 1 (leaf)", |&leaf: &u8| leaf <= 1)? == 1;
    let mut bytes = [0; 32];
    for byte in &mut bytes {
        *byte = fields.number("32 descriptor bytes", |_: &u8| true)?;
    }
    let weight = fields.number("a weight, not negative", |w: &f32| w.is_finite() && *w >= 0.0)?;
    fields.end()?;
    // Adding zero makes a negative zero positive.
    Ok(Node {
        line: fields.line,
        parent,
        is_leaf,
        median: Descriptor::from_bytes(&bytes).0,
        weight: weight + 0.0,
    })
}

/// The tables of a tree given as a list of nodes.
fn breadth_first(nodes: &[Node], branching: u32, levels: u32) -> Result<Tables, FormatError> {
    let children = Children::of(nodes);
    for (i, node) in nodes.iter().enumerate() {
        if node.is_leaf != children.range(i + 1).is_empty() {
            let (found, expected) =
                if node.is_leaf { ("a leaf", "no children") } else { ("no leaf", "children") };
            return Err(line_error(node.line, found.into(), format!("{expected} further down")));
        }
    }
    let mut tables = Tables {
        branching,
        levels,
        origin: Origin::default(),
        medians: vec![[0; 4]],
        first_child: Vec::with_capacity(nodes.len() + 2),
        weights: vec![0.0],
    };
    let mut order = vec![0];
    let mut next = 0;
    while next < order.len() {
        tables.first_child.push(order.len() as u32);
        for &child in &children.members[children.range(order[next])] {
            order.push(child as usize);
            tables.medians.push(nodes[child as usize - 1].median);
            tables.weights.push(nodes[child as usize - 1].weight);
        }
        next += 1;
    }
    tables.first_child.push(order.len() as u32);
    Ok(tables)
}

/// Children of every node of a list, in the list's order.
struct Children {
    starts: Vec<u32>,
    members: Vec<u32>,
}

impl Children {
    fn of(nodes: &[Node]) -> Self {
        let mut starts = vec![0; nodes.len() + 2];
        for node in nodes {
            starts[node.parent as usize + 1] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut free = starts.clone();
        let mut members = vec![0; nodes.len()];
        for (i, node) in nodes.iter().enumerate() {
            let place = &mut free[node.parent as usize];
            members[*place as usize] = i as u32 + 1;
            *place += 1;
        }
        Self { starts, members }
    }

    fn range(&self, node: usize) -> Range<usize> {
        self.starts[node] as usize..self.starts[node + 1] as usize
    }
}

/// The fields of a line.
struct Fields<'a> {
    line: usize,
    fields: SplitAsciiWhitespace<'a>,
}

impl<'a> Fields<'a> {
    fn new(line: usize, text: &'a str) -> Self {
        Self { line, fields: text.split_ascii_whitespace() }
    }

    /// The next field, a number that fits.
    fn number<T: FromStr>(&mut self, expected: &str, fits: impl Fn(&T) -> bool) -> Result<T, FormatError> {
        let field = self.fields.next().unwrap_or("");
        field.parse().ok().filter(fits).ok_or_else(|| {
            let found = if field.is_empty() { "the end of the line".into() } else { format!("{field:?}") };
            line_error(self.line, found, expected.into())
        })
    }

    /// Checks that there is no further field.
    fn end(&mut self) -> Result<(), FormatError> {
        match self.fields.next() {
            None => Ok(()),
            Some(field) => Err(line_error(self.line, format!("{field:?}"), "the end of the line".into())),
        }
    }
}

fn line_error(line: usize, found: String, expected: String) -> FormatError {
    FormatError::Line { line, found, expected }
}

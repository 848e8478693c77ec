//! XML as a value: elements with elements inside are sections, all others are text.

use roxmltree::Document;

use super::{Node, SyntaxError, Value};

/// The outermost element under its name.
pub(super) fn parse(text: &str) -> Result<Node, SyntaxError> {
    let document = Document::parse(text).map_err(|error| SyntaxError {
        line: u64::from(error.pos().row),
        column: u64::from(error.pos().col),
        format: "XML",
        message: error.to_string(),
    })?;
    let root = document.root_element();
    let value = Value::Section(vec![(root.tag_name().name().to_owned(), node(root, MOST_LEVELS))]);
    Ok(Node { line: 1, column: 1, value })
}

/// Elements that lie deeper in each other are left out.
const MOST_LEVELS: usize = 64;

fn node(element: roxmltree::Node<'_, '_>, levels: usize) -> Node {
    let place = element.document().text_pos_at(element.range().start);
    let inside = |child: roxmltree::Node<'_, '_>| {
        (child.tag_name().name().to_owned(), node(child, levels.saturating_sub(1)))
    };
    let elements = element.children().filter(|child| levels > 0 && child.is_element());
    let children: Vec<_> = elements.map(inside).collect();
    let value = if children.is_empty() {
        Value::Text(element.text().unwrap_or("").trim().to_owned())
    } else {
        Value::Section(children)
    };
    Node { line: u64::from(place.row), column: u64::from(place.col), value }
}

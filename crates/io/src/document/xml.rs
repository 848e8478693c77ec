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
    let value = Value::Section(vec![(root.tag_name().name().to_owned(), node(root))]);
    Ok(Node { line: 1, column: 1, value })
}

fn node(element: roxmltree::Node<'_, '_>) -> Node {
    let place = element.document().text_pos_at(element.range().start);
    let inside = |child: roxmltree::Node<'_, '_>| (child.tag_name().name().to_owned(), node(child));
    let children: Vec<_> = element.children().filter(roxmltree::Node::is_element).map(inside).collect();
    let value = if children.is_empty() {
        Value::Text(element.text().unwrap_or("").trim().to_owned())
    } else {
        Value::Section(children)
    };
    Node { line: u64::from(place.row), column: u64::from(place.col), value }
}

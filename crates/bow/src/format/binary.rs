//! Our own format: checked completely, then used in place.

use crate::error::FormatError;
use crate::format::layout::{CHECKSUM, HEADER_BYTES, Layout, MAGIC, VERSION};
use crate::vocabulary::{MAX_BRANCHING, MAX_LEVELS, Origin, Tables, Tree};

/// The numbers at the head of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Header {
    pub(crate) branching: u32,
    pub(crate) levels: u32,
    pub(crate) n_nodes: u32,
    pub(crate) n_words: u32,
    pub(crate) origin: Origin,
}

/// Whether the bytes begin as our format does.
pub(crate) fn is_binary(bytes: &[u8]) -> bool {
    bytes.starts_with(&MAGIC)
}

/// Checks every byte (aligned to 8); gives the header and where the tables are.
pub(crate) fn check(bytes: &[u8]) -> Result<(Header, Layout), FormatError> {
    let length = bytes.len() as u64;
    if !is_binary(bytes) {
        return Err(FormatError::Unknown { found: describe_head(bytes) });
    }
    if bytes.len() < HEADER_BYTES {
        return Err(FormatError::Truncated { found: length, expected: HEADER_BYTES as u64 });
    }
    match u32_at(bytes, 8) {
        VERSION => {}
        0 => return Err(FormatError::Version { found: 0, supported: VERSION }),
        found => return Err(FormatError::Newer { found, supported: VERSION }),
    }
    let expected = u64_at(bytes, 16);
    if length < expected {
        return Err(FormatError::Truncated { found: length, expected });
    }
    if length > expected {
        return Err(FormatError::TooLong { found: length, expected });
    }
    let (found, expected) = (checksum(bytes), u32_at(bytes, CHECKSUM.start));
    if found != expected {
        return Err(FormatError::Checksum { found, expected });
    }
    check_contents(bytes)
}

/// Checks what a right checksum does not prove: that the tables are those of a tree.
fn check_contents(bytes: &[u8]) -> Result<(Header, Layout), FormatError> {
    let header = Header {
        branching: u32_at(bytes, 24),
        levels: u32_at(bytes, 28),
        n_nodes: u32_at(bytes, 32),
        n_words: u32_at(bytes, 36),
        origin: Origin {
            n_images: u64_at(bytes, 40),
            n_descriptors: u64_at(bytes, 48),
            seed: u64_at(bytes, 56),
        },
    };
    let layout = Layout::of(header.n_nodes).filter(|layout| layout.total == bytes.len());
    let layout = layout.ok_or_else(|| invalid(format!("{} nodes do not fill its length", header.n_nodes)))?;
    let n_words = check_tree(&Tree::of(bytes, layout), header.branching, header.levels)?;
    if n_words != header.n_words {
        return Err(invalid(format!("{} words announced, {n_words} leaves found", header.n_words)));
    }
    if bytes[layout.end..].iter().any(|&byte| byte != 0) {
        return Err(invalid("padding is not zero".into()));
    }
    Ok((header, layout))
}

/// Checks that the tables describe a breadth-first tree; gives the number of its leaves.
pub(crate) fn check_tree(tree: &Tree<'_>, branching: u32, levels: u32) -> Result<u32, FormatError> {
    let (first, n_nodes) = (tree.first_child, tree.medians.len());
    if !(2..=MAX_BRANCHING).contains(&branching) || !(1..=MAX_LEVELS).contains(&levels) {
        return Err(invalid(format!("branching {branching}, levels {levels}")));
    }
    if n_nodes < 2 || first[0] != 1 || first[n_nodes] as usize != n_nodes {
        return Err(invalid("the root has no children or some nodes no parent".into()));
    }
    let counts = first.iter().zip(&first[1..]);
    // A descending pair wraps around to more than any branching.
    let most_children = counts.clone().fold(0, |most, (&a, &b)| b.wrapping_sub(a).max(most));
    if most_children > branching {
        return Err(invalid(format!("a node has more than {branching} children")));
    }
    let n_words = counts.fold(0, |n, (a, b)| n + u32::from(a == b));
    // Levels lie one behind the other: the children of the nodes of one level are the next one.
    let (mut start, mut end, mut depth) = (0, 1, 0);
    while start < end {
        (start, end, depth) = (end, first[end] as usize, depth + 1);
    }
    if end != n_nodes || depth - 1 > levels {
        return Err(invalid(format!("its nodes do not form a tree of {levels} levels")));
    }
    // Exponent all ones: not finite; sign: negative. As integers, so that the loop is vectorised.
    let largest = tree.weights.iter().fold(0, |largest: u32, weight| largest.max(weight.to_bits()));
    if largest >= f32::INFINITY.to_bits() {
        return Err(invalid("a weight is negative or not finite".into()));
    }
    Ok(n_words)
}

/// The file of a tree.
pub(crate) fn assemble(tables: &Tables) -> Result<Vec<u8>, FormatError> {
    let n_nodes = tables.medians.len();
    let tree = Tree { medians: &tables.medians, first_child: &tables.first_child, weights: &tables.weights };
    let n_words = check_tree(&tree, tables.branching, tables.levels)?;
    let layout = u32::try_from(n_nodes).ok().and_then(Layout::of);
    let layout = layout.ok_or_else(|| invalid(format!("{n_nodes} nodes are too many")))?;
    let mut bytes = vec![0; layout.total];
    bytes[..8].copy_from_slice(&MAGIC);
    let numbers =
        [(8, VERSION), (24, tables.branching), (28, tables.levels), (32, n_nodes as u32), (36, n_words)];
    for (at, number) in numbers {
        bytes[at..at + 4].copy_from_slice(&number.to_le_bytes());
    }
    let Origin { n_images, n_descriptors, seed } = tables.origin;
    for (at, number) in [(16, layout.total as u64), (40, n_images), (48, n_descriptors), (56, seed)] {
        bytes[at..at + 8].copy_from_slice(&number.to_le_bytes());
    }
    bytes[HEADER_BYTES..layout.children].copy_from_slice(bytemuck::cast_slice(&tables.medians));
    bytes[layout.children..layout.weights].copy_from_slice(bytemuck::cast_slice(&tables.first_child));
    bytes[layout.weights..layout.end].copy_from_slice(bytemuck::cast_slice(&tables.weights));
    let sum = checksum(&bytes);
    bytes[CHECKSUM].copy_from_slice(&sum.to_le_bytes());
    Ok(bytes)
}

/// CRC-32 of all bytes but the checksum's own; the header must be there.
pub(crate) fn checksum(bytes: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&bytes[..CHECKSUM.start]);
    hasher.update(&bytes[CHECKSUM.end..]);
    hasher.finalize()
}

/// The beginning of unknown data, for messages.
pub(crate) fn describe_head(bytes: &[u8]) -> String {
    if bytes.is_empty() {
        return "nothing".into();
    }
    let head: String = bytes.iter().take(16).flat_map(|byte| byte.escape_ascii()).map(char::from).collect();
    format!("\"{head}\"")
}

fn invalid(reason: String) -> FormatError {
    FormatError::Invalid(reason)
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(std::array::from_fn(|i| bytes[at + i]))
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(std::array::from_fn(|i| bytes[at + i]))
}

//! Layout of a vocabulary's bytes, which are the same in memory and in the file (little endian).
//!
//! | bytes | content |
//! |---|---|
//! | 0..8 | magic |
//! | 8..12 | format version |
//! | 12..16 | CRC-32 (IEEE) of all other bytes |
//! | 16..24 | length of the whole in bytes |
//! | 24..28 | branching: most children of a node |
//! | 28..32 | levels: most steps from the root to a leaf |
//! | 32..36 | number of nodes, the root included |
//! | 36..40 | number of words (leaves) |
//! | 40..48 | images it was trained on, 0 when unknown |
//! | 48..56 | descriptors it was trained on, 0 when unknown |
//! | 56..64 | seed of the training |
//! | then | a 32-byte median per node, breadth first; the root's is zero |
//! | then | u32 per node and one more: first child; the children of node i end where those of node i + 1 begin |
//! | then | f32 per node: weight |
//! | last | zeros up to a multiple of 8 bytes |

/// First bytes of a file: the first is not text, and a transfer that changes line ends is noticed.
pub(crate) const MAGIC: [u8; 8] = *b"\x89DSBOW\r\n";
/// Version that is written, and the highest that is read.
pub(crate) const VERSION: u32 = 1;
/// Bytes before the first median.
pub(crate) const HEADER_BYTES: usize = 64;
/// Where the checksum stands.
pub(crate) const CHECKSUM: std::ops::Range<usize> = 12..16;

const _: () =
    assert!(cfg!(target_endian = "little"), "tables are used in place, which needs a little-endian machine");

/// Byte ranges of the tables of a tree with this number of nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Layout {
    /// Start of the table of first children, end of the medians.
    pub(crate) children: usize,
    /// Start of the weights.
    pub(crate) weights: usize,
    /// End of the weights.
    pub(crate) end: usize,
    /// Length of the whole, a multiple of 8.
    pub(crate) total: usize,
}

impl Layout {
    /// The layout, unless it exceeds the address space.
    pub(crate) fn of(n_nodes: u32) -> Option<Self> {
        let n = n_nodes as usize;
        let children = n.checked_mul(32)?.checked_add(HEADER_BYTES)?;
        let weights = n.checked_add(1)?.checked_mul(4)?.checked_add(children)?;
        let end = n.checked_mul(4)?.checked_add(weights)?;
        Some(Self { children, weights, end, total: end.checked_next_multiple_of(8)? })
    }
}

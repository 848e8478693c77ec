//! Our own format: what was written is read again, everything else is refused with its reason.

use super::support::{images, options, random, small_vocabulary};
use dsslam_bow::{FormatError, Vocabulary, train};
use rand::Rng;

/// Offset of the checksum and of the numbers behind it, see the crate's table of the format.
const CHECKSUM: usize = 12;
const LENGTH: usize = 16;
const BRANCHING: usize = 24;
const LEVELS: usize = 28;
const NODES: usize = 32;
const WORDS: usize = 36;
const MEDIANS: usize = 64;

/// The bytes with a checksum that fits them, so that the checks behind it are reached.
fn resealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let rest = [&bytes[..CHECKSUM], &bytes[CHECKSUM + 4..]].concat();
    bytes[CHECKSUM..CHECKSUM + 4].copy_from_slice(&crc32fast::hash(&rest).to_le_bytes());
    bytes
}

fn with_u32(vocabulary: &Vocabulary, at: usize, value: u32) -> Vec<u8> {
    let mut bytes = vocabulary.as_bytes().to_vec();
    bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
    resealed(bytes)
}

fn refusal(bytes: Vec<u8>) -> String {
    Vocabulary::from_bytes(bytes).expect_err("to be refused").to_string()
}

#[test]
fn round_trip() {
    let vocabulary = small_vocabulary();
    let again = Vocabulary::from_bytes(vocabulary.as_bytes().to_vec()).unwrap();
    assert_eq!(again, vocabulary);
    assert_eq!(again.as_bytes(), vocabulary.as_bytes());
    assert_eq!((again.n_nodes(), again.n_words()), (vocabulary.n_nodes(), vocabulary.n_words()));
    assert_eq!(again.origin(), vocabulary.origin());
    let image = &images(1, 100, 40, 9)[0];
    assert_eq!(again.transform(image, None), vocabulary.transform(image, None));
}

#[test]
fn bytes_anywhere_in_memory_are_read() {
    let vocabulary = small_vocabulary();
    for shift in 0..8 {
        let padded = [&vec![0; shift], vocabulary.as_bytes()].concat();
        let bytes: &'static [u8] = &padded.leak()[shift..];
        assert_eq!(Vocabulary::from_static(bytes).unwrap(), vocabulary);
    }
}

#[test]
fn every_flipped_bit_is_refused() {
    let vocabulary = train(&images(2, 20, 8, 1), &options(3, 2)).unwrap();
    let bytes = vocabulary.as_bytes();
    for at in 0..bytes.len() {
        for bit in 0..8 {
            let mut damaged = bytes.to_vec();
            damaged[at] ^= 1 << bit;
            assert!(Vocabulary::from_bytes(damaged).is_err(), "bit {bit} of byte {at}");
        }
    }
}

#[test]
fn a_thousand_random_changes_are_refused() {
    let vocabulary = small_vocabulary();
    let mut random = random(5);
    for _ in 0..1000 {
        let mut damaged = vocabulary.as_bytes().to_vec();
        let at = random.random_range(0..damaged.len());
        damaged[at] = damaged[at].wrapping_add(random.random_range(1..=255));
        assert!(Vocabulary::from_bytes(damaged).is_err());
    }
}

#[test]
fn every_truncation_is_refused() {
    let bytes = small_vocabulary().as_bytes().to_vec();
    for length in 0..bytes.len() {
        let error = Vocabulary::from_bytes(bytes[..length].to_vec()).unwrap_err();
        let found = length as u64;
        match length {
            0..8 => assert!(matches!(error, FormatError::Unknown { .. })),
            8..64 => assert_eq!(error, FormatError::Truncated { found, expected: 64 }),
            _ => assert_eq!(error, FormatError::Truncated { found, expected: bytes.len() as u64 }),
        }
    }
}

#[test]
fn messages_say_what_is_wrong() {
    let vocabulary = small_vocabulary();
    let bytes = vocabulary.as_bytes();
    let length = bytes.len();
    assert_eq!(
        refusal(b"PNG".to_vec()),
        "not a vocabulary: found \"PNG\", expected a DSSLAM vocabulary or ORB-SLAM2's text format"
    );
    assert_eq!(
        refusal(Vec::new()),
        "not a vocabulary: found nothing, expected a DSSLAM vocabulary or ORB-SLAM2's text format"
    );
    assert_eq!(
        refusal(with_u32(&vocabulary, 8, 2)),
        "format version 2 is newer than this program reads (up to 1)"
    );
    assert_eq!(refusal(with_u32(&vocabulary, 8, 0)), "format version 0 does not exist, expected 1 to 1");
    assert_eq!(
        refusal(bytes[..length - 1].to_vec()),
        format!("truncated: found {} bytes, expected {length}", length - 1)
    );
    let longer = [bytes, &[0]].concat();
    assert_eq!(refusal(longer), format!("too long: found {} bytes, expected {length}", length + 1));
    let mut damaged = bytes.to_vec();
    damaged[MEDIANS + 40] ^= 1;
    assert!(refusal(damaged).starts_with("corrupted: checksum "));
}

#[test]
fn lengths_are_not_trusted() {
    let vocabulary = small_vocabulary();
    for n_nodes in [0, 1, 2, vocabulary.n_nodes() - 1, vocabulary.n_nodes() + 1, u32::MAX] {
        let message = refusal(with_u32(&vocabulary, NODES, n_nodes));
        assert_eq!(message, format!("invalid: {n_nodes} nodes do not fill its length"));
    }
    for at in [LENGTH, LENGTH + 4] {
        let message = refusal(with_u32(&vocabulary, at, u32::MAX));
        assert!(message.starts_with("truncated: "), "{message}");
    }
}

#[test]
fn a_right_checksum_does_not_make_a_tree() {
    let vocabulary = small_vocabulary();
    let n_nodes = vocabulary.n_nodes() as usize;
    let children = MEDIANS + 32 * n_nodes;
    let weights = children + 4 * (n_nodes + 1);
    let invalid = |at, value| {
        let message = refusal(with_u32(&vocabulary, at, value));
        message.strip_prefix("invalid: ").expect("an invalid tree").to_string()
    };
    assert_eq!(invalid(BRANCHING, 1), "branching 1, levels 3");
    assert_eq!(invalid(BRANCHING, 3), "a node has more than 3 children");
    assert_eq!(invalid(LEVELS, 0), "branching 4, levels 0");
    assert_eq!(invalid(LEVELS, 2), "its nodes do not form a tree of 2 levels");
    assert!(invalid(WORDS, 1).starts_with("1 words announced, "));
    let n_nodes = n_nodes as u32;
    assert_eq!(invalid(children, 0), "the root has no children or some nodes no parent");
    assert_eq!(
        invalid(children + 4 * n_nodes as usize, n_nodes - 1),
        "the root has no children or some nodes no parent"
    );
    assert_eq!(invalid(children + 4, 0), "a node has more than 4 children");
    for bad in [f32::NAN, f32::INFINITY, -1.0, -0.0] {
        assert_eq!(invalid(weights + 8, bad.to_bits()), "a weight is negative or not finite");
    }
}

#[test]
fn a_node_that_is_its_own_parent_is_refused() {
    let median = " 0".repeat(32);
    let node = |parent: u32, leaf: u32| format!("{parent} {leaf}{median} 1\n");
    let lines =
        [(0, 1), (0, 1), (0, 1), (0, 0), (4, 1), (4, 1), (4, 1)].map(|(parent, leaf)| node(parent, leaf));
    let vocabulary = Vocabulary::from_text(&format!("4 3 0 0\n{}", lines.concat())).unwrap();
    assert_eq!(vocabulary.children(4), Some(5..8));
    // The three children of node 4 become those of node 5, one of the three.
    let children_of_5 = MEDIANS + 32 * 8 + 4 * 5;
    let message = refusal(with_u32(&vocabulary, children_of_5, 5));
    assert_eq!(message, "invalid: its nodes do not form a tree of 3 levels");
}

#[test]
fn random_tables_with_a_right_checksum_never_panic() {
    let vocabulary = small_vocabulary();
    let image = &images(1, 50, 40, 2)[0];
    let mut random = random(8);
    let mut n_read = 0;
    for _ in 0..5000 {
        let mut bytes = vocabulary.as_bytes().to_vec();
        for _ in 0..random.random_range(1..4) {
            let at = random.random_range(24..bytes.len());
            bytes[at] = random.random();
        }
        if let Ok(vocabulary) = Vocabulary::from_bytes(resealed(bytes)) {
            n_read += 1;
            assert_eq!(vocabulary.words_of(image).len(), image.len());
        }
    }
    assert!(n_read > 1000, "most changes hit medians, which are free");
}

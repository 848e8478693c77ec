//! A place must look alike from several keyframes in a row.

use super::*;
use crate::scene::{chain, line};

/// Rows that the candidates of successive keyframes come to, and whether the last is accepted after three.
fn advance(steps: &[&[u32]]) -> (Vec<usize>, Vec<u32>) {
    let map = chain(&line(12, 1.0), 4);
    let mut consistency = Consistency::default();
    let mut rows = Vec::new();
    let mut last = Vec::new();
    for step in steps {
        let candidates: Vec<KeyframeId> = step.iter().map(|&id| KeyframeId(id)).collect();
        let (accepted, row) = consistency.advance(&map, &candidates, 3);
        rows.push(row);
        last = accepted.iter().map(|id| id.0).collect();
    }
    (rows, last)
}

#[test]
fn the_fourth_time_in_a_row_is_accepted() {
    assert_eq!(advance(&[&[5], &[5], &[5]]), (vec![0, 1, 2], vec![]));
    assert_eq!(advance(&[&[5], &[5], &[5], &[5]]), (vec![0, 1, 2, 3], vec![5]));
}

#[test]
fn a_neighbor_continues_the_row() {
    // The groups of 5 and 7 share keyframe 6; those of 5 and 8 share none.
    assert_eq!(advance(&[&[5], &[7], &[7]]).0, vec![0, 1, 2]);
    assert_eq!(advance(&[&[5], &[8], &[8]]).0, vec![0, 0, 1]);
}

#[test]
fn a_gap_ends_the_row() {
    assert_eq!(advance(&[&[5], &[5], &[], &[5]]).0, vec![0, 1, 0, 0]);
}

#[test]
fn each_candidate_has_its_own_row() {
    assert_eq!(advance(&[&[2], &[2], &[2, 9], &[9, 2]]), (vec![0, 1, 2, 3], vec![2]));
}

#[test]
fn clearing_forgets() {
    let map = chain(&line(12, 1.0), 4);
    let mut consistency = Consistency::default();
    consistency.advance(&map, &[KeyframeId(5)], 1);
    consistency.clear();
    assert_eq!(consistency.advance(&map, &[KeyframeId(5)], 1), (vec![], 0));
}

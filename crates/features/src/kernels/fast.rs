//! FAST-9/16 corner scores (Rosten and Drummond, ECCV 2006) of whole rows.
//!
//! The score of a pixel is the largest threshold for which it is a corner: with the saturated differences of the 16 ring
//! pixels to the center, the largest over the 16 arcs of the least difference in the arc, minus one.

#[cfg(target_arch = "x86_64")]
use crate::kernels::avx2;
use simd::Simd;

/// Radius of the ring in pixels.
pub(crate) const RADIUS: usize = 3;
/// The ring, clockwise from the top: `(dx + 3, dy + 3)`.
pub(crate) const RING: [(usize, usize); 16] = [
    (3, 0),
    (4, 0),
    (5, 1),
    (6, 2),
    (6, 3),
    (6, 4),
    (5, 5),
    (4, 6),
    (3, 6),
    (2, 6),
    (1, 5),
    (0, 4),
    (0, 3),
    (0, 2),
    (1, 1),
    (2, 0),
];

/// Writes the scores of the pixels `first..end` of the middle of seven successive rows to `scores[first..end]`: 0 below
/// `threshold` (at least 1). Places up to 32 behind `end` are overwritten with 0.
pub(crate) fn score_row(
    simd: Simd,
    rows: &[&[u8]; 7],
    first: usize,
    end: usize,
    threshold: u8,
    scores: &mut [u8],
) {
    #[cfg(target_arch = "x86_64")]
    if let Some(token) = simd.avx2() {
        return avx2::fast::score_row(token, rows, first, end, threshold, scores);
    }
    let _ = simd;
    scores[end..end + 32].fill(0);
    for (x, score) in (first..end).zip(&mut scores[first..end]) {
        let value = score_at(rows, x);
        *score = if value >= threshold { value } else { 0 };
    }
}

/// The score of one pixel of the middle row; 0 where it is not a corner at any threshold.
pub(crate) fn score_at(rows: &[&[u8]; 7], x: usize) -> u8 {
    let center = rows[RADIUS][x];
    let ring = RING.map(|(dx, dy)| rows[dy][x + dx - RADIUS]);
    let bright = best_arc(&ring.map(|p| p.saturating_sub(center)));
    let dark = best_arc(&ring.map(|p| center.saturating_sub(p)));
    bright.max(dark).saturating_sub(1)
}

/// The largest over all arcs of nine of the least value in the arc.
fn best_arc(differences: &[u8; 16]) -> u8 {
    let mut best = 0;
    for start in 0..16 {
        let least = (0..9).map(|i| differences[(start + i) % 16]).min().unwrap_or(0);
        best = best.max(least);
    }
    best
}

/// Replaces `places` by those of the pixels `first..end` of the middle row, from left to right, whose score is above zero and
/// above that of all eight neighbors.
pub(crate) fn local_maxima(
    simd: Simd,
    [above, middle, below]: [&[u8]; 3],
    first: usize,
    end: usize,
    places: &mut Vec<u16>,
) {
    #[cfg(target_arch = "x86_64")]
    if let Some(token) = simd.avx2() {
        return avx2::fast::local_maxima(token, [above, middle, below], first, end, places);
    }
    places.clear();
    let _ = simd;
    for x in first..end {
        let score = middle[x];
        if score == 0 {
            continue;
        }
        let around = [
            above[x - 1],
            above[x],
            above[x + 1],
            middle[x - 1],
            middle[x + 1],
            below[x - 1],
            below[x],
            below[x + 1],
        ];
        if around.iter().all(|&other| score > other) {
            places.push(x as u16);
        }
    }
}

/// The scores around `(x, middle row)` of nine successive rows, whatever their threshold.
pub(crate) fn score_square(simd: Simd, rows: &[&[u8]; 9], x: usize) -> [[u8; 3]; 3] {
    #[cfg(target_arch = "x86_64")]
    if let Some(token) = simd.avx2() {
        return avx2::fast::score_square(token, rows, x);
    }
    let _ = simd;
    std::array::from_fn(|j| {
        let rows = std::array::from_fn(|i| rows[j + i]);
        [x - 1, x, x + 1].map(|x| score_at(&rows, x))
    })
}

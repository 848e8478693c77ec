//! FAST scores of 32 pixels at a time.

use super::{load, store};
use crate::kernels::Avx2;
use crate::kernels::fast::{RADIUS, RING};
use std::arch::x86_64::*;

/// See `kernels::fast::score_row`.
pub(crate) fn score_row(
    _: Avx2,
    rows: &[&[u8]; 7],
    first: usize,
    end: usize,
    threshold: u8,
    scores: &mut [u8],
) {
    assert!(first >= RADIUS && scores.len() >= end + 32 && rows.iter().all(|r| r.len() >= end + 32 + RADIUS));
    let rows = rows.map(<[u8]>::as_ptr);
    // SAFETY: blocks start before `end`, so that all places from `first - 3` to `end + 31 + 3` cover what is read.
    unsafe { score_blocks(rows, first, end, threshold, scores.as_mut_ptr()) };
    scores[end..end + 32].fill(0);
}

#[target_feature(enable = "avx2")]
unsafe fn score_blocks(rows: [*const u8; 7], first: usize, end: usize, threshold: u8, out: *mut u8) {
    let limit = _mm256_set1_epi8(threshold as i8);
    for x in (first..end).step_by(32) {
        // SAFETY: see `score_row`.
        let scores = unsafe {
            let centre = load(rows[RADIUS].add(x));
            match find_candidates(&rows, x, centre, limit) {
                (false, false) => _mm256_setzero_si256(),
                (bright, dark) => score_block(&rows, x, centre, limit, bright, dark),
            }
        };
        // SAFETY: see `score_row`.
        unsafe { store(out.add(x), scores) };
    }
}

/// Whether any of 32 pixels can be a bright or a dark corner: an arc of nine holds two neighbours of the four ring pixels at
/// right angles, and likewise of the four diagonal ones.
///
/// # Safety
/// The ring of all 32 pixels must be readable.
#[inline]
#[target_feature(enable = "avx2")]
unsafe fn find_candidates(rows: &[*const u8; 7], x: usize, centre: __m256i, limit: __m256i) -> (bool, bool) {
    let (high, low) = (_mm256_adds_epu8(centre, limit), _mm256_subs_epu8(centre, limit));
    let mut bright = _mm256_set1_epi8(-1);
    let mut dark = bright;
    for start in [0, 2] {
        // SAFETY: the caller's.
        let [a, b, c, d] = [0, 8, 4, 12].map(|i| unsafe { load(ring_place(rows, x, start + i)) });
        let above = |p: __m256i| _mm256_subs_epu8(p, high);
        let below = |p: __m256i| _mm256_subs_epu8(low, p);
        bright = _mm256_min_epu8(bright, _mm256_max_epu8(above(a), above(b)));
        bright = _mm256_min_epu8(bright, _mm256_max_epu8(above(c), above(d)));
        dark = _mm256_min_epu8(dark, _mm256_max_epu8(below(a), below(b)));
        dark = _mm256_min_epu8(dark, _mm256_max_epu8(below(c), below(d)));
        let any = _mm256_or_si256(bright, dark);
        if _mm256_testz_si256(any, any) == 1 {
            return (false, false);
        }
    }
    (_mm256_testz_si256(bright, bright) == 0, _mm256_testz_si256(dark, dark) == 0)
}

/// Scores of 32 pixels for the polarities asked for, 0 below the limit.
///
/// # Safety
/// The ring of all 32 pixels must be readable.
#[inline]
#[target_feature(enable = "avx2")]
unsafe fn score_block(
    rows: &[*const u8; 7],
    x: usize,
    centre: __m256i,
    limit: __m256i,
    bright: bool,
    dark: bool,
) -> __m256i {
    let mut best = _mm256_setzero_si256();
    if bright {
        // SAFETY: the caller's.
        let difference = |i: usize| unsafe { _mm256_subs_epu8(load(ring_place(rows, x, i)), centre) };
        best = best_arc(difference);
    }
    if dark {
        // SAFETY: the caller's.
        let difference = |i: usize| unsafe { _mm256_subs_epu8(centre, load(ring_place(rows, x, i))) };
        best = _mm256_max_epu8(best, best_arc(difference));
    }
    let too_low = _mm256_cmpeq_epi8(_mm256_subs_epu8(best, limit), _mm256_setzero_si256());
    _mm256_andnot_si256(too_low, _mm256_subs_epu8(best, _mm256_set1_epi8(1)))
}

/// The largest over all arcs of nine of the least difference in the arc. Two arcs share eight ring pixels, so that only
/// every second run of eight is needed: the better arc has the better of the two pixels at its ends.
#[inline]
#[target_feature(enable = "avx2")]
fn best_arc(difference: impl Fn(usize) -> __m256i) -> __m256i {
    let differences: [__m256i; 16] = std::array::from_fn(difference);
    let pairs: [__m256i; 8] =
        std::array::from_fn(|i| _mm256_min_epu8(differences[2 * i], differences[2 * i + 1]));
    let fours: [__m256i; 8] = std::array::from_fn(|i| _mm256_min_epu8(pairs[i], pairs[(i + 1) % 8]));
    let mut best = _mm256_setzero_si256();
    for i in 0..8 {
        let eight = _mm256_min_epu8(fours[i], fours[(i + 2) % 8]);
        let ends = _mm256_max_epu8(differences[(2 * i + 8) % 16], differences[(2 * i + 15) % 16]);
        best = _mm256_max_epu8(best, _mm256_min_epu8(eight, ends));
    }
    best
}

#[inline(always)]
fn ring_place(rows: &[*const u8; 7], x: usize, i: usize) -> *const u8 {
    let (dx, dy) = RING[i];
    rows[dy].wrapping_add(x + dx - RADIUS)
}

/// See `kernels::fast::local_maxima`.
pub(crate) fn local_maxima(
    _: Avx2,
    rows: [&[u8]; 3],
    first: usize,
    end: usize,
    found: impl FnMut(usize, u8),
) {
    assert!(first >= 1 && rows.iter().all(|r| r.len() >= end + 32));
    // SAFETY: blocks start before `end`, so that the places from `first - 1` to `end + 31` cover what is read.
    unsafe { find_maxima(rows, first, end, found) };
}

#[target_feature(enable = "avx2")]
unsafe fn find_maxima(rows: [&[u8]; 3], first: usize, end: usize, mut found: impl FnMut(usize, u8)) {
    let [above, middle, below] = rows.map(<[u8]>::as_ptr);
    for x in (first..end).step_by(32) {
        // SAFETY: see `local_maxima`.
        let mut maxima = unsafe {
            let scores = load(middle.add(x));
            if _mm256_testz_si256(scores, scores) == 1 {
                continue;
            }
            let three = |row: *const u8| {
                let ends = _mm256_max_epu8(load(row.add(x - 1)), load(row.add(x + 1)));
                (ends, _mm256_max_epu8(ends, load(row.add(x))))
            };
            let around = _mm256_max_epu8(_mm256_max_epu8(three(above).1, three(below).1), three(middle).0);
            let excess = _mm256_subs_epu8(scores, around);
            !_mm256_movemask_epi8(_mm256_cmpeq_epi8(excess, _mm256_setzero_si256())) as u32
        };
        if end - x < 32 {
            maxima &= (1 << (end - x)) - 1;
        }
        while maxima != 0 {
            let place = x + maxima.trailing_zeros() as usize;
            found(place, rows[1][place]);
            maxima &= maxima - 1;
        }
    }
}

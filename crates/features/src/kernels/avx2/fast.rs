//! FAST scores of 32 pixels at a time.

use super::{load, store};
use crate::kernels::fast::{RADIUS, RING};
use simd::Avx2;
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

/// First marks the blocks that can have corners, without branches, then scores those: about half of them, in no order that
/// the processor could foresee.
#[target_feature(enable = "avx2")]
unsafe fn score_blocks(rows: [*const u8; 7], first: usize, end: usize, threshold: u8, out: *mut u8) {
    let limit = _mm256_set1_epi8(threshold as i8);
    for start in (first..end).step_by(32 * 64) {
        let (mut bright, mut dark) = (0u64, 0u64);
        for (i, x) in (start..end.min(start + 32 * 64)).step_by(32).enumerate() {
            // SAFETY: see `score_row`.
            let (is_bright, is_dark) = unsafe {
                store(out.add(x), _mm256_setzero_si256());
                find_candidates(&rows, x, limit)
            };
            bright |= u64::from(is_bright) << i;
            dark |= u64::from(is_dark) << i;
        }
        let mut marked = bright | dark;
        while marked != 0 {
            let i = marked.trailing_zeros();
            let x = start + 32 * i as usize;
            // SAFETY: see `score_row`.
            unsafe {
                let scores = score_block(&rows, x, limit, bright >> i & 1 == 1, dark >> i & 1 == 1);
                store(out.add(x), scores);
            }
            marked &= marked - 1;
        }
    }
}

/// Whether any of 32 pixels can be a bright or a dark corner: an arc of nine holds two neighbors of the four ring pixels at
/// right angles, and likewise of the four diagonal ones.
///
/// # Safety
/// The ring of all 32 pixels must be readable.
#[inline]
#[target_feature(enable = "avx2")]
unsafe fn find_candidates(rows: &[*const u8; 7], x: usize, limit: __m256i) -> (bool, bool) {
    // SAFETY: the caller's.
    let center = unsafe { load(rows[RADIUS].add(x)) };
    let (high, low) = (_mm256_adds_epu8(center, limit), _mm256_subs_epu8(center, limit));
    let mut bright = _mm256_set1_epi8(-1);
    let mut dark = bright;
    for start in [0, 2] {
        // SAFETY: the caller's.
        let ring = |i: usize| unsafe { load(ring_place(rows, x, start + i)) };
        let (a, b, c, d) = (ring(0), ring(8), ring(4), ring(12));
        // At least one of a pair is above: the larger one is.
        let above = |p: __m256i, q: __m256i| _mm256_subs_epu8(_mm256_max_epu8(p, q), high);
        let below = |p: __m256i, q: __m256i| _mm256_subs_epu8(low, _mm256_min_epu8(p, q));
        bright = _mm256_min_epu8(bright, _mm256_min_epu8(above(a, b), above(c, d)));
        dark = _mm256_min_epu8(dark, _mm256_min_epu8(below(a, b), below(c, d)));
    }
    (_mm256_testz_si256(bright, bright) == 0, _mm256_testz_si256(dark, dark) == 0)
}

/// Scores of 32 pixels for the polarities asked for, 0 below the limit.
///
/// # Safety
/// The ring of all 32 pixels must be readable.
#[inline]
#[target_feature(enable = "avx2")]
unsafe fn score_block(rows: &[*const u8; 7], x: usize, limit: __m256i, bright: bool, dark: bool) -> __m256i {
    // SAFETY: the caller's.
    let center = unsafe { load(rows[RADIUS].add(x)) };
    let mut ring = [center; 16];
    // Plain loops: a closure handed to a library function would lose the vector instructions.
    for (i, value) in ring.iter_mut().enumerate() {
        // SAFETY: the caller's.
        *value = unsafe { load(ring_place(rows, x, i)) };
    }
    let mut best = _mm256_setzero_si256();
    if bright {
        best = _mm256_subs_epu8(brightest_arc(&ring), center);
    }
    if dark {
        best = _mm256_max_epu8(best, _mm256_subs_epu8(center, darkest_arc(&ring)));
    }
    let too_low = _mm256_cmpeq_epi8(_mm256_subs_epu8(best, limit), _mm256_setzero_si256());
    _mm256_andnot_si256(too_low, _mm256_subs_epu8(best, _mm256_set1_epi8(1)))
}

/// Defines the best over all arcs of nine of the worst value in the arc. Two arcs share eight ring pixels, so that only every
/// second run of eight is needed: the better arc has the better of the two pixels at its ends.
macro_rules! best_arc {
    ($name:ident, $worse:ident, $better:ident) => {
        #[inline]
        #[target_feature(enable = "avx2")]
        fn $name(ring: &[__m256i; 16]) -> __m256i {
            let mut pairs = [ring[0]; 8];
            for i in 0..8 {
                pairs[i] = $worse(ring[2 * i], ring[2 * i + 1]);
            }
            let mut fours = pairs;
            for i in 0..8 {
                fours[i] = $worse(pairs[i], pairs[(i + 1) % 8]);
            }
            let arcs = |i: usize| {
                let eight = $worse(fours[i], fours[(i + 2) % 8]);
                $worse(eight, $better(ring[(2 * i + 8) % 16], ring[(2 * i + 15) % 16]))
            };
            let mut best = arcs(0);
            for i in 1..8 {
                best = $better(best, arcs(i));
            }
            best
        }
    };
}
best_arc!(brightest_arc, _mm256_min_epu8, _mm256_max_epu8);
best_arc!(darkest_arc, _mm256_max_epu8, _mm256_min_epu8);

#[inline(always)]
fn ring_place(rows: &[*const u8; 7], x: usize, i: usize) -> *const u8 {
    let (dx, dy) = RING[i];
    rows[dy].wrapping_add(x + dx - RADIUS)
}

/// See `kernels::fast::local_maxima`.
pub(crate) fn local_maxima(_: Avx2, rows: [&[u8]; 3], first: usize, end: usize, places: &mut Vec<u16>) {
    assert!(first >= 1 && rows.iter().all(|r| r.len() >= end + 32));
    // SAFETY: blocks start before `end`, so that the places from `first - 1` to `end + 31` cover what is read.
    unsafe { find_maxima(rows, first, end, places) };
}

#[target_feature(enable = "avx2")]
unsafe fn find_maxima(rows: [&[u8]; 3], first: usize, end: usize, places: &mut Vec<u16>) {
    let [above, middle, below] = [rows[0].as_ptr(), rows[1].as_ptr(), rows[2].as_ptr()];
    // Of two neighbors at most one is a maximum; two more are written in vain.
    places.resize(end.saturating_sub(first) + 4, 0);
    let mut n = 0;
    for x in (first..end).step_by(32) {
        // SAFETY: see `local_maxima`.
        let mut maxima = unsafe {
            let scores = load(middle.add(x));
            let three = |row: *const u8| {
                let ends = _mm256_max_epu8(load(row.add(x - 1)), load(row.add(x + 1)));
                (ends, _mm256_max_epu8(ends, load(row.add(x))))
            };
            let around = _mm256_max_epu8(_mm256_max_epu8(three(above).1, three(below).1), three(middle).0);
            // Where the larger one is the neighbor, or both are zero, there is no maximum.
            let larger = _mm256_max_epu8(scores, around);
            !_mm256_movemask_epi8(_mm256_cmpeq_epi8(larger, around)) as u32
        };
        if end - x < 32 {
            maxima &= (1 << (end - x)) - 1;
        }
        // Few blocks have more than two.
        for _ in 0..2 {
            places[n] = (x as u32 + maxima.trailing_zeros()) as u16;
            n += usize::from(maxima != 0);
            maxima &= maxima.wrapping_sub(1);
        }
        while maxima != 0 {
            places[n] = (x as u32 + maxima.trailing_zeros()) as u16;
            n += 1;
            maxima &= maxima - 1;
        }
    }
    places.truncate(n);
}

/// See `kernels::fast::score_square`.
pub(crate) fn score_square(_: Avx2, rows: &[&[u8]; 9], x: usize) -> [[u8; 3]; 3] {
    assert!(x > RADIUS && rows.iter().all(|r| r.len() >= x + RADIUS + 3));
    // SAFETY: four bytes from `x - 1 + dx`, `dx` at most 3, are inside of each row.
    let scores = unsafe { score_nine(rows, x - 1) };
    [0, 1, 2].map(|j| [scores[4 * j], scores[4 * j + 1], scores[4 * j + 2]])
}

/// The scores of three times four pixels from `x` on, in the first twelve bytes.
///
/// The lower half of the vectors finds the bright arcs, the upper half the dark ones on the negative.
#[target_feature(enable = "avx2")]
unsafe fn score_nine(rows: &[&[u8]; 9], x: usize) -> [u8; 16] {
    let negative = _mm256_set_m128i(_mm_set1_epi8(-1), _mm_setzero_si128());
    let at = |dx: usize, dy: usize| {
        // SAFETY: see `score_square`.
        let four =
            |j: usize| unsafe { rows[dy + j].as_ptr().add(x + dx - RADIUS).cast::<i32>().read_unaligned() };
        let twelve = _mm_insert_epi32(_mm_insert_epi32(_mm_cvtsi32_si128(four(0)), four(1), 1), four(2), 2);
        _mm256_xor_si256(_mm256_broadcastsi128_si256(twelve), negative)
    };
    let center = at(RADIUS, RADIUS);
    let mut ring = [center; 16];
    for (value, (dx, dy)) in ring.iter_mut().zip(RING) {
        *value = at(dx, dy);
    }
    let both = _mm256_subs_epu8(brightest_arc(&ring), center);
    let best = _mm_max_epu8(_mm256_castsi256_si128(both), _mm256_extracti128_si256(both, 1));
    let mut scores = [0; 16];
    // SAFETY: the array has the size of the vector.
    unsafe { _mm_storeu_si128(scores.as_mut_ptr().cast(), _mm_subs_epu8(best, _mm_set1_epi8(1))) };
    scores
}

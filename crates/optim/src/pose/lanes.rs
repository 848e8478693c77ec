//! Four f64 side by side: plain arrays that the compiler keeps in one AVX2 (or two SSE2) registers.

use std::ops::{Add, AddAssign, Mul, Sub};

/// Four lanes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct F4(pub(super) [f64; 4]);

/// One truth value per lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mask([bool; 4]);

impl F4 {
    #[inline(always)]
    pub(super) fn splat(x: f64) -> Self {
        Self([x; 4])
    }

    #[inline(always)]
    pub(super) fn map2(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|l| f(self.0[l], other.0[l])))
    }

    #[inline(always)]
    pub(super) fn sqrt(self) -> Self {
        Self(self.0.map(f64::sqrt))
    }

    #[inline(always)]
    pub(super) fn recip(self) -> Self {
        Self(self.0.map(|x| 1.0 / x))
    }

    #[inline(always)]
    pub(super) fn above(self, other: Self) -> Mask {
        Mask(std::array::from_fn(|l| self.0[l] > other.0[l]))
    }

    /// Lane sum in a fixed order.
    #[inline(always)]
    pub(super) fn sum(self) -> f64 {
        (self.0[0] + self.0[2]) + (self.0[1] + self.0[3])
    }
}

impl Mask {
    #[inline(always)]
    pub(super) fn and(self, other: Self) -> Self {
        Self(std::array::from_fn(|l| self.0[l] & other.0[l]))
    }

    #[inline(always)]
    pub(super) fn select(self, yes: F4, no: F4) -> F4 {
        F4(std::array::from_fn(|l| if self.0[l] { yes.0[l] } else { no.0[l] }))
    }
}

impl Add for F4 {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.map2(other, |a, b| a + b)
    }
}

impl Sub for F4 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.map2(other, |a, b| a - b)
    }
}

impl Mul for F4 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.map2(other, |a, b| a * b)
    }
}

impl AddAssign for F4 {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

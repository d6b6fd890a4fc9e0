//! The scalar that kernels compute with: one number, or one number of several members side by side.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// A real number, or a short vector of them on which every operation acts lane by lane.
///
/// Kernels are written once against this trait. They never branch on a value, so that all lanes go the same way.
pub trait Real:
    Copy
    + Debug
    + Default
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    /// How many members lie side by side.
    const LANES: usize;

    /// The same number in every lane.
    fn splat(value: f64) -> Self;
    /// The number in one lane. It is read where it is: a copy of all lanes would cost more than most of what is done with it.
    fn lane(&self, index: usize) -> f64;
    /// Puts a number into one lane, and leaves the others where they are.
    fn set_lane(&mut self, index: usize, value: f64);
    /// Puts the numbers of all lanes in a row of [`Real::LANES`].
    #[inline(always)]
    fn store(&self, row: &mut [f64]) {
        for (lane, number) in row.iter_mut().enumerate() {
            *number = self.lane(lane);
        }
    }
    /// The numbers of all lanes from a row of [`Real::LANES`].
    #[inline(always)]
    fn load(row: &[f64]) -> Self {
        let mut all = Self::default();
        for (lane, &number) in row.iter().enumerate() {
            all.set_lane(lane, number);
        }
        all
    }
    /// Square root.
    fn sqrt(self) -> Self;
    /// Size without sign.
    fn abs(self) -> Self;
    /// self + a b, rounded once where these numbers have an instruction for it.
    #[inline(always)]
    fn plus(self, a: Self, b: Self) -> Self {
        self + a * b
    }
    /// self − a b, rounded once where these numbers have an instruction for it.
    #[inline(always)]
    fn minus(self, a: Self, b: Self) -> Self {
        self - a * b
    }
    /// The larger of the two.
    fn max(self, other: Self) -> Self;
    /// One where the number is negative, else zero.
    fn is_negative(self) -> Self;
    /// Sine and cosine of an angle in radians.
    fn sin_cos(self) -> (Self, Self);

    /// Does work compiled for the instructions of these numbers; all of it should be inlined.
    #[inline(always)]
    fn run<W: Work>(work: W) -> W::Output {
        work.run()
    }

    /// Zero in every lane.
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }

    /// One in every lane.
    #[inline(always)]
    fn one() -> Self {
        Self::splat(1.0)
    }
}

/// A piece of work on numbers of one kind.
pub trait Work {
    /// What comes of it.
    type Output;

    /// Does it, compiled for the lanes that there are.
    fn run(self) -> Self::Output;
}

/// Puts an array in a row, the lanes of each of its entries side by side.
#[inline(always)]
pub fn store<T: Real, const N: usize>(array: &[T; N], row: &mut [f64]) {
    for (entry, numbers) in array.iter().zip(row.chunks_exact_mut(T::LANES)) {
        entry.store(numbers);
    }
}

/// The array that [`store`] put in a row.
#[inline(always)]
pub fn load<T: Real, const N: usize>(row: &[f64]) -> [T; N] {
    let mut array = [T::default(); N];
    for (entry, numbers) in array.iter_mut().zip(row.chunks_exact(T::LANES)) {
        *entry = T::load(numbers);
    }
    array
}

impl Real for f64 {
    const LANES: usize = 1;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn lane(&self, _: usize) -> f64 {
        *self
    }
    #[inline(always)]
    fn set_lane(&mut self, _: usize, value: f64) {
        *self = value;
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        f64::max(self, other)
    }
    #[inline(always)]
    fn is_negative(self) -> Self {
        if self < 0.0 { 1.0 } else { 0.0 }
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        f64::sin_cos(self)
    }
}

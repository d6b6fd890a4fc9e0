//! Four members side by side in one register of the processor.
//!
//! The only `unsafe` of the crate. Products that are added are rounded once, together with the sum, so that a member
//! gets the same digits in a lane and alone up to rounding.

/// Whether the processor can compute with [`Lanes`].
pub fn are_there() -> bool {
    #[cfg(target_arch = "x86_64")]
    return is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
    #[cfg(not(target_arch = "x86_64"))]
    return false;
}

#[cfg(target_arch = "x86_64")]
pub use avx2::Lanes;
#[cfg(not(target_arch = "x86_64"))]
pub use f64 as Lanes;

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::*;
    use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

    use crate::real::{Real, Work};

    /// Four numbers that are computed with at once; only where [`super::are_there`] says so.
    #[derive(Clone, Copy, Debug)]
    pub struct Lanes(__m256d);

    impl Lanes {
        #[inline(always)]
        fn numbers(self) -> [f64; 4] {
            // SAFETY: both are four numbers in a row.
            unsafe { std::mem::transmute(self.0) }
        }

        #[inline(always)]
        fn map(self, f: impl FnMut(f64) -> f64) -> Self {
            Self::from(self.numbers().map(f))
        }
    }

    impl From<[f64; 4]> for Lanes {
        #[inline(always)]
        fn from(numbers: [f64; 4]) -> Self {
            // SAFETY: both are four numbers in a row.
            Self(unsafe { std::mem::transmute::<[f64; 4], __m256d>(numbers) })
        }
    }

    impl Default for Lanes {
        #[inline(always)]
        fn default() -> Self {
            Self::splat(0.0)
        }
    }

    /// Runs work compiled for processors with these registers.
    #[target_feature(enable = "avx2,fma")]
    fn run<W: Work>(work: W) -> W::Output {
        work.run()
    }

    // SAFETY of all that follows: lanes are made only where the processor has them.
    macro_rules! operator {
        ($name:ident, $method:ident, $intrinsic:ident) => {
            impl $name for Lanes {
                type Output = Self;
                #[inline(always)]
                fn $method(self, other: Self) -> Self {
                    Self(unsafe { $intrinsic(self.0, other.0) })
                }
            }
        };
    }

    operator!(Add, add, _mm256_add_pd);
    operator!(Sub, sub, _mm256_sub_pd);
    operator!(Mul, mul, _mm256_mul_pd);
    operator!(Div, div, _mm256_div_pd);

    impl Neg for Lanes {
        type Output = Self;
        #[inline(always)]
        fn neg(self) -> Self {
            Self(unsafe { _mm256_xor_pd(self.0, _mm256_set1_pd(-0.0)) })
        }
    }

    impl AddAssign for Lanes {
        #[inline(always)]
        fn add_assign(&mut self, other: Self) {
            *self = *self + other;
        }
    }

    impl SubAssign for Lanes {
        #[inline(always)]
        fn sub_assign(&mut self, other: Self) {
            *self = *self - other;
        }
    }

    impl Real for Lanes {
        const LANES: usize = 4;

        #[inline(always)]
        fn splat(value: f64) -> Self {
            Self(unsafe { _mm256_set1_pd(value) })
        }
        #[inline(always)]
        fn lane(self, index: usize) -> f64 {
            self.numbers()[index]
        }
        #[inline(always)]
        fn set_lane(&mut self, index: usize, value: f64) {
            let mut numbers = self.numbers();
            numbers[index] = value;
            *self = Self::from(numbers);
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            Self(unsafe { _mm256_sqrt_pd(self.0) })
        }
        #[inline(always)]
        fn abs(self) -> Self {
            Self(unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0) })
        }
        #[inline(always)]
        fn plus(self, a: Self, b: Self) -> Self {
            Self(unsafe { _mm256_fmadd_pd(a.0, b.0, self.0) })
        }
        #[inline(always)]
        fn minus(self, a: Self, b: Self) -> Self {
            Self(unsafe { _mm256_fnmadd_pd(a.0, b.0, self.0) })
        }
        #[inline(always)]
        fn max(self, other: Self) -> Self {
            // The instruction gives the second where one is not a number; the larger of two is the one that is.
            unsafe {
                let larger = _mm256_max_pd(self.0, other.0);
                Self(_mm256_blendv_pd(larger, self.0, _mm256_cmp_pd::<_CMP_UNORD_Q>(other.0, other.0)))
            }
        }
        #[inline(always)]
        fn is_negative(self) -> Self {
            unsafe {
                let below = _mm256_cmp_pd::<_CMP_LT_OQ>(self.0, _mm256_setzero_pd());
                Self(_mm256_and_pd(below, _mm256_set1_pd(1.0)))
            }
        }
        #[inline(always)]
        fn sin_cos(self) -> (Self, Self) {
            (self.map(f64::sin), self.map(f64::cos))
        }
        #[inline(always)]
        fn run<W: Work>(work: W) -> W::Output {
            unsafe { run(work) }
        }
    }
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::*;
    use crate::real::Real;

    /// A lane computes what a number computes, bit for bit, for whatever number; products added are rounded once.
    #[test]
    fn lanes_have_the_digits_of_numbers() {
        if !are_there() {
            return;
        }
        let a = [0.1, -3.7, f64::NAN, -0.0];
        let b = [-7.3, f64::NAN, 2.5, 1e-300];
        let (x, y) = (Lanes::from(a), Lanes::from(b));
        for i in 0..4 {
            let same = |lanes: Lanes, number: f64| {
                let lane = lanes.lane(i);
                assert!(lane.to_bits() == number.to_bits() || lane.is_nan() && number.is_nan(), "{lane} {number}");
            };
            same(x + y, a[i] + b[i]);
            same(x - y, a[i] - b[i]);
            same(x * y, a[i] * b[i]);
            same(x / y, a[i] / b[i]);
            same(x.plus(y, x), b[i].mul_add(a[i], a[i]));
            same(x.minus(y, x), (-b[i]).mul_add(a[i], a[i]));
            same(-x, -a[i]);
            same(Real::abs(x), a[i].abs());
            same(Real::sqrt(y), b[i].sqrt());
            same(Real::max(x, y), a[i].max(b[i]));
            same(Real::is_negative(x), Real::is_negative(a[i]));
            same(Real::sin_cos(x).0, a[i].sin_cos().0);
            same(Real::sin_cos(x).1, a[i].sin_cos().1);
        }
    }
}

//! Four or eight members side by side in one register of the processor.
//!
//! The only `unsafe` of the crate. The numbers themselves cannot be named outside: who computes with them gets their type
//! from a [`Width`], and only a look at the processor makes one of those. So there is no number whose instructions are
//! missing.
//!
//! Products that are added are rounded once, together with the sum, which numbers alone are not: a member has the same
//! digits in a lane and alone up to rounding.

#![allow(unsafe_code, reason = "instructions that not every processor has are unsafe to call")]

use crate::real::Real;

/// So many numbers side by side, which this processor has instructions for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Width(Kind);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    One,
    #[cfg(target_arch = "x86_64")]
    Four,
    #[cfg(target_arch = "x86_64")]
    Eight,
}

/// A piece of work that is written for numbers of every kind.
pub trait Generic {
    /// What comes of it.
    type Output;

    /// Does it with numbers of one kind.
    fn with<T: Real>(self) -> Self::Output;
}

impl Width {
    /// One number at a time, which every processor has.
    pub const ONE: Self = Self(Kind::One);

    /// As many as the processor has registers for.
    pub fn widest() -> Self {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            let eight = is_x86_feature_detected!("avx512f");
            return Self(if eight { Kind::Eight } else { Kind::Four });
        }
        Self::ONE
    }

    /// The narrowest that holds so many members, and this one where none does.
    pub fn for_members(self, members: usize) -> Self {
        match self.0 {
            _ if members <= 1 => Self::ONE,
            #[cfg(target_arch = "x86_64")]
            Kind::Eight if members <= 4 => Self(Kind::Four),
            _ => self,
        }
    }

    /// How many members lie side by side.
    pub fn lanes(self) -> usize {
        match self.0 {
            Kind::One => <f64 as Real>::LANES,
            #[cfg(target_arch = "x86_64")]
            Kind::Four => avx2::Lanes::LANES,
            #[cfg(target_arch = "x86_64")]
            Kind::Eight => avx512::WideLanes::LANES,
        }
    }

    /// Does work with numbers of this width.
    pub fn run<W: Generic>(self, work: W) -> W::Output {
        match self.0 {
            Kind::One => work.with::<f64>(),
            #[cfg(target_arch = "x86_64")]
            Kind::Four => work.with::<avx2::Lanes>(),
            #[cfg(target_arch = "x86_64")]
            Kind::Eight => work.with::<avx512::WideLanes>(),
        }
    }
}

/// π/2 as the sum of three numbers.
#[cfg(target_arch = "x86_64")]
const QUARTER: [f64; 3] = [std::f64::consts::FRAC_PI_2, 6.123_233_995_736_766e-17, -1.497_384_904_859_169_8e-33];

/// Coefficients of (sin r − r)/r³ and of (cos r − 1 + r²/2)/r⁴ in r², for |r| ≤ π/4: `k_sin.c` and `k_cos.c` of fdlibm.
#[cfg(target_arch = "x86_64")]
const SINE: [f64; 6] = [
    -1.666_666_666_666_663_2e-1,
    8.333_333_333_322_49e-3,
    -1.984_126_982_985_795e-4,
    2.755_731_370_707_006_8e-6,
    -2.505_076_025_340_686_3e-8,
    1.589_690_995_211_55e-10,
];
#[cfg(target_arch = "x86_64")]
const COSINE: [f64; 6] = [
    4.166_666_666_666_66e-2,
    -1.388_888_888_887_411e-3,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];

#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn polynomial<T: Real>(coefficients: &[f64; 6], z: T) -> T {
    let mut sum = T::splat(coefficients[5]);
    for &coefficient in coefficients[..5].iter().rev() {
        sum = T::splat(coefficient).plus(sum, z);
    }
    sum
}

/// Sine and cosine of what an angle has above or below the nearest quarter turn, and a number whose last two bits count
/// the quarters. With these, sines and cosines are within two units of their last digit for angles below 2⁵⁰.
///
/// The angle less the nearest quarter turns is exact in its first part: both are multiples of one power of two.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn near_quarter<T: Real>(angle: T) -> (T, T, T) {
    // Adding 1.5 · 2⁵² rounds to a whole number, which is in the last bits of the sum then.
    let round = T::splat(6_755_399_441_055_744.0);
    let shifted = round.plus(angle, T::splat(std::f64::consts::FRAC_2_PI));
    let turns = shifted - round;
    let mut r = angle;
    for part in QUARTER {
        r = r.minus(turns, T::splat(part));
    }
    let z = r * r;
    let sine = r.plus(r * z, polynomial(&SINE, z));
    let half = T::splat(0.5) * z;
    let whole = T::one() - half;
    let cosine = whole + ((T::one() - whole) - half).plus(z * z, polynomial(&COSINE, z));
    (shifted, sine, cosine)
}

/// Numbers in one register, what they are made of, and their arithmetic.
#[cfg(target_arch = "x86_64")]
macro_rules! lanes {
    ($(#[$doc:meta])* $lanes:ident: $count:literal in $register:ty, $add:ident, $sub:ident, $mul:ident, $div:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        pub(super) struct $lanes($register);

        impl $lanes {
            #[inline(always)]
            fn numbers(&self) -> &[f64; $count] {
                // SAFETY: both are so many numbers in a row.
                unsafe { &*(&raw const self.0).cast() }
            }

            #[inline(always)]
            fn numbers_mut(&mut self) -> &mut [f64; $count] {
                // SAFETY: both are so many numbers in a row.
                unsafe { &mut *(&raw mut self.0).cast() }
            }
        }

        impl From<[f64; $count]> for $lanes {
            #[inline(always)]
            fn from(numbers: [f64; $count]) -> Self {
                // SAFETY: both are so many numbers in a row.
                Self(unsafe { std::mem::transmute::<[f64; $count], $register>(numbers) })
            }
        }

        impl Default for $lanes {
            #[inline(always)]
            fn default() -> Self {
                Self::splat(0.0)
            }
        }

        lanes!(@operator $lanes, Add, add, $add);
        lanes!(@operator $lanes, Sub, sub, $sub);
        lanes!(@operator $lanes, Mul, mul, $mul);
        lanes!(@operator $lanes, Div, div, $div);

        impl std::ops::AddAssign for $lanes {
            #[inline(always)]
            fn add_assign(&mut self, other: Self) {
                *self = *self + other;
            }
        }

        impl std::ops::SubAssign for $lanes {
            #[inline(always)]
            fn sub_assign(&mut self, other: Self) {
                *self = *self - other;
            }
        }
    };
    (@operator $lanes:ident, $name:ident, $method:ident, $intrinsic:ident) => {
        impl std::ops::$name for $lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: a `Width` gives the type away only where the processor has these instructions.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        }
    };
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::*;
    use std::ops::Neg;

    use crate::real::{Real, Work};

    lanes! {
        /// Four numbers that are computed with at once.
        Lanes: 4 in __m256d, _mm256_add_pd, _mm256_sub_pd, _mm256_mul_pd, _mm256_div_pd
    }

    /// Runs work compiled for processors with these registers.
    #[target_feature(enable = "avx2,fma")]
    fn run<W: Work>(work: W) -> W::Output {
        work.run()
    }

    // SAFETY of all that follows: a `Width` gives the type away only where the processor has these instructions.
    impl Neg for Lanes {
        type Output = Self;
        #[inline(always)]
        fn neg(self) -> Self {
            Self(unsafe { _mm256_xor_pd(self.0, _mm256_set1_pd(-0.0)) })
        }
    }

    impl Real for Lanes {
        const LANES: usize = 4;

        #[inline(always)]
        fn splat(value: f64) -> Self {
            Self(unsafe { _mm256_set1_pd(value) })
        }
        #[inline(always)]
        fn lane(&self, index: usize) -> f64 {
            self.numbers()[index]
        }
        #[inline(always)]
        fn set_lane(&mut self, index: usize, value: f64) {
            self.numbers_mut()[index] = value;
        }
        #[inline(always)]
        fn store(&self, row: &mut [f64]) {
            row.copy_from_slice(self.numbers());
        }
        #[inline(always)]
        fn load(row: &[f64]) -> Self {
            let mut numbers = [0.0; Self::LANES];
            numbers.copy_from_slice(row);
            Self::from(numbers)
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
            sin_cos(self)
        }
        #[inline(always)]
        fn run<W: Work>(work: W) -> W::Output {
            unsafe { run(work) }
        }
    }

    #[inline(always)]
    fn sin_cos(angle: Lanes) -> (Lanes, Lanes) {
        let (shifted, sine, cosine) = super::near_quarter(angle);
        unsafe {
            let bits = _mm256_castpd_si256(shifted.0);
            // Odd quarters swap the two; sine is negative in the third and fourth, cosine in the second and third.
            let odd = _mm256_castsi256_pd(_mm256_slli_epi64::<63>(bits));
            let minus = _mm256_castpd_si256(_mm256_set1_pd(-0.0));
            let sign = |bits| _mm256_castsi256_pd(_mm256_and_si256(_mm256_slli_epi64::<62>(bits), minus));
            let s = _mm256_blendv_pd(sine.0, cosine.0, odd);
            let c = _mm256_blendv_pd(cosine.0, sine.0, odd);
            let after = _mm256_add_epi64(bits, _mm256_set1_epi64x(1));
            (Lanes(_mm256_xor_pd(s, sign(bits))), Lanes(_mm256_xor_pd(c, sign(after))))
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod avx512 {
    use std::arch::x86_64::*;
    use std::ops::Neg;

    use crate::real::{Real, Work};

    lanes! {
        /// Eight numbers that are computed with at once.
        WideLanes: 8 in __m512d, _mm512_add_pd, _mm512_sub_pd, _mm512_mul_pd, _mm512_div_pd
    }

    /// Runs work compiled for processors with these registers.
    #[target_feature(enable = "avx512f,avx2,fma")]
    fn run<W: Work>(work: W) -> W::Output {
        work.run()
    }

    /// The numbers of a with their signs changed where those of b are negative.
    #[inline(always)]
    fn signed(a: __m512d, b: __m512i) -> WideLanes {
        unsafe {
            let minus = _mm512_castpd_si512(_mm512_set1_pd(-0.0));
            let bits = _mm512_xor_si512(_mm512_castpd_si512(a), _mm512_and_si512(b, minus));
            WideLanes(_mm512_castsi512_pd(bits))
        }
    }

    // SAFETY of all that follows: a `Width` gives the type away only where the processor has these instructions.
    impl Neg for WideLanes {
        type Output = Self;
        #[inline(always)]
        fn neg(self) -> Self {
            signed(self.0, unsafe { _mm512_set1_epi64(-1) })
        }
    }

    impl Real for WideLanes {
        const LANES: usize = 8;

        #[inline(always)]
        fn splat(value: f64) -> Self {
            Self(unsafe { _mm512_set1_pd(value) })
        }
        #[inline(always)]
        fn lane(&self, index: usize) -> f64 {
            self.numbers()[index]
        }
        #[inline(always)]
        fn set_lane(&mut self, index: usize, value: f64) {
            self.numbers_mut()[index] = value;
        }
        #[inline(always)]
        fn store(&self, row: &mut [f64]) {
            row.copy_from_slice(self.numbers());
        }
        #[inline(always)]
        fn load(row: &[f64]) -> Self {
            let mut numbers = [0.0; Self::LANES];
            numbers.copy_from_slice(row);
            Self::from(numbers)
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            Self(unsafe { _mm512_sqrt_pd(self.0) })
        }
        #[inline(always)]
        fn abs(self) -> Self {
            Self(unsafe { _mm512_abs_pd(self.0) })
        }
        #[inline(always)]
        fn plus(self, a: Self, b: Self) -> Self {
            Self(unsafe { _mm512_fmadd_pd(a.0, b.0, self.0) })
        }
        #[inline(always)]
        fn minus(self, a: Self, b: Self) -> Self {
            Self(unsafe { _mm512_fnmadd_pd(a.0, b.0, self.0) })
        }
        #[inline(always)]
        fn max(self, other: Self) -> Self {
            // The instruction gives the second where one is not a number; the larger of two is the one that is.
            unsafe {
                let larger = _mm512_max_pd(self.0, other.0);
                let not_a_number = _mm512_cmp_pd_mask::<_CMP_UNORD_Q>(other.0, other.0);
                Self(_mm512_mask_blend_pd(not_a_number, larger, self.0))
            }
        }
        #[inline(always)]
        fn is_negative(self) -> Self {
            unsafe {
                let below = _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, _mm512_setzero_pd());
                Self(_mm512_maskz_mov_pd(below, _mm512_set1_pd(1.0)))
            }
        }
        #[inline(always)]
        fn sin_cos(self) -> (Self, Self) {
            let (shifted, sine, cosine) = super::near_quarter(self);
            unsafe {
                let bits = _mm512_castpd_si512(shifted.0);
                // Odd quarters swap the two; sine is negative in the third and fourth, cosine in the second and third.
                let odd = _mm512_test_epi64_mask(bits, _mm512_set1_epi64(1));
                let s = _mm512_mask_blend_pd(odd, sine.0, cosine.0);
                let c = _mm512_mask_blend_pd(odd, cosine.0, sine.0);
                let after = _mm512_add_epi64(bits, _mm512_set1_epi64(1));
                (signed(s, _mm512_slli_epi64::<62>(bits)), signed(c, _mm512_slli_epi64::<62>(after)))
            }
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

    /// Checks numbers of every width that the processor has.
    fn in_every_width(check: impl Generic<Output = ()> + Copy) {
        let widest = Width::widest();
        for members in [1, 4, 8] {
            widest.for_members(members).run(check);
        }
    }

    /// A width holds the members that it is asked for, as narrowly as it can, and never more than the processor has.
    #[test]
    fn a_width_is_the_narrowest_for_its_members() {
        let widest = Width::widest();
        for members in 1..=widest.lanes() {
            let width = widest.for_members(members);
            assert!(width.lanes() >= members && width.lanes() < 4 * members, "{members}: {width:?}");
        }
        assert_eq!(widest.for_members(100), widest);
        assert_eq!(Width::ONE.for_members(100), Width::ONE);
    }

    /// A lane computes what a number computes, bit for bit, for whatever number; products added are rounded once.
    #[test]
    fn lanes_have_the_digits_of_numbers() {
        #[derive(Clone, Copy)]
        struct Check;
        impl Generic for Check {
            type Output = ();
            fn with<T: Real>(self) {
                if T::LANES > 1 {
                    have_digits_of_numbers::<T>();
                }
            }
        }
        in_every_width(Check);
    }

    fn of<T: Real>(numbers: [f64; 4]) -> T {
        let mut lanes = T::zero();
        (0..T::LANES).for_each(|lane| lanes.set_lane(lane, numbers[lane % 4]));
        lanes
    }

    fn have_digits_of_numbers<T: Real>() {
        let a = [0.1, -3.7, f64::NAN, -0.0];
        let b = [-7.3, f64::NAN, 2.5, 1e-300];
        let (x, y) = (of::<T>(a), of::<T>(b));
        for lane in 0..T::LANES {
            let i = lane % 4;
            let same = |lanes: T, number: f64| {
                let lane = lanes.lane(lane);
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
        }
    }

    /// Units of the last digit of `exact` between it and `lane`.
    fn units(lane: f64, exact: f64) -> f64 {
        (lane - exact).abs() / (exact.abs() * f64::EPSILON).max(f64::MIN_POSITIVE)
    }

    #[test]
    fn sines_and_cosines_are_those_of_numbers() {
        #[derive(Clone, Copy)]
        struct Check;
        impl Generic for Check {
            type Output = ();
            fn with<T: Real>(self) {
                if T::LANES > 1 {
                    have_sines_of_numbers::<T>();
                }
            }
        }
        in_every_width(Check);
    }

    fn have_sines_of_numbers<T: Real>() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let near = (-40..=40).flat_map(|k| [-1e-7, -1e-16, 0.0, 3e-13, 0.1, 0.785].map(|d| f64::from(k) * quarter + d));
        let far = (0..60).map(|k| 1.37f64.powi(k) * if k % 2 == 0 { 1e-3 } else { -1e-3 });
        let small = [0.0, 5e-324, -1e-310, 1e-200, -1e-8, 2e-8];
        let large = [12_345_678.9, -1e9 - 0.3, 3e12, 1e15];
        for angle in near.chain(far).chain(small).chain(large) {
            let (s, c) = of::<T>([0.3, angle, -angle, 1.0]).sin_cos();
            let (sine, cosine) = angle.sin_cos();
            assert!(
                units(s.lane(1), sine) <= 2.0 && units(s.lane(T::LANES - 2), -sine) <= 2.0,
                "sin {angle}: {s:?}, {sine}"
            );
            assert!(
                units(c.lane(1), cosine) <= 2.0 && units(c.lane(T::LANES - 2), cosine) <= 2.0,
                "cos {angle}: {c:?}, {cosine}"
            );
        }
        let (s, c) = of::<T>([f64::NAN, f64::INFINITY, -0.0, 0.0]).sin_cos();
        assert!(s.lane(0).is_nan() && c.lane(0).is_nan() && s.lane(1).is_nan() && c.lane(1).is_nan());
        assert!(c.lane(2) == 1.0 && c.lane(3) == 1.0);
    }
}

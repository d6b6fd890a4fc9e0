//! Directions in the space of motions and fractions, and what they are measured by.
//!
//! Theory: docs/theory/continuation.md, Eq. 8.2 and 8.3.

use super::Tuning;

/// A motion of the joints together with a change of the fraction, or a functional of both.
#[derive(Clone, Debug, Default)]
pub(super) struct Direction {
    pub motions: Vec<[f64; 6]>,
    pub rate: f64,
}

impl Direction {
    /// Value of this functional.
    pub(crate) fn along(&self, motions: &[[f64; 6]], fraction: f64) -> f64 {
        let joints: f64 = self.motions.iter().zip(motions).map(|(n, m)| (0..6).map(|c| n[c] * m[c]).sum::<f64>()).sum();
        joints + self.rate * fraction
    }

    pub(super) fn reverse(&mut self) {
        self.motions.iter_mut().flatten().for_each(|x| *x = -*x);
        self.rate = -self.rate;
    }
}

/// Weight of displacements and rotations against the fraction: the square of what a unit of the fraction counts for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Metric {
    displacement: f64,
    rotation: f64,
}

impl Metric {
    /// Joints and fraction count for the same where the joints move as they do here, but for joints that hardly move,
    /// `hardly` (lengths of the network, or radians) for a unit of the fraction: a straight column only shortens until it
    /// buckles, and must not be measured by that.
    pub(crate) fn balanced(motions: &[[f64; 6]], rate: f64, size: f64, hardly: f64) -> Self {
        let plain = Self { displacement: 1.0 / (size * size), rotation: 1.0 };
        let moved = plain.product(motions, motions).max((hardly * rate).powi(2));
        let factor = if moved > 0.0 && rate != 0.0 { rate * rate / moved } else { 1.0 };
        Self { displacement: factor * plain.displacement, rotation: factor }
    }

    fn product(&self, a: &[[f64; 6]], b: &[[f64; 6]]) -> f64 {
        let part = |a: &[f64; 6], b: &[f64; 6], from: usize| (from..from + 3).map(|c| a[c] * b[c]).sum::<f64>();
        let sum = |from| a.iter().zip(b).map(|(a, b)| part(a, b, from)).sum::<f64>();
        self.displacement * sum(0) + self.rotation * sum(3)
    }

    pub(crate) fn inner(&self, a: &Direction, b: &Direction) -> f64 {
        self.product(&a.motions, &b.motions) + a.rate * b.rate
    }

    /// The direction, made of length one.
    pub(crate) fn unit(&self, mut direction: Direction) -> Direction {
        let length = self.inner(&direction, &direction).sqrt().max(f64::MIN_POSITIVE);
        direction.motions.iter_mut().flatten().for_each(|x| *x /= length);
        direction.rate /= length;
        direction
    }

    /// Whether the way between two points of a path goes the way of the unit tangents at both, taken together.
    ///
    /// It does where the path bends as a circle, whatever the angle; a chord that does not leads to another path. Curvature
    /// that changes by as much as itself takes the chord of a path that turns by the angle of `straight` a third of that aside.
    pub(crate) fn is_chord(&self, chord: &Direction, tangents: [&Direction; 2], tuning: &Tuning) -> bool {
        let [first, second] = tangents;
        let along = self.inner(chord, first) + self.inner(chord, second);
        let length = (2.0 + 2.0 * self.inner(first, second)).max(0.0).sqrt();
        let parallel = (tuning.straight.acos() / 3.0).cos();
        along >= parallel * length * self.inner(chord, chord).sqrt()
    }

    /// Whether the path that a chord cuts off bends about as much in its first half as in its second: on to another one, at
    /// a kink, it does not. Where it hardly bends there is nothing to compare.
    ///
    /// The angles of a chord with the tangents at its ends differ by a factor of two where the curvature rises evenly from zero.
    pub(crate) fn bends_evenly(&self, chord: &Direction, tangents: [&Direction; 2], tuning: &Tuning) -> bool {
        let length = self.inner(chord, chord).sqrt();
        let [first, second] = tangents.map(|tangent| (self.inner(chord, tangent) / length).clamp(-1.0, 1.0).acos());
        first + second <= 2.0 * tuning.miss || tuning.shorter * first.max(second) <= first.min(second)
    }

    /// The functional that measures along a direction.
    pub(crate) fn functional(&self, direction: &Direction) -> Direction {
        let mut functional = direction.clone();
        for motion in &mut functional.motions {
            for (c, x) in motion.iter_mut().enumerate() {
                *x *= if c < 3 { self.displacement } else { self.rotation };
            }
        }
        functional
    }
}

//! Folds that are foretold: where the stiffness of a network will be lost, by how it fell so far.
//!
//! Right before a fold the square of the overall stiffness falls linearly with the fraction of the ramp. What it foretells limits how
//! far an increment goes, says what to find at its end, and calls for the arc where the fold is next to the last state.
//!
//! Theory: docs/theory/continuation.md, Eq. 8.9.

use super::Tuning;

/// Part of its square that the stiffness is to lose in an increment, by what is foretold, for what it loses to say anything.
const FALLS: f64 = 0.3;

/// How the square of the stiffness fell in an increment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slope {
    /// The change of the square for a unit of the fraction.
    rate: f64,
    /// The length of the increment.
    length: f64,
}

impl Slope {
    /// Between these values of the stiffness, at the beginning and at the end of an increment.
    pub(super) fn of(from: f64, to: f64, length: f64) -> Self {
        Self { rate: (to - from) * (to + from) / length, length }
    }
}

/// How the square of the stiffness goes on from a state, where it is zero ahead.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foretold {
    /// The square at the state.
    square: f64,
    /// Its change for a unit of the fraction, and half the change of that for another.
    slope: f64,
    half_curvature: f64,
    /// How much farther it is zero, in parts of the ramp.
    pub ahead: f64,
}

impl Foretold {
    /// By the parabola through the states at the ends of two increments, the last one of this stiffness; `None` where that is zero nowhere
    /// ahead, as where stiffness fades more and more slowly.
    pub(super) fn by(stiffness: f64, [before, last]: [Slope; 2]) -> Option<Self> {
        let square = stiffness * stiffness;
        let half_curvature = (last.rate - before.rate) / (last.length + before.length);
        let slope = last.rate + half_curvature * last.length;
        // No number where there is no root.
        let ahead = 2.0 * square / ((slope * slope - 4.0 * half_curvature * square).sqrt() - slope);
        (ahead > 0.0).then_some(Self { square, slope, half_curvature, ahead })
    }

    /// The longest increment that does not go beyond it.
    pub(super) fn longest(&self, tuning: &Tuning) -> f64 {
        tuning.missed * self.ahead
    }

    /// Whether the stiffness at the end of an increment is another than that of the path: it was to fall by far more than it did.
    pub(super) fn is_missed(&self, length: f64, stiffness: f64, tuning: &Tuning) -> bool {
        let fall = -length * (self.slope + length * self.half_curvature);
        fall > FALLS * self.square && self.square - stiffness * stiffness < tuning.contraction * fall
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A law of the stiffness over the fraction, seen at three fractions.
    fn foretold(stiffness: impl Fn(f64) -> f64, at: [f64; 3]) -> Option<Foretold> {
        let slope = |i: usize| Slope::of(stiffness(at[i]), stiffness(at[i + 1]), at[i + 1] - at[i]);
        Foretold::by(stiffness(at[2]), [slope(0), slope(1)])
    }

    #[test]
    fn a_fold_is_foretold_where_it_is() {
        let root = |at: f64| (0.8 - at).sqrt();
        let fold = foretold(root, [0.1, 0.3, 0.4]).unwrap();
        assert!((fold.ahead - 0.4).abs() < 1e-12);
        let tuning = Tuning::default();
        assert!(!fold.is_missed(0.2, root(0.6), &tuning));
        assert!(fold.is_missed(0.2, root(0.4), &tuning));
        // The square that is a parabola.
        let fold = foretold(|at| (0.8 - at + 0.3 * (0.64 - at * at)).sqrt(), [0.1, 0.3, 0.4]).unwrap();
        assert!((fold.ahead - 0.4).abs() < 1e-12);
    }

    #[test]
    fn what_fades_has_none() {
        assert!(foretold(|at| 1.0 / (1.0 + 9.0 * at), [0.1, 0.3, 0.4]).is_none());
        assert!(foretold(|at| 1.0 + at, [0.1, 0.3, 0.4]).is_none());
    }
}

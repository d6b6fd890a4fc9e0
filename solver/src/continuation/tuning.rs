//! Every number that steers an iteration or a path, in one table.
//!
//! None of them is part of an answer: they say when an iteration is given up, how long an increment is, what is looked at
//! twice. `tests/paths/tuning.rs` moves each by a factor of two and finds the same answers. A length stands here for
//! displacements over the length of the member, or over the size of the network, and goes with radians of rotations.

/// The numbers, with their defaults.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tuning {
    /// Iterations after which one is given up. With mixed points 3 to 9 lead to an equilibrium at any slenderness (Magisano,
    /// Leonetti, Garcea, Int. J. Numer. Methods Engrg. 111, 2017).
    pub iterations: usize,
    /// Increment (radians, or lengths) whose square is rounding: a quadratic iteration has converged. An increment along an arc is
    /// not made shorter than this part of the first.
    pub increment: f64,
    /// Residual, over the largest force or moment, at which such a state needs no further iteration: rounding of sums of a
    /// million terms.
    pub residual: f64,
    /// Increment (radians, or lengths) that is rounding.
    pub rounding: f64,
    /// Contraction of one increment of an iteration over the one before that is no quadratic convergence, and its inverse where
    /// increments grow (Deuflhard, Newton Methods for Nonlinear Problems, 2004, ch. 2: monotone up to one half).
    pub contraction: f64,
    /// Increment (radians, or lengths) up to which an iteration may grow.
    pub trust: f64,
    /// Radians, or lengths, that are near, and the part of a ramp, a residual or a force that is small: an iteration within them
    /// converges quadratically, a path within them is one.
    pub near: f64,
    /// Part of its loads at which linear buckling of the first increment tells that they are too much for it. Factors a
    /// little below one are common where nothing buckles: a curved beam bent out of its plane.
    pub buckling: f64,
    /// Iterations that say that the state was not near its prediction.
    pub many: usize,
    /// Distance (radians, or lengths) of a prediction from the state that few iterations mend; the next increment is to miss
    /// by this (den Heijer & Rheinboldt, SIAM J. Numer. Anal. 18, 1981).
    pub miss: f64,
    /// Factor of an increment that is made again.
    pub shorter: f64,
    /// Factor by which the next increment may be longer, a move farther than foreseen, and a rate greater than at first.
    pub longer: f64,
    /// Part of what was foreseen by which a move may miss it and still point the same way.
    pub missed: f64,
    /// Part of an increment by which the state half way may be away from where the ends, a rate and the state before say that it is. Of
    /// 1,370 increments of six or seven iterations that a path joins half are away by less than two hundredths, and those that leap a
    /// limit point by more than a half as a rule, but by a fifth beside a bifurcation that is not quite perfect (random frames, arches,
    /// networks and linkages). One that is away farther on a path costs a shorter increment, where a sixteenth of it is left.
    pub swing: f64,
    /// Part of the ramp within which a change of stability is a singular point, and what lies beside one is looked for; part of
    /// its stiffness that a network has left that near to one.
    pub bracket: f64,
    /// Part of the ramp below which increments are not shortened, and distance (radians, or lengths) of states that are one.
    pub shortest: f64,
    /// Cosine of the angle by which a path turns in one increment along its arc.
    pub straight: f64,
    /// Part of a bracket to which the root in it is closed in, and increment (radians, or lengths) of an iteration that is to
    /// tell whether a motion has any stiffness: half of all digits and a little more.
    pub exact: f64,
    /// Distance (radians, or lengths) along a mode at which a branch is entered.
    pub amplitude: f64,
    /// Displacement over the size of the network that nothing holds, and times that a path may bear the loads of a ramp the other
    /// way before it is said to lead away.
    pub endless: f64,
}

impl Default for Tuning {
    fn default() -> Self {
        Self {
            iterations: 16,
            increment: 1e-7,
            residual: 1e-10,
            rounding: 1e-12,
            contraction: 0.5,
            trust: 0.5,
            near: 1e-2,
            buckling: 0.3,
            many: 7,
            miss: 0.05,
            shorter: 0.4,
            longer: 4.0,
            missed: 0.8,
            swing: 0.1,
            bracket: 2e-3,
            shortest: 1e-4,
            straight: 0.85,
            exact: 1e-9,
            amplitude: 0.02,
            endless: 100.0,
        }
    }
}

impl Tuning {
    /// Iterations that lead to what lies near, whatever was foreseen.
    pub fn few(&self) -> usize {
        self.many.div_ceil(2) + 1
    }

    /// Iterations from which on a state is made sure of that loads without a potential led to: fewer where positive pivots were lost
    /// on the way.
    pub(crate) fn most_nearby(&self, rose: bool) -> usize {
        if rose { self.few() } else { self.many }
    }

    /// Residual, and strain that is held to zero, that count as an equilibrium where no iteration makes them smaller: half of the digits
    /// that rounding leaves.
    pub(crate) fn tolerance(&self) -> f64 {
        self.rounding.sqrt()
    }

    /// Distance (radians, or lengths) by which a prediction is wrong.
    pub(crate) fn wrong(&self) -> f64 {
        self.longer * self.miss
    }

    /// Part of the ramp, and of what leads to a point, that is right beside it.
    pub(crate) fn beside(&self) -> f64 {
        0.5 * self.bracket
    }

    /// Length of the increment that follows one of this length and so many iterations; `missed` is how far its prediction was
    /// from the state (radians, or lengths), where that is known.
    ///
    /// What extrapolation misses goes with the square of the increment, and an iteration that has less to do is shorter.
    pub(crate) fn next_length(&self, length: f64, iterations: usize, missed: Option<f64>) -> f64 {
        let twice = self.longer.sqrt();
        let factor = match (iterations, missed) {
            (n, Some(missed)) if n < self.many => (self.miss / missed).sqrt().clamp(twice, self.longer),
            (n, None) if n < self.few() => twice,
            (n, None) if n < self.many => twice.sqrt(),
            (n, _) if n < self.many + 2 => 1.0,
            _ => self.shorter.sqrt(),
        };
        factor * length
    }
}

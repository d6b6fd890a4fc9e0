//! Local unknowns and strains of elements at their present state, and what strains that are held still have.

use pennate_elements::beam::Beam;
use pennate_elements::laws::LocalLaw;
use pennate_elements::real::{Real, Work};

use crate::Chain;

/// Local unknowns of one element, as work in lanes.
pub(super) struct LocalUnknowns<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize>(
    pub(super) &'a Chain<T, B, D, P>,
    pub(super) usize,
);

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for LocalUnknowns<'_, T, B, D, P> {
    type Output = [[T; D]; P];

    #[inline(always)]
    fn run(self) -> [[T; D]; P] {
        let Self(chain, e) = self;
        let frame = B::frame(chain.piece(e), &chain.state.nodes[e], &chain.state.nodes[e + 1]);
        chain.local_of(e, &frame)
    }
}

/// Strains of one element, as work in lanes.
pub(super) struct Strains<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize>(
    pub(super) &'a Chain<T, B, D, P>,
    pub(super) usize,
);

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for Strains<'_, T, B, D, P> {
    type Output = [[T; D]; P];

    #[inline(always)]
    fn run(self) -> [[T; D]; P] {
        let Self(chain, e) = self;
        let local = LocalUnknowns(chain, e).run();
        B::strains(&chain.at(e, &local))
    }
}

/// Largest strain that a held component has, beyond that which its mixed stress explains, as work in lanes.
struct Violation<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize>(&'a Chain<T, B, D, P>);

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for Violation<'_, T, B, D, P> {
    type Output = T;

    #[inline(always)]
    fn run(self) -> T {
        let Self(chain) = self;
        let mut largest = T::zero();
        for (e, &segment) in chain.mesh.segment_of.iter().enumerate() {
            let moduli = &chain.moduli[segment];
            let (mut held, mut compliance) = (T::zero(), [T::zero(); D]);
            for d in 0..D {
                held += moduli.held[d];
                compliance[d] = (T::one() - moduli.held[d]) / moduli.stiffness[d];
            }
            if (0..T::LANES).all(|lane| held.lane(lane) == 0.0) {
                continue;
            }
            let strains = Strains(chain, e).run();
            let stress = chain.stress_of(e);
            for g in 0..P {
                for d in 0..D {
                    let own = compliance[d] * stress[g][d];
                    let off = moduli.held[d] * (strains[g][d] - moduli.rest[d] - own);
                    largest = largest.max(off.abs());
                }
            }
        }
        largest
    }
}

/// Largest tangent of the angle by which the bending within an element that cannot be stretched lets its chord lean, as work in lanes.
struct Lean<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize>(&'a Chain<T, B, D, P>);

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for Lean<'_, T, B, D, P> {
    type Output = T;

    #[inline(always)]
    fn run(self) -> T {
        let Self(chain) = self;
        let (one, least) = (T::one(), T::splat(f64::MIN_POSITIVE));
        let mut largest = T::zero();
        for (e, &segment) in chain.mesh.segment_of.iter().enumerate() {
            let moduli = &chain.moduli[segment];
            let held = moduli.held[0];
            if (0..T::LANES).all(|lane| held.lane(lane) == 0.0) {
                continue;
            }
            let strains = Strains(chain, e).run();
            for strain in &strains {
                let along = one + strain[0];
                let transverse = 1..if D == 6 { 3 } else { 2 };
                let mut square = along * along;
                for d in transverse.clone() {
                    square = square.plus(strain[d], strain[d]);
                }
                let mut lean = T::zero();
                for d in transverse {
                    let by_bending = moduli.softening[d - 1] * square;
                    let part = strain[d] * by_bending / Real::max(one / moduli.stiffness[d] + by_bending, least);
                    lean = lean.plus(part, part);
                }
                largest = largest.max(held * lean.sqrt() / Real::max(along, least));
            }
        }
        largest
    }
}

/// The largest of all lanes.
fn largest_lane<T: Real>(of: T) -> f64 {
    (0..T::LANES).fold(0.0, |all, lane| f64::max(all, of.lane(lane)))
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    pub(super) fn violation_impl(&self) -> f64 {
        largest_lane(T::run(Violation(self)))
    }

    pub(super) fn lean_impl(&self) -> f64 {
        if B::Law::ABOUT.sheared_by_bending { largest_lane(T::run(Lean(self))) } else { 0.0 }
    }
}

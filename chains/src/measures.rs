//! Present length and largest strains of a member.

use pennate_elements::beam::Beam;
use pennate_elements::real::{Real, Work};

use crate::Chain;
use crate::member::Peak;
use crate::strains::Strains;

/// Present length of the axis of a member, and its largest strains.
#[derive(Clone, Copy, Debug, Default)]
pub struct Measures {
    /// Present length of the centre line.
    pub length: f64,
    /// Axial strain that stresses the member, the induced one apart, where its size is largest; positive in tension.
    pub stretch: Peak,
    /// Largest strain that bending brings to a fibre, where sections have a shape; induced curvature apart.
    pub bending: Peak,
}

/// The value of largest size so far, and where it is.
#[derive(Clone, Copy, Default)]
struct Largest<T> {
    value: T,
    at: T,
}

impl<T: Real> Largest<T> {
    #[inline(always)]
    fn take(&mut self, value: T, at: T) {
        let larger = (self.value.abs() - value.abs()).is_negative();
        self.value += larger * (value - self.value);
        self.at += larger * (at - self.at);
    }

    fn lane(&self, lane: usize) -> Peak {
        Peak { value: self.value.lane(lane), at: self.at.lane(lane) }
    }
}

/// Length, stretch and bending, as work in lanes.
struct Measure<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize>(&'a Chain<T, B, D, P>);

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for Measure<'_, T, B, D, P> {
    type Output = (T, Largest<T>, Largest<T>);

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self(chain) = self;
        let mut length = T::zero();
        let (mut stretch, mut bending) = (Largest::default(), Largest::default());
        let mut before = T::zero();
        for e in 0..chain.frames.len() {
            let piece = chain.piece(e);
            let strains = Strains(chain, e).run();
            let segment = chain.mesh.segment_of[e];
            let rest = &chain.moduli[segment].rest;
            let [second, third, corner] = chain.fibres[segment];
            for g in 0..P {
                let along = T::one() + strains[g][0];
                let mut square = (along * along).plus(strains[g][1], strains[g][1]);
                if D == 6 {
                    square = square.plus(strains[g][2], strains[g][2]);
                }
                length += T::splat(chain.table.weights[g]) * piece.length * square.sqrt();
                let at = before.plus(T::splat(chain.table.points[g]), piece.length);
                stretch.take(strains[g][0] - rest[0], at);
                // About axis 3, the last, whose fibres lie along axis 2; in space about axis 2 as well.
                let b = ((strains[g][D - 1] - rest[D - 1]) * second).abs();
                let fibre = if D == 6 {
                    let a = ((strains[g][D - 2] - rest[D - 2]) * third).abs();
                    // A corner has the sum of both, a round section the root of their squares.
                    let square = (a * a).plus(b, b).plus(corner * (a + a), b);
                    square.sqrt()
                } else {
                    b
                };
                bending.take(fibre, at);
            }
            before += piece.length;
        }
        let over = T::one() / chain.total_length;
        stretch.at = stretch.at * over;
        bending.at = bending.at * over;
        (length, stretch, bending)
    }
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    pub(super) fn measures_impl(&self) -> Vec<Measures> {
        let (length, stretch, bending) = T::run(Measure(self));
        let of =
            |lane| Measures { length: length.lane(lane), stretch: stretch.lane(lane), bending: bending.lane(lane) };
        (0..self.mesh.members.len()).map(of).collect()
    }
}

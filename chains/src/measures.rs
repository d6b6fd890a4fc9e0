//! Present length and largest strains of a member, and the energy that coarser elements lack.

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
    /// Strain energy in the highest mode of the strains of all elements, the Legendre component of order P − 1: what elements of
    /// an order less lack. Strains that are held have none.
    pub top_energy: f64,
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

/// Factors of the strains at P Gauss points whose sum, squared, is the part of their mean square that the highest polynomial has
/// which so many points see.
fn highest_mode<const P: usize>(points: &[f64; P], weights: &[f64; P]) -> [f64; P] {
    // Up to a factor it is the alternating one of the divided difference.
    let mut mode = [0.0; P];
    for g in 0..P {
        let product: f64 = (0..P).filter(|&o| o != g).map(|o| points[g] - points[o]).product();
        mode[g] = 1.0 / product;
    }
    let square: f64 = (0..P).map(|g| mode[g] * mode[g] / weights[g]).sum();
    mode.map(|value| value / square.sqrt())
}

/// Length, stretch, bending and energy in the highest mode, as work in lanes.
struct Measure<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize>(&'a Chain<T, B, D, P>);

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for Measure<'_, T, B, D, P> {
    type Output = (T, Largest<T>, Largest<T>, T);

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self(chain) = self;
        let mut length = T::zero();
        let (mut stretch, mut bending) = (Largest::default(), Largest::default());
        let mode = highest_mode(&chain.table.points, &chain.table.weights);
        let (mut energy, least) = (T::zero(), T::splat(f64::MIN_POSITIVE));
        let mut before = T::zero();
        for e in 0..chain.frames.len() {
            let piece = chain.piece(e);
            let strains = Strains(chain, e).run();
            let segment = chain.mesh.segment_of[e];
            let moduli = &chain.moduli[segment];
            let rest = &moduli.rest;
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
            for d in 0..D {
                let mut top = T::zero();
                for g in 0..P {
                    top += T::splat(mode[g]) * strains[g][d];
                }
                let free = T::one() - moduli.held[d];
                let stiffness = (T::zero() - free).is_negative() * moduli.stiffness[d];
                energy += stiffness * piece.length * top * top / Real::max(free, least);
            }
            before += piece.length;
        }
        let over = T::one() / chain.total_length;
        stretch.at = stretch.at * over;
        bending.at = bending.at * over;
        (length, stretch, bending, T::splat(0.5) * energy)
    }
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    pub(super) fn measures_impl(&self) -> Vec<Measures> {
        let (length, stretch, bending, energy) = T::run(Measure(self));
        let of = |lane| Measures {
            length: length.lane(lane),
            stretch: stretch.lane(lane),
            bending: bending.lane(lane),
            top_energy: energy.lane(lane),
        };
        (0..self.mesh.members.len()).map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use pennate_elements::interpolation::Table;

    use super::*;

    /// Of the constant and the linear function nothing, of the Legendre polynomial 6 s² − 6 s + 1 all of its mean square, 1/5.
    #[test]
    fn the_highest_mode_is_the_legendre_polynomial() {
        let table = Table::<3>::new();
        let mode = highest_mode(&table.points, &table.weights);
        let part = |f: fn(f64) -> f64| {
            let sum: f64 = mode.iter().zip(&table.points).map(|(mode, &s)| mode * f(s)).sum();
            sum * sum
        };
        assert!(part(|_| 1.0) < 1e-28);
        assert!(part(|s| s) < 1e-28);
        assert!((part(|s| 6.0 * s * s - 6.0 * s + 1.0) - 0.2).abs() < 1e-14);
    }
}

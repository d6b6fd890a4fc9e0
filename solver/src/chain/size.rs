//! How large an increment is.

use pennate_elements::beam::Beam;
use pennate_elements::real::Real;
use pennate_elements::small::{V3, add, cross, norm, sub, tapply};

use super::{Chain, Size, lanes, larger};

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    pub(super) fn size_impl(&self, lane: usize) -> Size {
        let mut size = Size::default();
        let length = self.total_length.lane(lane);
        for increment in &self.increments {
            for (d, x) in increment.iter().enumerate() {
                let x = x.lane(lane).abs();
                if d < Self::TRANSLATIONS {
                    size.displacement = larger(size.displacement, x / length);
                } else {
                    size.rotation = larger(size.rotation, x);
                }
            }
        }
        size
    }

    pub(super) fn own_size_impl(&self, lane: usize) -> Size {
        let length = self.total_length.lane(lane);
        let (first, spin) = Self::motion(&lanes::lane(&self.increments[0], lane));
        let start = B::pose(&self.state.nodes[0], lane).displacement;
        let mut chord: V3<f64> = [0.0; 3];
        let mut size = Size::default();
        for (e, piece) in self.pieces.iter().enumerate() {
            let axes = piece.axes.map(|row| row.map(|x| x.lane(lane)));
            chord = add(chord, tapply(&axes, &piece.chord.map(|x| x.lane(lane))));
            let arm = add(chord, sub(B::pose(&self.state.nodes[e + 1], lane).displacement, start));
            let (shift, turn) = Self::motion(&lanes::lane(&self.increments[e + 1], lane));
            let own = sub(sub(shift, first), cross(spin, arm));
            size = size.join(Size { rotation: norm(sub(turn, spin)), displacement: norm(own) / length });
        }
        size
    }

    /// Displacement and spin of an increment.
    fn motion(increment: &[f64; D]) -> (V3<f64>, V3<f64>) {
        if D == 6 {
            let [u, phi] = [0, 3].map(|first| std::array::from_fn(|i| increment[first + i]));
            (u, phi)
        } else {
            ([increment[0], increment[1], 0.0], [0.0, 0.0, increment[2]])
        }
    }
}

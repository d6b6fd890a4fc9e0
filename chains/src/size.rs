//! How large an increment is.

use pennate_elements::beam::Beam;
use pennate_elements::real::{Real, Work};
use pennate_elements::small::{V3, add, cross, dot, sub, tapply};

use crate::{Chain, MOST_LANES};

/// The size of an increment: largest rotation (radians) and largest displacement over the member's length.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Size {
    /// Largest rotation (radians).
    pub rotation: f64,
    /// Largest displacement, over the length of the member.
    pub displacement: f64,
}

impl Size {
    /// The larger of each.
    pub fn join(self, other: Self) -> Self {
        Self {
            rotation: larger(self.rotation, other.rotation),
            displacement: larger(self.displacement, other.displacement),
        }
    }

    /// The larger of both.
    pub fn largest(self) -> f64 {
        larger(self.rotation, self.displacement)
    }
}

/// The larger of two numbers; a NaN wins, so that it is never overlooked.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// Sizes of an increment: largest rotation and largest displacement over the length of the member.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sizes<T> {
    whole: [T; 2],
    /// Without the motion that the member makes as a whole with its start.
    own: [T; 2],
}

impl<T: Real> Sizes<T> {
    pub(crate) fn of(&self, lane: usize) -> [Size; 2] {
        let Self { whole, own } = self;
        [whole, own].map(|of| Size { rotation: of[0].lane(lane), displacement: of[1].lane(lane) })
    }
}

/// How far the element ends are from a saved state, as work in lanes: what [`Beam::turned`] says, and the square of the
/// largest displacement over the length of the member.
struct Distance<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize>(&'a Chain<T, B, D, P>, &'a [f64]);

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for Distance<'_, T, B, D, P> {
    type Output = [T; 2];

    #[inline(always)]
    fn run(self) -> [T; 2] {
        let Self(chain, row) = self;
        let saved = chain.saved(row);
        let o = T::zero();
        let (mut turned, mut moved, mut spoilt) = (o, o, o);
        for (index, now) in chain.state.nodes.iter().enumerate() {
            let then = &saved.node::<T, B, D>(index);
            let shift = sub(B::displacement(now), B::displacement(then));
            let (angle, square) = (B::turned(now, then), dot(shift, shift));
            turned = turned.max(angle);
            moved = moved.max(square);
            spoilt += (angle + square) * o;
        }
        let length = chain.total_length;
        [turned + spoilt, moved / (length * length) + spoilt]
    }
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    pub(super) fn distances_impl(&self, row: &[f64]) -> [Size; MOST_LANES] {
        let [turned, moved] = T::run(Distance(self, row));
        let mut sizes = [Size::default(); MOST_LANES];
        for lane in 0..self.mesh.members.len() {
            sizes[lane] = Size { rotation: B::angle(turned.lane(lane)), displacement: moved.lane(lane).sqrt() };
        }
        sizes
    }

    /// Sizes of the present increments, before the nodes move.
    #[inline(always)]
    pub(super) fn sizes(&self) -> Sizes<T> {
        let o = T::zero();
        let (mut whole, mut own) = ([o; 2], [o; 2]);
        // Infinite or not a number where any part is: the larger of two numbers would hide that.
        let mut spoilt = o;
        for increment in &self.increments {
            for d in 0..D {
                let kind = usize::from(d < Self::TRANSLATIONS);
                whole[kind] = whole[kind].max(increment[d].abs());
                spoilt += increment[d] * o;
            }
        }
        let (first, spin) = Self::motion(&self.increments[0]);
        let start = B::displacement(&self.state.nodes[0]);
        let mut chord: V3<T> = [o; 3];
        for e in 0..self.frames.len() {
            let piece = self.piece(e);
            chord = add(chord, tapply(&piece.axes, &piece.chord));
            let arm = add(chord, sub(B::displacement(&self.state.nodes[e + 1]), start));
            let (shift, turn) = Self::motion(&self.increments[e + 1]);
            let shift = sub(sub(shift, first), cross(spin, arm));
            let turn = sub(turn, spin);
            own[0] = own[0].max(dot(turn, turn));
            own[1] = own[1].max(dot(shift, shift));
            spoilt += (shift[0] + shift[1] + shift[2]) * o;
        }
        Sizes {
            whole: [whole[0] + spoilt, whole[1] / self.total_length + spoilt],
            own: [own[0].sqrt() + spoilt, own[1].sqrt() / self.total_length + spoilt],
        }
    }

    /// Displacement and spin of an increment.
    #[inline(always)]
    fn motion(increment: &[T; D]) -> (V3<T>, V3<T>) {
        let o = T::zero();
        if D == 6 {
            ([increment[0], increment[1], increment[2]], [increment[3], increment[4], increment[5]])
        } else {
            ([increment[0], increment[1], o], [o, o, increment[2]])
        }
    }
}

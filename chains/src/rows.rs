//! The ends of members whose lanes are those of the joints that they meet at: equal parts of a network, side by side.
//!
//! What such members add to their joints, and what these move them by, lies in rows: the numbers of all lanes one after the
//! other, so that a member adds and takes those of all parts at once.

use pennate_elements::beam::{Beam, Placement};
use pennate_elements::real::{Real, Work};

use crate::Chain;

/// Sums of what members give, by rows: forces and diagonals of the stiffness D a joint, and entries of a matrix.
#[derive(Clone, Debug, Default)]
pub struct EndRows {
    /// Forces on the joints.
    pub forces: Vec<f64>,
    /// Stiffness of members on every component.
    pub stiffness: Vec<f64>,
    /// Entries of the matrix.
    pub values: Vec<f64>,
}

/// Where the entries of the stiffness of a member go, by its blocks: start and start, start and end, end and end. Place in the
/// block, row by row, and row among the entries of the matrix.
pub type EndPlaces = [Vec<(u8, u32)>; 3];

/// What the ends of the members of a pack move by, and where they are: two joints of their own for all members, in rows. Lanes
/// without a member stay at rest.
#[derive(Clone, Debug)]
pub struct OwnRows<const D: usize> {
    lanes: usize,
    /// Displacements, then spins.
    pub motions: Vec<f64>,
    /// Displacements, and the angle in the plane or the rotation in space.
    pub poses: Vec<f64>,
}

impl<const D: usize> OwnRows<D> {
    /// At rest, for as many lanes.
    pub fn new(lanes: usize) -> Self {
        let size = if D == 3 { 3 } else { 7 };
        let mut rows = Self { lanes, motions: vec![0.0; 2 * D * lanes], poses: vec![0.0; 2 * size * lanes] };
        for lane in 0..lanes {
            (0..2).for_each(|end| rows.set_pose(lane, end, &Placement::default()));
        }
        rows
    }

    /// What the ends of a member move by.
    pub fn set_motions(&mut self, lane: usize, ends: &[[f64; D]; 2]) {
        let mut at = lane;
        for motion in ends.as_flattened() {
            self.motions[at] = *motion;
            at += self.lanes;
        }
    }

    /// Where an end of a member is.
    pub fn set_pose(&mut self, lane: usize, end: usize, place: &Placement) {
        let Placement { displacement: [x, y, z], rotation: [a, b, c, d], angle } = *place;
        if D == 3 {
            self.put(lane, end, [x, y, angle]);
        } else {
            self.put(lane, end, [x, y, z, a, b, c, d]);
        }
    }

    fn put<const N: usize>(&mut self, lane: usize, end: usize, pose: [f64; N]) {
        let mut at = end * N * self.lanes + lane;
        for number in pose {
            self.poses[at] = number;
            at += self.lanes;
        }
    }
}

/// Adds what the ends of members give, as work in lanes; without places to forces alone.
pub(super) struct AddEnds<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize> {
    pub chain: &'a Chain<T, B, D, P>,
    pub rows: &'a mut EndRows,
    pub joints: [usize; 2],
    pub places: Option<&'a EndPlaces>,
}

#[inline(always)]
fn add<T: Real>(rows: &mut [f64], row: usize, number: T) {
    let row = &mut rows[row * T::LANES..(row + 1) * T::LANES];
    (T::load(row) + number).store(row);
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for AddEnds<'_, T, B, D, P> {
    /// Squares of the largest force and moment.
    type Output = [f64; 2];

    #[inline(always)]
    fn run(self) -> [f64; 2] {
        let Self { chain, rows, joints, places } = self;
        let ends = &chain.ends;
        let mut largest = [T::zero(); 2];
        for (joint, force) in [(joints[0], &ends.r0), (joints[1], &ends.r1)] {
            let mut squares = [T::zero(); 2];
            for d in 0..D {
                add(&mut rows.forces, joint * D + d, force[d]);
                let kind = usize::from(d >= Chain::<T, B, D, P>::TRANSLATIONS);
                squares[kind] = squares[kind].plus(force[d], force[d]);
            }
            for kind in 0..2 {
                largest[kind] = largest[kind].max(squares[kind]);
            }
        }
        if let Some(places) = places {
            for d in 0..D {
                add(&mut rows.stiffness, joints[0] * D + d, ends.k00[d][d]);
                add(&mut rows.stiffness, joints[1] * D + d, ends.k11[d][d]);
            }
            for (block, places) in [&ends.k00, &ends.k01, &ends.k11].into_iter().zip(places) {
                let block = block.as_flattened();
                for &(place, row) in places {
                    add(&mut rows.values, row as usize, block[usize::from(place)]);
                }
            }
        }
        let mut squares = [0.0f64; 2];
        for lane in 0..T::LANES {
            for kind in 0..2 {
                squares[kind] = squares[kind].max(largest[kind].lane(lane));
            }
        }
        squares
    }
}

/// Puts the ends where joints are, as work in lanes.
pub(super) struct TakePoses<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize> {
    pub chain: &'a mut Chain<T, B, D, P>,
    pub poses: &'a [f64],
    pub joints: [usize; 2],
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for TakePoses<'_, T, B, D, P> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { chain, poses, joints } = self;
        let last = chain.state.nodes.len() - 1;
        let size = B::POSE * T::LANES;
        chain.state.nodes[0] = B::load_pose(&poses[joints[0] * size..(joints[0] + 1) * size]);
        chain.state.nodes[last] = B::load_pose(&poses[joints[1] * size..(joints[1] + 1) * size]);
    }
}

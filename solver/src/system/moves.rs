//! What the last increment of an iteration moved, and the first one.

use crate::chain::Size;
use crate::reduce::MAX_FREE;

/// Motions of the last increment, and how large they were.
#[derive(Debug)]
pub struct Moves {
    /// Size of the last increment, without what members and joints move as a whole with what carries them.
    pub own: Size,
    /// The same of the first increment of an iteration.
    pub first_own: f64,
    /// The largest angle (radians) by which the first increment of an iteration turned a joint that no member carries, beyond what turns
    /// it for certain.
    pub(crate) first_turn: f64,
    /// By how much each part of the network moved in the first increment of an iteration.
    pub first_by_part: Vec<Size>,
    /// By how much each part of the network moved in the last increment.
    pub(super) by_part: Vec<Size>,
    /// See [`Self::first_turn`], of the last increment.
    pub(super) turn: f64,
    /// Motions of all joints.
    pub(super) motions: Vec<[f64; 6]>,
    /// Moves of released rotations, by member.
    pub(super) releases: Vec<[f64; MAX_FREE]>,
}

impl Moves {
    /// Nothing has moved yet.
    pub(super) fn new(joints: usize, members: usize, parts: usize) -> Self {
        Self {
            own: Size::default(),
            first_own: 0.0,
            first_turn: 0.0,
            turn: 0.0,
            first_by_part: Vec::new(),
            by_part: vec![Size::default(); parts],
            motions: vec![[0.0; 6]; joints],
            releases: vec![[0.0; MAX_FREE]; members],
        }
    }

    /// The same in the memory at hand.
    pub(super) fn renew(&mut self) {
        (self.own, self.first_own) = (Size::default(), 0.0);
        (self.turn, self.first_turn) = (0.0, 0.0);
        self.first_by_part.clear();
        self.by_part.fill(Size::default());
        self.motions.fill([0.0; 6]);
        self.releases.fill([0.0; MAX_FREE]);
    }

    /// Notes what the last increment moved as the first of an iteration.
    pub(crate) fn note_first(&mut self) {
        self.first_own = self.own.largest();
        self.first_turn = self.turn;
        self.first_by_part.clone_from(&self.by_part);
    }

    /// How many parts the network has.
    pub fn parts(&self) -> usize {
        self.by_part.len()
    }

    /// The part of the network that moved farthest in the last increment.
    pub fn farthest_part(&self) -> Option<usize> {
        let size = |part: &usize| self.by_part[*part].largest();
        (0..self.by_part.len()).max_by(|a, b| size(a).total_cmp(&size(b)))
    }

    /// The largest of all parts in the last increment.
    pub(super) fn size(&self) -> Size {
        self.by_part.iter().copied().fold(Size::default(), Size::join)
    }
}

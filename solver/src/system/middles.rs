//! Members between joints that do not move: no joint tells what they do, and their middles stand for joints where a path is measured.

use pennate_elements::rotation::{compose, exp, inverse, log};
use pennate_elements::small::sub;

use super::{State, System};
use crate::chain::{Middle, middle};
use crate::structure::MemberId;

impl<const D: usize> System<D> {
    /// The members between joints that rows hold in all motions.
    pub(crate) fn out_of_sight(&self) -> Vec<MemberId> {
        let held = |node: &usize| self.pattern.equations.holds_all(self.topology.links[*node].joint);
        let members = self.structure.members.iter().enumerate();
        members.filter(|(_, member)| member.nodes.iter().all(held)).map(|(index, _)| index).collect()
    }

    /// Where the middles of members are.
    pub(crate) fn middles(&self, members: &[MemberId]) -> Vec<Middle> {
        let of = |&member: &MemberId| {
            let (pack, lane) = self.members.chain(member);
            middle(pack, lane)
        };
        members.iter().map(of).collect()
    }

    /// Motions of all joints since a state, and after them those of the middles of members out of sight.
    pub(crate) fn seen_since(&mut self, then: &State) -> Vec<[f64; 6]> {
        let mut motions = self.motions_since(then);
        let members = self.out_of_sight();
        if !members.is_empty() {
            let now = self.middles(&members);
            let then = self.middles_at(&members, then);
            motions.extend(between(&then, &now));
        }
        motions
    }

    /// Where the middles of members are in another state.
    pub(crate) fn middles_at(&mut self, members: &[MemberId], state: &State) -> Vec<Middle> {
        if members.is_empty() {
            return Vec::new();
        }
        let here = self.snapshot();
        self.restore(state);
        let middles = self.middles(members);
        self.restore(&here);
        middles
    }

    /// Where a step of the iteration at the last assembly carries the middles of members out of sight; the state stays as it is. Their
    /// ends move by what is held alone.
    pub(super) fn middles_ahead(&mut self, members: &[MemberId]) -> Vec<Middle> {
        let here = self.snapshot();
        self.move_by(&vec![0.0; self.tangent.rhs.len()], true);
        let there = self.middles(members);
        self.restore(&here);
        there
    }
}

/// Motions that lead middles from where they were to where they are: displacements, and spins in global axes.
pub(crate) fn between<'a>(then: &'a [Middle], now: &'a [Middle]) -> impl Iterator<Item = [f64; 6]> + 'a {
    now.iter().zip(then).map(|(now, then)| {
        let shift = sub(now.displacement, then.displacement);
        let [now, then] = [now, then].map(|middle| exp(middle.rotation_vector));
        let spin = log(compose(now, inverse(then)));
        [shift[0], shift[1], shift[2], spin[0], spin[1], spin[2]]
    })
}

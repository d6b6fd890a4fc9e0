//! Whether a negative pivot is a loss of stability, or what arithmetic leaves of a motion without stiffness.
//!
//! A motion that needs no force (a buckled round strut turns freely about its axis) has a pivot of either sign. Its
//! stiffness is zero but for two things. Rounding: a tangent is made by subtraction from the stiffness of single elements,
//! and keeps their unit in the last place. And the distance from equilibrium: along a motion u(s) that keeps the energy,
//! 0 = u'ᵀ K u' + r·u'', so that the residual r makes a stiffness of −r·u''. Both are added to the tangent of the joints;
//! what is negative still, by Sylvester's law of inertia, has a stiffness below zero by more than they can explain.
//! A third thing is what holds strains: the stress of a held strain is a number of its own, and where a motion turns the force N
//! that a member carries that stress has to follow, for which the stiffness C behind it takes N²/C, over the length, from the motion.
//! Nothing of this depends on how stiff other motions are: a stiff frame that sways softly is no neutral one.
//!
//! Theory: docs/theory/stability.md, Eq. 7.1 and 7.2.

use pennate_elements::beam::Ends;
use pennate_elements::small::norm;

use super::System;
use super::members::MemberSlot;
use super::tangent::Inertia;
use crate::chain::{MemberEnds, any};
use crate::linear::Pivots;
use crate::mechanism::NEAR;
use crate::reduce;
use crate::structure::Member;

/// Rounding of a stiffness, over the largest of the terms that it is the difference of: a unit in their last place.
const LAST_PLACE: f64 = f64::EPSILON;
/// Pivot within a member, over the diagonal entry it came from, whose sign rounding may hide: the elimination of some ten
/// elements leaves ten units in the last place in each of its ten operations.
const HIDDEN: f64 = 100.0 * f64::EPSILON;

/// Part of what is left of a stiffness that elements of the next order leave too, where the mesh tells that there is some.
const LEFT: f64 = 0.5;

/// Part of a motion's stiffness that rounding and the residual may have taken at most where they hide no sign: iterations that
/// look for the motion of which they take most are near it, and not at it.
const CLEAR: f64 = 1e-2;
/// Such iterations: a motion that so many of them do not single out takes hardly more than the one that they are at.
const LOOKS: usize = 6;

impl<const D: usize> System<D> {
    /// Negative pivots of the last assembly that neither rounding nor the residual explains.
    ///
    /// Costs two factorizations; the factors are those of the tangent again afterwards.
    pub fn certain_negative(&mut self) -> usize {
        let doubt = self.doubtful_stiffness();
        self.certain_within() + self.in_doubt(1.0, &doubt, |_, pivots| pivots.negative)
    }

    /// Negative pivots within members and of their released ends.
    fn certain_within(&self) -> usize {
        self.members.pivots().0 + self.tangent.released_negative
    }

    /// Whether rounding hides the sign of a stiffness of the unloaded structure, which has these pivots. Small ones may be rounding,
    /// and any where members meet a joint with released ends, which may leave it nothing else.
    pub fn hides_signs_at_rest(&mut self, at_rest: &Inertia) -> bool {
        (at_rest.smallest < NEAR || !self.structure.is_welded()) && self.hidden_signs() > 0
    }

    /// Motions of which rounding and the residual hide the sign of the stiffness at the last assembly, if none is negative for
    /// certain; zero where one is.
    ///
    /// Costs a few solves where the stiffness of every motion is far above what may have been taken from it, else two
    /// factorizations, and two more where there are any; the factors are those of the tangent again afterwards.
    pub(crate) fn hidden_signs(&mut self) -> usize {
        let lowest = |member: usize| {
            let (pack, lane) = self.members.chain(member);
            pack.interior(lane).smallest
        };
        let within = (0..self.members.count()).filter(|&member| lowest(member) <= HIDDEN).count();
        let doubt = self.doubtful_stiffness();
        if within == 0 && self.part_in_doubt(&doubt) <= CLEAR {
            return 0;
        }
        let hidden = self.in_doubt(-1.0, &doubt, |_, pivots| pivots.negative + pivots.neutral);
        let certain = |system: &mut Self| system.in_doubt(1.0, &doubt, |_, pivots| pivots.negative);
        let possible = within + hidden;
        if possible > 0 && self.certain_within() + certain(self) == 0 { possible } else { 0 }
    }

    /// Whether rounding may take a part of what bends the softest member as a whole, as on elements by the thousand whose held strains
    /// have a stiffness of their own, or beside members that are stiffer by far: what it hides then need be no motion without
    /// stiffness.
    pub(crate) fn may_hide_bending(&self) -> bool {
        let translations = self.pattern.equations.active.iter().filter(|component| **component < 3).count();
        let bare: Vec<_> = self.members.packs.iter().map(|pack| pack.bare_stiffness()).collect();
        let (mut softest, mut stiffest) = (f64::INFINITY, 0.0_f64);
        let mut bends_less = false;
        for (member, own) in self.structure.members.iter().enumerate().take(self.members.count()) {
            let slot = &self.members.slots[member];
            let sections = (0..own.segments.len()).map(|segment| self.section(member, segment).section);
            let bending = sections.map(|section| if D == 3 { section.ei3 } else { section.ei2.min(section.ei3) });
            let bending = bending.fold(f64::INFINITY, f64::min) / own.length().powi(3);
            let stiff = (0..translations).map(|i| bare[slot.pack][slot.lane][1][i][i].abs()).fold(0.0, f64::max);
            bends_less |= LAST_PLACE * stiff > CLEAR * bending;
            (softest, stiffest) = (softest.min(bending), stiffest.max(stiff));
        }
        // Sums in twice the digits leave every member its own.
        bends_less || !self.tangent.linear.is_wide() && LAST_PLACE * stiffest > CLEAR * softest
    }

    /// Whether elements of the next order, in the same state, leave no half of what is left of the stiffness here, of the network as a
    /// whole or of a member whose ends are held: what they change once more may be all of it. Both are stable.
    ///
    /// A state that is about to lose stability within a member shows at its ends alone, which answer to each other by one over the
    /// stiffness that is left. A motion that needs no force has none on any elements.
    pub(crate) fn is_far_stiffer(&mut self, refined: &mut Self) -> bool {
        let of_all = |system: &mut Self| system.tangent.singular_test_of_all(&system.pattern, system.size);
        let whole = of_all(self).zip(of_all(refined)).is_some_and(|(own, other)| other < LEFT * own);
        whole && self.hidden_signs() == 0
            || (0..self.members.count()).any(|member| self.is_far_stiffer_within(refined, member))
    }

    /// The same of one member.
    fn is_far_stiffer_within(&self, refined: &Self, member: usize) -> bool {
        let translations = self.pattern.equations.active.iter().filter(|component| **component < 3).count();
        let (own, other) = (self.members.condensed(member), refined.members.condensed(member));
        // Moments on both ends for turns of either.
        let turns = |ends: &MemberEnds<D>, [row, column]: [usize; 2]| match [row / D, column / D] {
            [0, 0] => ends.k00[row][column],
            [0, _] => ends.k01[row][column - D],
            [_, 0] => ends.k01[column][row - D],
            _ => ends.k11[row - D][column - D],
        };
        let rotations = || (0..2 * D).filter(|i| i % D >= translations);
        rotations().any(|row| {
            let entries = rotations().map(|column| [&own, &other].map(|ends| turns(ends, [row, column])));
            let (changed, all) = entries.fold((0.0, 0.0), |(changed, all), [own, other]| {
                (changed + f64::abs(own - other), all + f64::abs(other))
            });
            changed > (1.0 - LEFT) * all
        })
    }

    /// The largest part of the stiffness of a motion that may have been taken from it.
    ///
    /// That motion is looked for by iteration: x = K⁻¹ D x, with the stiffness D that may have been taken.
    fn part_in_doubt(&mut self, doubt: &[f64]) -> f64 {
        let size = self.tangent.linear.size();
        let mut x: Vec<f64> = (0..size).map(any).collect();
        let mut taken = vec![0.0; size];
        self.tangent.linear.apply_values(doubt, &x, &mut taken);
        let mut part = 0.0;
        for _ in 0..LOOKS {
            x.copy_from_slice(&taken);
            if !self.tangent.linear.solve(&mut x, 1) {
                return f64::INFINITY;
            }
            let stiffness: f64 = x.iter().zip(&taken).map(|(x, kx)| x * kx).sum();
            self.tangent.linear.apply_values(doubt, &x, &mut taken);
            let own: f64 = x.iter().zip(&taken).map(|(x, dx)| x * dx).sum();
            if own == 0.0 {
                return 0.0;
            }
            part = (own / stiffness).abs();
            let length = x.iter().map(|x| x * x).sum::<f64>().sqrt();
            taken.iter_mut().for_each(|dx| *dx /= length);
        }
        part
    }

    /// Pivots of the last assembly that need not be positive: they are not where all that rounding may have given to the stiffness is
    /// taken from it. `bare` is the stiffness of both ends of every member whose other nodes are held.
    ///
    /// Costs two factorizations; the factors are those of the tangent again afterwards.
    pub(crate) fn not_certainly_positive(&mut self, bare: &[[[[f64; D]; D]; 2]]) -> usize {
        let doubt = self.doubtful(bare, &[]);
        self.in_doubt(-1.0, &doubt, |_, pivots| pivots.negative + pivots.neutral)
    }

    /// What rounding and residual may change the value of [`super::Tangent::singular_test`] by at the last assembly.
    pub(crate) fn doubt(&mut self, b: &[f64]) -> Option<f64> {
        let here = self.tangent.singular_test(b)?;
        let doubt = self.rounded_stiffness();
        let there = self.in_doubt(1.0, &doubt, |system, _| system.tangent.singular_test(b))?;
        Some(there - here)
    }

    /// Looks at the factors of the tangent with so many times what may have been taken from it.
    fn in_doubt<R>(&mut self, times: f64, doubt: &[f64], look: impl FnOnce(&mut Self, Pivots) -> R) -> R {
        let linear = &mut self.tangent.linear;
        let (values, low) = (linear.values.clone(), linear.low.clone());
        doubt.iter().enumerate().for_each(|(position, doubt)| linear.add(position, times * doubt));
        let pivots = linear.factorize();
        let seen = look(self, pivots);
        (self.tangent.linear.values, self.tangent.linear.low) = (values, low);
        self.tangent.linear.factorize();
        seen
    }

    /// What rounding, held strains and the residual may have taken from the tangent, in the places of its values.
    pub(crate) fn doubtful_stiffness(&mut self) -> Vec<f64> {
        let taken = self.taken_by_held_strains();
        let bare = self.bare_stiffness();
        self.doubtful(&bare, &taken)
    }

    /// What rounding and the residual alone may have taken, where more than one stiffness of held strains is looked at.
    pub(crate) fn rounded_stiffness(&mut self) -> Vec<f64> {
        let bare = self.bare_stiffness();
        self.doubtful(&bare, &[])
    }

    /// The stiffness of both ends of every member whose other nodes are held.
    fn bare_stiffness(&self) -> Vec<[[[f64; D]; D]; 2]> {
        let packs: Vec<_> = self.members.packs.iter().map(|pack| pack.bare_stiffness()).collect();
        self.members.slots.iter().map(|slot| packs[slot.pack][slot.lane]).collect()
    }

    /// What may have been taken from the tangent, with that stiffness and what held strains take of each member.
    fn doubtful(&mut self, bare: &[[[[f64; D]; D]; 2]], taken: &[f64]) -> Vec<f64> {
        let zero = vec![0.0; self.tangent.linear.values.len()];
        let own: Vec<f64> = (0..self.tangent.linear.size()).map(|i| self.tangent.linear.diagonal(i).abs()).collect();
        let tangent = std::mem::replace(&mut self.tangent.linear.values, zero);
        let low = std::mem::take(&mut self.tangent.linear.low);
        // Sums in twice the digits are rounded by less than what they are made of.
        if low.is_empty() {
            self.tangent.linear.shift(LAST_PLACE, &own);
        }
        self.add_doubt(bare, taken);
        self.tangent.linear.low = low;
        std::mem::replace(&mut self.tangent.linear.values, tangent)
    }

    /// What the stiffness behind the held strains of every member takes at most from the stiffness of its ends against each other;
    /// nothing where no strain is held.
    fn taken_by_held_strains(&self) -> Vec<f64> {
        if !self.loading.holds_strains() {
            return Vec::new();
        }
        let translations = self.pattern.equations.active.iter().filter(|component| **component < 3).count();
        let forces: Vec<_> = self.members.packs.iter().map(|pack| pack.carried_forces()).collect();
        let of = |(slot, member): (&MemberSlot, &Member)| {
            let (pack, force) = (&self.members.packs[slot.pack], forces[slot.pack][slot.lane]);
            let moduli = (0..pack.mesh().segments()).map(|segment| pack.segment(slot.lane, segment).moduli);
            let held = moduli.flat_map(|moduli| (0..translations).map(move |i| (moduli.held[i], moduli.stiffness[i])));
            let softest = held.filter(|(held, _)| *held > 0.0).fold(f64::INFINITY, |soft, (_, own)| soft.min(own));
            force * force / (softest * member.length())
        };
        self.members.slots.iter().zip(&self.structure.members).map(of).collect()
    }

    /// Adds what rounding of members, held strains and the residual may have taken from the tangent.
    fn add_doubt(&mut self, bare: &[[[[f64; D]; D]; 2]], taken: &[f64]) {
        let active = self.pattern.equations.active;
        let translations = active.iter().filter(|component| **component < 3).count();
        for (index, bare) in bare.iter().enumerate() {
            let mut ends = doubtful_ends(bare, translations);
            let taken = taken.get(index).copied().unwrap_or(0.0);
            for i in 0..translations {
                ends.k00[i][i] += taken;
                ends.k01[i][i] -= taken;
                ends.k11[i][i] += taken;
            }
            let info = self.end_info(index, &[[0.0; 6]; 2]);
            let mut factor = self.tangent.releases[index];
            let reduced = reduce::reduce(&ends, &active, &info, Some(&mut factor));
            self.scatter_member(index, &reduced);
        }
        for joint in 0..self.tangent.forces.len() {
            let left = self.pattern.equations.unbalanced(joint, &self.tangent.forces[joint]);
            let force = norm([left[0], left[1], left[2]]);
            let turning = force * self.size + norm([left[3], left[4], left[5]]);
            let mut block = [[0.0; 6]; 6];
            for c in 0..3 {
                block[c][c] = force / self.size;
                block[c + 3][c + 3] = turning;
            }
            self.add_joint_block(joint, &block, None);
        }
    }
}

/// The rounding of a member's stiffness: on the motion of its ends against each other, since a member that moves as a whole
/// has none, and on their rotations. What a stiff direction that is no axis leaves in the entries of a row is lost to soft ones too.
fn doubtful_ends<const D: usize>(bare: &[[[f64; D]; D]; 2], translations: usize) -> Ends<f64, D> {
    let o = [[0.0; D]; D];
    let mut ends = Ends { k00: o, k01: o, k11: o, r0: [0.0; D], r1: [0.0; D] };
    for i in 0..translations {
        let own = LAST_PLACE * bare[1][i][..translations].iter().map(|entry| entry.abs()).sum::<f64>();
        (ends.k00[i][i], ends.k01[i][i], ends.k11[i][i]) = (own, -own, own);
    }
    for i in translations..D {
        ends.k00[i][i] = LAST_PLACE * bare[0][i][i];
        ends.k11[i][i] = LAST_PLACE * bare[1][i][i];
    }
    ends
}

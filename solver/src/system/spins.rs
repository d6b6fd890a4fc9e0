//! Whether straight bars that nothing keeps from turning about themselves would turn.
//!
//! Such a bar is kept from it, since no force resists or wants it as long as the bar is straight ([`Line`]). Bent by a load
//! across it a bar that is stiffer in one direction than in the other does want it: a strip on edge between pins turns flat. What it is
//! kept by bears nothing where it stands on edge exactly, so that the balance does not tell; the second variation does. With the
//! spins s of all such bars free as well, and the rest of the network f, the energy has the stiffness S = K_ss − K_sf K_ff⁻¹ K_fs against
//! them. Where K_ff is positive, the negative pivots of the whole are those of S, so the same tangent is put together with these spins
//! free, and a weak spring against each: a straight bar has no stiffness of its own there, and rounding makes one of either sign.
//!
//! Theory: docs/theory/joints.md, motions that nothing resists.

use std::sync::Arc;

use pennate_elements::rotation::{Quaternion, compose, inverse, log, turn};
use pennate_elements::small::{V3, dot, scale};

use super::{Places, System};
use crate::chain::MemberEnds;
use crate::joints::{Kept, Line};
use crate::structure::MemberId;

/// The spring against the spin of a bar, over EI/L: a bar that a load bends by the sag w is turned by about 48 (w/L)² EI/L.
const WEAK: f64 = 1e-12;
/// Parts of the largest stiffness at the end of a bar, times L², that rounding may make of the spin of a joint, and of that of a released
/// end, which is eliminated with the bar and is not looked at for its rounding: buckled strips, which turn freely about the line between
/// their ends, show up to a tenth of it.
const ROUNDING: [f64; 2] = [1e2 * f64::EPSILON, 1e5 * f64::EPSILON];
/// Moment over EI/L that bends a bar no more than rounding does.
const STRAIGHT: f64 = 1e-6;
/// Angle (radians) that the springs are wound by, to see which bars are turned with them and which against.
const WOUND: f64 = 1e-6;

/// A line of bars that is free to spin against a weak spring.
#[derive(Clone, Debug)]
pub(crate) struct Spinning {
    bars: Vec<MemberId>,
    /// Along the line, unloaded: unit vector in global axes.
    axis: V3<f64>,
    /// Moment for a radian.
    stiffness: f64,
    /// What the spring is wound by (radians).
    wound: f64,
}

impl<const D: usize> System<D> {
    /// Whether a bar that is kept from turning about itself is bent at the present state, and not alike in all directions.
    pub fn may_spin(&self) -> bool {
        !self.lines_that_may_spin().is_empty()
    }

    fn lines_that_may_spin(&self) -> Vec<Line> {
        let mut lines = self.topology.kept_lines(&self.structure);
        lines.retain(|line| {
            line.bars.iter().any(|&bar| !self.bends_alike(bar)) && line.bars.iter().any(|&bar| self.is_bent(bar))
        });
        lines
    }

    /// Whether a moment bends a member.
    fn is_bent(&self, index: usize) -> bool {
        let member = &self.structure.members[index];
        let (pack, lane) = self.members.chain(index);
        let most = STRAIGHT * self.bending_of(index) * member.length() * member.length();
        let moments = if D == 3 { 2..3 } else { 4..6 };
        let mut elements = 0..member.segments.iter().map(|segment| segment.elements.max(1)).sum();
        let bends = |element: usize| {
            let stress = pack.stress(lane, element);
            stress.iter().flat_map(|node| &node[moments.clone()]).any(|moment| moment.abs() > most)
        };
        elements.any(bends)
    }

    /// Puts weak springs against the spins of bars that may turn about themselves in place of what keeps them.
    fn let_spin(&mut self) {
        let lines = self.lines_that_may_spin();
        self.topology = Arc::new(self.topology.let_spin(&lines));
        self.spinning = lines.into_iter().map(|line| (line.kept, self.spinning_line(line))).collect();
        let held = self.held();
        self.pattern.hold(&self.topology, held, true);
        self.analyse();
    }

    fn spinning_line(&self, Line { bars, kept }: Line) -> Spinning {
        let rounding = ROUNDING[usize::from(matches!(kept, Kept::End(..)))];
        let own = |&bar: &MemberId| {
            let MemberEnds { k00, .. } = self.members.condensed(bar);
            let stiffest = (0..3).map(|i| k00[i][i].abs()).fold(0.0, f64::max);
            let length = self.structure.members[bar].length();
            (WEAK * self.bending_of(bar) + rounding * stiffest) * length * length
        };
        let stiffness = bars.iter().map(own).fold(0.0, f64::max);
        let axis = self.structure.members[bars[0]].axes[0];
        Spinning { bars, axis, stiffness, wound: 0.0 }
    }

    /// Adds the weak springs to the ends of a member that is free to spin there.
    pub(super) fn add_spins_of_member(&self, index: usize, ends: &mut MemberEnds<D>) {
        if D != 6 {
            return;
        }
        for end in 0..2 {
            let kept = Kept::End(index, end);
            let Some(spinning) = self.spinning.get(&kept) else { continue };
            let [moment, stiffness] = self.spin_spring(kept, spinning);
            let (block, force) = if end == 0 { (&mut ends.k00, &mut ends.r0) } else { (&mut ends.k11, &mut ends.r1) };
            for i in 0..3 {
                force[3 + i] += moment[i];
                for j in 0..3 {
                    block[3 + i][3 + j] += stiffness[i] * stiffness[j];
                }
            }
        }
    }

    /// Adds those on joints.
    pub(super) fn add_spins_of_joints(&mut self) {
        let all = std::mem::take(&mut self.spinning);
        for (&kept, spinning) in &all {
            let Kept::Joint(joint) = kept else { continue };
            let [moment, stiffness] = self.spin_spring(kept, spinning);
            let mut block = [[0.0; 6]; 6];
            for i in 0..3 {
                self.tangent.forces[joint][3 + i] += moment[i];
                for j in 0..3 {
                    block[3 + i][3 + j] = stiffness[i] * stiffness[j];
                }
            }
            self.add_joint_block(joint, &block, None);
        }
        self.spinning = all;
    }

    /// The moment of a weak spring on what it is at, and the vector whose square is its stiffness.
    fn spin_spring(&self, kept: Kept, spinning: &Spinning) -> [V3<f64>; 2] {
        let along = turn(self.places.rotation_of(kept), spinning.axis);
        [scale(-spinning.stiffness * spinning.wound, along), scale(spinning.stiffness.sqrt(), along)]
    }
}

impl Places {
    /// The rotation of what a line is kept from spinning at.
    fn rotation_of(&self, kept: Kept) -> Quaternion<f64> {
        match kept {
            Kept::End(bar, end) => self.releases[bar][end].rotation,
            Kept::Joint(joint) => self.joints[joint].place.rotation,
        }
    }
}

/// What bars would do at an equilibrium, had they not been kept from turning about themselves.
#[derive(Clone, Debug, Default)]
pub struct Spins {
    /// So many motions of them have a stiffness below zero.
    pub motions: usize,
    /// The bars of lines that would turn.
    pub members: Vec<MemberId>,
}

/// Finds that at the state of a system, which does not serve for anything else any more.
pub(crate) fn spins_of(system: &mut System<6>) -> Spins {
    let known = system.tangent.inertia().negative;
    system.let_spin();
    let negative = system.assemble(false).negative.min(system.certain_negative());
    let motions = negative.saturating_sub(known);
    if motions == 0 {
        return Spins::default();
    }
    // A wound spring turns a bar with it, but for one that wants to turn: that goes against it.
    system.spinning.values_mut().for_each(|spinning| spinning.wound = WOUND);
    system.assemble(false);
    let before = system.places.clone();
    let solved = system.advance(system.pattern.equations.has_general()).is_some();
    let goes_against = |(kept, spinning): &(&Kept, &Spinning)| {
        let [then, now] = [&before, &system.places].map(|places| places.rotation_of(**kept));
        dot(log(compose(now, inverse(then))), turn(then, spinning.axis)) < 0.0
    };
    let lines = system.spinning.iter();
    let bars = |(_, spinning): (&Kept, &Spinning)| spinning.bars.clone();
    let mut members: Vec<MemberId> = lines.clone().filter(|line| solved && goes_against(line)).flat_map(bars).collect();
    if members.is_empty() {
        members = lines.flat_map(bars).collect();
    }
    Spins { motions, members }
}

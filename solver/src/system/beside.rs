//! How much the network resists beside members that cannot be stretched, or hardly.
//!
//! The auxiliary stiffness of such a member has to be large beside what gives way when its ends are drawn together, and that is the rest of the
//! network: a wire of a hundredth of the radius of the column that it stays has 10⁻⁸ of its bending stiffness, and 10⁸ times that would be no
//! stay at all.

use crate::joints::Topology;
use crate::packs;
use crate::spring::Spring;
use crate::structure::{Dimension, Member, SectionState, Structure};

/// So many times as stiff as what its ends are held by, across its length too, an auxiliary stiffness may be: rounding of it takes digits of
/// that where the member lies across the axes. With ten times as much the critical load of a portal whose beam is 10⁷ times as stiff as its
/// columns loses the seventh digit.
const ROUNDED: f64 = 1e9;

/// The force with which the network answers when the ends of a member come nearer by all of its length, if only bending gives way,
/// for members that cannot be stretched, or hardly; zero for others.
///
/// Wires in a row are one: what the first is tied to is felt by the last.
pub(super) fn forces_beside(structure: &Structure, topology: &Topology) -> Vec<f64> {
    let mut forces = vec![0.0; structure.members.len()];
    let states: Vec<SectionState> = structure.laws.iter().map(|law| law.at(0.0)).collect();
    let sections: Vec<Section> = structure.members.iter().map(|member| Section::of(&states, member)).collect();
    if !sections.iter().any(|section| section.is_hard) {
        return forces;
    }
    let joints = Joints::of(structure, topology, &sections);
    let largest = joints.felt(structure, &sections);
    let held = joints.held(structure, &sections);
    for ((force, member), _) in forces.iter_mut().zip(&structure.members).zip(&sections).filter(|(_, own)| own.is_hard)
    {
        let length = member.length();
        let ends = member.nodes.map(|node| topology.links[node].joint);
        let free = ends.into_iter().filter(|&joint| !joints.fixed[joint]);
        let most = free.clone().map(|joint| largest[joint]).fold(0.0, f64::max);
        let least = free.map(|joint| held[joint]).fold(f64::INFINITY, f64::min);
        *force = length * most.min(ROUNDED / packs::AUXILIARY.carried * least);
    }
    forces
}

/// What counts of the section of a member, without its control.
struct Section {
    bending: f64,
    /// Whether it cannot be stretched, or hardly.
    is_hard: bool,
}

impl Section {
    /// With the states of all laws without their control.
    fn of(states: &[SectionState], member: &Member) -> Self {
        let mut found = Self { bending: 0.0, is_hard: false };
        let length = member.length();
        for segment in &member.segments {
            let state = &states[segment.law];
            found.bending = found.bending.max(state.section.ei2.max(state.section.ei3));
            found.is_hard |= packs::is_hard_to_stretch(state, length);
        }
        found
    }
}

/// The joints of a network.
struct Joints<'a> {
    topology: &'a Topology,
    /// Whether a support fixes its place.
    fixed: Vec<bool>,
    /// By how much members and springs resist its displacement, if only bending gives way and all other joints are held.
    stiffness: Vec<f64>,
    /// By how much springs to the ground do.
    grounded: Vec<f64>,
}

impl<'a> Joints<'a> {
    fn of(structure: &Structure, topology: &'a Topology, sections: &[Section]) -> Self {
        let count = topology.references.len();
        let joint = |node: usize| topology.links[node].joint;
        let translations = if structure.dimension == Dimension::Space { 3 } else { 2 };
        let mut fixed = vec![false; count];
        for support in &structure.supports {
            fixed[joint(support.node)] |= support.fixed[..translations].iter().all(|&fixed| fixed);
        }
        let (mut stiffness, mut grounded) = (vec![0.0; count], vec![0.0; count]);
        for (member, section) in structure.members.iter().zip(sections) {
            for node in member.nodes {
                stiffness[joint(node)] += bends(member, section);
            }
        }
        for spring in &structure.springs {
            let own = match spring {
                Spring::Axial { stiffness, .. } => *stiffness,
                Spring::Ground { stiffness, .. } | Spring::Coupling { stiffness, .. } => {
                    stiffness[..3].iter().copied().fold(0.0, f64::max)
                }
            };
            for &node in spring.nodes() {
                stiffness[joint(node)] += own;
            }
            if let Spring::Ground { node, .. } = spring {
                grounded[joint(*node)] += own;
            }
        }
        Self { topology, fixed, stiffness, grounded }
    }

    fn ends(&self, member: &Member) -> [usize; 2] {
        member.nodes.map(|node| self.topology.links[node].joint)
    }

    /// The largest resistance of a joint that members that cannot be stretched lead to, which they do no farther than to what is fixed.
    fn felt(&self, structure: &Structure, sections: &[Section]) -> Vec<f64> {
        let own = |(stiffness, fixed): (&f64, &bool)| if *fixed { 0.0 } else { *stiffness };
        let mut felt: Vec<f64> = self.stiffness.iter().zip(&self.fixed).map(own).collect();
        let mut spreads = true;
        while std::mem::take(&mut spreads) {
            for (member, _) in structure.members.iter().zip(sections).filter(|(_, section)| section.is_hard) {
                let ends = self.ends(member);
                let most = felt[ends[0]].max(felt[ends[1]]);
                for end in ends.into_iter().filter(|&end| !self.fixed[end]) {
                    spreads |= felt[end] < most;
                    felt[end] = felt[end].max(most);
                }
            }
        }
        felt
    }

    /// By how much every joint is held by the stiffest way of members in bending from what is fixed.
    fn held(&self, structure: &Structure, sections: &[Section]) -> Vec<f64> {
        let own = |(grounded, fixed): (&f64, &bool)| if *fixed { f64::INFINITY } else { *grounded };
        let mut held: Vec<f64> = self.grounded.iter().zip(&self.fixed).map(own).collect();
        let mut spreads = true;
        while std::mem::take(&mut spreads) {
            for (member, section) in structure.members.iter().zip(sections) {
                let [a, b] = self.ends(member);
                for (from, to) in [(a, b), (b, a)] {
                    let by = 1.0 / (1.0 / held[from] + 1.0 / bends(member, section));
                    spreads |= held[to] < by;
                    held[to] = held[to].max(by);
                }
            }
        }
        held
    }
}

/// The resistance of a member to a displacement of one end across the other.
fn bends(member: &Member, section: &Section) -> f64 {
    12.0 * section.bending / member.length().powi(3)
}

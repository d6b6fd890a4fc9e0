//! Numbers wanted by name at every increment.

use std::sync::Arc;

use nalgebra::{Matrix3, Rotation3, Vector3};
use pennate_elements::section::Section;
use pennate_solver::history::{Equilibrium, SectionForces};
use pennate_solver::structure::{ComplianceOf, MemberId, NodeId};

use crate::expression::Expression;
use crate::hsim::{Muscle, Part};
use crate::section::Shape;

/// The probes of a network, in the order of the file.
#[derive(Clone, Debug, Default)]
pub struct Probes {
    /// As the file has them.
    pub names: Vec<String>,
    pub(crate) probes: Vec<Probe>,
    /// Indices of all probes, each after those that it needs.
    pub(crate) order: Vec<usize>,
    /// In the plane rotations are counted over whole turns.
    pub(crate) in_plane: bool,
}

/// What a probe measures.
#[derive(Clone, Debug)]
pub enum Probe {
    /// Displacement along a unit direction.
    Displacement {
        /// The node.
        node: NodeId,
        /// Unit direction in global axes.
        direction: [f64; 3],
    },
    /// Coordinate along a unit direction.
    Position {
        /// The node.
        node: NodeId,
        /// Where the node, or the second node seen from the first, is unloaded.
        unloaded: [f64; 3],
        /// Unit direction in global axes.
        direction: [f64; 3],
    },
    /// Component of the rotation vector, degrees; in the plane the total angle.
    Rotation {
        /// The node.
        node: NodeId,
        /// 0, 1, 2: about x, y, z.
        axis: usize,
    },
    /// Norm of the rotation vector, degrees; in the plane the size of the total angle.
    Angle {
        /// The node.
        node: NodeId,
    },
    /// Force of the support on the structure along a unit direction.
    ReactionForce {
        /// The node.
        node: NodeId,
        /// Unit direction in global axes.
        direction: [f64; 3],
    },
    /// Moment of the support on the structure about a global axis.
    ReactionMoment {
        /// The node.
        node: NodeId,
        /// 0, 1, 2: about x, y, z.
        axis: usize,
    },
    /// Angle by which a direction of a body has turned, degrees.
    Tilt {
        /// Reference node of the body.
        reference: NodeId,
        /// Unit direction, unloaded, in global axes.
        normal: [f64; 3],
    },
    /// Distance of two nodes; `unloaded` is the vector between them.
    Distance {
        /// Both nodes.
        nodes: [NodeId; 2],
        /// Where the node, or the second node seen from the first, is unloaded.
        unloaded: [f64; 3],
    },
    /// Axial force in a member, positive in tension.
    AxialForce {
        /// Index of the member.
        member: usize,
        /// Where along it.
        place: AxialPlace,
    },
    /// The greatest value along some members, in material axes.
    Greatest {
        /// What is greatest.
        quantity: Quantity,
        /// Along which members.
        members: Vec<Along>,
    },
    /// Force (or moment) along a direction of a node for a unit of displacement (or a radian) along it, with everything
    /// else free to follow; or the inverse of that. `index` counts the probes of this kind.
    Stiffness {
        /// Number of the probe among those of this kind.
        index: usize,
        /// The node.
        node: NodeId,
        /// Unit displacement (0, 1, 2) or rotation (3, 4, 5) in global axes.
        along: [f64; 6],
        /// The compliance instead.
        inverse: bool,
    },
    /// An expression of other values.
    Expression {
        /// Over the operands, by their place.
        expression: Arc<Expression>,
        /// What it refers to.
        operands: Vec<Operand>,
    },
}

/// Where a member's axial force is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxialPlace {
    /// At its first node.
    Start,
    /// In its middle.
    Middle,
    /// At its second node.
    End,
}

/// What is greatest somewhere along a member.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Stress of the outermost fibre, |N|/A and bending together.
    Stress,
    /// Stress of the outermost fibre by bending alone.
    BendingStress,
    /// Strain of the outermost fibre, that of the axis and bending together, without what is induced.
    Strain,
    /// Strain of the outermost fibre by bending alone.
    BendingStrain,
    /// Bending moment about axes 2 and 3 together.
    Moment,
}

/// A member whose section forces a probe looks at.
#[derive(Clone, Debug)]
pub struct Along {
    /// Index of the member.
    pub member: usize,
    /// Index among the members whose sections are wanted.
    pub index: usize,
    /// What its segments are made of.
    pub segments: Vec<Matter>,
    /// Own components of a vector are this matrix times those in the axes that the network is solved in.
    pub turn: Matrix3<f64>,
}

/// What stresses and strains of a segment follow from.
#[derive(Clone, Debug)]
pub enum Matter {
    /// A section that does not change, and its shape where it has one.
    Fixed {
        /// Its stiffnesses.
        section: Section,
        /// Its outermost fibres, where it has a shape.
        shape: Option<Shape>,
    },
    /// A part of a muscle.
    Muscle {
        /// The muscle.
        muscle: Arc<Muscle>,
        /// Its end or its middle.
        part: Part,
    },
}

impl Matter {
    fn at(&self, control: f64) -> (Section, Option<Shape>) {
        match self {
            Self::Fixed { section, shape } => (*section, *shape),
            Self::Muscle { muscle, part } => {
                let (section, shape) = muscle.part(*part, control);
                (section, Some(shape))
            }
        }
    }
}

impl Quantity {
    /// Value at a place; not a number where the shape of the section is not known and would have to be.
    fn at(self, forces: &SectionForces, matter: &Matter, turn: &Matrix3<f64>, control: f64) -> f64 {
        let moment = turn * Vector3::from(forces.moment);
        let bent = [moment.y, moment.z];
        if self == Self::Moment {
            return bent[0].hypot(bent[1]);
        }
        let (section, Some(shape)) = matter.at(control) else { return f64::NAN };
        let axial = forces.force[0].abs();
        let strain = || shape.fibres.strain([bent[0] / section.ei2, bent[1] / section.ei3]);
        match self {
            Self::Stress => axial / shape.area + shape.bending_stress(bent),
            Self::BendingStress => shape.bending_stress(bent),
            Self::Strain => axial / section.ea + strain(),
            Self::BendingStrain | Self::Moment => strain(),
        }
    }

    /// The greatest value along a member. Between neighbouring places forces and moments are those of cubics through four of them, at
    /// the ends of a segment too: a moment may be greatest right beside a pin.
    fn greatest(self, along: &[SectionForces], observed: &Along, control: f64) -> f64 {
        let value = |at: &SectionForces| self.at(at, &observed.segments[at.segment], &observed.turn, control);
        // Stretches of elements of other lengths meet in a place that both have.
        let mut places: Vec<&SectionForces> = along.iter().collect();
        places.dedup_by(|next, last| next.segment == last.segment && next.at <= last.at);
        let values: Vec<f64> = places.iter().map(|at| value(at)).collect();
        let mut greatest = values.iter().copied().fold(f64::NAN, f64::max);
        let near = NEAR_GREATEST * greatest;
        // What is greater than at any place, as the segment's places, the place after it, and the part of the way there.
        let mut top: Option<(&[&SectionForces], usize, f64)> = None;
        let mut rest = values.as_slice();
        for places in places.chunk_by(|a, b| a.segment == b.segment) {
            let (values, others) = rest.split_at(places.len());
            rest = others;
            for index in 1..places.len() {
                if values[index].max(values[index - 1]) < near {
                    continue;
                }
                let sample = |part: usize| match part {
                    0 => values[index - 1],
                    BETWEEN => values[index],
                    _ => value(&between(places, index, part as f64 / BETWEEN as f64)),
                };
                let samples: [f64; BETWEEN + 1] = std::array::from_fn(sample);
                for (first, three) in samples.windows(3).enumerate() {
                    let (part, highest) = highest(three);
                    if highest > greatest {
                        greatest = highest;
                        top = Some((places, index, (first as f64 + 1.0 + part) / BETWEEN as f64));
                    }
                }
            }
        }
        let Some((places, index, mut part)) = top else { return greatest };
        // A parabola through places so far apart is off by what it leaves out: from nearer it is looked at until that is nothing.
        let mut apart = 1.0 / BETWEEN as f64;
        for _ in 0..NEARER {
            apart /= BETWEEN as f64;
            let three = [-1.0, 0.0, 1.0].map(|side| value(&between(places, index, part + side * apart)));
            let (aside, highest) = highest(&three);
            part = (part + aside * apart).clamp(0.0, 1.0);
            greatest = highest;
        }
        greatest
    }
}

/// How often a greatest value is looked at from nearer by so many times: what is left is the fourth power of 1/512.
const NEARER: usize = 2;
/// Places between two neighbouring ones that are looked at, and the part of the greatest value at any place that both must be below
/// where the greatest of all is not looked for between them.
const BETWEEN: usize = 8;
const NEAR_GREATEST: f64 = 0.8;

/// Forces and moments at a part of the way to a place from the one before it: those of the cubic through these two and one to either
/// side, or two to one side.
fn between(places: &[&SectionForces], index: usize, part: f64) -> SectionForces {
    let most = places.len().min(4);
    let first = (index.max(2) - 2).min(places.len() - most);
    let window = &places[first..first + most];
    let [from, to] = [places[index - 1].at, places[index].at];
    let at = from + part * (to - from);
    let mut sum = SectionForces { at, force: [0.0; 3], moment: [0.0; 3], ..*places[index] };
    for own in window {
        let others = window.iter().filter(|other| other.at != own.at);
        let weight: f64 = others.map(|other| (at - other.at) / (own.at - other.at)).product();
        for component in 0..3 {
            sum.force[component] += weight * own.force[component];
            sum.moment[component] += weight * own.moment[component];
        }
    }
    sum
}

/// Where the parabola through three equally spaced values is highest, from the first to the last of them, in spacings from that in the
/// middle, and its value there.
fn highest(values: &[f64]) -> (f64, f64) {
    let [before, here, after] = [values[0], values[1], values[2]];
    let (slope, curvature) = (0.5 * (after - before), before - 2.0 * here + after);
    if curvature < 0.0 && slope.abs() < -curvature {
        return (-slope / curvature, here - 0.5 * slope * slope / curvature);
    }
    if before > after { (-1.0, before) } else { (1.0, after) }
}

/// What an expression of probes refers to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Operand {
    /// A parameter by its value.
    Parameter(f64),
    /// Another probe by its place.
    Probe(usize),
    /// The value of a probe after a step.
    After {
        /// Index of the probe.
        probe: usize,
        /// Index of the step.
        step: usize,
    },
}

/// What kind of quantity a probe gives, for judging its error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProbeKind {
    /// In units of length.
    Displacement,
    /// In degrees.
    Rotation,
    /// Force.
    Force,
    /// Moment.
    Moment,
    /// The greatest along a member, which no accuracy is asked of.
    GreatestMoment,
    /// Stress.
    Stress,
    /// No unit.
    Strain,
    /// An expression: no kind of its own.
    Other,
}

impl Probe {
    /// The members whose section forces the probe asks for.
    fn along(&self) -> &[Along] {
        match self {
            Self::Greatest { members, .. } => members,
            _ => &[],
        }
    }
}

impl ProbeKind {
    /// Whether the accuracy asked for is asked of such probes.
    pub fn is_asked(self) -> bool {
        !matches!(self, Self::GreatestMoment | Self::Stress | Self::Strain | Self::Other)
    }
}

impl Probes {
    /// Whether nothing is wanted by name.
    pub fn is_empty(&self) -> bool {
        self.probes.is_empty()
    }

    /// Number of probes.
    pub fn len(&self) -> usize {
        self.probes.len()
    }

    /// Whether a probe is one of stiffness or compliance.
    pub fn is_stiffness(&self, probe: usize) -> bool {
        self.compliance(probe).is_some()
    }

    /// The place of a probe among those of stiffness and compliance, and whether it gives the compliance; `None` for any other.
    pub fn compliance(&self, probe: usize) -> Option<(usize, bool)> {
        match self.probes[probe] {
            Probe::Stiffness { index, inverse, .. } => Some((index, inverse)),
            _ => None,
        }
    }

    /// Whether any probe asks for what is measured along members: axial forces, but not sections.
    pub fn measure_members(&self) -> bool {
        self.probes.iter().any(|probe| matches!(probe, Probe::AxialForce { .. }))
    }

    /// The nodes whose compliance the probes ask for, in the order of their indices.
    pub fn compliances(&self) -> Vec<ComplianceOf> {
        let of = |probe: &Probe| match *probe {
            Probe::Stiffness { node, along, .. } => Some(ComplianceOf { node, along }),
            _ => None,
        };
        self.probes.iter().filter_map(of).collect()
    }

    /// The members whose section forces the probes ask for, in the order of their indices.
    pub fn sections(&self) -> Vec<MemberId> {
        let mut all: Vec<(usize, MemberId)> =
            self.observed().map(|observed| (observed.index, observed.member)).collect();
        all.sort_unstable();
        all.dedup();
        all.into_iter().map(|(_, member)| member).collect()
    }

    fn observed(&self) -> impl Iterator<Item = &Along> {
        self.probes.iter().flat_map(Probe::along)
    }

    /// Says how the axes that a network is solved in lie in the members' own.
    pub(crate) fn set_turns(&mut self, turn: impl Fn(MemberId) -> Matrix3<f64>) {
        for probe in &mut self.probes {
            if let Probe::Greatest { members, .. } = probe {
                members.iter_mut().for_each(|observed| observed.turn = turn(observed.member));
            }
        }
    }

    /// Kind of the quantity that a probe gives.
    pub fn kind(&self, probe: usize) -> ProbeKind {
        match self.probes[probe] {
            Probe::Displacement { .. } | Probe::Position { .. } | Probe::Distance { .. } => ProbeKind::Displacement,
            Probe::Rotation { .. } | Probe::Angle { .. } | Probe::Tilt { .. } => ProbeKind::Rotation,
            Probe::ReactionForce { .. } | Probe::AxialForce { .. } => ProbeKind::Force,
            Probe::ReactionMoment { .. } => ProbeKind::Moment,
            Probe::Greatest { quantity: Quantity::Moment, .. } => ProbeKind::GreatestMoment,
            Probe::Greatest { quantity: Quantity::Stress | Quantity::BendingStress, .. } => ProbeKind::Stress,
            Probe::Greatest { .. } => ProbeKind::Strain,
            Probe::Stiffness { .. } | Probe::Expression { .. } => ProbeKind::Other,
        }
    }

    /// Values of all probes in an equilibrium, in order. Angles are degrees.
    ///
    /// `after` holds the values after each finished step, which `name@step` looks up. While that step is under
    /// way the present value stands for it; before it the value is not a number.
    pub fn evaluate(&self, state: &Equilibrium, after: &[Vec<f64>]) -> Vec<f64> {
        let mut values = vec![f64::NAN; self.probes.len()];
        for &index in &self.order {
            values[index] = match &self.probes[index] {
                Probe::Expression { expression, operands } => {
                    let operands: Vec<f64> = operands.iter().map(|operand| operand.value(&values, after)).collect();
                    expression.value(&operands)
                }
                probe => self.measure(probe, state),
            };
        }
        values
    }

    fn measure(&self, probe: &Probe, state: &Equilibrium) -> f64 {
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        match *probe {
            Probe::Displacement { node, direction } => dot(state.nodes[node].displacement, direction),
            Probe::Position { node, unloaded, direction } => {
                dot(unloaded, direction) + dot(state.nodes[node].displacement, direction)
            }
            Probe::Rotation { node, axis: 2 } if self.in_plane => state.nodes[node].rotation_total.to_degrees(),
            Probe::Rotation { node, axis } => state.nodes[node].rotation[axis].to_degrees(),
            Probe::Angle { node } if self.in_plane => state.nodes[node].rotation_total.abs().to_degrees(),
            Probe::Angle { node } => Vector3::from(state.nodes[node].rotation).norm().to_degrees(),
            Probe::ReactionForce { node, direction } => dot(state.nodes[node].reaction_force, direction),
            Probe::ReactionMoment { node, axis } => state.nodes[node].reaction_moment[axis],
            Probe::Tilt { reference, normal } => {
                let normal = Vector3::from(normal);
                let turned = Rotation3::from_scaled_axis(state.nodes[reference].rotation.into()) * normal;
                normal.cross(&turned).norm().atan2(normal.dot(&turned)).to_degrees()
            }
            Probe::Distance { nodes: [first, second], unloaded } => {
                let moved =
                    Vector3::from(state.nodes[second].displacement) - Vector3::from(state.nodes[first].displacement);
                (Vector3::from(unloaded) + moved).norm()
            }
            Probe::AxialForce { member, place } => match place {
                AxialPlace::Start => state.members[member].axial_force_ends[0],
                AxialPlace::Middle => state.members[member].axial_force,
                AxialPlace::End => state.members[member].axial_force_ends[1],
            },
            Probe::Greatest { quantity, ref members } => {
                let of = |observed: &Along| {
                    let along = state.sections.get(observed.index).map_or(&[][..], Vec::as_slice);
                    quantity.greatest(along, observed, state.members[observed.member].control)
                };
                members.iter().map(of).fold(f64::NAN, f64::max)
            }
            Probe::Stiffness { index, along, inverse, .. } => {
                let compliance = state.compliances.get(index).map_or(f64::NAN, |columns| {
                    (0..6).map(|c| (0..6).map(|r| along[r] * columns[c][r]).sum::<f64>() * along[c]).sum()
                });
                if inverse { compliance } else { 1.0 / compliance }
            }
            Probe::Expression { .. } => f64::NAN,
        }
    }
}

impl Operand {
    pub(crate) fn value(self, values: &[f64], after: &[Vec<f64>]) -> f64 {
        match self {
            Self::Parameter(value) => value,
            Self::Probe(probe) => values[probe],
            Self::After { probe, step } if step == after.len() => values[probe],
            Self::After { probe, step } => after.get(step).map_or(f64::NAN, |values| values[probe]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pennate_solver::history::NodeState;

    fn probes(probes: Vec<Probe>, in_plane: bool) -> Probes {
        let order = (0..probes.len()).collect();
        Probes { names: vec![String::new(); probes.len()], probes, order, in_plane }
    }

    #[test]
    fn angles_are_degrees() {
        let node = NodeState { rotation: [0.0, 0.3, 0.4], rotation_total: -7.0, ..NodeState::default() };
        let state = Equilibrium { nodes: vec![node], ..Equilibrium::default() };
        let all = vec![
            Probe::Rotation { node: 0, axis: 2 },
            Probe::Angle { node: 0 },
            Probe::Tilt { reference: 0, normal: [1.0, 0.0, 0.0] },
        ];
        let degrees = 180.0 / std::f64::consts::PI;
        let space = probes(all.clone(), false).evaluate(&state, &[]);
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        near(space[0], 0.4 * degrees);
        near(space[1], 0.5 * degrees);
        near(space[2], 0.5 * degrees);
        let plane = probes(all, true).evaluate(&state, &[]);
        near(plane[0], -7.0 * degrees);
        near(plane[1], 7.0 * degrees);
    }

    #[test]
    fn a_value_after_a_step_is_kept() {
        let twice = Expression::parse("2 * a").unwrap();
        let expression =
            Probe::Expression { expression: twice.into(), operands: vec![Operand::After { probe: 0, step: 1 }] };
        let probes = probes(vec![Probe::Displacement { node: 0, direction: [0.0, 1.0, 0.0] }, expression], true);
        let node = NodeState { displacement: [0.0, 3.0, 0.0], ..NodeState::default() };
        let state = Equilibrium { nodes: vec![node], ..Equilibrium::default() };
        assert!(probes.evaluate(&state, &[])[1].is_nan());
        assert_eq!(probes.evaluate(&state, &[vec![0.0; 2]])[1], 6.0);
        assert_eq!(probes.evaluate(&state, &[vec![0.0; 2], vec![5.0, 10.0]])[1], 10.0);
    }
}

//! Model to structure: members become chains of elements, targets become drives.

use rustc_hash::FxHashMap;
use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};
use pennate_solver::structure::{
    Dimension, Drive, DriveId, Fibres, Member, RigidBody, SectionLaw, SectionState, Segment, Step, Structure,
};

use crate::hsim::{MuscleLaw, Part};
use crate::mesh::Mesh;
use crate::model::{self, FixedLaw, MemberKind, Model, SegmentLaw, Target};

/// Turns a model into what the solver takes.
///
/// Nodes, members, supports, springs and bodies keep their order and so their indices; segments are the stretches of
/// the mesh. In the plane, material
/// axes are turned about the tangent so that axis 3 is global z, see [`plane_turn`].
pub fn discretize(model: &Model, mesh: &Mesh) -> (Structure, Vec<Step>) {
    let mut laws = Laws::default();
    let mut drives = Drives::default();
    let controls: Vec<Option<DriveId>> = model
        .members
        .iter()
        .enumerate()
        .map(|(index, member)| match member.kind {
            MemberKind::Passive => None,
            MemberKind::Muscle(_) | MemberKind::Actuated => Some(drives.of(Target::Control(index))),
        })
        .collect();
    let members = model
        .members
        .iter()
        .enumerate()
        .zip(controls)
        .map(|((index, member), control)| chain(model, mesh, (index, member), control, &mut laws))
        .collect();
    let steps = model
        .steps
        .iter()
        .map(|step| Step {
            targets: step.targets.iter().map(|(target, value)| (drives.of(*target), *value)).collect(),
            changes: step.changes.clone(),
            min_increments: step.increments,
            method: step.method,
            branch: step.branch,
            stop: step.stop,
        })
        .collect();
    let in_plane = model.dimension == Dimension::Plane;
    let structure = Structure {
        dimension: model.dimension,
        stability: model.stability,
        nodes: model.nodes.iter().map(|node| flat(node.position, in_plane)).collect(),
        members,
        laws: laws.all,
        supports: model.supports.clone(),
        bodies: model
            .bodies
            .iter()
            .map(|body| RigidBody { nodes: body.nodes.clone(), reference: body.reference, mass: body.mass })
            .collect(),
        springs: model.springs.iter().map(|spring| spring.spring.clone()).collect(),
        drives: drives.all,
        compliances: model.probes.compliances(),
        sections: model.probes.sections(),
    };
    (structure, steps)
}

/// What rounding may leave of z is taken out in the plane.
fn flat(position: [f64; 3], in_plane: bool) -> [f64; 3] {
    if in_plane { [position[0], position[1], 0.0] } else { position }
}

/// The turn from a member's own axes to those it is solved in: own components times this matrix's transpose.
///
/// It is the identity in space. In the plane axis 3 becomes global z, which changes nothing but names: where
/// the user's axis 2 is along z, axes 2 and 3 swap.
pub fn plane_turn(dimension: Dimension, member: &model::Member) -> Matrix3<f64> {
    if dimension == Dimension::Space {
        return Matrix3::identity();
    }
    let [second, third] = [member.axes[1], member.axes[2]];
    // New axis 3 = z in the old axes (0, second·z, third·z); new axis 2 = new axis 3 × axis 1.
    let (along_second, along_third) = (snap(second[2]), snap(third[2]));
    Matrix3::from_columns(&[
        Vector3::x(),
        Vector3::new(0.0, along_third, -along_second),
        Vector3::new(0.0, along_second, along_third),
    ])
}

/// Axes that are along z within rounding are so exactly.
fn snap(cosine: f64) -> f64 {
    if cosine.abs() > 1.0 - 1e-9 {
        cosine.signum()
    } else if cosine.abs() < 1e-9 {
        0.0
    } else {
        cosine
    }
}

fn chain(
    model: &Model,
    mesh: &Mesh,
    (index, member): (usize, &model::Member),
    control: Option<DriveId>,
    laws: &mut Laws,
) -> Member {
    let turn = plane_turn(model.dimension, member);
    let own = Matrix3::from_columns(&member.axes.map(Vector3::from));
    let mut axes: [[f64; 3]; 3] = std::array::from_fn(|axis| (own * turn.column(axis)).into());
    if model.dimension == Dimension::Plane {
        let tangent = Vector3::new(axes[0][0], axes[0][1], 0.0).normalize();
        axes = [tangent.into(), [-tangent.y, tangent.x, 0.0], [0.0, 0.0, 1.0]];
    }
    let stretch = |(k, &elements): (usize, &usize)| {
        let stretch = mesh.stretch(model, index, k);
        let segment = &member.segments[stretch.segment];
        Segment {
            length: stretch.length,
            elements,
            law: laws.of(model, &segment.material, &turn),
            initial_curvature: (turn.transpose() * Vector3::from(segment.initial_curvature)).into(),
        }
    };
    let segments = mesh.refinement[index].iter().enumerate().map(stretch).collect();
    Member {
        nodes: member.nodes,
        axes,
        segments,
        releases: member.releases.clone(),
        control,
        formulation: member.formulation,
        order: member.order(mesh.order),
    }
}

/// A section that does not change, with induced strains in proportion to the actuation.
#[derive(Clone, Copy, Debug)]
struct ProportionalLaw(FixedLaw);

impl SectionLaw for ProportionalLaw {
    fn at(&self, actuation: f64) -> SectionState {
        let Self(law) = self;
        SectionState {
            section: law.section,
            strain: law.strain * actuation,
            curvature: law.curvature.map(|curvature| curvature * actuation),
        }
    }

    fn fibres(&self) -> Fibres {
        self.0.shape.map(|shape| shape.fibres).unwrap_or_default()
    }
}

/// The laws of a structure: one for all segments that are alike.
#[derive(Default)]
struct Laws {
    all: Vec<Arc<dyn SectionLaw>>,
    muscles: FxHashMap<(usize, bool), usize>,
    fixed: FxHashMap<[u64; 16], usize>,
}

impl Laws {
    fn of(&mut self, model: &Model, material: &SegmentLaw, turn: &Matrix3<f64>) -> usize {
        match material {
            SegmentLaw::MuscleEnd(muscle) => self.muscle(model, *muscle, Part::End),
            SegmentLaw::MuscleMiddle(muscle) => self.muscle(model, *muscle, Part::Middle),
            SegmentLaw::Fixed(law) => self.fixed(turned(law, turn)),
        }
    }

    fn muscle(&mut self, model: &Model, muscle: usize, part: Part) -> usize {
        let next = self.all.len();
        let index = *self.muscles.entry((muscle, part == Part::Middle)).or_insert(next);
        if index == next {
            self.all.push(Arc::new(MuscleLaw { muscle: model.muscles[muscle].clone(), part }));
        }
        index
    }

    fn fixed(&mut self, law: FixedLaw) -> usize {
        let section = &law.section;
        let [k1, k2, k3] = law.curvature;
        let Fibres { distance: [second, third], corner } = law.shape.map(|shape| shape.fibres).unwrap_or_default();
        let key = [
            section.ea,
            section.ga2,
            section.ga3,
            section.gj,
            section.ei2,
            section.ei3,
            section.mass_per_length,
            section.rotary_inertia[0],
            section.rotary_inertia[1],
            law.strain,
            k1,
            k2,
            k3,
            second,
            third,
            f64::from(u8::from(corner)),
        ];
        let next = self.all.len();
        let index = *self.fixed.entry(key.map(f64::to_bits)).or_insert(next);
        if index == next {
            self.all.push(Arc::new(ProportionalLaw(law)));
        }
        index
    }
}

/// A law in axes turned about the tangent: by a quarter turn, or for a section to which the turn is all the same.
fn turned(law: &FixedLaw, turn: &Matrix3<f64>) -> FixedLaw {
    let mut law = *law;
    if turn[(1, 2)].abs() > 0.5 && turn[(1, 1)] == 0.0 {
        std::mem::swap(&mut law.section.ei2, &mut law.section.ei3);
        std::mem::swap(&mut law.section.ga2, &mut law.section.ga3);
        law.section.rotary_inertia.swap(0, 1);
        if let Some(shape) = &mut law.shape {
            shape.fibres.distance.swap(0, 1);
            shape.second_moments.swap(0, 1);
        }
    }
    law.curvature = (turn.transpose() * Vector3::from(law.curvature)).into();
    law
}

/// Drives in the order in which they are first needed.
#[derive(Default)]
struct Drives {
    all: Vec<Drive>,
    index: FxHashMap<Target, DriveId>,
}

impl Drives {
    fn of(&mut self, target: Target) -> DriveId {
        let next = self.all.len();
        let index = *self.index.entry(target).or_insert(next);
        if index == next {
            self.all.push(match target {
                Target::Control(_) => Drive::Control,
                Target::Force(node, component) => Drive::Force(node, component),
                Target::Moment(node, component) => Drive::Moment(node, component),
                Target::FollowerForce(node, component) => Drive::FollowerForce(node, component),
                Target::FollowerMoment(node, component) => Drive::FollowerMoment(node, component),
                Target::Gravity(component) => Drive::Gravity(component),
                Target::Distributed(member, component) => Drive::Distributed(member, component),
            });
        }
        index
    }
}

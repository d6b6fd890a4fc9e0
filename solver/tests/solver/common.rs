//! Structures that several tests use.

use std::sync::Arc;

use pennate_elements::section::Section;
use pennate_solver::history::{History, StepHistory};
use pennate_solver::options::Options;
use pennate_solver::structure::{
    Dimension, Drive, Formulation, Member, Release, SectionLaw, SectionState, Segment, Stability, Step, Structure,
    Support,
};

#[derive(Debug)]
pub(crate) struct Fixed(pub SectionState);

impl SectionLaw for Fixed {
    fn at(&self, control: f64) -> SectionState {
        SectionState { strain: control * self.0.strain, curvature: self.0.curvature.map(|k| control * k), ..self.0 }
    }
}

pub(crate) fn elastic(ea: f64, ga: f64, gj: f64, ei: f64) -> Section {
    Section { ea, ga2: ga, ga3: ga, gj, ei2: ei, ei3: ei, mass_per_length: 0.0, rotary_inertia: [0.0; 2] }
}

pub(crate) const AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

pub(crate) fn law(section: Section) -> Arc<dyn SectionLaw> {
    Arc::new(Fixed(SectionState { section, strain: 0.0, curvature: [0.0; 3] }))
}

/// A cantilever along x, clamped at node 0.
pub(crate) fn cantilever(
    dimension: Dimension,
    length: f64,
    section: Section,
    elements: usize,
    order: usize,
) -> Structure {
    Structure {
        dimension,
        stability: Stability::Space,
        nodes: vec![[0.0; 3], [length, 0.0, 0.0]],
        members: vec![Member {
            nodes: [0, 1],
            axes: AXES,
            segments: vec![Segment { length, elements, law: 0, initial_curvature: [0.0; 3] }],
            releases: [Release::Welded, Release::Welded],
            control: None,
            formulation: Formulation::Exact,
            order,
        }],
        laws: vec![law(section)],
        supports: vec![Support { node: 0, fixed: [true; 6], axes: AXES }],
        bodies: vec![],
        springs: vec![],
        drives: vec![],
        compliances: vec![],
        sections: Vec::new(),
    }
}

/// Solves one step that moves new drives to the given values.
pub(crate) fn solve_one(mut structure: Structure, loads: &[(Drive, f64)]) -> (StepHistory, History) {
    let mut step = Step::default();
    for &(drive, value) in loads {
        step.targets.push((structure.drives.len(), value));
        structure.drives.push(drive);
    }
    let history = pennate_solver::solve(&structure, &[step], &Options::default(), &mut |_| true).unwrap();
    (history.steps[0].clone(), history)
}

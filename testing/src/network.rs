//! Networks written in a test, and their equilibria by names.

use nalgebra::{UnitQuaternion, Vector3};
use pennate_models::{Mesh, Model, discretize, read_text};
use pennate_solver::error::{FreeMotion, Place, SolveError};
use pennate_solver::history::{Equilibrium, History, MemberState, NodeState, Status, StepHistory};
use pennate_solver::options::Options;

/// Three components along global axes.
pub type Vector = Vector3<f64>;

/// A rod of which every stiffness differs from every other.
pub const ROD: &str = "
format = \"pennate/1\"
sections.rod = { stiffness = { EA = 3e4, GA2 = 1e4, GA3 = 1.4e4, GJ = 7e3, EI2 = 1e4, EI3 = 2e4, mass_per_length = 1e-3 } }
sections.round = { stiffness = { EA = 3e4, GA2 = 1e4, GA3 = 1e4, GJ = 7e3, EI2 = 1e4, EI3 = 1e4, mass_per_length = 1e-3 } }
sections.strong = { stiffness = { EA = 1e8, GA2 = 1e8, GA3 = 1e8, GJ = 1e9, EI2 = 1e9, EI3 = 1e9 } }
";

/// The sections of [`ROD`], and the rest of a network.
pub fn rod(rest: &str) -> String {
    format!("{ROD}{rest}")
}

/// A network and what the solver made of it.
#[derive(Debug)]
pub struct Solved {
    /// What the text says.
    pub model: Model,
    /// All accepted states.
    pub history: History,
}

/// Reads a network; panics with all errors.
pub fn model(text: &str) -> Model {
    let parsed = read_text("test.toml", text, &[]);
    parsed.unwrap_or_else(|errors| {
        let lines: Vec<_> = errors.errors.iter().map(|error| format!("{error:?}")).collect();
        panic!("{}\n{text}", lines.join("\n"))
    })
}

/// Solves a network, on the mesh that it would begin with; its steps may fail.
pub fn attempt(text: &str) -> Result<Solved, Vec<FreeMotion>> {
    let model = model(text);
    let mesh = Mesh::initial(&model, 1e-6);
    attempt_on(model, &mesh)
}

/// Solves on a mesh; steps may fail.
pub fn attempt_on(model: Model, mesh: &Mesh) -> Result<Solved, Vec<FreeMotion>> {
    let (structure, steps) = discretize(&model, mesh);
    match pennate_solver::solve(&structure, &steps, &Options::default(), &mut |_| true) {
        Ok(history) => Ok(Solved { model, history }),
        Err(SolveError::Mechanism(motions)) => Err(motions),
    }
}

/// Solves a network whose steps all converge.
#[track_caller]
pub fn solve(text: &str) -> Solved {
    let model = model(text);
    let mesh = Mesh::initial(&model, 1e-6);
    solve_on(model, &mesh)
}

/// Solves on elements of order 4, `factor` times as many as the network would begin with.
#[track_caller]
pub fn solve_finely(text: &str, factor: usize) -> Solved {
    let model = model(text);
    let mesh = Mesh::initial(&model, 1e-10).refined(&model, &vec![factor; model.members.len()]);
    solve_on(model, &mesh)
}

/// Solves on a mesh; all steps converge.
#[track_caller]
pub fn solve_on(model: Model, mesh: &Mesh) -> Solved {
    match attempt_on(model, mesh) {
        Ok(solved) => {
            for step in &solved.history.steps {
                assert_eq!(step.status, Status::Converged, "{:?}", step.failure);
            }
            solved
        }
        Err(motions) => panic!("refused as a mechanism: {motions:?}"),
    }
}

impl Solved {
    /// A step by its name.
    pub fn step(&self, name: &str) -> &StepHistory {
        let index = self.model.steps.iter().position(|step| step.name == name);
        &self.history.steps[index.unwrap_or_else(|| panic!("no step {name}"))]
    }

    /// The state at the end of a step.
    pub fn after(&self, step: &str) -> &Equilibrium {
        &self.step(step).increments.last().expect("a step that converged").state
    }

    /// The last equilibrium of all.
    pub fn last(&self) -> &Equilibrium {
        &self.history.steps.last().expect("steps").increments.last().expect("a step that converged").state
    }

    /// Factorizations of all steps.
    pub fn factorizations(&self) -> usize {
        self.history.steps.iter().map(|step| step.factorizations).sum()
    }

    /// Place of a node among the nodes.
    pub fn node_index(&self, name: &str) -> usize {
        let found = self.model.nodes.iter().position(|node| node.name == name);
        found.unwrap_or_else(|| panic!("no node {name}"))
    }

    /// A node at the end of the last step.
    pub fn node(&self, name: &str) -> &NodeState {
        &self.last().nodes[self.node_index(name)]
    }

    /// A member at the end of the last step.
    pub fn member(&self, name: &str) -> &MemberState {
        let found = self.model.members.iter().position(|member| member.name == name);
        &self.last().members[found.unwrap_or_else(|| panic!("no member {name}"))]
    }

    /// Position of a node at the end.
    pub fn place(&self, name: &str) -> Vector {
        Vector::from(self.model.nodes[self.node_index(name)].position) + self.shift(name)
    }

    /// Displacement of a node at the end.
    pub fn shift(&self, name: &str) -> Vector {
        self.node(name).displacement.into()
    }

    /// Rotation of a node at the end.
    pub fn rotation(&self, name: &str) -> UnitQuaternion<f64> {
        UnitQuaternion::from_scaled_axis(Vector::from(self.node(name).rotation))
    }

    /// Reaction force on a node at the end.
    pub fn force(&self, name: &str) -> Vector {
        self.node(name).reaction_force.into()
    }

    /// Reaction moment on a node at the end.
    pub fn moment(&self, name: &str) -> Vector {
        self.node(name).reaction_moment.into()
    }

    /// What is left of all reactions and these loads (node, force, moment): force, and moment about the origin.
    pub fn imbalance(&self, loads: &[(&str, [f64; 3], [f64; 3])]) -> (f64, f64) {
        let (mut force, mut moment) = (Vector::zeros(), Vector::zeros());
        let mut count = |at: Vector, f: Vector, m: Vector| {
            force += f;
            moment += m + at.cross(&f);
        };
        for node in &self.model.nodes {
            count(self.place(&node.name), self.force(&node.name), self.moment(&node.name));
        }
        for (node, f, m) in loads {
            count(self.place(node), (*f).into(), (*m).into());
        }
        (force.norm(), moment.norm())
    }
}

/// The nodes and members that a refusal is about, with direction and whether it turns.
pub fn places(solved: Result<Solved, Vec<FreeMotion>>) -> Vec<(Place, Vector, bool)> {
    let motions = solved.expect_err("a mechanism that was not refused");
    motions.into_iter().map(|motion| (motion.place, motion.direction.into(), motion.turns)).collect()
}

/// Fails where two vectors are farther apart than a tolerance, in their unit.
#[track_caller]
pub fn assert_close(found: impl Into<Vector>, expected: impl Into<Vector>, tolerance: f64) {
    let (found, expected): (Vector, Vector) = (found.into(), expected.into());
    let error = (found - expected).norm();
    assert!(error <= tolerance, "{found:?} is {error:.2e} from {expected:?}, more than {tolerance:.0e}");
}

/// Fails where two numbers are farther apart than a tolerance, in their unit.
#[track_caller]
pub fn assert_near(found: f64, expected: f64, tolerance: f64) {
    let error = (found - expected).abs();
    assert!(error <= tolerance, "{found} is {error:.2e} from {expected}, more than {tolerance:.0e}");
}

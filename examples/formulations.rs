//! Prints error and time of every formulation and order on finer and finer meshes, as a Markdown table.
//!
//!     cargo run --release --example formulations            the table
//!     cargo run --release --example formulations -- --csv   the same as comma-separated values
//!
//! Every segment of every member has the same number of elements. The error is that of the displacement of one node
//! against the reference of `validation/`, over its norm; the time is the least of several solves on one thread, from
//! the structure to the equilibrium, without an estimate of the error.

use std::path::Path;
use std::time::{Duration, Instant};

use pennate_models::{Mesh, Model, discretize, read};
use pennate_solver::history::{History, Status};
use pennate_solver::options::Options;
use pennate_solver::structure::Formulation;
use serde_json::Value;

/// Solves are repeated for so long, and so many times at most.
const PATIENCE: Duration = Duration::from_millis(300);
const REPEATS: usize = 25;
/// Finer meshes than the one with this error say nothing: references have ten digits or so.
const EXACT: f64 = 3e-10;
/// Elements of a mesh at most.
const LARGEST: usize = 20_000;

/// A network file, the steps taken of it, and a displacement or position that is known.
struct Problem {
    name: &'static str,
    file: &'static str,
    steps: &'static [&'static str],
    node: &'static str,
    /// Whether positions are known, not displacements.
    positions: bool,
    /// Component, place of its reference, and by what the value is multiplied to be the latter.
    references: &'static [(usize, &'static str, f64)],
}

const PROBLEMS: [Problem; 7] = [
    Problem {
        name: "roll-up, 3/4 turn",
        file: "01_roll_up/roll_up.toml",
        steps: &["3/4 turn"],
        node: "T",
        positions: true,
        references: &[
            (0, "/results/3/quantities/tip_position/0", 1.0),
            (1, "/results/3/quantities/tip_position/1", 1.0),
        ],
    },
    Problem {
        name: "elastica, k = 10",
        file: "02_elastica_tip_load/elastica.toml",
        steps: &["k = 10"],
        node: "T",
        positions: false,
        references: &[(0, "/results_elastica/7/shortening_u", -1.0), (1, "/results_elastica/7/deflection_w", -1.0)],
    },
    Problem {
        name: "45-degree bend",
        file: "04_bathe_bolourchi_bend/one_step.toml",
        steps: &["load 600"],
        node: "T",
        positions: false,
        references: &[
            (0, "/results/2/quantities/tip/displacement/0", 1.0),
            (1, "/results/2/quantities/tip/displacement/1", 1.0),
            (2, "/results/2/quantities/tip/displacement/2", 1.0),
        ],
    },
    Problem {
        name: "HSIM cantilever",
        file: "12_hsim_member/muscle.toml",
        steps: &["free contraction", "tip load 0.5"],
        node: "T",
        positions: false,
        references: &[
            (0, "/results/6/quantities/tip/displacement/0", 1.0),
            (1, "/results/6/quantities/tip/displacement/1", 1.0),
        ],
    },
    Problem {
        name: "dyad",
        file: "13_pennate_dyad/clamped.toml",
        steps: &["actuate"],
        node: "J",
        positions: false,
        references: &[(1, "/results/0/quantities/free_stroke", -1.0)],
    },
    Problem {
        name: "tripod",
        file: "15_tripod/tripod.toml",
        steps: &["all actuated", "all actuated, skew load"],
        node: "O",
        positions: false,
        references: &[
            (0, "/results/2/quantities/plate/displacement/0", 1.0),
            (1, "/results/2/quantities/plate/displacement/1", 1.0),
            (2, "/results/2/quantities/plate/displacement/2", 1.0),
        ],
    },
    Problem {
        name: "P6, 16 cells",
        file: "peers/p6_16.toml",
        steps: &["contract"],
        node: "r16n0",
        positions: false,
        references: &[
            (0, "/results/1/quantities/top/displacement/0", 1.0),
            (1, "/results/1/quantities/top/displacement/1", 1.0),
            (2, "/results/1/quantities/top/displacement/2", 1.0),
        ],
    },
];

fn main() {
    let csv = std::env::args().any(|argument| argument == "--csv");
    if csv {
        println!("problem,formulation,order,elements,error,factorizations,milliseconds");
    } else {
        println!("| reference | formulation | order | elements | error | factorizations | time |");
        println!("|---|---|---:|---:|---:|---:|---:|");
    }
    let orders = |of: &Formulation| if of.has_higher_orders() { 1..=4 } else { 1..=1 };
    let formulations: Vec<_> =
        Formulation::ALL.iter().rev().flat_map(|of| orders(of).map(|order| (*of, order))).collect();
    for problem in &PROBLEMS {
        for &(formulation, order) in &formulations {
            let model = problem.model(formulation);
            let mut elements = if order == 1 { 2 } else { 1 };
            while let Some(row) = problem.solve(&model, order, elements) {
                let Row { elements: all, error, factorizations, seconds } = row;
                let ms = 1e3 * seconds;
                let (name, formulation) = (problem.name, formulation.about().word);
                if csv {
                    println!("\"{name}\",{formulation},{order},{all},{error:.3e},{factorizations},{ms:.4}");
                } else {
                    println!(
                        "| {name} | {formulation} | {order} | {all} | {error:.1e} | {factorizations} | {ms:.3} ms |"
                    );
                }
                elements *= 2;
                if error < EXACT || 2 * all > LARGEST {
                    break;
                }
            }
        }
    }
}

/// What came of one mesh.
struct Row {
    elements: usize,
    error: f64,
    factorizations: usize,
    seconds: f64,
}

impl Problem {
    fn path(&self) -> std::path::PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("validation").join(self.file)
    }

    /// The network with these steps alone, which are taken from where the one before ends.
    fn model(&self, formulation: Formulation) -> Model {
        let mut model = read(&self.path(), &[]).unwrap_or_else(|errors| panic!("{}: {errors:?}", self.file));
        model.steps.retain(|step| self.steps.contains(&step.name.as_str()));
        assert_eq!(model.steps.len(), self.steps.len(), "{}: steps", self.file);
        for member in &mut model.members {
            member.formulation = formulation;
        }
        model
    }

    /// Solves on so many elements a segment; `None` where that comes to no end.
    fn solve(&self, model: &Model, order: usize, elements: usize) -> Option<Row> {
        let refinement = model.members.iter().map(|member| vec![elements; member.segments.len()]).collect();
        let mesh = Mesh::new(order, refinement);
        let (structure, steps) = discretize(model, &mesh);
        let begin = Instant::now();
        let (mut seconds, mut solved) = (f64::INFINITY, None);
        for _ in 0..REPEATS {
            let start = Instant::now();
            let history = pennate_solver::solve(&structure, &steps, &Options::default(), &mut |_| true).ok()?;
            seconds = start.elapsed().as_secs_f64().min(seconds);
            solved = Some(history);
            if begin.elapsed() > PATIENCE {
                break;
            }
        }
        let history = solved?;
        if history.steps.iter().any(|step| step.status != Status::Converged) {
            return None;
        }
        Some(Row {
            elements: mesh.elements(),
            error: self.error(model, &history),
            factorizations: history.steps.iter().map(|step| step.factorizations).sum(),
            seconds,
        })
    }

    fn error(&self, model: &Model, history: &History) -> f64 {
        let folder = self.path();
        let text = std::fs::read_to_string(folder.with_file_name("reference.json")).expect("a reference");
        let data: Value = serde_json::from_str(&text).expect("a reference in JSON");
        let node = model.nodes.iter().position(|node| node.name == self.node).expect("the node");
        let state = history.steps.last().and_then(|step| step.increments.last()).expect("a state");
        let mut value = state.state.nodes[node].displacement;
        if self.positions {
            value = std::array::from_fn(|c| value[c] + model.nodes[node].position[c]);
        }
        let (mut gap, mut size) = (0.0, 0.0);
        for &(component, place, factor) in self.references {
            let reference = data.pointer(place).unwrap_or_else(|| panic!("{}: {place}", self.file));
            let reference = reference.as_f64().or_else(|| reference.as_str()?.parse().ok()).expect("a number");
            gap += (factor * value[component] - reference).powi(2);
            size += reference.powi(2);
        }
        (gap / size).sqrt()
    }
}

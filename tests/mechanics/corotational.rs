//! Corotational elements against the references of `validation/`, and against exact ones: the same rod.

use std::f64::consts::PI;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use pennate_elements::small::{norm, sub};
use pennate_models::{Mesh, Model, discretize};
use pennate_solver::history::{History, ShapeCell, Status, StepHistory};
use pennate_solver::options::Options;
use pennate_solver::structure::Formulation;
use serde_json::Value;

use pennate_testing::comparison::{Case, Setting};
use pennate_testing::program::{results, settings};

/// Largest factor between an estimated error and the true one.
const ESTIMATE_FACTOR: f64 = 10.0;

macro_rules! cases {
    ($($test:ident: $folder:literal,)*) => {
        $(
            #[test]
            fn $test() {
                validate($folder);
            }
        )*
    };
}

cases! {
    roll_up: "01_roll_up",
    elastica_tip_load: "02_elastica_tip_load",
    follower_tip_load: "03_follower_tip_load",
    bathe_bolourchi_bend: "04_bathe_bolourchi_bend",
    williams_toggle: "06_williams_toggle",
    helical_roll_up: "09_helical_roll_up",
    euler_post_buckling: "10_euler_post_buckling",
    hsim_member: "12_hsim_member",
    pennate_dyad: "13_pennate_dyad",
    dyad_asymmetric: "14_dyad_asymmetric",
    tripod: "15_tripod",
    soft_stiff_series: "16_soft_stiff_series",
    extreme_slenderness: "17_extreme_slenderness",
    helix_actuated: "18_helix_actuated",
}

fn validate(folder: &str) {
    let case = Case::open(folder);
    let mut failures = Vec::new();
    for run in case.runs() {
        let outcome = case.compare(run, Setting::Default, solve);
        let title = &outcome.label;
        if let Some(worst) = outcome.worst() {
            println!(
                "{title}: worst {:.1e}, {}, {}; {} elements, {} factorizations, {:.0} ms",
                worst.relative(),
                worst.step,
                worst.quantity,
                outcome.elements,
                outcome.factorizations,
                1e3 * outcome.solve_seconds,
            );
        }
        // Counts of factorizations belong to the mesh of the exact elements; `iterations_are_those_of_exact_elements`.
        let faults = outcome.failures().into_iter().filter(|failure| !failure.contains("factorizations"));
        failures.extend(faults.map(|failure| format!("{title}: {failure}")));
        if let Some((factor, row)) = outcome.worst_estimate() {
            println!("  estimate: true error {factor:.2e} times the estimate, {}, {}", row.step, row.quantity);
            if !(1.0 / ESTIMATE_FACTOR..=ESTIMATE_FACTOR).contains(&factor) {
                failures.push(format!("{title}: {}, {}: {factor:.1e} times its estimate", row.step, row.quantity));
            }
        }
    }
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}

/// A copy of a network file whose members are corotational.
fn corotational(network: &Path) -> (tempfile::TempDir, PathBuf) {
    let text = std::fs::read_to_string(network).expect("a network file");
    let folder = tempfile::tempdir().expect("a directory");
    let file = folder.path().join("network.toml");
    std::fs::write(&file, format!("formulation = \"corotational\"\n{text}")).expect("a file");
    (folder, file)
}

fn run(command: &str, file: &Path, more: &[impl AsRef<OsStr>]) -> Result<Value, String> {
    results(env!("CARGO_BIN_EXE_pennate"), command, file, more)
}

/// The results of the command line for the network with corotational elements.
fn solve(network: &Path, set: &[(String, String)], _: Option<&str>) -> Result<Value, String> {
    let (_folder, file) = corotational(network);
    run("solve", &file, &settings(set))
}

fn validation(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("validation").join(file)
}

fn read(file: &str, formulation: Formulation) -> Model {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    let mut model = pennate_models::read(&path, &[]).expect("a network");
    model.members.iter_mut().for_each(|member| member.formulation = formulation);
    model
}

/// On elements of order 1, `elements` in each segment.
fn on(model: &Model, elements: usize) -> History {
    let refinement = model.members.iter().map(|member| vec![elements; member.segments.len()]).collect();
    let (structure, steps) = discretize(model, &Mesh::new(1, refinement));
    let options = Options { shapes: true, ..Options::default() };
    let history = pennate_solver::solve(&structure, &steps, &options, &mut |_| true).expect("no mechanism");
    assert!(history.steps.iter().all(|step| step.status == Status::Converged));
    history
}

/// Shear forces as unknowns of their own make the softening linear: a circle in one step, and slenderness costs nothing.
#[test]
fn iterations_are_those_of_exact_elements() {
    let elastica = "validation/02_elastica_tip_load/elastica.toml";
    let slender = "validation/17_extreme_slenderness/slender.toml";
    let bend = "validation/04_bathe_bolourchi_bend/one_step.toml";
    for (file, most) in [("validation/01_roll_up/full_circle.toml", 6), (elastica, 80), (slender, 130), (bend, 22)] {
        // The verdict on the end of a step takes one more; later steps of a cantilever are looked at half way.
        let count = |formulation| -> usize {
            on(&read(file, formulation), 64).steps.iter().map(|step| step.factorizations - 1).sum()
        };
        let (exact, own) = (count(Formulation::Exact), count(Formulation::Corotational));
        println!("{file}: {own} factorizations, exact elements of order 1 {exact}");
        assert!(own <= most && 10 * own <= 13 * exact, "{file}: {own} factorizations, exact elements {exact}");
    }
}

/// Energies, lengths, and what pictures show of every element: those of the exact element of the same length but for
/// the square of it.
#[test]
fn section_forces_strains_and_energies_are_those_of_exact_elements() {
    for file in ["models/networks/dyad.toml", "validation/18_helix_actuated/helix.toml"] {
        let of = |formulation, elements| on(&read(file, formulation), elements);
        let gap = |elements| {
            let (exact, own) = (of(Formulation::Exact, elements), of(Formulation::Corotational, elements));
            let last = |step: &StepHistory| step.increments.last().expect("a state").clone();
            let largest = |of: &dyn Fn(&ShapeCell) -> f64| {
                let shapes = exact.steps.iter().flat_map(|step| last(step).shapes);
                shapes.flat_map(|shape| shape.cells).map(|cell| of(&cell).abs()).fold(0.0, f64::max)
            };
            let scales = [
                largest(&|cell| norm(cell.force)),
                largest(&|cell| norm(cell.moment)),
                largest(&|cell| cell.strain),
                largest(&|cell| cell.curvature),
            ];
            let energy = exact.steps.iter().map(|step| last(step).state.energy).fold(0.0, f64::max);
            let mut gap = [0.0f64; 6];
            for (exact, own) in exact.steps.iter().zip(&own.steps) {
                let (exact, own) = (last(exact), last(own));
                gap[0] = gap[0].max((own.state.energy - exact.state.energy).abs() / energy);
                for (a, b) in exact.state.members.iter().zip(&own.state.members) {
                    gap[1] = gap[1].max((b.length / a.length - 1.0).abs());
                }
                for (exact, own) in exact.shapes.iter().zip(&own.shapes) {
                    for (a, b) in exact.cells.iter().zip(&own.cells) {
                        gap[2] = gap[2].max(norm(sub(a.force, b.force)) / scales[0]);
                        gap[3] = gap[3].max(norm(sub(a.moment, b.moment)) / scales[1]);
                        gap[4] = gap[4].max((a.strain - b.strain).abs() / scales[2]);
                        gap[5] = gap[5].max((a.curvature - b.curvature).abs() / scales[3]);
                        assert_eq!(a.induced_strain, b.induced_strain);
                    }
                }
            }
            gap
        };
        let (coarse, fine) = (gap(32), gap(64));
        println!("{file}: {coarse:?} {fine:?}");
        for (coarse, fine) in coarse.iter().zip(fine) {
            assert!(fine < 5e-3 && fine < 0.3 * coarse, "{file}: {coarse:.1e} {fine:.1e}");
        }
    }
}

/// The values of an analysis of a corotational network with so many elements a segment, and their errors.
///
/// Values are those of elements of the next order, and an error is how far off the corotational ones are.
fn errors(text: &str, elements: usize, command: &str, more: &[&str]) -> Vec<(f64, f64)> {
    let folder = tempfile::tempdir().expect("a directory");
    let file = folder.path().join("network.toml");
    std::fs::write(&file, text.replace("ELEMENTS", &elements.to_string())).expect("a file");
    let (_folder, file) = corotational(&file);
    let found = run(command, &file, more).unwrap_or_else(|message| panic!("{message}"));
    let number = |mode: &Value, name: &str| mode[name].as_f64().unwrap_or_else(|| panic!("{name} of {mode}"));
    let name = if command == "modes" { "angular_frequency" } else { "factor" };
    let modes = found["modes"].as_array().expect("modes").iter();
    modes.map(|mode| (number(mode, name), number(mode, "error"))).collect()
}

/// Checks that values are the expected ones, and that errors fall at least with the square of the elements' length.
fn check_errors(text: &str, elements: usize, command: &str, more: &[&str], expected: &[f64]) {
    let (coarse, fine) = (errors(text, elements, command, more), errors(text, 2 * elements, command, more));
    for (k, expected) in expected.iter().enumerate() {
        let (value, error) = fine[k];
        println!("{value} instead of {expected}, errors {:.1e} {error:.1e}", coarse[k].1);
        assert!((value / expected - 1.0).abs() < 2e-5, "{value} instead of {expected}");
        let gain = coarse[k].1 / error;
        assert!(gain > 3.4 && error < 1e-2, "{expected}: errors {:.1e} {error:.1e}", coarse[k].1);
    }
}

/// Frequencies of a shear-rigid cantilever, ω = β² √(EI/ρA)/L², and of an HSIM member before and after it contracts.
#[test]
fn frequencies_are_those_of_the_rod() {
    let bar = "format = \"pennate/1\"\nnodes = { A = [0, 0, 0], B = [2, 0, 0] }\nsupports.A = \"clamped\"\n\
               sections.rod = { stiffness = { EA = 1e6, GJ = 5, EI2 = 3, EI3 = 12, mass_per_length = 0.7 } }\n\
               members.bar = { nodes = [\"A\", \"B\"], section = \"rod\", elements = ELEMENTS }\n";
    let of = |ei: f64, root: f64| root * root * (ei / 0.7_f64).sqrt() / 4.0;
    let (first, second) = (1.875_104_068_711_961, 4.694_091_132_974_175);
    let expected = [of(3.0, first), of(12.0, first), of(3.0, second), of(12.0, second)];
    check_errors(bar, 12, "modes", &["--count", "4"], &expected);

    let text = std::fs::read_to_string(validation("19_natural_frequencies/hsim.toml")).expect("a network");
    let text = text.replace("[members.muscle]\n", "[members.muscle]\nelements = ELEMENTS\n");
    let reference = std::fs::read_to_string(validation("19_natural_frequencies/reference.json")).expect("a reference");
    let reference: Value = serde_json::from_str(&reference).expect("JSON");
    for (result, step) in [(2, "straight"), (3, "contract")] {
        let expected = reference["results"][result]["bending_angular_frequencies_rad_s"][0].as_str().expect("text");
        let expected: f64 = expected.parse().expect("a number");
        check_errors(&text, 12, "modes", &["--count", "2", "--step", step], &[expected, expected]);
    }
}

/// Euler's column with and without a load, rigid in shear and stretch, and a frame that buckles out of its plane.
#[test]
fn critical_factors_are_those_of_the_rod() {
    let column = "format = \"pennate/1\"\nparameters.P = 1\nnodes = { A = [0, 0], B = [1, 0] }\n\
                  sections.rod = { stiffness = { EA = 1, EI3 = 1 }, shear = false, stretch = false }\n\
                  members.rod = { nodes = [\"A\", \"B\"], section = \"rod\", elements = ELEMENTS }\n\
                  supports = { A = \"clamped\", B = [\"uy\", \"rz\"] }\n\
                  steps = [{ name = \"push\", force = { B = [\"= -P\", 0, 0] } }]\n";
    let euler = 4.0 * PI * PI;
    check_errors(column, 12, "buckle", &["--count", "1"], &[euler]);
    check_errors(column, 12, "buckle", &["--count", "1", "--step", "push", "--set", "P=30"], &[euler / 30.0]);

    // From so near the critical load that what linear buckling leaves out is of no account.
    let text = std::fs::read_to_string(validation("08_right_angle_frame/cantilever.toml")).expect("a network");
    let text = text.replace("section = \"strip\"", "section = \"strip\", elements = ELEMENTS");
    for (critical, near) in [(1.087_517_840_8, "P=1.08"), (-0.680_427_362_26, "P=-0.67")] {
        let load: f64 = near[2..].parse().expect("a number");
        check_errors(&text, 4, "buckle", &["--count", "1", "--step", "load", "--set", near], &[critical / load]);
    }
}

/// Elements too long for a tension, N h² > 12 EI, give way sideways: the mesh is refined until they hold.
#[test]
fn tension_is_resolved() {
    let text = "format = \"pennate/1\"\nnodes = { A = [0, 0], B = [60, 0] }\nsupports.A = \"clamped\"\n\
                sections.rod = { stiffness = { EA = 3e3, GA2 = 1e3, EI3 = 20 } }\n\
                members.rod = { nodes = [\"A\", \"B\"], section = \"rod\" }\n\
                steps = [{ force = { B = [600, 0] } }]\n";
    let folder = tempfile::tempdir().expect("a directory");
    let file = folder.path().join("network.toml");
    std::fs::write(&file, text).expect("a file");
    let (_folder, file) = corotational(&file);
    let results = run("solve", &file, &[""; 0]).expect("results");
    assert_eq!(results["steps"][0]["status"], "converged");
    let stretched = results["steps"][0]["nodes"]["B"]["displacement"][0].as_f64().expect("a displacement");
    assert!((stretched - 12.0).abs() < 1e-9, "{stretched}");
    let elements = results["mesh"]["elements"].as_f64().expect("a count");
    assert!(60.0 / elements < (12.0 * 20.0 / 600.0_f64).sqrt(), "{elements} elements");
}

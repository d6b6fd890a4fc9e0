//! Extreme networks: how many digits are kept, what it takes, and what is said where it ends.
//!
//! `cargo run --release --example extreme` prints the table of docs/extremes.md. References are closed forms, or the same
//! network in other units or twice as fine; the error is that of one displacement or reaction, relative to it.

use std::fmt::Write;

use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_analysis::solution::status_name;
use pennate_models::{InputErrors, read_text};
use pennate_solver::history::{Equilibrium, Status};
use pennate_solver::options::Options;

/// Discretization error asked for.
const ACCURACY: f64 = 1e-10;

struct Case {
    family: &'static str,
    value: String,
    text: String,
    /// What is looked at in the last state, and what it must be.
    found: fn(&Equilibrium) -> f64,
    reference: f64,
}

impl Case {
    /// Of the kinds of [`pennate_solver::history::Rounding`], that of what is looked at.
    fn kind(&self) -> usize {
        match self.family {
            "rotation, turns" => 1,
            "stiff over soft, in parallel" | "rise of a snap over the span" => 2,
            _ => 0,
        }
    }
}

fn main() {
    println!("| what | at | relative error | digits stated | factorizations | elements | said |");
    println!("|---|---:|---:|---:|---:|---:|---|");
    for case in cases() {
        println!("| {} | {} | {} |", case.family, case.value, measure(&case));
    }
}

fn measure(case: &Case) -> String {
    let model = match read_text("extreme.toml", &case.text, &[]) {
        Ok(model) => model,
        Err(errors) => return format!("- | - | - | - | refused: {}", first(&errors)),
    };
    let options = Options { estimate: true, ..Options::default() };
    let solution = match solve_to_accuracy(model, ACCURACY, &options, &mut |_| true) {
        Ok(solution) => solution,
        Err(_) => return "- | - | - | - | refused as a mechanism".to_owned(),
    };
    let step = solution.history.steps.last().expect("a step");
    let Some(last) = step.increments.last() else {
        return format!("- | - | {} | - | {}", step.factorizations, status_name(step.status));
    };
    let error = ((case.found)(&last.state) - case.reference).abs() / case.reference.abs();
    let said = match (step.status, step.stable) {
        (Status::Converged, Some(true)) => "converged, stable",
        (Status::Converged, None) => "converged; a moment in space has no potential",
        (Status::Converged, Some(false)) => "converged, unstable",
        (status, _) => status_name(status),
    };
    let factorizations: usize = solution.history.steps.iter().map(|step| step.factorizations).sum();
    let digits = last.state.rounding.and_then(|rounding| rounding.digits(case.kind()));
    let digits = digits.map_or_else(|| "-".to_owned(), |digits| format!("{digits:.1}"));
    format!("{error:.1e} | {digits} | {factorizations} | {} | {said}", solution.history.mesh.elements)
}

fn first(errors: &InputErrors) -> String {
    errors.errors.first().map(|error| error.message.clone()).unwrap_or_default()
}

fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    series(&mut cases);
    parallel(&mut cases);
    slender(&mut cases);
    lengths(&mut cases);
    short_tips(&mut cases);
    units(&mut cases);
    turns(&mut cases);
    turns_in_space(&mut cases);
    strains(&mut cases);
    bending(&mut cases);
    nearly_free(&mut cases);
    pressures(&mut cases);
    rigid(&mut cases);
    rigid_aslant(&mut cases);
    segments(&mut cases);
    snaps(&mut cases);
    sizes(&mut cases);
    meshes(&mut cases);
    chains(&mut cases);
    cases
}

/// The last state of a network that is there to be compared with.
fn solved(text: &str) -> Equilibrium {
    let model = read_text("reference.toml", text, &[]).expect("a network");
    let options = Options { estimate: true, ..Options::default() };
    let solution = solve_to_accuracy(model, ACCURACY, &options, &mut |_| true).expect("no mechanism");
    let step = solution.history.steps.last().expect("a step");
    step.increments.last().expect("an increment").state.clone()
}

fn tip_x(state: &Equilibrium) -> f64 {
    state.nodes[1].displacement[0]
}

fn tip_y(state: &Equilibrium) -> f64 {
    state.nodes[1].displacement[1]
}

/// A soft and a stiff rod in one line under a pull: strains add, N / EA each.
fn series(cases: &mut Vec<Case>) {
    for ratio in [1.0, 1e3, 1e6, 1e9] {
        let text = format!(
            "format = \"pennate/1\"\nnodes = {{ A = [0, 0], T = [100, 0], M = [50, 0] }}\n[sections]\n\
             soft = {{ stiffness = {{ EA = 100, GA2 = 40, EI3 = 1e4 }} }}\n\
             stiff = {{ stiffness = {{ EA = {:?}, GA2 = {:?}, EI3 = {:?} }} }}\n\
             [members]\nsoft = {{ nodes = [\"A\", \"M\"], section = \"soft\" }}\nstiff = {{ nodes = [\"M\", \"T\"], section = \"stiff\" }}\n\
             [supports]\nA = \"clamped\"\n[[steps]]\nforce = {{ T = [10, 0] }}\n",
            100.0 * ratio,
            40.0 * ratio,
            1e4 * ratio
        );
        let reference = 50.0 * 0.1 * (1.0 + 1.0 / ratio);
        cases.push(Case {
            family: "stiff over soft, in series",
            value: format!("{ratio:.0e}"),
            text,
            found: tip_x,
            reference,
        });
    }
}

/// The same side by side: forces add, and the soft one carries its share of the reaction.
fn parallel(cases: &mut Vec<Case>) {
    for ratio in [1.0, 1e3, 1e6, 1e9] {
        let text = format!(
            "format = \"pennate/1\"\nnodes = {{ A = [0, 0], T = [100, 0], B = [200, 0] }}\n[sections]\n\
             soft = {{ stiffness = {{ EA = 100, GA2 = 40, EI3 = 1e4 }} }}\n\
             stiff = {{ stiffness = {{ EA = {:?}, GA2 = {:?}, EI3 = {:?} }} }}\n\
             [members]\nsoft = {{ nodes = [\"A\", \"T\"], section = \"soft\" }}\nstiff = {{ nodes = [\"T\", \"B\"], section = \"stiff\" }}\n\
             [supports]\nA = \"clamped\"\nB = \"clamped\"\n[[steps]]\nforce = {{ T = [{:?}, 0] }}\n",
            100.0 * ratio,
            40.0 * ratio,
            1e4 * ratio,
            0.1 * (1.0 + ratio)
        );
        // One tenth of a unit of displacement, of which the soft rod feels 0.1.
        let found = |state: &Equilibrium| state.nodes[0].reaction_force[0];
        cases.push(Case {
            family: "stiff over soft, in parallel",
            value: format!("{ratio:.0e}"),
            text,
            found,
            reference: -0.1,
        });
    }
}

/// A moment of pi EI / L on a cantilever of a solid circle: half a circle, its tip 2 L / pi aside.
fn slender(cases: &mut Vec<Case>) {
    for slenderness in [2.0, 1e2, 1e3, 1e4, 1e5] {
        let text = format!(
            "format = \"pennate/1\"\nnodes = {{ A = [0, 0], T = [100, 0] }}\n[parameters]\nd = {:?}\n[materials]\nm = {{ youngs_modulus = 1000, poissons_ratio = 0.3 }}\n\
             [sections]\nrod = {{ circle = {{ radius = \"= d / 2\" }} }}\n[members]\nrod = {{ nodes = [\"A\", \"T\"], section = \"rod\", material = \"m\" }}\n\
             [supports]\nA = \"clamped\"\n[[steps]]\nmoment = {{ T = [0, 0, \"= pi * 1000 * pi * d^4 / 64 / 100\"] }}\n",
            100.0 / slenderness
        );
        let reference = 200.0 / std::f64::consts::PI;
        cases.push(Case { family: "slenderness", value: format!("{slenderness:.0e}"), text, found: tip_y, reference });
    }
}

/// Two members in a row of very unequal length under the same end moment.
fn lengths(cases: &mut Vec<Case>) {
    for ratio in [1e-2, 1e-4, 1e-6, 1e-8, 1e-10] {
        let text = format!(
            "format = \"pennate/1\"\nnodes = {{ A = [0, 0], T = [100, 0], M = [{:?}, 0] }}\n[sections]\n\
             rod = {{ stiffness = {{ EA = 1e4, GA2 = 5e3, EI3 = 1e4 }} }}\n[members]\nshort = {{ nodes = [\"A\", \"M\"], section = \"rod\" }}\n\
             long = {{ nodes = [\"M\", \"T\"], section = \"rod\" }}\n[supports]\nA = \"clamped\"\n[[steps]]\nmoment = {{ T = [0, 0, {:?}] }}\n",
            100.0 * ratio,
            std::f64::consts::PI * 100.0
        );
        let reference = 200.0 / std::f64::consts::PI;
        cases.push(Case {
            family: "length of neighbours",
            value: format!("{ratio:.0e}"),
            text,
            found: tip_y,
            reference,
        });
    }
}

/// A cantilever whose tip is a member of its own, under a force: as in one piece.
fn short_tips(cases: &mut Vec<Case>) {
    let network = |middle: &str, members: &str| {
        format!(
            "format = \"pennate/1\"\nnodes = {{ A = [0, 0], T = [80, 60]{middle} }}\n[sections]\n\
             rod = {{ stiffness = {{ EA = 1e4, GA2 = 5e3, EI3 = 1e4 }} }}\n[members]\n{members}\n\
             [supports]\nA = \"clamped\"\n[[steps]]\nforce = {{ T = [1, 3] }}\n"
        )
    };
    let reference = tip_y(&solved(&network("", "rod = { nodes = [\"A\", \"T\"], section = \"rod\" }")));
    for ratio in [1e-2, 1e-4, 1e-6, 1e-8] {
        let middle = format!(", M = [{:?}, {:?}]", 80.0 * (1.0 - ratio), 60.0 * (1.0 - ratio));
        let members = "long = { nodes = [\"A\", \"M\"], section = \"rod\" }\n\
                       short = { nodes = [\"M\", \"T\"], section = \"rod\" }";
        cases.push(Case {
            family: "length of the last of two, aslant",
            value: format!("{ratio:.0e}"),
            text: network(&middle, members),
            found: tip_y,
            reference,
        });
    }
}

/// The half circle again, from micrometres to kilometres.
fn units(cases: &mut Vec<Case>) {
    for length in [1e-6, 1e-3, 1.0, 1e3, 1e6] {
        let text = format!(
            "format = \"pennate/1\"\nnodes = {{ A = [0, 0], T = [{length:?}, 0] }}\n[parameters]\nd = {:?}\n[materials]\nm = {{ youngs_modulus = 1000, poissons_ratio = 0.3 }}\n\
             [sections]\nrod = {{ circle = {{ radius = \"= d / 2\" }} }}\n[members]\nrod = {{ nodes = [\"A\", \"T\"], section = \"rod\", material = \"m\" }}\n\
             [supports]\nA = \"clamped\"\n[[steps]]\nmoment = {{ T = [0, 0, \"= pi * 1000 * pi * d^4 / 64 / {length:?}\"] }}\n",
            length / 50.0
        );
        let reference = 2.0 * length / std::f64::consts::PI;
        cases.push(Case { family: "size, mm", value: format!("{length:.0e}"), text, found: tip_y, reference });
    }
}

/// Roll-ups: the total rotation of the tip.
fn turns(cases: &mut Vec<Case>) {
    for turns in [1.0, 4.0, 10.0] {
        let angle = turns * std::f64::consts::TAU;
        let text = format!(
            "format = \"pennate/1\"\ndimension = \"plane\"\nnodes = {{ A = [0, 0], T = [100, 0] }}\nsections.rod = {{ stiffness = {{ EA = 1e4, GA2 = 5e3, EI3 = 1e4 }} }}\n\
             members.rod = {{ nodes = [\"A\", \"T\"], section = \"rod\" }}\nsupports.A = \"clamped\"\n[[steps]]\nmoment = {{ T = [0, 0, {:?}] }}\n",
            angle * 100.0
        );
        let found = |state: &Equilibrium| state.nodes[1].rotation_total;
        cases.push(Case { family: "rotation, turns", value: format!("{turns}"), text, found, reference: angle });
    }
}

/// Roll-ups in space: after whole turns the tip is at the root.
fn turns_in_space(cases: &mut Vec<Case>) {
    for turns in [1.0, 4.0, 10.0] {
        let text = format!(
            "format = \"pennate/1\"\ndimension = \"space\"\nnodes = {{ A = [0, 0], T = [80, 60] }}\n\
             sections.rod = {{ stiffness = {{ EA = 1e4, GA2 = 5e3, GA3 = 5e3, GJ = 1e4, EI2 = 1e4, EI3 = 1e4 }} }}\n\
             members.rod = {{ nodes = [\"A\", \"T\"], section = \"rod\" }}\nsupports.A = \"clamped\"\n[[steps]]\nmoment = {{ T = [0, 0, {:?}] }}\n",
            turns * std::f64::consts::TAU * 100.0
        );
        let value = format!("{turns}");
        cases.push(Case { family: "rotation in space, turns", value, text, found: tip_x, reference: -80.0 });
    }
}

/// A bar pulled and pushed: N = EA strain, with bending stiffness enough not to buckle.
fn strains(cases: &mut Vec<Case>) {
    for strain in [-0.9, -0.5, 1.0, 5.0] {
        let text = format!(
            "format = \"pennate/1\"\ndimension = \"plane\"\nnodes = {{ A = [0, 0], T = [100, 0] }}\nsections.rod = {{ stiffness = {{ EA = 100, GA2 = 1e4, EI3 = 1e8 }} }}\n\
             members.rod = {{ nodes = [\"A\", \"T\"], section = \"rod\" }}\nsupports.A = \"clamped\"\n[[steps]]\nforce = {{ T = [{:?}, 0] }}\n",
            100.0 * strain
        );
        cases.push(Case {
            family: "strain",
            value: format!("{strain}"),
            text,
            found: tip_x,
            reference: 100.0 * strain,
        });
    }
}

/// The half circle in space, about the soft axis of a ribbon.
fn bending(cases: &mut Vec<Case>) {
    for ratio in [1.0, 1e4, 1e8] {
        let text = format!(
            "format = \"pennate/1\"\ndimension = \"space\"\nnodes = {{ A = [0, 0], T = [100, 0] }}\n\
             sections.rod = {{ stiffness = {{ EA = 1e4, GA2 = 5e3, GA3 = 5e3, GJ = 1e4, EI2 = {:?}, EI3 = 1e4 }} }}\n\
             members.rod = {{ nodes = [\"A\", \"T\"], section = \"rod\" }}\nsupports.A = \"clamped\"\n[[steps]]\nmoment = {{ T = [0, 0, {:?}] }}\n",
            1e4 * ratio,
            std::f64::consts::PI * 100.0
        );
        let reference = 200.0 / std::f64::consts::PI;
        cases.push(Case { family: "EI2 over EI3", value: format!("{ratio:.0e}"), text, found: tip_y, reference });
    }
}

/// A bar that turns about its start, held by a spring of next to no stiffness across its end: it moves by force over stiffness.
fn nearly_free(cases: &mut Vec<Case>) {
    for stiffness in [1e-3, 1e-6, 1e-9, 1e-12, 1e-15] {
        let text = format!(
            "format = \"pennate/1\"\ndimension = \"plane\"\nnodes = {{ A = [0, 0], T = [100, 0] }}\n\
             sections.rod = {{ stiffness = {{ EA = 1e4, GA2 = 5e3, EI3 = 1e4 }} }}\nmembers.rod = {{ nodes = [\"A\", \"T\"], section = \"rod\" }}\n\
             supports.A = \"pinned\"\nsprings.k = {{ node = \"T\", stiffness = {{ uy = {stiffness:?} }} }}\n[[steps]]\nforce = {{ T = [0, {:?}] }}\n",
            10.0 * stiffness
        );
        cases.push(Case {
            family: "spring, N/mm, that alone holds a turn",
            value: format!("{stiffness:.0e}"),
            text,
            found: tip_y,
            reference: 10.0,
        });
    }
}

/// A muscle under a pull, from no pressure to the end of its table and a little beyond: segments in series.
fn pressures(cases: &mut Vec<Case>) {
    // Between the rows the table is linear; below the first its values are kept.
    for (name, pressure, e, alpha, r1, r2) in [
        ("0", 0.0, 3.6, -9e-3, 6.8, 7.9),
        ("1e-9 below the first row", 10.0 * (1.0 - 1e-9), 3.6, -9e-3, 6.8, 7.9),
        ("first row", 10.0, 3.6, -9e-3, 6.8, 7.9),
        ("1e-9 above the first row", 10.0 * (1.0 + 1e-9), 3.6, -9e-3, 6.8, 7.9),
        ("last row", 25.0, 4.2, -7e-3, 7.1, 8.9),
        ("1e-10 beyond the last row", 25.0 * (1.0 + 1e-10), 4.2, -7e-3, 7.1, 8.9),
        ("1e-8 beyond the last row", 25.0 * (1.0 + 1e-8), 4.2, -7e-3, 7.1, 8.9),
        ("-1e-9", -1e-9, 3.6, -9e-3, 6.8, 7.9),
    ] {
        let text = format!(
            "format = \"pennate/1\"\nnodes = {{ A = [0, 0], T = [130, 0] }}\n[muscles.m]\ndiameter = 13\nwall = 2\npressure_unit = \"psi\"\n\
             table = [{{ pressure = 10, E = 3.6, alpha = -9e-3, R1 = 6.8, R2 = 7.9 }}, {{ pressure = 25, E = 4.2, alpha = -7e-3, R1 = 7.1, R2 = 8.9 }}]\n\
             [members]\nm = {{ nodes = [\"A\", \"T\"], muscle = \"m\" }}\n[supports]\nA = \"clamped\"\n[[steps]]\npressure = {{ m = {pressure:?} }}\nforce = {{ T = [3, 0] }}\n"
        );
        let stretch = |radius: f64| 3.0 / (e * std::f64::consts::PI * (radius * radius - (radius - 2.0).powi(2)));
        let reference = 26.0 * stretch(r1) + 104.0 * (stretch(r2) + alpha * pressure);
        cases.push(Case { family: "pressure", value: name.to_owned(), text, found: tip_x, reference });
    }
}

/// A cantilever under a tip load of 10 EI / L², against the inextensible, shear-rigid one.
fn rigid(cases: &mut Vec<Case>) {
    let network = |section: &str| {
        format!(
            "format = \"pennate/1\"\ndimension = \"plane\"\nnodes = {{ A = [0, 0], T = [100, 0] }}\n[sections]\nrod = {section}\n\
             [members]\nrod = {{ nodes = [\"A\", \"T\"], section = \"rod\" }}\n[supports]\nA = \"clamped\"\n[[steps]]\nforce = {{ T = [0, 10] }}\n"
        )
    };
    let reference = tip_y(&solved(&network("{ stiffness = { EA = 1, EI3 = 1e4 }, stretch = false }")));
    for ratio in [1e4, 1e6, 1e8, 1e10, 1e12, 1e14] {
        let text = network(&format!("{{ stiffness = {{ EA = {ratio:?}, GA2 = {ratio:?}, EI3 = 1e4 }} }}"));
        let value = format!("{ratio:.0e}");
        cases.push(Case { family: "EA and GA over EI/L²", value, text, found: tip_y, reference });
    }
}

/// The same aslant, where stretch and bending share every equation.
fn rigid_aslant(cases: &mut Vec<Case>) {
    let network = |section: &str| {
        format!(
            "format = \"pennate/1\"\ndimension = \"plane\"\nnodes = {{ A = [0, 0], T = [80, 60] }}\n[sections]\nrod = {section}\n\
             [members]\nrod = {{ nodes = [\"A\", \"T\"], section = \"rod\" }}\n[supports]\nA = \"clamped\"\n[[steps]]\nforce = {{ T = [-6, 8] }}\n"
        )
    };
    let reference = tip_y(&solved(&network("{ stiffness = { EA = 1, EI3 = 1e4 }, stretch = false }")));
    for ratio in [1e6, 1e8, 1e10, 1e12, 1e14] {
        let text = network(&format!("{{ stiffness = {{ EA = {ratio:?}, GA2 = {ratio:?}, EI3 = 1e4 }} }}"));
        let value = format!("{ratio:.0e}");
        cases.push(Case { family: "EA and GA over EI/L², aslant", value, text, found: tip_y, reference });
    }
}

/// The half circle of a member with a segment far shorter than the other.
fn segments(cases: &mut Vec<Case>) {
    for ratio in [1e-2, 1e-4, 1e-6] {
        let text = format!(
            "format = \"pennate/1\"\nnodes = {{ A = [0, 0], T = [100, 0] }}\n[sections]\nrod = {{ stiffness = {{ EA = 1e4, GA2 = 5e3, EI3 = 1e4 }} }}\n\
             [members]\nrod = {{ nodes = [\"A\", \"T\"], segments = [{{ length = {:?}, section = \"rod\" }}, {{ length = {:?}, section = \"rod\" }}] }}\n\
             [supports]\nA = \"clamped\"\n[[steps]]\nmoment = {{ T = [0, 0, {:?}] }}\n",
            100.0 * ratio,
            100.0 - 100.0 * ratio,
            std::f64::consts::PI * 100.0
        );
        let reference = 200.0 / std::f64::consts::PI;
        cases.push(Case { family: "length of segments", value: format!("{ratio:.0e}"), text, found: tip_y, reference });
    }
}

/// Two pinned bars, nearly in one line, pushed through it to half their height beyond.
fn snaps(cases: &mut Vec<Case>) {
    for height in [10.0, 1.0, 0.1, 1e-2, 1e-3, 1e-4] {
        let text = format!(
            "format = \"pennate/1\"\ndimension = \"plane\"\nnodes = {{ A = [-100, 0], T = [0, {height:?}], B = [100, 0] }}\n\
             [sections]\nbar = {{ stiffness = {{ EA = 1e4, GA2 = 5e3, EI3 = 1e6 }} }}\n[members]\na = {{ nodes = [\"A\", \"T\"], section = \"bar\", release = {{ end = \"pin\" }} }}\n\
             b = {{ nodes = [\"B\", \"T\"], section = \"bar\", release = {{ end = \"pin\" }} }}\n[supports]\nA = \"pinned\"\nB = \"pinned\"\n\
             [[steps]]\ndisplacement = {{ T = {{ ux = 0, uy = {:?} }} }}\n",
            -1.5 * height
        );
        let (unloaded, now) = (100f64.hypot(height), 100f64.hypot(0.5 * height));
        // l - L without cancellation.
        let strain = -0.75 * height * height / (now + unloaded) / unloaded;
        let reference = 2.0 * 1e4 * strain * (-0.5 * height / now);
        let found = |state: &Equilibrium| state.nodes[1].reaction_force[1];
        cases.push(Case {
            family: "rise of a snap over the span",
            value: format!("{:.0e}", height / 200.0),
            text,
            found,
            reference,
        });
    }
}

/// A cantilever under a tip load and its weight in space, at all sizes against that of 1 m: alike, as everything scales.
fn sizes(cases: &mut Vec<Case>) {
    let network = |units: &str, length: f64| {
        // Modulus 1 GPa; loads by the square of the size.
        let modulus = if units == "m-N-Pa" { 1e9 } else { 1e3 };
        format!(
            "format = \"pennate/1\"\nunits = \"{units}\"\nnodes = {{ A = [0, 0, 0], T = [{length:?}, 0, 0] }}\n[parameters]\nL = {length:?}\nE = {modulus:?}\n\
             [materials]\nm = {{ youngs_modulus = \"= E\", poissons_ratio = 0.3 }}\n[sections]\nrod = {{ circle = {{ radius = \"= L / 50\" }} }}\n\
             [members]\nrod = {{ nodes = [\"A\", \"T\"], section = \"rod\", material = \"m\" }}\n[supports]\nA = \"clamped\"\n\
             [[steps]]\nforce = {{ T = [0, \"= E * L^2 * 1e-6\", \"= -E * L^2 * 5e-7\"] }}\ndistributed = {{ rod = [0, 0, \"= E * L * 3e-7\"] }}\n"
        )
    };
    let reference = tip_y(&solved(&network("m-N-Pa", 1.0)));
    for (name, units, length) in [
        ("1 µm", "m-N-Pa", 1e-6),
        ("1 µm, in mm", "mm-N-MPa", 1e-3),
        ("1 mm", "mm-N-MPa", 1.0),
        ("1 m", "mm-N-MPa", 1e3),
        ("1 km, in mm", "mm-N-MPa", 1e6),
        ("1 km", "m-N-Pa", 1e3),
    ] {
        let text = network(units, length);
        cases.push(Case {
            family: "size of one network",
            value: name.to_owned(),
            text,
            found: tip_y,
            reference: reference * length,
        });
    }
}

/// The half circle on meshes that the file asks for.
fn meshes(cases: &mut Vec<Case>) {
    for elements in [1, 10, 1_000, 100_000] {
        let text = format!(
            "format = \"pennate/1\"\nnodes = {{ A = [0, 0], T = [100, 0] }}\n[sections]\nrod = {{ stiffness = {{ EA = 1e4, GA2 = 5e3, EI3 = 1e4 }} }}\n\
             [members]\nrod = {{ nodes = [\"A\", \"T\"], section = \"rod\", elements = {elements} }}\n[supports]\nA = \"clamped\"\n[[steps]]\nmoment = {{ T = [0, 0, {:?}] }}\n",
            std::f64::consts::PI * 100.0
        );
        let reference = 200.0 / std::f64::consts::PI;
        cases.push(Case { family: "elements of a member", value: elements.to_string(), text, found: tip_y, reference });
    }
}

/// A row of members between clamps, pulled at its middle: two bars side by side, however many members.
fn chains(cases: &mut Vec<Case>) {
    for count in [2usize, 100, 1_000, 10_000, 100_000] {
        let mut text = format!("format = \"pennate/1\"\n[nodes]\nn0 = [0, 0]\nn{} = [100, 0]\n", count / 2);
        for node in (1..=count).filter(|&node| node != count / 2) {
            let _ = writeln!(text, "n{node} = [{:?}, 0]", 200.0 * node as f64 / count as f64);
        }
        text += "[sections]\nrod = { stiffness = { EA = 1e4, GA2 = 5e3, EI3 = 1e4 } }\n[members]\n";
        for member in 0..count {
            let _ = writeln!(
                text,
                "m{member} = {{ nodes = [\"n{member}\", \"n{}\"], section = \"rod\", elements = 1 }}",
                member + 1
            );
        }
        let _ = writeln!(
            text,
            "[supports]\nn0 = \"clamped\"\nn{count} = \"clamped\"\n[[steps]]\nforce = {{ n{} = [10, 0] }}",
            count / 2
        );
        cases.push(Case { family: "members", value: format!("{count}"), text, found: tip_x, reference: 0.05 });
    }
}

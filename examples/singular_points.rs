//! Prints limit points, bifurcations and snaps against their references as a Markdown table.
//!
//!     cargo run --release --example singular_points              the table
//!     cargo run --release --example singular_points -- --write   the same, into docs/validation.md and docs/load_path.svg
//!
//! Every case is solved from its network file with default settings. References are those of `reference.json`, Euler's
//! load, or for frames stability functions (`testing/src/frames.rs`). The estimated error is that of pennate. Factorizations are those of the steps, the time is that of the solver
//! on every mesh it tried.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_analysis::solution::Solution;
use pennate_models::{Model, read, read_text};
use pennate_solver::history::{CriticalPoint, NodeState, StepHistory};
use pennate_solver::options::Options;
use pennate_solver::structure::Change;
use pennate_testing::frames::Frame;
use pennate_testing::page;
use plotters::prelude::*;
use serde_json::Value;

const ACCURACY: f64 = 1e-6;
/// Increments of the curve in the picture.
const FINE: usize = 200;
const SIZE: (u32, u32) = (720, 460);
const LABEL: (&str, u32) = ("sans-serif", 15);

type Settings<'a> = &'a [(&'a str, &'a str)];

fn main() -> ExitCode {
    let mut lines = vec![
        "| case | quantity | reference | pennate | relative error | estimated error | factorizations | time |"
            .to_owned(),
        "|---|---|---:|---:|---:|---:|---:|---:|".to_owned(),
    ];
    lines.extend(limit_points());
    lines.extend(bifurcations());
    lines.extend(columns());
    lines.extend(frames());
    lines.extend(wheel_chain());
    let table = lines.join("\n");
    println!("{table}");
    if std::env::args().any(|argument| argument == "--write") {
        let picture = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/load_path.svg");
        let written = page::put("singular points", &table).and_then(|()| draw(&picture).map_err(|e| e.to_string()));
        if let Err(message) = written {
            eprintln!("{message}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

fn limit_points() -> Vec<String> {
    let (lee, toggle, arch) = ("05_lee_frame", "06_williams_toggle", "07_deep_arch_215");
    let mut rows = Vec::new();
    for (case, file, settings, result) in [
        (lee, "lee_frame", &[][..], 0),
        (lee, "lee_frame", &[("stiff", "1e4")], 2),
        (toggle, "toggle_load", &[], 0),
        (arch, "arch", &[], 0),
        (arch, "arch", &[("EA", "1e14")], 1),
    ] {
        let run = Run::new(case, file, settings);
        rows.push(run.at_point(
            0,
            "limit load",
            -run.target(),
            reference(case, &format!("/results/{result}/quantities/load")),
        ));
    }
    let run = Run::new(lee, "path", &[]);
    for (point, quantity) in [(0, "first limit load"), (1, "second limit load")] {
        let expected = reference(lee, &format!("/results/{point}/quantities/load"));
        rows.push(run.at_point(point, quantity, -run.target(), expected));
    }
    rows
}

fn bifurcations() -> Vec<String> {
    let (frame, twist) = ("08_right_angle_frame", "11_twist_buckling");
    let mut rows = Vec::new();
    for (file, settings, quantity, result) in [
        ("cantilever", &[][..], "load, sideways", 0),
        ("cantilever", &[("P", "-1")], "load, sideways", 1),
        ("hinged", &[], "moment, sideways", 2),
        ("hinged", &[("M", "-700")], "moment, sideways", 3),
    ] {
        let run = Run::new(frame, file, settings);
        let expected = reference(frame, &format!("/results/{result}/quantities/critical_load_factor"));
        rows.push(run.at_point(0, quantity, run.target(), expected));
    }
    for (settings, result) in [(&[][..], 0), (&[("EA", "1e10"), ("GA", "1e10")], 1)] {
        let run = Run::new(twist, "twist", settings);
        let at = format!("/results_reissner/{result}/quantities/critical_end_rotation");
        rows.push(run.at_point(0, "end rotation, rad", run.prescribed(), reference(twist, &at)));
    }
    rows
}

fn columns() -> Vec<String> {
    let mut rows = Vec::new();
    for times in ["1.2", "4"] {
        let run = Run::new("columns", "cantilever", &[("times", times)]);
        rows.push(run.at_point(0, "load / Euler's load", times.parse().expect("a number"), 1.0));
    }
    let run = Run::new("columns", "clamped", &[]);
    let push = |fraction: f64, state: &NodeState| -state.reaction_force[0] / fraction;
    let (step, end) = (run.step(), run.node("B"));
    // Straight, the column pushes back in proportion to what it is shortened by.
    let first = &step.increments[0];
    let straight = push(first.fraction, &first.state.nodes[end]);
    let euler = reference("10_euler_post_buckling", "/results_reissner_critical_load/clamped_clamped_P");
    rows.push(run.at_point(0, "critical load", straight, euler));
    let buckled = "/results_reissner/0/quantities/end_B/reaction_force/0";
    rows.push(run.at_end("push", "load once buckled", -reference("10_euler_post_buckling", buckled)));
    rows
}

/// Frames that sway, against stability functions.
fn frames() -> Vec<String> {
    let mut rows = Vec::new();
    let mut rng = fastrand::Rng::with_seed(4);
    let named = |slenderness: f64| match slenderness.is_finite() {
        true => format!("L/r = {slenderness:.0}"),
        false => "inextensible".to_owned(),
    };
    for slenderness in [30.0, 1e3, 1e5, f64::INFINITY] {
        rows.push((format!("pinned portal, {}", named(slenderness)), Frame::portal(slenderness)));
    }
    for slenderness in [1e3, f64::INFINITY] {
        let frame = Frame { braced: false, ..Frame::random(&mut rng, slenderness) };
        let (storeys, bays) = (frame.heights.len(), frame.widths.len());
        rows.push((format!("frame of {storeys} × {bays} cells, {}", named(slenderness)), frame));
    }
    let row = |(name, frame): (String, Frame)| {
        let exact = frame.critical_factor();
        let model = read_text("frame.toml", &frame.network(2.0 * exact, 0.0, ""), &[]);
        let run = Run { name, solution: of_model(model.unwrap_or_else(|errors| panic!("{errors:?}"))) };
        run.at_point(0, "critical load", 2.0 * exact, exact)
    };
    rows.into_iter().map(row).collect()
}

/// A prototype gave what stands for the references here.
fn wheel_chain() -> Vec<String> {
    let case = "wheel_chain";
    let about = |at: &str| reference(case, at);
    let guided = Run::new(case, "guided", &[]);
    let last = guided.step().critical_points.len() - 1;
    let limit =
        guided.at_point(last, "limit load, N (prototype)", -guided.target(), about("/results/0/quantities/load"));
    let load = about("/results/1/load").to_string();
    let snapped = Run::new(case, "guided", &[("load", &load)]);
    let pressed =
        snapped.at_end("pressed", "press after the snap, mm (prototype)", about("/results/1/quantities/pressed"));
    let free = Run::new(case, "free", &[]);
    let leans = free.at_point(
        0,
        "load where it leans, N (prototype: soon after)",
        -free.target(),
        about("/results/2/quantities/load"),
    );
    vec![limit, pressed, leans]
}

/// A network file that was solved, and how it is called in the table.
struct Run {
    name: String,
    solution: Solution,
}

impl Run {
    fn new(case: &str, file: &str, settings: Settings<'_>) -> Self {
        let words: String = settings.iter().map(|(key, value)| format!(" {key}={}", short(value))).collect();
        let solution = solve(&format!("{case}/{file}.toml"), settings, None);
        Self { name: format!("{case}/{file}{words}"), solution }
    }

    /// The last step, which holds what the table asks for.
    fn step(&self) -> &StepHistory {
        self.solution.history.steps.last().expect("a step")
    }

    fn node(&self, name: &str) -> usize {
        self.solution.model.nodes.iter().position(|node| node.name == name).expect("the node")
    }

    /// The load at the end of the last step's ramp.
    fn target(&self) -> f64 {
        let targets = &self.solution.model.steps.last().expect("a step").targets;
        targets.iter().map(|(_, value)| *value).find(|&value| value != 0.0).expect("a load")
    }

    /// The motion at the end of the last step's ramp.
    fn prescribed(&self) -> f64 {
        let changes = &self.solution.model.steps.last().expect("a step").changes;
        let values = changes.iter().filter_map(|change| match change {
            Change::Prescribe { to, .. } => Some(*to),
            _ => None,
        });
        values.into_iter().find(|&value| value != 0.0).expect("a motion")
    }

    /// A row: what stands at a singular point of a ramp that ends at `whole`.
    fn at_point(&self, point: usize, quantity: &str, whole: f64, expected: f64) -> String {
        let CriticalPoint { fraction, error, .. } = self.step().critical_points[point];
        self.row(quantity, expected, whole * fraction, error.map(|error| error / fraction.abs()))
    }

    /// A row: a probe at the end.
    fn at_end(&self, probe: &str, quantity: &str, expected: f64) -> String {
        let index = self.solution.model.probes.names.iter().position(|name| name == probe).expect("the probe");
        let probes = self.solution.probes.steps.last().expect("a step");
        let now = probes.last().expect("a state")[index];
        self.row(quantity, expected, now.abs(), probes.errors().map(|errors| errors[index] / now.abs()))
    }

    fn row(&self, quantity: &str, expected: f64, now: f64, estimate: Option<f64>) -> String {
        let factorizations: usize = self.solution.history.steps.iter().map(|step| step.factorizations).sum();
        format!(
            "| {} | {quantity} | {} | {} | {:.1e} | {} | {factorizations} | {:.1} ms |",
            self.name,
            digits(expected),
            digits(now),
            (now / expected - 1.0).abs(),
            estimate.map_or("–".to_owned(), |error| format!("{error:.1e}")),
            1e3 * self.solution.timing.solve.as_secs_f64(),
        )
    }
}

/// Ten digits, without zeros at their end.
fn digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.9e}").parse().unwrap_or(value);
    rounded.to_string()
}

fn short(value: &str) -> String {
    if value.len() > 6 { value[..6].to_owned() } else { value.to_owned() }
}

fn validation(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("validation").join(path)
}

fn reference(case: &str, at: &str) -> f64 {
    let text = std::fs::read_to_string(validation(case).join("reference.json")).expect("a reference");
    let data: Value = serde_json::from_str(&text).expect("a reference in JSON");
    data.pointer(at).and_then(Value::as_f64).unwrap_or_else(|| panic!("{case} has no number at {at}"))
}

fn solve(file: &str, settings: Settings<'_>, increments: Option<usize>) -> Solution {
    let settings: Vec<_> = settings.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    let mut model = read(&validation(file), &settings).unwrap_or_else(|errors| panic!("{errors:?}"));
    for step in &mut model.steps {
        step.increments = increments.or(step.increments);
    }
    of_model(model)
}

fn of_model(model: Model) -> Solution {
    let options = Options { estimate: true, clock: pennate::clock, ..Options::default() };
    solve_to_accuracy(model, ACCURACY, &options, &mut |_| true).unwrap_or_else(|(_, error)| panic!("{error}"))
}

/// Lee's frame: its load against the displacement of the load point, along the path and with the jump.
fn draw(picture: &Path) -> Result<(), Box<dyn Error>> {
    let run = |file: &str, increments| Run { name: String::new(), solution: solve(file, &[], increments) };
    let path = run("05_lee_frame/path.toml", Some(FINE));
    let jumped = run("05_lee_frame/jump.toml", None);
    let curve = points(&path, "P");
    let limits: Vec<_> =
        path.step().critical_points.iter().map(|point| nearest(&curve, -path.target() * point.fraction)).collect();
    let jump = jumped.step().jumps.first().ok_or("no jump")?;
    let load = -jumped.target() * jump.fraction;
    let landed = jumped.step().increments.iter().position(|increment| increment.fraction >= jump.fraction);
    let from = limits.first().ok_or("no limit point")?.0;
    let to = points(&jumped, "P")[landed.ok_or("no landing")? + 1].0;

    let area = SVGBackend::new(picture, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let (low, high) = curve.iter().fold((f64::MAX, f64::MIN), |(low, high), (_, y)| (low.min(*y), high.max(*y)));
    let right = curve.iter().map(|point| point.0).fold(0.0, f64::max);
    let mut chart = ChartBuilder::on(&area)
        .margin(14)
        .x_label_area_size(46)
        .y_label_area_size(60)
        .build_cartesian_2d(0.0..1.04 * right, low - 0.15 * (high - low)..high + 0.1 * (high - low))?;
    chart
        .configure_mesh()
        .max_light_lines(1)
        .light_line_style(BLACK.mix(0.04))
        .bold_line_style(BLACK.mix(0.12))
        .x_desc("displacement of the load point, downwards")
        .y_desc("load")
        .axis_desc_style(LABEL)
        .label_style(("sans-serif", 13))
        .draw()?;
    let (blue, red) = (RGBColor(31, 78, 140), RGBColor(190, 50, 40));
    chart.draw_series(LineSeries::new(curve.iter().copied(), blue.stroke_width(2)))?;
    chart.draw_series(LineSeries::new([(from, load), (to, load)], red.stroke_width(2)))?;
    let (wide, tall) = (0.018 * right, 0.014 * (high - low));
    let head = vec![(to, load), (to - wide, load + tall), (to - wide, load - tall)];
    chart.draw_series([Polygon::new(head, red.filled())])?;
    chart.draw_series(limits.iter().map(|&point| Circle::new(point, 5, blue.filled())))?;
    for &(x, y) in &limits {
        let shift = if y > 0.0 { (-60, -22) } else { (-60, 12) };
        let text = format!("limit point, {y:.4}");
        chart.draw_series([EmptyElement::at((x, y)) + Text::new(text, shift, LABEL)])?;
    }
    let falling = curve.iter().find(|point| point.1 < 0.0).ok_or("no load below zero")?;
    let names = [((0.5 * (from + to), load), (-20, -20), "jump", red), (*falling, (10, 0), "arc length", blue)];
    for (place, shift, text, colour) in names {
        let style = TextStyle::from(LABEL).color(&colour);
        chart.draw_series([EmptyElement::at(place) + Text::new(text, shift, style)])?;
    }
    area.present()?;
    Ok(())
}

/// Displacement of a node downwards and load, from the unloaded state on.
fn points(run: &Run, node: &str) -> Vec<(f64, f64)> {
    let (node, whole) = (run.node(node), -run.target());
    let states = run.step().increments.iter();
    let points = states.map(|now| (-now.state.nodes[node].displacement[1], whole * now.fraction));
    std::iter::once((0.0, 0.0)).chain(points).collect()
}

/// The point of a curve nearest to a load: the path keeps its states at singular points.
fn nearest(curve: &[(f64, f64)], load: f64) -> (f64, f64) {
    let distance = |point: &(f64, f64)| (point.1 - load).abs();
    curve.iter().copied().min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("a curve")
}

//! The two surrogates of a muscle, HSIM and the pseudo-rigid-body model, against the high-fidelity data of `validation/hifi`:
//! parameters, errors, times, regression, and two mechanisms. `cargo run --release --example surrogates`; with `-- --write` it
//! draws docs/surrogates.svg too.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use pennate::output::text::{Align, columns};
use pennate_analysis::fit::cantilever::{Cantilever, Load};
use pennate_analysis::fit::errors::{Errors, over_pressures};
use pennate_analysis::fit::prb::{self, FittedPrb, NAMES};
use pennate_analysis::fit::regression::regress;
use pennate_analysis::fit::{self, Fitted, TESTS};
use pennate_models::prb::{Gripper, Joint, Prb};
use pennate_testing::muscle::{self, DIAMETER, LENGTH};
use plotters::prelude::*;

fn main() {
    let fitted = fit::run(&muscle::request()).unwrap_or_else(|errors| panic!("{errors}"));
    let models = fit_all(&fitted);
    println!(
        "Pseudo-rigid-body model, K_th in 0.1 N m/rad, K_ex in N/mm of one of its two springs:\n\n{}",
        parameters(&models)
    );
    let measured = measure(&fitted, &models);
    println!("Mean absolute errors at {LENGTH} mm, and the time of a load case:\n\n{}", errors(&measured));
    if std::env::args().any(|argument| argument == "--write") {
        let pressures: Vec<f64> = fitted.rows.iter().map(|row| row.row.pressure).collect();
        draw(&measured, &pressures, Path::new("docs/surrogates.svg")).expect("docs/surrogates.svg can be written");
    }
    println!(
        "Regression over aspect ratio and pressure; the fibre angle is 30 degrees throughout:\n\n{}",
        regressions(&models)
    );
    println!("Mechanisms at 20 psi with muscles of {LENGTH} mm:\n\n{}", mechanisms(&fitted, &models));
}

fn fit_all(fitted: &Fitted) -> Vec<FittedPrb> {
    let mut models = Vec::new();
    for &length in &fitted.selection.lengths {
        for row in &fitted.rows {
            let pressure = row.row.pressure;
            let all = &fitted.selection.all;
            let cases = muscle::cases(all, length, pressure, &TESTS);
            let stroke = muscle::stroke(all, length, pressure);
            models.push(prb::fit(stroke, &cases).expect("an equilibrium for every load"));
        }
    }
    models
}

fn parameters(models: &[FittedPrb]) -> String {
    let head =
        ["L/D", "psi", "gamma", "K_th", "K_ex", "axial, mm", "bending, mm", "slope, deg", "starts agree", "on a bound"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for model in models {
        let mut cells = vec![format!("{}", model.model.length / DIAMETER), format!("{}", model.pressure)];
        cells.extend(model.parameters().map(|value| format!("{value:.4}")));
        cells.extend(model.errors.mean.map(|mean| format!("{mean:.3}")));
        cells.push(format!("{} of {}", model.agreeing[0], model.agreeing[1]));
        cells.push(model.on_bounds.join(", "));
        rows.push(cells);
    }
    columns(&[Align::Right; 10], &rows)
}

/// Errors and time of a load case at one pressure, of both surrogates.
struct Measured {
    name: &'static str,
    /// By pressure: mean differences, and seconds.
    points: Vec<(Errors, f64)>,
}

fn measure(fitted: &Fitted, models: &[FittedPrb]) -> [Measured; 2] {
    let mut hsim = Measured { name: "HSIM", points: Vec::new() };
    let mut prb = Measured { name: "pseudo-rigid body", points: Vec::new() };
    let here = models.iter().filter(|model| model.model.length == LENGTH);
    for (row, model) in fitted.rows.iter().zip(here) {
        let cases = muscle::cases(&fitted.selection.all, LENGTH, row.row.pressure, &TESTS);
        let loads: Vec<Load> = cases.iter().map(|case| Load { force: case.force, moment: case.moment }).collect();
        let mut cantilever = Cantilever::new(&fitted.tube.muscle(row.row), LENGTH);
        let hsim_time = time(loads.len(), &mut || {
            std::hint::black_box(cantilever.solve(&loads, false).expect("stable states"));
        });
        let prb_time = time(loads.len(), &mut || {
            for load in &loads {
                std::hint::black_box(model.model.under_load(load.force, load.moment).expect("an equilibrium"));
            }
        });
        hsim.points.push((row.errors, hsim_time));
        prb.points.push((model.errors, prb_time));
    }
    [hsim, prb]
}

fn errors(measured: &[Measured]) -> String {
    let head = ["surrogate", "axial, mm", "bending, mm", "slope, deg", "us a load case"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for Measured { name, points } in measured {
        let errors: Vec<Errors> = points.iter().map(|point| point.0).collect();
        let times = || points.iter().map(|point| 1e6 * point.1);
        let line = over_pressures(LENGTH, DIAMETER, &errors);
        let mut cells = vec![(*name).to_owned()];
        cells.extend((0..3).map(|kind| format!("{:.2} ± {:.2}", line.mean[kind], line.deviation[kind])));
        cells.push(format!("{:.1} to {:.1}", times().fold(f64::INFINITY, f64::min), times().fold(0.0, f64::max)));
        rows.push(cells);
    }
    columns(&[Align::Left, Align::Right, Align::Right, Align::Right, Align::Right], &rows)
}

/// Errors against the time of a load case, one point a pressure.
fn draw(measured: &[Measured], pressures: &[f64], path: &Path) -> Result<(), Box<dyn Error>> {
    let area = SVGBackend::new(path, (1200, 340)).into_drawing_area();
    area.fill(&WHITE)?;
    let colours = [RGBColor(31, 78, 168), RGBColor(192, 72, 24)];
    let labels = ["axial error (mm)", "bending error (mm)", "slope error (deg)"];
    for (kind, panel) in area.split_evenly((1, 3)).iter().enumerate() {
        let high = measured.iter().flat_map(|one| &one.points).map(|point| point.0.mean[kind]).fold(0.0, f64::max);
        let mut chart = ChartBuilder::on(panel)
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(56)
            .build_cartesian_2d((0.5..50.0).log_scale(), 0.0..1.25 * high)?;
        chart
            .configure_mesh()
            .max_light_lines(1)
            .y_labels(6)
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.12))
            .x_label_formatter(&|x| x.to_string())
            .x_desc("microseconds a load case")
            .y_desc(labels[kind])
            .axis_desc_style(("sans-serif", 15))
            .label_style(("sans-serif", 13))
            .draw()?;
        for (index, (one, colour)) in measured.iter().zip(colours).enumerate() {
            for ((errors, seconds), pressure) in one.points.iter().zip(pressures) {
                let at = (1e6 * seconds, errors.mean[kind]);
                chart.draw_series([Circle::new(at, 4, colour.filled())])?;
                let label = (1.08 * at.0, at.1 + 0.02 * high);
                chart.draw_series([Text::new(
                    format!("{pressure} psi"),
                    label,
                    ("sans-serif", 11).into_font().color(&colour),
                )])?;
            }
            if kind == 0 {
                let y = 1.25 * high * (0.95 - 0.07 * index as f64);
                chart.draw_series([Circle::new((0.62, y), 4, colour.filled())])?;
                chart.draw_series([Text::new(one.name, (0.72, y * 1.015), ("sans-serif", 13))])?;
            }
        }
    }
    area.present()?;
    Ok(())
}

/// Seconds of one of `count` pieces of work: the best of many tries, which other programs disturb least.
fn time(count: usize, work: &mut dyn FnMut()) -> f64 {
    let one = |_| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    };
    (0..500).map(one).fold(f64::INFINITY, f64::min) / count as f64
}

fn regressions(models: &[FittedPrb]) -> String {
    let names = ["lambda", "alpha", "P"];
    let point = |model: &FittedPrb| vec![model.model.length / DIAMETER, 30.0, model.pressure];
    let points: Vec<Vec<f64>> = models.iter().map(point).collect();
    let head = ["parameter", "order", "Akaike", "rms", "largest standardized residual", "polynomial"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for (index, name) in NAMES.iter().enumerate() {
        let values: Vec<f64> = models.iter().map(|model| model.parameters()[index]).collect();
        let fits = [1, 2].map(|order| regress(&names, &points, &values, order).expect("twenty points"));
        let better = usize::from(fits[1].akaike < fits[0].akaike);
        for (order, fit) in fits.iter().enumerate() {
            let largest = fit.standardized.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            let terms: Vec<String> = fit.terms.iter().map(|(term, value)| format!("{value:+.4e} {term}")).collect();
            let chosen = if order == better { " *" } else { "" };
            rows.push(vec![
                (*name).to_owned(),
                format!("{}{chosen}", order + 1),
                format!("{:.1}", fit.akaike),
                format!("{:.4}", fit.rms),
                format!("{largest:.2}"),
                terms.join("  "),
            ]);
        }
    }
    columns(&[Align::Left, Align::Left, Align::Right, Align::Right, Align::Right, Align::Left], &rows)
}

fn mechanisms(fitted: &Fitted, models: &[FittedPrb]) -> String {
    let model =
        models.iter().find(|model| model.model.length == LENGTH && model.pressure == 20.0).expect("20 psi").model;
    let directory = std::env::temp_dir().join(format!("surrogates-{}", std::process::id()));
    std::fs::create_dir_all(&directory).expect("a temporary folder");
    std::fs::write(directory.join("muscle.toml"), pennate::fit::file::text(fitted)).expect("a muscle file");
    let mut rows = vec![["mechanism", "HSIM", "pseudo-rigid body", "difference"].map(str::to_owned).to_vec()];
    let mut add = |name: String, unit: &str, hsim: f64, prb: f64| {
        rows.push(vec![
            name,
            format!("{hsim:.2} {unit}"),
            format!("{prb:.2} {unit}"),
            format!("{:+.1} %", 100.0 * (prb / hsim - 1.0)),
        ]);
    };
    for angle in [15.0_f64, 20.0, 25.0, 30.0, 45.0, 60.0] {
        for (joint, name) in [(Joint::Fixed, "fixed"), (Joint::Pinned, "pinned")] {
            let hsim = solve(&directory, &dyad(angle, joint));
            if let (Some(hsim), Ok(prb)) = (hsim, model.dyad_stroke(angle.to_radians(), joint)) {
                add(format!("dyad, {name}, {angle} degrees: stroke"), "mm", hsim, prb);
            }
        }
    }
    for angle in [0.0_f64, 15.0, 30.0, 45.0] {
        if let (Some(hsim), Ok(prb)) =
            (solve(&directory, &motor(angle)), model.motor_rotation(32.0, angle.to_radians()))
        {
            add(format!("rotary motor, {angle} degrees: rotation"), "deg", hsim, prb.to_degrees());
        }
    }
    for angle in [20.0_f64, 30.0, 45.0, 60.0] {
        let strip = |length: f64| Prb::strip(length, 2200.0 * 12.0 * 1.2, 2200.0 * 12.0 * 1.2_f64.powi(3) / 12.0);
        let half =
            Gripper { muscle: model, post: strip(60.0), link: strip(35.0_f64.hypot(60.0)), jaw: 80.0, offset: 35.0 };
        if let (Some(hsim), Ok([stroke, ..])) = (solve(&directory, &gripper(angle)), half.motion(angle.to_radians())) {
            add(format!("compliant gripper, {angle} degrees: stroke"), "mm", hsim, stroke);
        }
    }
    // What could not be removed is for the system to clean up.
    let _ = std::fs::remove_dir_all(&directory);
    columns(&[Align::Left, Align::Right, Align::Right, Align::Right], &rows)
}

fn dyad(angle: f64, joint: Joint) -> String {
    let (support, release) = match joint {
        Joint::Fixed => ("clamped", ""),
        Joint::Pinned => ("pinned", ", release = { end = \"pin\" }"),
    };
    format!(
        "format = \"pennate/1\"\nparameters = {{ L = {LENGTH}, chi = {angle} }}\n\
         muscles.m = {{ file = \"muscle.toml\" }}\n\
         nodes = {{ A = [\"= -L * cos(chi)\", 0], B = [\"= L * cos(chi)\", 0], C = [0, \"= L * sin(chi)\"] }}\n\
         members.a = {{ nodes = [\"A\", \"C\"], muscle = \"m\"{release} }}\n\
         members.b = {{ nodes = [\"B\", \"C\"], muscle = \"m\"{release} }}\n\
         supports = {{ A = \"{support}\", B = \"{support}\", C = [\"ux\"] }}\n\
         steps = [{{ name = \"inflate\", pressure = {{ all = 20 }} }}]\n\
         probes.out = \"= -drop\"\nprobes.drop = {{ node = \"C\", displacement = \"uy\" }}\n"
    )
}

fn motor(angle: f64) -> String {
    format!(
        "format = \"pennate/1\"\nparameters = {{ L = {LENGTH}, zeta = {angle} }}\n\
         muscles.m = {{ file = \"muscle.toml\" }}\n\
         nodes = {{ O = [0, 0], P = [32, 0], F = [\"= 32 + L * sin(zeta)\", \"= L * cos(zeta)\"] }}\n\
         members.m = {{ nodes = [\"F\", \"P\"], muscle = \"m\", release = {{ end = \"pin\" }} }}\n\
         rigid_bodies.rotor = {{ nodes = [\"O\", \"P\"], reference = \"O\" }}\n\
         supports = {{ F = \"clamped\", O = \"pinned\" }}\n\
         steps = [{{ name = \"inflate\", pressure = {{ all = 20 }} }}]\n\
         probes.out = {{ node = \"O\", rotation = \"rz\" }}\n"
    )
}

fn gripper(angle: f64) -> String {
    format!(
        "format = \"pennate/1\"\nparameters = {{ L = {LENGTH}, chi = {angle}, h = \"= L * sin(chi)\" }}\n\
         muscles.m = {{ file = \"muscle.toml\" }}\n\
         materials.abs = {{ youngs_modulus = 2200, poissons_ratio = 0.3 }}\n\
         sections.strip = {{ rectangle = {{ width = 12, height = 1.2 }}, shear = false }}\n\
         nodes = {{ A = [\"= L * cos(chi)\", 0], B = [0, \"= h\"], G = [35, \"= h\"], K = [35, \"= h + 60\"] }}\n\
         members.m = {{ nodes = [\"A\", \"B\"], muscle = \"m\" }}\n\
         members.post = {{ nodes = [\"G\", \"K\"], section = \"strip\", material = \"abs\" }}\n\
         members.link = {{ nodes = [\"B\", \"K\"], section = \"strip\", material = \"abs\" }}\n\
         supports = {{ A = \"clamped\", G = \"clamped\", B = [\"ux\", \"rz\"] }}\n\
         steps = [{{ name = \"inflate\", pressure = {{ all = 20 }} }}]\n\
         probes.out = {{ node = \"B\", displacement = [0, -1] }}\n"
    )
}

/// The probe `out` at the end; `None` where the step does not get there.
fn solve(directory: &Path, network: &str) -> Option<f64> {
    let file = directory.join("network.toml");
    std::fs::write(&file, network).expect("a network file");
    let input = pennate::Input { file, settings: Vec::new() };
    let job = pennate::Job { input, accuracy: 1e-6, threads: None, shapes: false };
    let solution = match pennate::run(&job, &mut |_| true) {
        Ok(solution) => solution,
        Err(pennate::Refusal::Input(errors)) => panic!("{errors}"),
        Err(pennate::Refusal::Mechanism(..)) => panic!("a mechanism"),
    };
    let out = solution.model.probes.names.iter().position(|name| name == "out")?;
    let whole = solution.status() == pennate_solver::history::Status::Converged;
    whole.then(|| solution.probes.steps[0].last().map(|values| values[out]))?
}

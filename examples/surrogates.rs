//! The two surrogates of a muscle, HSIM and the pseudo-rigid-body model, against the high-fidelity data of `validation/hifi`:
//! parameters, errors, times, regression, and two mechanisms. `cargo run --release --example surrogates`

use std::path::Path;
use std::time::Instant;

use pennate::fit::cantilever::{Cantilever, Load};
use pennate::fit::data::Case;
use pennate::fit::errors::{Errors, over_pressures};
use pennate::fit::optimize::Method;
use pennate::fit::prb::{self, FittedPrb, NAMES};
use pennate::fit::regression::regress;
use pennate::fit::{self, EndLength, Fitted, Request, TESTS};
use pennate::output::text::{Align, columns};
use pennate_models::prb::{Gripper, Joint, Prb};

const LENGTH: f64 = 130.0;

fn main() {
    let fitted = fit::run(&request()).unwrap_or_else(|errors| panic!("{errors}"));
    let models = fit_all(&fitted);
    println!(
        "Pseudo-rigid-body model, K_th in 0.1 N m/rad, K_ex in N/mm of one of its two springs:\n\n{}",
        parameters(&models)
    );
    println!("Mean absolute errors at {LENGTH} mm, and the time of a load case:\n\n{}", errors(&fitted, &models));
    println!(
        "Regression over aspect ratio and pressure; the fibre angle is 30 degrees throughout:\n\n{}",
        regressions(&models)
    );
    println!("Mechanisms at 20 psi with muscles of {LENGTH} mm:\n\n{}", mechanisms(&fitted, &models));
}

fn request() -> Request {
    Request {
        data: "validation/hifi/load_cases.csv".into(),
        variant: Some("A".into()),
        length: Some(LENGTH),
        tests: TESTS.map(str::to_owned).to_vec(),
        min_ovality: None,
        diameter: 13.0,
        wall: 2.0,
        end_length: EndLength::Diameter,
        shear: false,
        two_moduli: false,
        method: Method::LeastSquares,
    }
}

fn cases(fitted: &Fitted, length: f64, pressure: f64) -> Vec<Case> {
    let wanted =
        |case: &&Case| case.length == length && case.pressure == pressure && TESTS.contains(&case.test.as_str());
    fitted.selection.all.iter().filter(wanted).cloned().collect()
}

fn fit_all(fitted: &Fitted) -> Vec<FittedPrb> {
    let mut models = Vec::new();
    for &length in &fitted.selection.lengths {
        for row in &fitted.rows {
            let pressure = row.row.pressure;
            let free = |case: &&Case| case.is_free() && case.length == length && case.pressure == pressure;
            let free = fitted.selection.all.iter().find(free).expect("a free stroke");
            let cases = cases(fitted, length, pressure);
            models.push(prb::fit(length - free.tip[0], &cases).expect("an equilibrium for every load"));
        }
    }
    models
}

fn parameters(models: &[FittedPrb]) -> String {
    let head =
        ["L/D", "psi", "gamma", "K_th", "K_ex", "axial, mm", "bending, mm", "slope, deg", "starts agree", "on a bound"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for model in models {
        let mut cells = vec![format!("{}", model.model.length / 13.0), format!("{}", model.pressure)];
        cells.extend(model.parameters().map(|value| format!("{value:.4}")));
        cells.extend(model.errors.mean.map(|mean| format!("{mean:.3}")));
        cells.push(format!("{} of {}", model.agreeing[0], model.agreeing[1]));
        cells.push(model.on_bounds.join(", "));
        rows.push(cells);
    }
    columns(&[Align::Right; 10], &rows)
}

fn errors(fitted: &Fitted, models: &[FittedPrb]) -> String {
    let here: Vec<&FittedPrb> = models.iter().filter(|model| model.model.length == LENGTH).collect();
    let hsim: Vec<Errors> = fitted.rows.iter().map(|row| row.errors).collect();
    let prb: Vec<Errors> = here.iter().map(|model| model.errors).collect();
    let all = cases(fitted, LENGTH, 25.0);
    let loads: Vec<Load> = all.iter().map(|case| Load { force: case.force, moment: case.moment }).collect();
    let row = fitted.rows.last().expect("four pressures").row;
    let mut cantilever = Cantilever::new(&fitted.tube.muscle(row), LENGTH);
    let hsim_time = time(loads.len(), &mut || {
        std::hint::black_box(cantilever.solve(&loads, false).expect("stable states"));
    });
    let model = here.last().expect("four pressures").model;
    let prb_time = time(loads.len(), &mut || {
        for load in &loads {
            std::hint::black_box(model.under_load(load.force, load.moment).expect("an equilibrium"));
        }
    });
    let head = ["surrogate", "axial, mm", "bending, mm", "slope, deg", "us a load case"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for (name, errors, time) in [("HSIM", hsim, hsim_time), ("pseudo-rigid body", prb, prb_time)] {
        let line = over_pressures(LENGTH, 13.0, &errors);
        let mut cells = vec![name.to_owned()];
        cells.extend((0..3).map(|kind| format!("{:.2} ± {:.2}", line.mean[kind], line.deviation[kind])));
        cells.push(format!("{:.1}", 1e6 * time));
        rows.push(cells);
    }
    columns(&[Align::Left, Align::Right, Align::Right, Align::Right, Align::Right], &rows)
}

fn time(count: usize, work: &mut dyn FnMut()) -> f64 {
    let repeats = 200;
    let start = Instant::now();
    for _ in 0..repeats {
        work();
    }
    start.elapsed().as_secs_f64() / (repeats * count) as f64
}

fn regressions(models: &[FittedPrb]) -> String {
    let names = ["lambda", "alpha", "P"];
    let point = |model: &FittedPrb| vec![model.model.length / 13.0, 30.0, model.pressure];
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
    std::fs::write(directory.join("muscle.toml"), fit::file::text(fitted)).expect("a muscle file");
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

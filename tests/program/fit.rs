//! Fits of muscles to test data.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

use pennate::fit::report;
use pennate_analysis::fit::cantilever::{Cantilever, Load};
use pennate_analysis::fit::errors::{Errors, by_length};
use pennate_analysis::fit::optimize::Method;
use pennate_analysis::fit::parameters::{Parameter, Space};
use pennate_analysis::fit::problem::{Problem, Tube};
use pennate_analysis::fit::{self, EndLength, Fitted, KINKED, Request, TESTS, muscle};
use pennate_models::hsim::Row;
use pennate_testing::muscle as hifi;

/// That fit, of other data.
fn request(data: PathBuf) -> Request {
    Request { data, length: None, ..hifi::request() }
}

const TUBE: Tube = Tube { diameter: 13.0, wall: 2.0, end_length: 13.0, shear: false };

fn at(fitted: &Fitted, length: f64, min_ovality: Option<f64>) -> [f64; 3] {
    by_length(fitted, min_ovality).iter().find(|errors| errors.length == length).unwrap().mean
}

/// Another program's parameters have here the errors that it found: one forward model, one meaning of an error.
///
/// There a stiffness of the middle belongs to the contracted length, here to the unloaded one: the same rod has here a
/// middle modulus larger by 1/(1 − contraction).
#[test]
fn errors_of_another_fit_are_those_it_reports() {
    let folder = hifi::folder();
    let table = |name: &str| -> Vec<Vec<f64>> {
        let mut reader = csv::Reader::from_path(folder.join(name)).unwrap();
        let number = |field: &str| field.parse().unwrap_or(f64::NAN);
        reader.records().map(|row| row.unwrap().iter().map(number).collect()).collect()
    };
    let parameters = table("hsim_parameters_A.csv");
    let fitted = fit::run(&hifi::request()).unwrap();
    for line in table("hsim_errors_A.csv") {
        let (length, pressure) = (line[0], line[2]);
        let given = parameters.iter().find(|row| row[0] == pressure).unwrap();
        let moduli = [given[4], given[4] / (1.0 - given[6])];
        let row = muscle::row(pressure, -given[7], [given[2], given[3]], moduli);
        let cases = hifi::cases(&fitted.selection.all, length, pressure, &TESTS);
        assert_eq!(cases.len() as f64, line[4]);
        let errors = Errors::of(&TUBE, row, &cases);
        for (kind, (found, expected)) in errors.mean.into_iter().zip([line[5], line[6], line[7]]).enumerate() {
            assert!((found - expected).abs() < 2e-3, "{length} mm, {pressure} psi, kind {kind}: {found} {expected}");
        }
    }
}

#[test]
fn the_muscle_of_the_data_is_fitted_well_kinked_states_included() {
    let fitted = fit::run(&hifi::request()).unwrap();
    let [axial, bending, slope] = at(&fitted, 130.0, None);
    assert!(axial <= 0.45 && bending <= 1.0 && slope <= 0.55, "{axial} {bending} {slope}");
    let [_, round, _] = at(&fitted, 130.0, Some(KINKED));
    assert!(round < bending);
    assert!(fitted.rows.iter().all(|row| row.agreeing == [3, 3] && row.on_bounds.is_empty()));
    let strokes = fitted.rows.iter().map(|row| -row.row.alpha * row.row.pressure * 104.0);
    for (found, measured) in strokes.zip([5.8311, 10.1727, 14.4652, 17.8680]) {
        assert!((found - measured).abs() < 1e-3, "{found} {measured}");
    }
}

#[test]
fn a_fitted_end_length_carries_over_to_other_lengths() {
    let with_diameter = fit::run(&hifi::request()).unwrap();
    let fitted = fit::run(&Request { end_length: EndLength::Fitted, ..hifi::request() }).unwrap();
    assert!((fitted.tube.end_length - 3.0).abs() < 0.1, "{}", fitted.tube.end_length);
    let [before, after] = [&with_diameter, &fitted].map(|fitted| at(fitted, 182.0, None)[0]);
    assert!(after < 0.5 * before, "{after} {before}");
    let [at_130, ..] = at(&fitted, 130.0, None);
    assert!(at_130 <= 0.45);
}

#[test]
fn both_optimizers_find_the_same_muscle() {
    let squares = fit::run(&hifi::request()).unwrap();
    let simplex = fit::run(&Request { method: Method::NelderMead, ..hifi::request() }).unwrap();
    for (a, b) in squares.rows.iter().zip(&simplex.rows) {
        assert!((a.cost - b.cost).abs() <= 1e-8 * a.cost, "{} {}", a.cost, b.cost);
        assert!((a.row.end_radius - b.row.end_radius).abs() < 1e-3);
        assert!((a.row.youngs_modulus - b.row.youngs_modulus).abs() < 1e-3);
        assert!(5 * a.evaluations < b.evaluations, "{} {}", a.evaluations, b.evaluations);
    }
}

/// A CSV of what a known muscle does.
fn measured(tube: Tube, rows: &[Row], length: f64) -> String {
    let mut text = "L_mm,pressure_psi,test,Fx_N,Fy_N,Mz_Nmm,tip_x_mm,tip_y_mm,tip_theta_rad\n".to_owned();
    for row in rows {
        let mut cantilever = Cantilever::new(&tube.muscle(*row), length);
        let pulls = [0.0, 2.0, 8.0, 15.0].map(|x| Load { force: [x, 0.0], moment: 0.0 });
        let pushes = [0.1, 0.4, 0.8, 1.2].map(|y| Load { force: [0.0, y], moment: 0.0 });
        for (test, loads) in [("axial+", pulls), ("bend", pushes)] {
            for (load, response) in loads.iter().zip(cantilever.solve(&loads, false).unwrap()) {
                let [x, y, slope] = response.tip;
                let [fx, fy] = load.force;
                let pressure = row.pressure;
                let _ = writeln!(text, "{length},{pressure},{test},{fx},{fy},0,{x:.12},{y:.12},{slope:.14}");
            }
        }
    }
    text
}

fn written(text: &str) -> (tempfile::TempDir, PathBuf) {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("test.csv");
    std::fs::write(&path, text).unwrap();
    (directory, path)
}

const KNOWN: [(f64, f64, [f64; 2], f64); 2] = [(10.0, -6e-3, [6.4, 7.6], 4.4), (20.0, -7e-3, [6.9, 8.3], 3.9)];

fn known() -> [Row; 2] {
    KNOWN.map(|(pressure, alpha, radii, modulus)| muscle::row(pressure, alpha, radii, [modulus; 2]))
}

#[test]
fn a_known_muscle_is_found_again() {
    for shear in [false, true] {
        let tube = Tube { shear, ..TUBE };
        let (_directory, path) = written(&measured(tube, &known(), 130.0));
        let fitted = fit::run(&Request { variant: None, shear, ..request(path) }).unwrap();
        for (found, row) in fitted.rows.iter().zip(known()) {
            let pairs = [
                (found.row.alpha, row.alpha),
                (found.row.end_radius, row.end_radius),
                (found.row.middle_radius, row.middle_radius),
                (found.row.youngs_modulus, row.youngs_modulus),
            ];
            assert!(pairs.iter().all(|(a, b)| (a / b - 1.0).abs() < 1e-6), "{shear} {found:?}");
        }
    }
}

/// Deflections of one pressure taken for those of a pull have no muscle: its numbers come with a warning.
#[test]
fn a_muscle_that_is_far_from_its_cases_is_said_to_be() {
    let text = measured(TUBE, &known(), 130.0);
    let (_directory, path) = written(&text);
    assert!(report::warnings(&fit::run(&Request { variant: None, ..request(path) }).unwrap()).is_empty());
    let mut wrong = String::new();
    for (row, line) in text.lines().enumerate() {
        let fields: Vec<&str> = line.split(',').collect();
        let place = text.lines().next().unwrap().split(',').position(|head| head == "tip_y_mm").unwrap();
        let turned = |(at, field): (usize, &&str)| match field.parse::<f64>() {
            Ok(y) if at == place && row > 0 && y != 0.0 => (30.0 - y).to_string(),
            _ => (*field).to_owned(),
        };
        let fields: Vec<String> = fields.iter().enumerate().map(turned).collect();
        wrong += &(fields.join(",") + "\n");
    }
    let (_directory, path) = written(&wrong);
    let warnings = report::warnings(&fit::run(&Request { variant: None, ..request(path) }).unwrap());
    let titles: Vec<&str> = warnings.iter().map(|warning| warning.title.as_str()).collect();
    assert!(
        matches!(titles[..], [title] if title.starts_with("the fitted muscle is far from its load cases")),
        "{titles:?}"
    );
}

/// A single length has no strokes to compare: the end length is that of the least sum of squares.
#[test]
fn the_end_length_of_a_known_muscle_is_found_from_one_length() {
    let tube = Tube { end_length: 9.0, ..TUBE };
    let (_directory, path) = written(&measured(tube, &known(), 130.0));
    let fitted = fit::run(&Request { variant: None, end_length: EndLength::Fitted, ..request(path) }).unwrap();
    assert!((fitted.tube.end_length - 9.0).abs() < 0.05, "{}", fitted.tube.end_length);
}

/// Exact derivatives against differences, all four parameters.
#[test]
fn derivatives_by_the_parameters_are_those_of_the_differences() {
    let fitted = fit::run(&hifi::request()).unwrap();
    let cases = &fitted.selection.pressures[2].cases;
    for shear in [false, true] {
        let tube = Tube { shear, ..TUBE };
        let space = Space::new(13.0, 2.0, true);
        let mut problem = Problem::new(tube, space, -7e-3, [1.0; 3], cases);
        let values = [7.0, 8.4, 4.0, 4.6];
        let exact = problem.differences(&values, true).unwrap().derivatives;
        for column in 0..values.len() {
            let mut shifted = |factor: f64| {
                let mut values = values;
                values[column] *= factor.exp();
                problem.differences(&values, false).unwrap().residuals
            };
            let step = 1e-5;
            let (up, down) = (shifted(step), shifted(-step));
            for (row, slopes) in exact.iter().enumerate() {
                let difference = (up[row] - down[row]) / (2.0 * step);
                let wrong = (difference - slopes[column]).abs();
                assert!(wrong < 1e-6 * (1.0 + difference.abs()), "{row} {column}: {difference} {}", slopes[column]);
            }
        }
    }
}

#[test]
fn a_parameter_that_ends_on_a_bound_is_named() {
    let fitted = fit::run(&Request { two_moduli: true, ..hifi::request() }).unwrap();
    assert!(
        fitted.rows.iter().any(|row| row.on_bounds.iter().any(|(parameter, ..)| *parameter == Parameter::EndRadius))
    );
    let report = pennate::fit::report::report(&fitted, Duration::ZERO);
    assert!(report.contains("R1 ends on its lower bound 3.25"), "{report}");
    assert!(pennate::fit::file::text(&fitted).contains("E1 = "));
}

/// The file is one that a network refers to, and the network's cantilever is the one that was fitted.
#[test]
fn the_muscle_file_serves_a_network() {
    let fitted = fit::run(&hifi::request()).unwrap();
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("muscle.toml"), pennate::fit::file::text(&fitted)).unwrap();
    let network = "format = \"pennate/1\"\nnodes = { A = [0, 0], B = [130, 0] }\nmuscles.m = { file = \"muscle.toml\" }\n\
        members.m = { nodes = [\"A\", \"B\"], muscle = \"m\" }\nsupports.A = \"clamped\"\n\
        steps = [{ name = \"inflate\", pressure = { m = 20 } }, { name = \"push\", force = { B = [0, 1.2] } }]\n\
        probes = { x = { node = \"B\", position = \"x\" }, y = { node = \"B\", position = \"y\" } }\n";
    let file = directory.path().join("network.toml");
    std::fs::write(&file, network).unwrap();
    let input = pennate::Input { file, settings: Vec::new() };
    let job = pennate::Job { input, accuracy: 1e-8, threads: None, shapes: false };
    let solution = pennate::run(&job, &mut |_| true).unwrap();
    let probes = solution.probes.steps[1].last().unwrap();
    let mut cantilever = Cantilever::new(&TUBE.muscle(fitted.rows[2].row), 130.0);
    let tip = cantilever.solve(&[Load { force: [0.0, 1.2], moment: 0.0 }], false).unwrap()[0].tip;
    for (network, fit) in probes.iter().zip(tip) {
        assert!((network - fit).abs() < 1e-4, "{network} {fit}");
    }
}

#[track_caller]
fn refused(text: &str, change: impl Fn(&mut Request), message: &str, place: Option<usize>) {
    let (_directory, path) = written(text);
    let mut request = Request { variant: None, ..request(path) };
    change(&mut request);
    let errors = fit::run(&request).unwrap_err();
    let found = errors.errors.iter().find(|error| error.message.contains(message));
    let error = found.unwrap_or_else(|| panic!("'{message}' expected: {errors}"));
    assert_eq!(errors.place(error).map(|(_, line, _)| line), place, "{errors}");
}

#[test]
fn data_that_cannot_be_fitted_are_refused_with_their_row() {
    let good = measured(TUBE, &known(), 130.0);
    let lines: Vec<&str> = good.lines().collect();
    let extended = good.replace(lines[1], "130,10,axial+,0,0,0,131.5,0,0");
    refused(&extended, |_| (), "no contraction explains that it extends", Some(2));
    let without_free = good.replace(&format!("{}\n", lines[1]), "");
    refused(&without_free, |_| (), "no load case without load", Some(2));
    let few: Vec<&str> = lines.iter().copied().filter(|line| !line.contains("bend")).collect();
    refused(&few.join("\n"), |_| (), "no load case is loaded across the axis", Some(2));
    let fewer = format!("{}\n{}\n{}\n", lines[0], lines[1], lines[2]);
    refused(&fewer, |_| (), "too few for 3 parameters", Some(2));
    refused(&good, |request| request.end_length = EndLength::Given(64.0), "more than the 2.0000 mm", Some(2));
    refused(&good, |request| request.length = Some(100.0), "has the length 100 mm", None);
    refused(&good, |request| request.variant = Some("B".into()), "variant 'B'", None);
    refused(&good, |request| request.wall = 7.0, "no wall of 7 mm", None);
    let mixed = good.replacen(",20,", ",5,", 1);
    refused(&mixed, |_| (), "the pressure falls from 10 to 5", Some(10));
}

#[test]
fn the_picture_shows_both_series() {
    let fitted = fit::run(&hifi::request()).unwrap();
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("check.svg");
    pennate::fit::plot::draw(&fitted, &path).unwrap();
    let svg = std::fs::read_to_string(path).unwrap();
    for text in
        ["aspect ratio L/D", "axial error (mm)", "bending error (mm)", "slope error (deg)", "without kinked states"]
    {
        assert!(svg.contains(text), "{text}");
    }
}

fn pennate(arguments: &[&str]) -> std::process::Output {
    std::process::Command::new(env!("CARGO_BIN_EXE_pennate")).args(arguments).output().unwrap()
}

#[test]
fn the_command_prints_the_fit_and_writes_its_files() {
    let directory = tempfile::tempdir().unwrap();
    let [file, picture] = ["muscle.toml", "check.svg"].map(|name| directory.path().join(name).display().to_string());
    let data = hifi::load_cases().display().to_string();
    let tube = ["--diameter", "13", "--wall", "2"];
    let rest = ["--variant", "A", "--check", "-o", &file, "--plot", &picture];
    let output = pennate(&[&["fit", &data], &tube[..], &rest[..]].concat());
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success());
    assert!(text.contains("3 of 3") && text.contains("Without kinked states"), "{text}");
    let warnings = String::from_utf8(output.stderr).unwrap();
    for warning in [
        "16 load cases of 'axial-' at 130 mm are not fitted: once the muscle buckles",
        "help: to fit them too: --tests axial+,bend,axial-",
        "56 load cases of 'bend_fx+', 'bend_fx-', 'moment' at 130 mm are not fitted: their kind of test is not asked for",
    ] {
        assert!(warnings.contains(warning), "{warnings}");
    }
    assert!(std::fs::read_to_string(&file).unwrap().contains("# Fitted to load_cases.csv, variant A: 60 load cases"));
    assert!(Path::new(&picture).exists());

    let output = pennate(&[&["fit", &data], &tube[..]].concat());
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(message.contains("choose with --variant: 'A', 'At', 'B', 'I'"), "{message}");
}

/// R1 and R2 share what bends a muscle: their errors lean against each other, and none is small or without bounds.
#[test]
fn a_fit_says_how_well_its_parameters_are_known_and_draws_them() {
    let fitted = fit::run(&hifi::request()).unwrap();
    for row in &fitted.rows {
        let known = row.uncertainty.as_ref().unwrap();
        assert_eq!(known.parameters, [Parameter::EndRadius, Parameter::MiddleRadius, Parameter::Modulus]);
        let values = [row.row.end_radius, row.row.middle_radius, row.row.youngs_modulus];
        for (index, (error, value)) in known.errors.iter().zip(values).enumerate() {
            assert!(*error > 0.005 * value && *error < 0.1 * value, "{error} of {value}");
            assert!((known.correlations[index][index] - 1.0).abs() < 1e-12);
        }
        assert!(known.correlations[0][1] < -0.7, "{:?}", known.correlations);
    }
    assert!(pennate::fit::report::report(&fitted, Duration::ZERO).contains("± R1, mm"));
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("curves.svg");
    pennate::fit::curves::draw(&fitted, &path).unwrap();
    let svg = std::fs::read_to_string(path).unwrap();
    for text in ["shortening (mm)", "deflection (mm)", "slope (deg)", "25 psi", "points: measured"] {
        assert!(svg.contains(text), "{text}");
    }
    assert!(svg.matches("<circle").count() > 60 && svg.matches("<polyline").count() >= 12);
}

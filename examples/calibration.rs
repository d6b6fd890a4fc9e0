//! Every figure of docs/fit.md about the muscle of `validation/hifi`: fits, errors, times.
//!
//! `cargo run --release --example calibration`; with `-- --write` it draws docs/fit_check.svg too.

use std::path::Path;
use std::time::{Duration, Instant};

use pennate::fit::report;
use pennate::output::text::{Align, columns};
use pennate_analysis::fit::cantilever::{Cantilever, Load};
use pennate_analysis::fit::errors::{Errors, by_length, over_pressures};
use pennate_analysis::fit::optimize::Method;
use pennate_analysis::fit::{self, EndLength, Fitted, Request};
use pennate_testing::muscle;

fn main() {
    let base = muscle::request();
    let (fitted, took) = run(&base);
    println!("{}\n{}", report::report(&fitted, took), report::check(&fitted));
    if std::env::args().any(|argument| argument == "--write") {
        pennate::fit::plot::draw(&fitted, Path::new("docs/fit_check.svg")).expect("docs/fit_check.svg can be written");
    }
    println!("Choices, errors at 130 mm and at 182 mm:\n\n{}", choices(&base));
    println!("Tests of variant A at 130 mm that were not fitted:\n\n{}", not_fitted(&fitted));
    times(&fitted, &muscle::folder());
}

fn run(request: &Request) -> (Fitted, Duration) {
    let start = Instant::now();
    let fitted = fit::run(request).unwrap_or_else(|errors| panic!("{errors}"));
    (fitted, start.elapsed())
}

fn choices(base: &Request) -> String {
    let fitted_ends = Request { end_length: EndLength::Fitted, ..base.clone() };
    let all = [
        ("as it is", base.clone()),
        ("Nelder-Mead", Request { method: Method::NelderMead, ..base.clone() }),
        ("fitted end length", fitted_ends.clone()),
        ("two moduli", Request { two_moduli: true, ..base.clone() }),
        ("shear-flexible", Request { shear: true, ..base.clone() }),
        ("without kinked states", Request { min_ovality: Some(fit::KINKED), ..base.clone() }),
        ("fibres in tension only (At)", Request { variant: Some("At".into()), ..base.clone() }),
    ];
    let head = [
        "fit",
        "ends, mm",
        "axial, mm",
        "bending, mm",
        "slope, deg",
        "at 182:",
        "axial",
        "bending",
        "slope",
        "load cases",
        "ms",
    ];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for (name, request) in all {
        let (fitted, took) = run(&request);
        let errors = by_length(&fitted, None);
        let mut cells = vec![name.to_owned(), format!("{:.2}", fitted.tube.end_length)];
        for length in [130.0, 182.0] {
            if length == 182.0 {
                cells.push(String::new());
            }
            let line = errors.iter().find(|errors| errors.length == length);
            for kind in 0..3 {
                cells.push(line.map_or_else(
                    || "-".to_owned(),
                    |line| format!("{:.2} ± {:.2}", line.mean[kind], line.deviation[kind]),
                ));
            }
        }
        let solved: usize =
            fitted.rows.iter().map(|row| row.evaluations * (row.errors.counts[0] + row.errors.counts[1])).sum();
        cells.push(solved.to_string());
        cells.push(format!("{:.0}", 1e3 * took.as_secs_f64()));
        rows.push(cells);
    }
    columns(
        &[
            Align::Left,
            Align::Right,
            Align::Right,
            Align::Right,
            Align::Right,
            Align::Right,
            Align::Right,
            Align::Right,
            Align::Right,
            Align::Right,
            Align::Right,
        ],
        &rows,
    )
}

/// Kinds of test that had no part in the fit.
fn not_fitted(fitted: &Fitted) -> String {
    let head = ["test", "bending, mm", "of", "slope, deg", "of", "cases", "no stable state"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for test in ["bend_fx+", "bend_fx-", "moment"] {
        let errors: Vec<Errors> = fitted
            .rows
            .iter()
            .map(|row| {
                let all = &fitted.selection.all;
                let cases = muscle::cases(all, fitted.selection.length, row.row.pressure, &[test]);
                Errors::of(&fitted.tube, row.row, &cases)
            })
            .collect();
        let line = over_pressures(fitted.selection.length, fitted.tube.diameter, &errors);
        let mut cells = vec![test.to_owned()];
        for kind in 1..3 {
            cells.push(format!("{:.2} ± {:.2}", line.mean[kind], line.deviation[kind]));
            cells.push(format!("{:.1}", line.largest[kind]));
        }
        cells.push(line.cases.to_string());
        cells.push(line.lost.to_string());
        rows.push(cells);
    }
    columns(&[Align::Left, Align::Right, Align::Right, Align::Right, Align::Right, Align::Right, Align::Right], &rows)
}

/// One load case against the high-fidelity model's.
fn times(fitted: &Fitted, folder: &Path) {
    let cases = &fitted.selection.pressures.last().expect("four pressures").cases;
    let loads: Vec<Load> = cases.iter().map(|case| Load { force: case.force, moment: case.moment }).collect();
    let row = fitted.rows.last().expect("four pressures").row;
    let mut cantilever = Cantilever::new(&fitted.tube.muscle(row), fitted.selection.length);
    let mut time = |derivatives: bool| {
        let repeats = 200;
        cantilever.factorizations = 0;
        let start = Instant::now();
        for _ in 0..repeats {
            std::hint::black_box(cantilever.solve(&loads, derivatives).expect("stable states"));
        }
        let count = (repeats * loads.len()) as f64;
        (start.elapsed().as_secs_f64() / count, cantilever.factorizations as f64 / count)
    };
    let (one, factorizations) = time(false);
    let (with_derivatives, _) = time(true);
    // One load alone, inflation from rest included.
    let load = Load { force: [0.0, 1.5], moment: 0.0 };
    let start = Instant::now();
    let repeats = 2000;
    for _ in 0..repeats {
        let mut alone = Cantilever::new(&fitted.tube.muscle(row), fitted.selection.length);
        std::hint::black_box(alone.solve(&[load], false).expect("a stable state"));
    }
    let alone = start.elapsed().as_secs_f64() / f64::from(repeats);
    let reference = cpu(&folder.join("convergence.csv"));
    println!(
        "One load case of a series: {:.1} us, {factorizations:.1} factorizations; with all derivatives {:.1} us.",
        1e6 * one,
        1e6 * with_derivatives
    );
    println!("One load case alone, set-up and inflation included: {:.1} us.", 1e6 * alone);
    println!(
        "The high-fidelity model takes {reference} s of CPU for it: {:.0} times as long as one of a series, {:.0} times as long as one alone.",
        reference / one,
        reference / alone
    );
}

/// CPU time of one load case on the mesh of the data: 1 x 6 x 32 elements, 1.5 N at 25 psi.
fn cpu(path: &Path) -> f64 {
    let mut reader = csv::Reader::from_path(path).expect("validation/hifi/convergence.csv");
    let row = reader
        .records()
        .map(Result::unwrap)
        .find(|row| ["25", "1.5", "1", "6", "32", "2"].iter().zip(row.iter()).all(|(wanted, field)| *wanted == field));
    row.expect("the mesh of the data")[12].parse().expect("a number of seconds")
}

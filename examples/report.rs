//! Solves the scenes of the dissertation and prints what it reports beside what pennate finds, as a Markdown table.
//!
//!     cargo run --release --example report              the table, and the time that each scene takes
//!     cargo run --release --example report -- --write   the same, put into docs/scenes.md

use std::fs;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use pennate_models::scenes::SCENES;

use pennate_testing::scenes::figures::{self, Figure};
use pennate_testing::scenes::run::solve;

const BEGIN: &str = "<!-- reported figures: begin -->";
const END: &str = "<!-- reported figures: end -->";

fn main() -> ExitCode {
    let write = std::env::args().any(|argument| argument == "--write");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let figures = figures::read(&root.join("validation/scenes/reported.toml"));
    let mut lines = vec![
        "| figure | reported | pennate | difference | how certain |".to_owned(),
        "|---|---:|---:|---:|---|".to_owned(),
    ];
    lines.extend(figures.iter().map(row));
    let (times, total) = times();
    let table = format!("{}\n\n{times}", lines.join("\n"));
    println!("{table}\nAll scenes: {total:.3} s");
    if write && let Err(message) = put_into(&root.join("docs/scenes.md"), &table) {
        eprintln!("{message}");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

fn row(figure: &Figure) -> String {
    let reported: f64 = figure.reported.parse().unwrap_or(f64::NAN);
    let decimals = figure.reported.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    let (found, difference) = match figure.found() {
        // One digit more than was reported; rounding is no digit.
        Ok(found) => {
            let found = if found.abs() < 0.05 * 0.1_f64.powi(decimals as i32) { 0.0 } else { found };
            let difference = match reported == 0.0 {
                true => "–".to_owned(),
                false => percent(100.0 * (found / reported - 1.0)),
            };
            (format!("{found:.*}", decimals + 1), difference)
        }
        Err(why) => (why, "–".to_owned()),
    };
    format!("| {} | {} | {found} | {difference} | {} |", figure.what, figure.reported, figure.certainty)
}

/// A difference with its sign; next to nothing has none.
fn percent(difference: f64) -> String {
    if difference.abs() < 0.05 { "0.0 %".to_owned() } else { format!("{difference:+.1} %") }
}

/// Every scene as it is without settings: its mesh and the wall-clock time of reading and solving it.
fn times() -> (String, f64) {
    let mut lines = vec![
        "| scene | elements | unknowns | increments | read and solved in |".to_owned(),
        "|---|---:|---:|---:|---:|".to_owned(),
    ];
    let mut total = 0.0;
    for scene in SCENES {
        let start = Instant::now();
        let solved = solve(scene.name, &[], 1e-6);
        let time = start.elapsed().as_secs_f64();
        total += time;
        lines.push(match solved {
            Ok(solution) => {
                let steps = solution.history.steps.iter();
                format!(
                    "| {} | {} | {} | {} | {:.1} ms |",
                    scene.name,
                    solution.history.mesh.elements,
                    solution.history.mesh.unknowns,
                    steps.map(|step| step.increments.len()).sum::<usize>(),
                    1e3 * time
                )
            }
            Err(why) => format!("| {} | – | – | – | {why} |", scene.name),
        });
    }
    (lines.join("\n"), total)
}

/// Replaces what stands between the two markers of a file.
fn put_into(path: &Path, table: &str) -> Result<(), String> {
    let failed = |why: &dyn std::fmt::Display| format!("{}: {why}", path.display());
    let text = fs::read_to_string(path).map_err(|error| failed(&error))?;
    let parts = text.split_once(BEGIN).and_then(|(before, rest)| Some((before, rest.split_once(END)?.1)));
    let (before, after) = parts.ok_or_else(|| failed(&"no markers for the table"))?;
    fs::write(path, format!("{before}{BEGIN}\n{table}\n{END}{after}")).map_err(|error| failed(&error))
}

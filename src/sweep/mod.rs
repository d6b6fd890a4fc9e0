//! Sweeps: one network for many values of its parameters, solved side by side, in one table.

pub mod plan;
pub mod plot;
pub mod report;
pub mod table;
pub mod vary;

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use pennate_models::error::InputError;
use pennate_models::{Document, InputErrors, Model};
use pennate_solver::batch::TOGETHER;
use pennate_solver::history::Status;
use pennate_solver::options::{Options, Progress};
use rayon::prelude::*;

use crate::accuracy::{Shared, Verdict, solve_to_accuracy, solve_together};
use crate::explain;
use crate::output::files::{WriteError, make_directory};
use crate::output::text::shown;
use crate::solution::{ProbeTable, Solution, stable, status_name};

use self::plan::{Parameter, Plan};
use self::table::{Columns, Earlier, Journal, Manifest, Row};

/// What to solve, for which parameters, and where the table goes.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// Network files; with several of them each is swept.
    pub files: Vec<PathBuf>,
    pub plan: Plan,
    /// Parameters set to one value throughout.
    pub settings: Vec<(String, String)>,
    pub accuracy: f64,
    /// Solves at a time; one for each core by default.
    pub threads: Option<usize>,
    pub directory: PathBuf,
    /// Whether the table of another sweep there may go.
    pub overwrite: bool,
}

/// Why a sweep has no table.
#[derive(Debug)]
pub enum Failure {
    Input(InputErrors),
    Write(WriteError),
}

impl From<WriteError> for Failure {
    fn from(error: WriteError) -> Self {
        Self::Write(error)
    }
}

/// What came of a sweep.
#[derive(Clone, Debug)]
pub struct Outcome {
    pub columns: Columns,
    /// In the order of the files and of the combinations.
    pub rows: Vec<Row>,
    /// Rows that an earlier run had solved.
    pub reused: usize,
    pub interrupted: bool,
}

/// Rows that converged have this status.
pub const CONVERGED: &str = "converged";
/// That of one that came to its end with an error nobody knows.
pub const NO_ESTIMATE: &str = "no_estimate";
/// Column with the numbers of the designs of a list.
pub const DESIGN: &str = "design";

/// A combination of one file.
struct Case<'a> {
    document: &'a Document,
    keys: Vec<String>,
    settings: Vec<(String, String)>,
}

/// Solves all combinations that an earlier run in the same directory has not solved; `advance` hears of each.
///
/// # Errors
/// A file that cannot be read, a parameter that it does not have, a directory that cannot be written.
pub fn run(sweep: &Sweep, interrupted: &AtomicBool, advance: &(dyn Fn(usize) + Sync)) -> Result<Outcome, Failure> {
    let documents: Vec<Document> =
        sweep.files.iter().map(|file| Document::open(file)).collect::<Result<_, _>>().map_err(Failure::Input)?;
    let models: Vec<Model> = documents
        .iter()
        .map(|document| document.model(&sweep.settings))
        .collect::<Result<_, _>>()
        .map_err(Failure::Input)?;
    check_names(sweep, &models).map_err(Failure::Input)?;
    let columns = columns(sweep, &models);
    let cases = cases(sweep, &documents);
    let manifest = manifest(sweep, &models);
    make_directory(&sweep.directory)?;
    let wanted: HashMap<&[String], usize> =
        cases.iter().enumerate().map(|(index, case)| (case.keys.as_slice(), index)).collect();
    let earlier = table::earlier(&sweep.directory, &manifest, &columns);
    if !sweep.overwrite {
        check_earlier(sweep, &earlier, &wanted).map_err(Failure::Input)?;
    }
    let mut known = match earlier {
        Earlier::Same(rows) => rows,
        Earlier::None | Earlier::Other(_) => HashMap::new(),
    };
    known.retain(|keys, _| wanted.contains_key(keys.as_slice()));
    let reused = known.len();
    let journal = Mutex::new(Journal::begin(&sweep.directory, &manifest, &columns, known.values())?);
    // Groups do not depend on what is known already, so that a row is the same digit by digit whenever it is solved.
    let groups: Vec<&[Case]> = cases
        .chunk_by(|a, b| std::ptr::eq(a.document, b.document))
        .flat_map(|cases| cases.chunks(TOGETHER))
        .filter(|group| group.iter().any(|case| !known.contains_key(&case.keys)))
        .collect();
    advance(reused);
    let trouble = Mutex::new(None);
    let write = |row: Row| {
        let added = journal.lock().ok()?.add(&row);
        if let (Err(error), Ok(mut trouble)) = (added, trouble.lock()) {
            *trouble = Some(error);
        }
        advance(1);
        Some(row)
    };
    let solve = || -> Vec<Row> {
        groups
            .par_iter()
            .flat_map_iter(|group| {
                let open = |case: &Case| !known.contains_key(&case.keys);
                solve_group(group, &open, &columns, sweep.accuracy, interrupted, &write)
            })
            .collect()
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(sweep.threads.unwrap_or(0)).build();
    let solved = match pool {
        Ok(pool) => pool.install(solve),
        Err(_) => solve(), // no threads to be had: one after the other
    };
    if let Ok(Some(source)) = trouble.into_inner() {
        return Err(Failure::Write(WriteError { path: sweep.directory.join("sweep.csv"), source }));
    }
    let mut rows: Vec<Row> = known.into_values().chain(solved).collect();
    rows.sort_by_key(|row| wanted.get(row.keys.as_slice()).copied());
    table::write_table(&sweep.directory, &columns, rows.iter())?;
    let interrupted = rows.len() < cases.len();
    Ok(Outcome { columns, rows, reused, interrupted })
}

/// A table that this sweep does not go on with is not overwritten unasked.
fn check_earlier(sweep: &Sweep, earlier: &Earlier, wanted: &HashMap<&[String], usize>) -> Result<(), InputErrors> {
    let why = match earlier {
        Earlier::None => return Ok(()),
        Earlier::Other(why) => (*why).to_owned(),
        Earlier::Same(rows) => match rows.keys().filter(|keys| !wanted.contains_key(keys.as_slice())).count() {
            0 => return Ok(()),
            1 => "it holds a row that this sweep does not ask for".to_owned(),
            many => format!("it holds {many} rows that this sweep does not ask for"),
        },
    };
    let table = sweep.directory.join("sweep.csv");
    let error = InputError::new(format!("{} is that of another sweep: {why}", table.display()))
        .help("give another directory with -o, or --overwrite if the table may go");
    Err(InputErrors { errors: vec![error], sources: Vec::new() })
}

/// Every varied parameter is one of every file, and is varied once.
fn check_names(sweep: &Sweep, models: &[Model]) -> Result<(), InputErrors> {
    let mut errors = Vec::new();
    for (index, vary) in sweep.plan.parameters.iter().enumerate() {
        for (model, file) in models.iter().zip(&sweep.files) {
            if model.parameters.iter().all(|(name, _)| *name != vary.name) {
                let known: Vec<String> = model.parameters.iter().map(|(name, _)| format!("'{name}'")).collect();
                let error = InputError::new(format!("{} has no parameter '{}' to vary", file.display(), vary.name));
                errors.push(error.help(match known.is_empty() {
                    true => "define it under [parameters], and use it in expressions \"= …\"".to_owned(),
                    false => format!("its parameters: {}", known.join(", ")),
                }));
            }
        }
        let set = sweep.settings.iter().any(|(name, _)| *name == vary.name);
        if set || sweep.plan.parameters[..index].iter().any(|other| other.name == vary.name) {
            let message = format!("parameter '{}' is given values twice", vary.name);
            errors.push(InputError::new(message).help("vary it once, or set it"));
        }
    }
    if errors.is_empty() { Ok(()) } else { Err(InputErrors { errors, sources: Vec::new() }) }
}

/// Files that share probes make one table; a probe of some of them only stays empty in the rows of the others.
fn columns(sweep: &Sweep, models: &[Model]) -> Columns {
    let mut keys: Vec<String> = sweep.plan.parameters.iter().map(Parameter::head).collect();
    if sweep.plan.is_list {
        keys.insert(0, DESIGN.to_owned());
    }
    if models.len() > 1 {
        keys.insert(0, "file".to_owned());
    }
    let (mut probes, mut units) = (Vec::new(), Vec::new());
    for model in models {
        for (name, unit) in probe_columns(model).into_iter().zip(probe_units(model)) {
            if !probes.contains(&name) {
                probes.push(name);
                units.push(unit);
            }
        }
    }
    Columns { keys, probes, units }
}

/// A probe after each step; with one step just the probe.
fn probe_columns(model: &Model) -> Vec<String> {
    let steps = model.step_names();
    let one = |step: &str| model.probes.names.iter().map(|name| format!("{name}@{step}")).collect::<Vec<_>>();
    match steps.len() {
        1 => model.probes.names.clone(),
        _ => steps.iter().flat_map(|step| one(step)).collect(),
    }
}

/// Units of the probe columns.
fn probe_units(model: &Model) -> Vec<String> {
    let unit = |index: usize| crate::output::table::unit(model, model.probes.kind(index));
    let one: Vec<String> = (0..model.probes.len()).map(|index| unit(index).to_owned()).collect();
    one.iter().cycle().take(one.len() * model.step_names().len()).cloned().collect()
}

fn cases<'a>(sweep: &Sweep, documents: &'a [Document]) -> Vec<Case<'a>> {
    let plan = &sweep.plan;
    let one = |(document, file): (&'a Document, &PathBuf)| {
        let name = (documents.len() > 1).then(|| file.display().to_string());
        let case = |(index, values): (usize, &Vec<String>)| {
            let number = plan.is_list.then(|| (index + 1).to_string());
            let varied = plan.parameters.iter().zip(values).map(|(parameter, value)| parameter.setting(value));
            Case {
                document,
                keys: name.iter().chain(&number).chain(values).cloned().collect(),
                settings: sweep.settings.iter().cloned().chain(varied).collect(),
            }
        };
        plan.rows.iter().enumerate().map(case).collect::<Vec<_>>()
    };
    documents.iter().zip(&sweep.files).flat_map(one).collect()
}

fn manifest(sweep: &Sweep, models: &[Model]) -> Manifest {
    let sources = models.iter().flat_map(|model| &model.sources);
    let mut sources: Vec<(String, String)> = sources.map(|source| (source.name.clone(), source.text.clone())).collect();
    sources.dedup();
    sources.extend(sweep.settings.iter().map(|(name, value)| (format!("--set {name}"), value.clone())));
    Manifest {
        format: "pennate-sweep/1".to_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        accuracy: sweep.accuracy,
        sources,
    }
}

/// Solves combinations of one file side by side, and those alone that need more than the others; `write` has the rows of
/// those that are open, which are left out where the user did not want to wait for them.
fn solve_group(
    cases: &[Case],
    open: &(dyn Fn(&Case) -> bool + Sync),
    columns: &Columns,
    accuracy: f64,
    interrupted: &AtomicBool,
    write: &(dyn Fn(Row) -> Option<Row> + Sync),
) -> Vec<Row> {
    let options = Options { estimate: true, ..Options::default() };
    let stopped = || interrupted.load(Ordering::Relaxed);
    if stopped() {
        return Vec::new();
    }
    let models: Vec<_> = cases.iter().map(|case| case.document.model(&case.settings)).collect();
    let sound: Vec<&Model> = models.iter().flatten().collect();
    let mut together = solve_together(&sound, accuracy, &options, &mut |_| !stopped()).into_iter();
    let shared: Vec<_> =
        models.iter().map(|model| model.as_ref().ok().and_then(|_| together.next().flatten())).collect();
    let finish = |((case, model), shared): ((&Case, Result<Model, InputErrors>), Option<Shared>)| {
        if !open(case) {
            return None;
        }
        let row = Row { keys: case.keys.clone(), probes: vec![None; columns.probes.len()], ..Row::default() };
        let row = match (model, shared) {
            (Err(errors), _) => refused(row, errors.errors[0].message.clone()),
            (Ok(model), Some(Shared { probes, error, stable })) => {
                let row = Row { status: CONVERGED.to_owned(), stable, error: Some(error), ..row };
                with_probes(row, &model, &probes, usize::MAX, columns)
            }
            (Ok(_), None) if stopped() => return None,
            (Ok(model), None) => solve_alone(model, row, columns, accuracy, &options, &mut |_| !stopped())?,
        };
        write(row)
    };
    cases.par_iter().zip(models).zip(shared).filter_map(finish).collect()
}

fn refused(row: Row, reason: String) -> Row {
    Row { status: "wrong_input".to_owned(), reason, ..row }
}

/// Solves one combination; `None` where the user did not want to wait for it.
fn solve_alone(
    model: Model,
    row: Row,
    columns: &Columns,
    accuracy: f64,
    options: &Options,
    go_on: &mut dyn FnMut(&Progress) -> bool,
) -> Option<Row> {
    match solve_to_accuracy(model, accuracy, options, go_on) {
        Err((model, pennate_solver::error::SolveError::Mechanism(motions))) => {
            let motion = motions.first().map(|motion| explain::mechanism(&model, motion).title);
            Some(refused(row, motion.unwrap_or_else(|| "the network is a mechanism".to_owned())))
        }
        Ok(solution) => solved_row(&solution, row, columns),
    }
}

fn solved_row(solution: &Solution, mut row: Row, columns: &Columns) -> Option<Row> {
    let status = solution.status();
    if status == Status::Interrupted || solution.accuracy.verdict == Verdict::Interrupted {
        return None;
    }
    // What stands behind a step that was not finished belongs to another state than the column says.
    let whole = solution.history.steps.iter().take_while(|step| step.status == Status::Converged).count();
    row = with_probes(row, &solution.model, &solution.probes, whole, columns);
    row.status = status_name(status).to_owned();
    row.error = solution.accuracy.estimated;
    row.stable = stable(&solution.history);
    let steps = solution.history.steps.iter().enumerate();
    let mut failures = steps.filter_map(|(index, step)| explain::failed_step(&solution.model, index, step));
    let failure = failures.next();
    if let (None, Some(message)) = (&failure, explain::no_estimate(solution)) {
        row.status = NO_ESTIMATE.to_owned();
        row.reason = message.title;
        return Some(row);
    }
    row.reason = failure.map(|message| message.title).unwrap_or_default();
    let unstable = solution.steps().find(|(_, step)| step.status == Status::Converged && step.stable == Some(false));
    if let (Some((name, _)), true) = (unstable, row.reason.is_empty()) {
        row.reason = format!("step '{}' ends in an unstable state", shown(name));
    }
    Some(row)
}

/// A row with the probes at the ends of the first `whole` steps.
fn with_probes(mut row: Row, model: &Model, probes: &ProbeTable, whole: usize, columns: &Columns) -> Row {
    let names = probe_columns(model);
    let count = model.probes.len();
    for (step, probes) in probes.steps.iter().take(whole).enumerate() {
        for (name, value) in names[step * count..].iter().zip(probes.last().unwrap_or_default()) {
            if let Some(column) = columns.probes.iter().position(|column| column == name) {
                row.probes[column] = value.is_finite().then_some(*value);
            }
        }
    }
    row
}

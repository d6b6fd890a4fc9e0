//! Sweeps: one network for many values of its parameters, solved side by side, in one table.

pub mod plot;
pub mod report;
pub mod table;

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;

use pennate_analysis::solution::{ProbeTable, Solution, stable, status_name};
use pennate_analysis::sweep::{Answer, Case, Parameter, Plan};
use pennate_models::error::InputError;
use pennate_models::{Document, InputErrors, Model};
use pennate_solver::history::Status;

use crate::explain;
use crate::output::files::{WriteError, make_directory};
use crate::output::text::{shown, undecided};

use self::table::{Columns, Earlier, Journal, Manifest, Row};

/// What to solve, for which parameters, and where the table goes.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// Network files; with several of them each is swept.
    pub files: Vec<PathBuf>,
    /// The designs.
    pub plan: Plan,
    /// Parameters set to one value throughout.
    pub settings: Vec<(String, String)>,
    /// Mesh error asked for, relative.
    pub accuracy: f64,
    /// Solves at a time; one for each core by default.
    pub threads: Option<usize>,
    /// Folder of the table.
    pub directory: PathBuf,
    /// Whether the table of another sweep there may go.
    pub overwrite: bool,
}

/// Why a sweep has no table.
#[derive(Debug)]
pub enum Failure {
    /// The network file or the designs are wrong.
    Input(InputErrors),
    /// A file cannot be written.
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
    /// What the table has of every design.
    pub columns: Columns,
    /// In the order of the files and of the combinations.
    pub rows: Vec<Row>,
    /// Rows that an earlier run had solved.
    pub reused: usize,
    /// Whether it was told to stop.
    pub interrupted: bool,
}

/// Rows that converged have this status.
pub const CONVERGED: &str = "converged";
/// That of one that came to its end with an error nobody knows.
pub const NO_ESTIMATE: &str = "no_estimate";
/// Column with the numbers of the designs of a list.
pub const DESIGN: &str = "design";

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
    let (keys, cases): (Vec<Vec<String>>, Vec<Case>) = cases(sweep, &documents).into_iter().unzip();
    let manifest = manifest(sweep, &models);
    make_directory(&sweep.directory)?;
    let wanted: HashMap<&[String], usize> =
        keys.iter().enumerate().map(|(index, keys)| (keys.as_slice(), index)).collect();
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
    advance(reused);
    let (solved, trouble) = (Mutex::new(Vec::new()), Mutex::new(None));
    let answered = |index: usize, answer: Answer| {
        let empty = Row { keys: keys[index].clone(), probes: vec![None; columns.probes.len()], ..Row::default() };
        let row = row(answer, empty, &columns);
        let Ok(mut journal) = journal.lock() else { return };
        let added = journal.add(&row);
        drop(journal);
        if let (Err(error), Ok(mut trouble)) = (added, trouble.lock()) {
            *trouble = Some(error);
        }
        if let Ok(mut solved) = solved.lock() {
            solved.push(row);
        }
        advance(1);
    };
    let open = |index: usize| !known.contains_key(&keys[index]);
    let solve = || pennate_analysis::sweep::solve(&cases, &open, sweep.accuracy, interrupted, &answered);
    match rayon::ThreadPoolBuilder::new().num_threads(sweep.threads.unwrap_or(0)).build() {
        Ok(pool) => pool.install(solve),
        Err(_) => solve(), // no threads to be had: one after the other
    }
    if let Ok(Some(source)) = trouble.into_inner() {
        return Err(Failure::Write(WriteError { path: sweep.directory.join("sweep.csv"), source }));
    }
    let mut rows: Vec<Row> = known.into_values().chain(solved.into_inner().unwrap_or_default()).collect();
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
            if model.parameters.iter().all(|parameter| parameter.name != vary.name) {
                let known: Vec<String> =
                    model.parameters.iter().map(|parameter| format!("'{}'", parameter.name)).collect();
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
    let mut keys: Vec<String> = sweep.plan.parameters.iter().map(head).collect();
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

/// Name and unit of a parameter, as columns and axes have them.
pub fn head(parameter: &Parameter) -> String {
    crate::output::csv::head(&parameter.name, &parameter.unit)
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

/// The keys of all rows, and what is solved for them.
fn cases<'a>(sweep: &Sweep, documents: &'a [Document]) -> Vec<(Vec<String>, Case<'a>)> {
    let plan = &sweep.plan;
    let one = |(document, file): (&'a Document, &PathBuf)| {
        let name = (documents.len() > 1).then(|| file.display().to_string());
        let case = |(index, values): (usize, &Vec<String>)| {
            let number = plan.is_list.then(|| (index + 1).to_string());
            let varied = plan.parameters.iter().zip(values).map(|(parameter, value)| parameter.setting(value));
            let settings = sweep.settings.iter().cloned().chain(varied).collect();
            (name.iter().chain(&number).chain(values).cloned().collect(), Case { document, settings })
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

/// What came of a case, as a row; `empty` has its keys alone.
fn row(answer: Answer, empty: Row, columns: &Columns) -> Row {
    match answer {
        Answer::Refused(errors) => refused(empty, errors.errors[0].message.clone()),
        Answer::Mechanism(model, motions) => {
            let motion = motions.first().map(|motion| explain::mechanism(&model, motion).title);
            refused(empty, motion.unwrap_or_else(|| "the network is a mechanism".to_owned()))
        }
        Answer::Together(model, shared) => {
            let row = Row { status: CONVERGED.to_owned(), stable: shared.stable, error: Some(shared.error), ..empty };
            with_probes(row, &model, &shared.probes, usize::MAX, columns)
        }
        Answer::Alone(solution) => solved_row(&solution, empty, columns),
    }
}

fn refused(row: Row, reason: String) -> Row {
    Row { status: "wrong_input".to_owned(), reason, ..row }
}

fn solved_row(solution: &Solution, mut row: Row, columns: &Columns) -> Row {
    let status = solution.status();
    // What stands behind a step that was not finished belongs to another state than the column says.
    let whole = solution.history.steps.iter().take_while(|step| step.status == Status::Converged).count();
    row = with_probes(row, &solution.model, &solution.probes, whole, columns);
    row.status = status_name(status).to_owned();
    row.error = solution.accuracy.estimated;
    row.stable = stable(&solution.history);
    let failure = explain::failed_steps(&solution.model, &solution.history.steps).next();
    if let (None, Some(message)) = (&failure, explain::no_estimate(solution)) {
        row.status = NO_ESTIMATE.to_owned();
        row.reason = message.title;
        return row;
    }
    row.reason = failure.map(|message| message.title).unwrap_or_default();
    let unstable = solution.steps().find(|(_, step)| step.status == Status::Converged && step.stable == Some(false));
    if let (Some((name, _)), true) = (unstable, row.reason.is_empty()) {
        row.reason = format!("step '{}' ends in an unstable state", shown(name));
    }
    let open = solution.steps().find_map(|(name, step)| Some((name, undecided(step)?)));
    if let (Some((name, why)), true) = (open, row.reason.is_empty()) {
        row.reason = format!("step '{}' ends {why}", shown(name));
    }
    row
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

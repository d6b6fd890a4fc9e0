//! The commands: what they print, what they write and how they end.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use pennate_analysis::accuracy::Verdict;
use pennate_analysis::fit::Request;
use pennate_analysis::solution::Solution;
use pennate_analysis::spectrum::NoSpectrum;
use pennate_models::scenes::{self, SCENES};
use pennate_solver::history::Status;

use crate::diagnostics::{Message, Severity, show, show_errors, show_warnings};
use crate::fit;
use crate::output::files::{check_writable, write_whole};
use crate::output::{Pictures, json, table, write_files};
use crate::progress::{Bar, Counter};
use crate::spectrum::{self, NoAnswer};
use crate::sweep::{self, Sweep};
use crate::{Input, Job, Refusal, clock, explain, output, read, run_until};

/// How a command ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Everything was done: 0.
    Done,
    /// No equilibrium where one was asked for, or the results could not be written.
    NotSolved,
    /// The input is wrong: 2.
    WrongInput,
    /// It was told to stop: 130.
    Interrupted,
}

impl Exit {
    /// The exit status of the process.
    pub fn status(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::NotSolved => 1,
            Self::WrongInput => 2,
            Self::Interrupted => 130,
        }
    }
}

/// What `pennate solve` writes, and where.
#[derive(Clone, Debug, Default)]
pub struct Destination {
    /// Folder of the files that are written; none without it.
    pub directory: Option<PathBuf>,
    /// Which states are drawn, if any.
    pub pictures: Option<Pictures>,
    /// Print `results.json` instead of the table.
    pub json: bool,
}

/// `pennate solve`: solves a network, prints the table or the results and writes the files asked for.
pub fn solve(job: &Job, destination: &Destination) -> Exit {
    if let Some(directory) = &destination.directory
        && let Err(error) = check_writable(directory)
    {
        return could_not(&error);
    }
    let interrupted = listen_for_interrupt();
    let mut bar = Bar::new();
    let outcome = run_until(job, Some(Arc::clone(&interrupted.asked)), &mut |progress| {
        bar.show(progress);
        !interrupted.is_asked()
    });
    interrupted.end();
    drop(bar);
    match outcome {
        Ok(mut solution) => deliver(&mut solution, &job.input, destination),
        Err(refusal) => refuse(&refusal),
    }
}

/// `pennate modes` and `pennate buckle`: prints the table or the results and writes the files asked for.
pub fn spectrum(job: &spectrum::Job, destination: &Destination) -> Exit {
    if let Some(directory) = &destination.directory
        && let Err(error) = check_writable(directory)
    {
        return could_not(&error);
    }
    let interrupted = listen_for_interrupt();
    let mut bar = Bar::new();
    let outcome = spectrum::run(job, &mut |progress| {
        bar.show(progress);
        !interrupted.is_asked()
    });
    interrupted.end();
    drop(bar);
    let spectrum = match outcome {
        Ok(spectrum) => spectrum,
        Err(why) => return no_spectrum(why),
    };
    show_warnings(&spectrum.model.warnings, &spectrum.model.sources);
    let written = match &destination.directory {
        Some(directory) => {
            output::spectrum::write_files(&spectrum, directory, &stem(&job.input), destination.pictures.is_some())
        }
        None => Ok(()),
    };
    let printed = match destination.json {
        true => print(|out| output::spectrum::json::write(&spectrum, &[], out)),
        false => print(|out| out.write_all(output::spectrum::table::report(&spectrum).as_bytes())),
    };
    match written {
        Err(error) => could_not(&error),
        Ok(()) => printed,
    }
}

fn no_spectrum(why: NoAnswer) -> Exit {
    let why = match why {
        NoAnswer::Input(errors) => return refuse(&Refusal::Input(errors)),
        NoAnswer::Spectrum(NoSpectrum::Mechanism(model, motions)) => {
            return refuse(&Refusal::Mechanism(model, motions));
        }
        NoAnswer::Spectrum(NoSpectrum::Interrupted) => return Exit::Interrupted,
        NoAnswer::Spectrum(why) => why,
    };
    let (exit, sources) = match &why {
        NoSpectrum::NotSolved(model, _) => (Exit::NotSolved, model.sources.clone()),
        _ => (Exit::WrongInput, Vec::new()),
    };
    for message in spectrum::messages(why) {
        show(Severity::Error, &message, &sources);
    }
    exit
}

/// `pennate flow`: prints the table or the results and writes the files asked for.
pub fn flow(input: &Input, threads: Option<usize>, destination: &Destination) -> Exit {
    if let Some(directory) = &destination.directory
        && let Err(error) = check_writable(directory)
    {
        return could_not(&error);
    }
    let document = match crate::flow::document(input) {
        Ok(document) => document,
        Err(errors) => return refuse(&Refusal::Input(errors)),
    };
    let interrupted = listen_for_interrupt();
    let mut bar = Bar::new();
    let stop = Some(Arc::clone(&interrupted.asked));
    let outcome = crate::flow::answer(&document, &input.settings, threads, stop, &mut |progress| {
        bar.show(progress);
        !interrupted.is_asked()
    });
    interrupted.end();
    drop(bar);
    let flow = match outcome {
        Ok(flow) => flow,
        Err(crate::flow::NoAnswer::Refused(refusal)) => return refuse(&refusal),
        Err(crate::flow::NoAnswer::Interrupted) => return Exit::Interrupted,
    };
    show_warnings(&flow.model.warnings, &flow.model.sources);
    let written = match &destination.directory {
        Some(directory) => output::flow::write_files(&flow, directory),
        None => Ok(()),
    };
    let printed = match destination.json {
        true => print(|out| output::flow::json::write(&flow, out)),
        false => print(|out| out.write_all(output::flow::table::report(&flow).as_bytes())),
    };
    match written {
        Err(error) => could_not(&error),
        Ok(()) => printed,
    }
}

/// `pennate check`: everything short of solving.
pub fn check(input: &Input) -> Exit {
    let model = match read(input) {
        Ok(model) => model,
        Err(errors) => return refuse(&Refusal::Input(errors)),
    };
    let near = match crate::near_motion(&model) {
        Ok(near) => near,
        Err(motions) => return refuse(&Refusal::Mechanism(Box::new(model), motions)),
    };
    show_warnings(&model.warnings, &model.sources);
    if let Some(near) = near {
        show(Severity::Warning, &explain::near_mechanism(&model, &near), &model.sources);
    }
    print(|out| writeln!(out, "{}", table::checked(&model)))
}

/// `pennate sweep`: many combinations of parameters, into one table and one plot.
pub fn sweep(sweep: &Sweep) -> Exit {
    if let Err(error) = check_writable(&sweep.directory) {
        return could_not(&error);
    }
    let start = clock();
    let interrupted = listen_for_interrupt();
    let bar = Counter::new(sweep.files.len() * sweep.plan.rows.len());
    let outcome = sweep::run(sweep, &interrupted.asked, &|count| bar.advance(count));
    interrupted.end();
    bar.clear();
    let outcome = match outcome {
        Ok(outcome) => outcome,
        Err(sweep::Failure::Input(errors)) => return refuse(&Refusal::Input(errors)),
        Err(sweep::Failure::Write(error)) => return could_not(&error),
    };
    let picture = sweep.directory.join("sweep.svg");
    let drawn = sweep::plot::draw(&outcome, &sweep.plan, &picture);
    let took = clock().saturating_sub(start);
    let exit = print(|out| out.write_all(sweep::report::report(&outcome, took).as_bytes()));
    if let Err(error) = drawn {
        let title = format!("cannot draw {}: {error}", picture.display());
        show(Severity::Error, &Message { title, ..Message::default() }, &[]);
        return Exit::NotSolved;
    }
    match (outcome.interrupted, outcome.rows.iter().all(sweep::table::Row::is_solved)) {
        (true, _) => Exit::Interrupted,
        (false, true) => exit,
        (false, false) => Exit::NotSolved,
    }
}

/// `pennate fit`: the table of a muscle from test data, with its errors, as text, file and picture.
pub fn fit(request: &Request, output: Option<&Path>, check: bool, plot: Option<&Path>, curves: Option<&Path>) -> Exit {
    let start = clock();
    let fitted = match pennate_analysis::fit::run(request) {
        Ok(fitted) => fitted,
        Err(errors) => return refuse(&Refusal::Input(errors)),
    };
    let took = clock().saturating_sub(start);
    for warning in fit::report::warnings(&fitted) {
        show(Severity::Warning, &warning, &[]);
    }
    let mut text = fit::report::report(&fitted, took);
    if check {
        text += &format!("\n{}", fit::report::check(&fitted));
    }
    let printed = print(|out| out.write_all(text.as_bytes()));
    if let Some(path) = output
        && let Err(error) = write_whole(path, |out| out.write_all(fit::file::text(&fitted).as_bytes()))
    {
        return could_not(&error);
    }
    let drawn = [
        plot.map(|path| (path, fit::plot::draw(&fitted, path))),
        curves.map(|path| (path, fit::curves::draw(&fitted, path))),
    ];
    for (path, drawn) in drawn.into_iter().flatten() {
        if let Err(error) = drawn {
            let title = format!("cannot draw {}: {error}", path.display());
            show(Severity::Error, &Message { title, ..Message::default() }, &[]);
            return Exit::NotSolved;
        }
    }
    printed
}

/// `pennate schema`: the JSON Schema of the network file.
pub fn schema() -> Exit {
    let schema = pennate_models::schema();
    print(|out| {
        serde_json::to_writer_pretty(&mut *out, &schema)?;
        writeln!(out)
    })
}

/// `pennate scene NAME`: the network file of a scene.
pub fn scene(name: &str, settings: &[(String, String)]) -> Exit {
    match scenes::write(name, settings) {
        Ok(text) => print(|out| out.write_all(text.as_bytes())),
        Err(errors) => refuse(&Refusal::Input(errors)),
    }
}

/// `pennate scene`: the scenes with their parameters.
pub fn scenes() -> Exit {
    print(|out| {
        for scene in SCENES {
            writeln!(out, "{:18}  {}", scene.name, scene.title)?;
            for parameter in scene.parameters {
                writeln!(
                    out,
                    "{:18}    {:10} {:24}  {}",
                    "",
                    parameter.name,
                    parameter.default.to_string(),
                    parameter.what
                )?;
            }
        }
        Ok(())
    })
}

fn deliver(solution: &mut Solution, input: &Input, destination: &Destination) -> Exit {
    show_warnings(&solution.model.warnings, &solution.model.sources);
    for message in explain::remarks(solution) {
        show(Severity::Warning, &message, &solution.model.sources);
    }
    let written = match &destination.directory {
        Some(directory) => write_files(solution, directory, &stem(input), destination.pictures),
        None => Ok(()),
    };
    let printed = match destination.json {
        true => print(|out| json::write(solution, &[], out)),
        false => print(|out| out.write_all(table::report(solution).as_bytes())),
    };
    for message in explain::failures(solution) {
        show(Severity::Error, &message, &solution.model.sources);
    }
    match written {
        Err(error) => could_not(&error),
        Ok(()) if printed != Exit::Done => printed,
        Ok(()) => exit_of(solution),
    }
}

/// The name that pictures go by: that of the network file.
fn stem(input: &Input) -> String {
    // Collections are XML, which cannot name a file that has such letters.
    let forbidden = |letter: char| letter.is_control() || matches!(letter, '\u{fffe}' | '\u{ffff}');
    let stem = input.file.file_stem().map(|stem| stem.to_string_lossy().replace(forbidden, "_"));
    stem.filter(|stem| stem != "-").unwrap_or_else(|| "network".to_owned())
}

fn exit_of(solution: &Solution) -> Exit {
    match solution.status() {
        Status::Converged if solution.accuracy.verdict == Verdict::Interrupted => Exit::Interrupted,
        Status::Converged if solution.accuracy.estimated.is_none() => Exit::NotSolved,
        Status::Converged => Exit::Done,
        Status::Interrupted => Exit::Interrupted,
        Status::LimitPoint | Status::Bifurcation | Status::NotConverged | Status::NotReached => Exit::NotSolved,
    }
}

/// Says why a network is not solved at all.
pub fn refuse(refusal: &Refusal) -> Exit {
    match refusal {
        Refusal::Input(errors) => show_errors(errors),
        Refusal::Mechanism(model, motions) => {
            show_warnings(&model.warnings, &model.sources);
            for message in explain::mechanisms(model, motions) {
                show(Severity::Error, &message, &model.sources);
            }
        }
    }
    Exit::WrongInput
}

/// Prints to standard output; a reader that has seen enough is no error.
fn print(write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Exit {
    let mut out = io::BufWriter::new(io::stdout().lock());
    match write(&mut out).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            could_not(&crate::output::files::WriteError { path: "standard output".into(), source: error })
        }
        _ => Exit::Done,
    }
}

fn could_not(error: &crate::output::files::WriteError) -> Exit {
    show(Severity::Error, &Message { title: error.to_string(), ..Message::default() }, &[]);
    Exit::NotSolved
}

/// How long after an interrupt a solve may take to come to a place where it can stop.
const PATIENCE: Duration = Duration::from_millis(900);

/// What a user who does not want to wait has asked for.
struct Interrupt {
    asked: Arc<AtomicBool>,
    solving: Arc<AtomicBool>,
}

impl Interrupt {
    fn is_asked(&self) -> bool {
        self.asked.load(Ordering::Relaxed)
    }

    /// The solve is over: what is left to do is done to its end.
    fn end(&self) {
        self.solving.store(false, Ordering::Relaxed);
    }
}

/// Listens for interrupts: the first one stops the solve where it can be stopped, or ends the process where that takes too
/// long; the second one ends the process at once.
fn listen_for_interrupt() -> Interrupt {
    let interrupt = Interrupt { asked: Arc::new(AtomicBool::new(false)), solving: Arc::new(AtomicBool::new(true)) };
    let (asked, solving) = (Arc::clone(&interrupt.asked), Arc::clone(&interrupt.solving));
    // Without a handler an interrupt ends the process, as it does anywhere else.
    let _ = ctrlc::set_handler(move || {
        if asked.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        let solving = Arc::clone(&solving);
        std::thread::spawn(move || {
            std::thread::sleep(PATIENCE);
            if solving.load(Ordering::Relaxed) {
                let title = "interrupted where nothing could be kept; nothing is written".to_owned();
                show(Severity::Error, &Message { title, ..Message::default() }, &[]);
                std::process::exit(130);
            }
        });
    });
    interrupt
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;
    use pennate_analysis::accuracy::Accuracy;

    fn converged(verdict: Verdict, estimated: Option<f64>) -> Solution {
        let mut solution = fixture::solution();
        solution.history.steps.iter_mut().for_each(|step| step.status = Status::Converged);
        solution.accuracy = Accuracy { verdict, estimated, ..solution.accuracy };
        solution
    }

    /// An error larger than asked for is an answer with a warning, one that nobody knows is none.
    #[test]
    fn an_answer_without_an_estimate_is_no_answer() {
        let met = converged(Verdict::Met, Some(1e-8));
        assert_eq!((exit_of(&met), explain::inaccurate(&met).is_some()), (Exit::Done, false));
        let forced = converged(Verdict::Forced, Some(0.5));
        assert_eq!((exit_of(&forced), explain::inaccurate(&forced).is_some()), (Exit::Done, true));
        assert!(explain::failures(&forced).is_empty());
        let unknown = converged(Verdict::NotEstimated, None);
        assert_eq!(exit_of(&unknown), Exit::NotSolved);
        assert_eq!(explain::failures(&unknown).len(), 1);
        assert!(table::report(&unknown).contains("NO ERROR ESTIMATE"));
    }
}

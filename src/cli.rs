//! The command line: arguments and exit status.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand};
use pennate_analysis::fit::optimize::Method;
use pennate_analysis::fit::{self, EndLength};
use pennate_analysis::spectrum::{Question, Request};
use pennate_analysis::sweep::{Plan, Vary};

use crate::commands::{self, Destination};
use crate::output::Pictures;
use crate::spectrum;
use crate::{Input, Job, Refusal};

/// Analyses networks of soft pneumatic muscles and compliant members.
#[derive(Parser)]
#[command(name = "pennate", version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Solve a network and print a short table.
    Solve(Solve),
    /// Print natural frequencies and modes of small vibrations about a converged state.
    ///
    /// Masses come from densities and rigid bodies; each frequency has its estimated error. A plane network vibrates in its
    /// plane and, where the supports hold it out of it, out of it too. A negative eigenvalue is no frequency: the state
    /// is unstable.
    Modes(Modes),
    /// Print critical factors and modes of linear buckling about a converged state.
    ///
    /// The factor multiplies the ramp of a step, the last one unless --along names another: 0 is its beginning, about
    /// which the network is linearized, and 1 its end. With --step the state is the end of that step, and the factor
    /// multiplies all loads, pressures and prescribed motions present there: 1 is the state itself. The shape is that of
    /// the state; the nearer the state is to the critical one, the more exact is the factor.
    Buckle(Buckle),
    /// Read and check a network: everything short of solving.
    Check(Network),
    /// Solve a network for many values of its parameters, into one table and one plot.
    Sweep(Sweep),
    /// Fit the table of a muscle to test data.
    ///
    /// The data are a CSV file with one equilibrium a row: length, pressure, dead loads on the tip of a clamped muscle, and
    /// where the tip comes to rest. Columns carry their units in their names, such as L_mm, pressure_psi, Fx_N, Fy_N,
    /// Mz_Nmm, tip_x_mm, tip_y_mm, tip_theta_deg; variant, test, converged and ovality_min are optional.
    Fit(Fit),
    /// Print which members of a mechanism transmit what its input puts in, and put muscles in place of them.
    ///
    /// The network file says under [load_flow] where the mechanism is driven and what it moves. Members are transmitters where
    /// at least half of the energy transferred along them is axial. Levels of transmitters of the right sense are replaced
    /// by muscles one after the other, from the clamped input on, and each network is solved.
    Flow(LoadFlow),
    /// Print the JSON Schema of the network file.
    Schema,
    /// Write the network file of a scene of the dissertation to standard output; list the scenes without a name.
    Scene(Scene),
}

#[derive(Args)]
struct Network {
    /// Network file, TOML or JSON; - reads TOML from standard input.
    file: PathBuf,
    /// Give a parameter another value; may be repeated.
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = setting)]
    settings: Vec<(String, String)>,
}

#[derive(Args)]
struct Solve {
    #[command(flatten)]
    network: Network,
    /// Write results.json and history.csv into this directory.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Print results.json instead of the table.
    #[arg(long)]
    json: bool,
    /// Write pictures too: NAME.pvd with the unloaded state and one .vtu an increment, or one every=N of them, or only
    /// those at the ends of steps.
    #[arg(
        long,
        requires = "output",
        value_name = "every=N|ends",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "all"
    )]
    vtk: Option<Pictures>,
    /// Discretization error asked for, relative to the largest value of its kind.
    #[arg(long, value_name = "ERROR", default_value = "1e-6", value_parser = accuracy)]
    accuracy: f64,
    /// Threads to use; the results are the same with any number.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
}

#[derive(Args)]
struct Sweep {
    /// Network files; each is swept.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Values of a parameter, from:to:step or a list, with a unit if need be; may be repeated.
    #[arg(long, value_name = "NAME=VALUES", required_unless_present = "designs")]
    vary: Vec<Vary>,
    /// Solve the rows of a CSV file instead, whose heads are parameters, with a unit if need be: beta (deg).
    #[arg(long, value_name = "FILE.csv", conflicts_with = "vary")]
    designs: Option<PathBuf>,
    /// Give a parameter one other value; may be repeated.
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = setting)]
    settings: Vec<(String, String)>,
    /// Write sweep.csv and sweep.svg into this directory; what it holds of this sweep is not solved again.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Write over the table of another sweep in that directory.
    #[arg(long)]
    overwrite: bool,
    /// Discretization error asked for, relative to the largest value of its kind.
    #[arg(long, value_name = "ERROR", default_value = "1e-6", value_parser = accuracy)]
    accuracy: f64,
    /// Solves at a time; one for each core by default.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
}

#[derive(Args)]
struct Fit {
    /// Test data, CSV.
    data: PathBuf,
    /// Undeformed outer diameter, mm.
    #[arg(long, value_name = "MM")]
    diameter: f64,
    /// Wall, mm.
    #[arg(long, value_name = "MM")]
    wall: f64,
    /// Which muscle of data that hold several, by the column 'variant'.
    #[arg(long, value_name = "NAME")]
    variant: Option<String>,
    /// Fit the load cases of this length, mm; the middle one of the data by default.
    #[arg(long, value_name = "MM")]
    length: Option<f64>,
    /// Kinds of test to fit, by the column 'test'.
    #[arg(long, value_name = "NAMES", value_delimiter = ',', default_values = fit::TESTS)]
    tests: Vec<String>,
    /// Leave out load cases of a smaller ovality: kinked ones have less than 0.93.
    #[arg(long, value_name = "RATIO")]
    min_ovality: Option<f64>,
    /// Length of the ends that do not contract, mm, or 'fit'; one diameter by default.
    #[arg(long, value_name = "MM", value_parser = end_length)]
    end_length: Option<EndLength>,
    /// Fit a modulus of the ends besides that of the middle.
    #[arg(long)]
    two_moduli: bool,
    /// Take the muscle for a shear-flexible (Timoshenko) rod.
    #[arg(long)]
    shear: bool,
    /// How the differences are made least.
    #[arg(long, value_enum, default_value = "least-squares")]
    method: FitMethod,
    /// Write the muscle file.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Print the errors at every length of the data.
    #[arg(long)]
    check: bool,
    /// Draw them, SVG.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Draw measured points and fitted curves of the load cases, SVG.
    #[arg(long, value_name = "FILE")]
    curves: Option<PathBuf>,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum FitMethod {
    /// Levenberg-Marquardt with exact derivatives.
    LeastSquares,
    /// Nelder-Mead, restarted.
    NelderMead,
}

#[derive(Args)]
struct LoadFlow {
    #[command(flatten)]
    network: Network,
    /// Write flow.json, flow.svg and a network file for each level of muscles into this directory.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Print flow.json instead of the table.
    #[arg(long)]
    json: bool,
    /// Threads to use; the results are the same with any number.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
}

#[derive(Args)]
struct Scene {
    /// Name of the scene.
    name: Option<String>,
    /// Give a parameter of the scene another value; may be repeated.
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = setting, requires = "name")]
    settings: Vec<(String, String)>,
}

/// What modes and buckling have in common.
#[derive(Args)]
struct Spectrum {
    #[command(flatten)]
    network: Network,
    /// How many modes.
    #[arg(long, value_name = "N", default_value = "6", value_parser = clap::value_parser!(u16).range(1..=1000))]
    count: u16,
    /// Write modes.json or buckling.json into this directory.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Print that file instead of the table.
    #[arg(long)]
    json: bool,
    /// Write pictures too: one NAME_mode_NN.vtu a mode.
    #[arg(long, requires = "output")]
    vtk: bool,
    /// Discretization error asked for, relative to each frequency or factor.
    #[arg(long, value_name = "ERROR", default_value = "1e-6", value_parser = accuracy)]
    accuracy: f64,
    /// Threads to use; the results are the same with any number.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
}

#[derive(Args)]
struct Modes {
    #[command(flatten)]
    spectrum: Spectrum,
    /// The step at whose end the state is; the last one unless named.
    #[arg(long, value_name = "NAME")]
    step: Option<String>,
}

#[derive(Args)]
struct Buckle {
    #[command(flatten)]
    spectrum: Spectrum,
    /// About the end of this step: the factor multiplies all loads, pressures and prescribed motions there.
    #[arg(long, value_name = "NAME", conflicts_with = "along")]
    step: Option<String>,
    /// About the beginning of this step: the factor multiplies its ramp; the last step unless named.
    #[arg(long, value_name = "NAME")]
    along: Option<String>,
}

impl Spectrum {
    fn answer(self, question: Question, step: Option<String>, along: Option<String>) -> commands::Exit {
        let pictures = self.vtk.then(Pictures::default);
        let destination = Destination { directory: self.output, pictures, json: self.json };
        let job = spectrum::Job {
            input: self.network.into(),
            request: Request { question, step, along, count: usize::from(self.count), accuracy: self.accuracy },
            threads: self.threads.map(usize::from),
        };
        commands::spectrum(&job, &destination)
    }
}

/// Commands of the Python package alone, and what they do.
const ELSEWHERE: [(&str, &str); 4] = [
    ("optimize", "Look for designs: pennate optimize STUDY.toml -o DIR"),
    ("plot", "Draw a network file, or the results of one: pennate plot FILE -o picture.png (or .gif, .mp4)"),
    ("view", "Show a network file as a page with sliders: pennate view FILE"),
    ("report", "Write one page to send to a colleague: pennate report FILE -o report.html"),
];

/// Does what the arguments ask for, the name of the program first, and returns the exit status of the process.
pub fn run(arguments: impl Iterator<Item = OsString>) -> u8 {
    let names = ELSEWHERE.map(|(name, _)| name).join(", ");
    let more = format!("With the Python package also: {names}");
    answer(Arguments::command().after_help(more), arguments)
}

/// The same for the Python package, which does more commands, and before they come here: help names them.
pub fn run_in_package(arguments: impl Iterator<Item = OsString>) -> u8 {
    let more = ELSEWHERE.map(|(name, what)| clap::Command::new(name).about(what));
    answer(Arguments::command().subcommands(more), arguments)
}

fn answer(command: clap::Command, arguments: impl Iterator<Item = OsString>) -> u8 {
    let matches = command.try_get_matches_from(joined(arguments));
    let arguments = match matches.and_then(|matches| Arguments::from_arg_matches(&matches)) {
        Ok(arguments) => arguments,
        Err(error) => {
            // Nobody is left to be told that the output is closed.
            let _ = error.print();
            return u8::try_from(error.exit_code()).unwrap_or(u8::MAX);
        }
    };
    let exit = match arguments.command {
        Command::Solve(arguments) => {
            let destination =
                Destination { directory: arguments.output, pictures: arguments.vtk, json: arguments.json };
            let job = Job {
                input: arguments.network.into(),
                accuracy: arguments.accuracy,
                threads: arguments.threads.map(usize::from),
                shapes: arguments.vtk.is_some(),
            };
            commands::solve(&job, &destination)
        }
        Command::Modes(modes) => modes.spectrum.answer(Question::Modes, modes.step, None),
        Command::Buckle(buckle) => buckle.spectrum.answer(Question::Buckling, buckle.step, buckle.along),
        Command::Check(network) => commands::check(&network.into()),
        Command::Sweep(arguments) => arguments.answer(),
        Command::Fit(fit) => fit.answer(),
        Command::Flow(flow) => {
            let destination = Destination { directory: flow.output, pictures: None, json: flow.json };
            commands::flow(&flow.network.into(), flow.threads.map(usize::from), &destination)
        }
        Command::Schema => commands::schema(),
        Command::Scene(Scene { name: Some(name), settings }) => commands::scene(&name, &settings),
        Command::Scene(Scene { name: None, .. }) => commands::scenes(),
    };
    exit.status()
}

/// Arguments with what follows --vtk joined to it: `--vtk ends` is `--vtk=ends`, and `--vtk FILE` stays as it is.
fn joined(arguments: impl Iterator<Item = OsString>) -> Vec<OsString> {
    let mut all: Vec<OsString> = Vec::new();
    for argument in arguments {
        let which = argument.to_str().filter(|text| text.parse::<Pictures>().is_ok() || text.starts_with("every="));
        match (all.last_mut(), which) {
            (Some(last), Some(which)) if last == "--vtk" => *last = format!("--vtk={which}").into(),
            _ => all.push(argument),
        }
    }
    all
}

impl Sweep {
    fn answer(self) -> commands::Exit {
        let plan = match &self.designs {
            Some(path) => Plan::list(path),
            None => Plan::combinations(&self.vary),
        };
        let plan = match plan {
            Ok(plan) => plan,
            Err(errors) => return commands::refuse(&Refusal::Input(errors)),
        };
        commands::sweep(&crate::sweep::Sweep {
            files: self.files,
            plan,
            settings: self.settings,
            accuracy: self.accuracy,
            threads: self.threads.map(usize::from),
            directory: self.output,
            overwrite: self.overwrite,
        })
    }
}

impl From<Network> for Input {
    fn from(network: Network) -> Self {
        Self { file: network.file, settings: network.settings }
    }
}

impl Fit {
    fn answer(&self) -> commands::Exit {
        let [output, plot, curves] = [&self.output, &self.plot, &self.curves].map(|path| path.as_deref());
        commands::fit(&self.request(), output, self.check, plot, curves)
    }

    fn request(&self) -> fit::Request {
        fit::Request {
            data: self.data.clone(),
            variant: self.variant.clone(),
            length: self.length,
            tests: self.tests.clone(),
            min_ovality: self.min_ovality,
            diameter: self.diameter,
            wall: self.wall,
            end_length: self.end_length.unwrap_or(EndLength::Diameter),
            shear: self.shear,
            two_moduli: self.two_moduli,
            method: match self.method {
                FitMethod::LeastSquares => Method::LeastSquares,
                FitMethod::NelderMead => Method::NelderMead,
            },
            words: fit::Words { variant: "--variant", end_length: "--end-length" },
        }
    }
}

fn end_length(text: &str) -> Result<EndLength, String> {
    match text.parse::<f64>() {
        Ok(length) if length > 0.0 && length.is_finite() => Ok(EndLength::Given(length)),
        Err(_) if text == "fit" => Ok(EndLength::Fitted),
        _ => Err("a length in mm expected, or 'fit'".to_owned()),
    }
}

fn setting(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() && !value.trim().is_empty() => {
            Ok((name.trim().to_owned(), value.trim().to_owned()))
        }
        _ => Err("NAME=VALUE expected, such as beta=30".to_owned()),
    }
}

fn accuracy(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value < 1.0 => Ok(value),
        _ => Err("a number between 0 and 1 expected, such as 1e-6".to_owned()),
    }
}

//! Makes a network file that shows a failure as small as it can be while the failure stays, and prints it.
//!
//! `cargo run --release --example shrink -- FILE --elsewhere`, for one that ends elsewhere than in 100 increments; with
//! `--status`, `--contradicted`, `--panics` or `--probe NAME` for other failures. `--while COMMAND` keeps what makes a command
//! of the shell end with status 0, `{}` standing for the file: two builds that disagree, say.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use pennate_testing::failures::Failure;
use pennate_testing::shrink::shrink;

/// Make a network file that shows a failure as small as it can be while the failure stays, and print it
#[derive(Parser)]
struct Arguments {
    /// The network file, in TOML
    file: PathBuf,
    #[command(flatten)]
    failure: Choice,
}

#[derive(clap::Args)]
#[group(required = true, multiple = false)]
struct Choice {
    /// It ends elsewhere than in 100 increments
    #[arg(long)]
    elsewhere: bool,
    /// It ends with another status than in 100 increments
    #[arg(long)]
    status: bool,
    /// Its lowest modes say other than its verdict on stability
    #[arg(long)]
    contradicted: bool,
    /// Something panics
    #[arg(long)]
    panics: bool,
    /// This probe has another value at the end than in 100 increments
    #[arg(long, value_name = "NAME")]
    probe: Option<String>,
    /// This command of the shell ends with status 0; {} is the file
    #[arg(long = "while", value_name = "COMMAND")]
    command: Option<String>,
}

impl Choice {
    fn failure(self) -> Failure {
        match (self.probe, self.command) {
            (Some(name), _) => Failure::Probe(name),
            (_, Some(command)) => Failure::Command(command),
            _ if self.elsewhere => Failure::Elsewhere,
            _ if self.status => Failure::Status,
            _ if self.contradicted => Failure::Contradicted,
            _ => Failure::Panics,
        }
    }
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let failure = arguments.failure.failure();
    if failure == Failure::Panics {
        std::panic::set_hook(Box::new(|_| {}));
    }
    let text = match std::fs::read_to_string(&arguments.file) {
        Ok(text) => text,
        Err(error) => {
            eprintln!("error: {}: {error}", arguments.file.display());
            return ExitCode::from(2);
        }
    };
    match shrink(&text, |text| failure.holds(text)) {
        Ok(shrunk) => {
            print!("{}", shrunk.text);
            eprintln!("{} files tried; {} bytes of {} are left", shrunk.tried, shrunk.text.len(), text.len());
            ExitCode::SUCCESS
        }
        Err(why) => {
            eprintln!("error: {why}");
            ExitCode::FAILURE
        }
    }
}

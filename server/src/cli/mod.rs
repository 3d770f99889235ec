//! The command line: what can be asked of `evswarm`, exit codes and logging.

mod catalog;
mod checkpoint;
mod client;
mod compare;
mod config;
mod data;
mod failure;
mod out;
mod output;
mod progress;
mod replay;
mod reproduce;
mod run;
mod serve;
mod token;
mod values;

use std::ffi::OsString;
use std::io::IsTerminal;
use std::process::ExitCode;
use std::sync::LazyLock;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use failure::{EXIT_FAILED, EXIT_WRONG_SPEC, Failure};

/// As `evswarm --version` says it.
static VERSION: LazyLock<String> = LazyLock::new(|| {
    let results = swarm::RESULTS_VERSION;
    format!("{} (results {results})", env!("CARGO_PKG_VERSION"))
});

/// Multi-robot swarm simulation: run experiments, serve them, watch them.
#[derive(Debug, Parser)]
#[command(name = "evswarm", version = VERSION.as_str(), propagate_version = true)]
struct Arguments {
    /// How the log on standard error is written.
    #[arg(
        long,
        global = true,
        env = "EVSWARM_LOG_FORMAT",
        value_enum,
        default_value_t
    )]
    log_format: LogFormat,
    #[command(subcommand)]
    command: Command,
}

/// How the log is written.
#[derive(Clone, Copy, Debug, Default, clap::ValueEnum)]
enum LogFormat {
    /// Lines for people.
    #[default]
    Text,
    /// An object a line, for programs.
    Json,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run one spec and write its results to a directory.
    Run(run::RunArguments),
    /// Run the thesis's experiments, test its claims and write a report.
    Reproduce(reproduce::ReproduceArguments),
    /// Start the HTTP service.
    Serve(serve::ServeArguments),
    /// Look through a data directory for damage: exit code 1 and a line for each fault, or 0.
    Check(data::CheckArguments),
    /// Copy a data directory, also while a service uses it.
    Backup(data::BackupArguments),
    /// Make a token, and its line for the file of `serve --tokens`.
    Token(token::TokenArguments),
    /// Post a job to a service.
    Submit(client::SubmitArguments),
    /// Show a job of a service, or its newest jobs.
    Status(client::StatusArguments),
    /// Show what a job of a service found, seeds pooled, with intervals.
    Summary(client::SummaryArguments),
    /// Compare the groups of a job of a service: which is best, or how many seeds would say it.
    Compare(compare::CompareArguments),
    /// Cancel a job of a service.
    Cancel(client::CancelArguments),
    /// Play a recording as text: of a file, or of a run of a service.
    Replay(replay::ReplayArguments),
    /// Make a film of a recording: .gif, or .mp4 and .webm by an installed ffmpeg.
    Video(replay::VideoArguments),
    /// Say why a run did what it did: of a spec, or of a run of a service. The run is stepped again.
    Explain(replay::ExplainArguments),
    /// List, check and draw arenas.
    #[command(subcommand)]
    Arenas(catalog::ArenasCommand),
    /// List methods and parameters, with default, range, unit and source.
    Controllers {
        /// As JSON.
        #[arg(long)]
        json: bool,
    },
    /// Print a completion script for a shell.
    Completions {
        /// The shell.
        shell: clap_complete::Shell,
    },
}

/// Does what the process's arguments ask for.
pub fn main() -> ExitCode {
    with_arguments(std::env::args_os())
}

/// Why there are no arguments.
enum Unparsed {
    Line(clap::Error),
    File(String),
}

/// The arguments, with what a file of settings says in place of defaults.
fn parsed(line: Vec<OsString>) -> Result<Arguments, Unparsed> {
    let arguments = Arguments::try_parse_from(&line).map_err(Unparsed::Line)?;
    let Command::Serve(serve) = &arguments.command else {
        return Ok(arguments);
    };
    let Some(file) = &serve.config else {
        return Ok(arguments);
    };
    let command = config::with_file(Arguments::command(), file).map_err(Unparsed::File)?;
    command
        .try_get_matches_from(&line)
        .and_then(|matches| Arguments::from_arg_matches(&matches))
        .map_err(Unparsed::Line)
}

fn with_arguments(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let arguments = match parsed(arguments.into_iter().collect()) {
        Ok(arguments) => arguments,
        Err(Unparsed::File(error)) => {
            output::complain(format_args!("error: {error}"));
            return ExitCode::from(EXIT_FAILED);
        }
        Err(Unparsed::Line(error)) => {
            #[allow(
                clippy::let_underscore_must_use,
                reason = "if the message cannot be shown there is nobody to tell"
            )]
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { EXIT_FAILED } else { 0 });
        }
    };
    log_to_stderr(arguments.log_format);
    if let Err(error) = crate::break_points::set_from_environment() {
        output::complain(format_args!("error: {error}"));
        return ExitCode::from(EXIT_FAILED);
    }
    match dispatch(arguments.command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::WrongSpec(errors)) => {
            for error in &errors {
                output::complain(error);
            }
            ExitCode::from(EXIT_WRONG_SPEC)
        }
        Err(Failure::Other(error)) => {
            output::complain(format_args!("error: {error:#}"));
            ExitCode::from(EXIT_FAILED)
        }
    }
}

fn dispatch(command: Command) -> Result<(), Failure> {
    match command {
        Command::Run(arguments) => run::run(&arguments),
        Command::Reproduce(arguments) => reproduce::reproduce(&arguments),
        Command::Serve(arguments) => serve::serve(arguments),
        Command::Check(arguments) => data::check(&arguments),
        Command::Backup(arguments) => data::backup(&arguments),
        Command::Token(arguments) => token::token(&arguments),
        Command::Submit(arguments) => client::submit(&arguments),
        Command::Status(arguments) => client::status(&arguments),
        Command::Summary(arguments) => client::summary(&arguments),
        Command::Compare(arguments) => compare::compare(&arguments),
        Command::Cancel(arguments) => client::cancel(&arguments),
        Command::Replay(arguments) => replay::replay(&arguments),
        Command::Video(arguments) => replay::video(&arguments),
        Command::Explain(arguments) => replay::explain(&arguments),
        Command::Arenas(command) => catalog::arenas(&command),
        Command::Controllers { json } => catalog::controllers(json),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Arguments::command(), "evswarm", &mut script);
            output::say_bytes(&script)
        }
    }
}

/// `RUST_LOG` chooses what is logged; `info` unless it says otherwise.
fn log_to_stderr(format: LogFormat) {
    let filter = tracing_subscriber::EnvFilter::builder()
        .with_default_directive(tracing::level_filters::LevelFilter::INFO.into())
        .from_env_lossy();
    let subscriber = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_target(false);
    #[allow(
        clippy::let_underscore_must_use,
        reason = "a second call in one process finds the first one's subscriber, which is as good"
    )]
    let _ = match format {
        LogFormat::Text => subscriber
            .with_ansi(std::io::stderr().is_terminal())
            .try_init(),
        LogFormat::Json => subscriber.json().flatten_event(true).try_init(),
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_well_formed() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn a_wrong_command_line_is_no_wrong_spec() {
        let code = |line: &str| with_arguments(line.split(' ').map(OsString::from));
        assert_eq!(code("evswarm run"), ExitCode::from(EXIT_FAILED));
        assert_eq!(
            code("evswarm run spec.json --out d --threads 0"),
            ExitCode::from(EXIT_FAILED)
        );
        assert_eq!(
            code("evswarm run /no/such/spec.json --out d"),
            ExitCode::from(EXIT_FAILED)
        );
    }
}

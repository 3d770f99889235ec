//! The command line: what can be asked of `evswarm`, exit codes and logging.

mod catalog;
mod checkpoint;
mod client;
mod compare;
mod data;
mod failure;
mod out;
mod output;
mod progress;
mod reproduce;
mod run;
mod token;
mod values;

use std::ffi::OsString;
use std::io::IsTerminal;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::LazyLock;
use std::time::Duration;

use clap::{CommandFactory, Parser, Subcommand};

use crate::http::ServeOptions;
use failure::{EXIT_FAILED, EXIT_WRONG_SPEC, Failure};
use values::{listen_address, threads};

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
    Serve {
        /// Address to listen on: an IP address or localhost, with a port; a port alone is one of
        /// 127.0.0.1, and port 0 takes a free one.
        #[arg(long, env = "EVSWARM_LISTEN", default_value = "127.0.0.1:8080", value_parser = listen_address)]
        listen: SocketAddr,
        /// Directory of the database, checkpoints and results.
        #[arg(long, default_value = "evswarm-data")]
        data: PathBuf,
        /// Threads that step runs [default: one a processor].
        #[arg(long, value_parser = threads)]
        threads: Option<usize>,
        /// Most bytes that a run may hold; one that holds more fails [default: three quarters of the
        /// machine's memory over the threads].
        #[arg(long, value_parser = clap::value_parser!(u64).range(1_000_000..))]
        run_memory_bytes: Option<u64>,
        /// File of tokens, whose lines `evswarm token` makes: clients must send one of them, or the
        /// one in the variable EVSWARM_TOKEN. Needed to listen beyond this machine.
        #[arg(long, value_name = "FILE")]
        tokens: Option<PathBuf>,
        /// Seconds that open requests have to end once the service is to stop.
        #[arg(long, env = "EVSWARM_DRAIN_S", default_value_t = 3, value_parser = clap::value_parser!(u64).range(0..=3_600))]
        drain_s: u64,
    },
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

fn with_arguments(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let arguments = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => arguments,
        Err(error) => {
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
        Command::Serve {
            listen,
            data,
            threads,
            run_memory_bytes,
            tokens,
            drain_s,
        } => {
            crate::http::serve(ServeOptions {
                listen,
                data,
                threads,
                run_memory_bytes,
                token: token::of_environment(),
                tokens,
                drain: Duration::from_secs(drain_s),
            })?;
            Ok(())
        }
        Command::Check(arguments) => data::check(&arguments),
        Command::Backup(arguments) => data::backup(&arguments),
        Command::Token(arguments) => token::token(&arguments),
        Command::Submit(arguments) => client::submit(&arguments),
        Command::Status(arguments) => client::status(&arguments),
        Command::Summary(arguments) => client::summary(&arguments),
        Command::Compare(arguments) => compare::compare(&arguments),
        Command::Cancel(arguments) => client::cancel(&arguments),
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

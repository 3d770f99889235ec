//! Settings from a file: what it says takes the place of the defaults, so that variables and flags
//! come before it.

use std::io::Read;
use std::path::Path;

use clap::{Arg, Command};
use strsim::damerau_levenshtein;
use toml::{Table, Value};

/// Largest file that is read.
const MAX_BYTES: u64 = 1 << 20;
/// Settings that cannot come from a file.
const NOT_IN_FILE: [&str; 3] = ["config", "help", "version"];

/// The command line with what a file says in place of defaults.
///
/// # Errors
/// The file cannot be read, or has what is no setting.
pub fn with_file(command: Command, path: &Path) -> Result<Command, String> {
    let shown = path.display();
    let mut text = String::new();
    std::fs::File::open(path)
        .and_then(|file| file.take(MAX_BYTES).read_to_string(&mut text))
        .map_err(|error| format!("cannot read the settings in {shown}: {error}"))?;
    let table: Table = text
        .parse()
        .map_err(|error| format!("the settings in {shown} are not TOML: {error}"))?;
    with_table(command, &table).map_err(|error| format!("the settings in {shown}: {error}"))
}

fn with_table(mut command: Command, table: &Table) -> Result<Command, String> {
    let known: Vec<String> = settings(&command)
        .iter()
        .map(|(_, arg)| arg.get_id().to_string())
        .collect();
    for (name, value) in table {
        if !known.contains(name) {
            let nearest = known
                .iter()
                .min_by_key(|known| damerau_levenshtein(known, name));
            let nearest = nearest.map(|nearest| format!("; is it {nearest}?"));
            return Err(format!(
                "there is no setting {name:?}{}",
                nearest.unwrap_or_default()
            ));
        }
        let text = match value {
            Value::String(text) => text.clone(),
            Value::Integer(number) => number.to_string(),
            Value::Float(number) => number.to_string(),
            Value::Boolean(truth) => truth.to_string(),
            _ => return Err(format!("{name} is one value, not a list or a table")),
        };
        // Clap keeps defaults as long as the program runs; a file is read once.
        let text: &'static str = Box::leak(text.into_boxed_str());
        let set = |arg: Arg| arg.default_value(text);
        let is_global = command.get_arguments().any(|arg| arg.get_id() == name);
        command = if is_global {
            command.mut_arg(name.clone(), set)
        } else {
            command.mut_subcommand("serve", |serve| serve.mut_arg(name.clone(), set))
        };
    }
    Ok(command)
}

/// Every setting of the service: those of the program, then those of `serve`.
fn settings(command: &Command) -> Vec<(&Command, &Arg)> {
    let serve = command.find_subcommand("serve");
    [Some(command), serve]
        .into_iter()
        .flatten()
        .flat_map(|command| command.get_arguments().map(move |arg| (command, arg)))
        .filter(|(_, arg)| !NOT_IN_FILE.contains(&arg.get_id().as_str()))
        .collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use clap::CommandFactory;

    use super::*;
    use crate::cli::Arguments;

    fn drain_s(file: &str, line: &[&str]) -> Result<u64, String> {
        let command = with_table(Arguments::command(), &file.parse().unwrap())?;
        let line = ["evswarm", "serve"].iter().chain(line);
        let matches = command
            .try_get_matches_from(line)
            .map_err(|error| error.to_string())?;
        let (_, serve) = matches.subcommand().unwrap();
        Ok(*serve.get_one::<u64>("drain_s").unwrap())
    }

    #[test]
    fn flags_come_before_the_file_and_the_file_before_defaults() {
        assert_eq!(drain_s("", &[]), Ok(3));
        assert_eq!(drain_s("drain_s = 7", &[]), Ok(7));
        assert_eq!(drain_s("drain_s = 7", &["--drain-s", "9"]), Ok(9));
    }

    #[test]
    fn what_a_file_cannot_say_is_told() {
        let told = |file: &str| drain_s(file, &[]).unwrap_err();
        assert!(told("drian_s = 7").contains("is it drain_s?"));
        assert!(told("config = 'x'").contains("no setting"));
        assert!(told("drain_s = [7]").contains("one value"));
        assert!(told("drain_s = 99999").contains("99999"));
    }

    /// The table in the documentation, as it follows from the arguments.
    fn documented() -> String {
        let mut text =
            "| Flag | Variable | In the file | Default | What it is |\n|---|---|---|---|---|\n"
                .to_owned();
        let command = Arguments::command();
        for (_, arg) in settings(&command) {
            let flag = arg.get_long().unwrap();
            let variable = arg.get_env().unwrap().to_str().unwrap();
            let help = arg.get_help().unwrap().to_string();
            let (about, told) = match help.split_once(" [default: ") {
                Some((about, default)) => (
                    about.to_owned() + ".",
                    default.trim_end_matches(['.', ']']).to_owned(),
                ),
                None => (help, String::new()),
            };
            let default = match arg.get_default_values() {
                [] => told,
                [value, ..] => format!("`{}`", value.to_str().unwrap()),
            };
            let about = about.trim_end_matches('.');
            let name = arg.get_id();
            text += &format!("| `--{flag}` | `{variable}` | `{name}` | {default} | {about} |\n");
        }
        text
    }

    #[test]
    fn the_table_in_the_documentation_is_this_one() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/operations/README.md");
        let text = std::fs::read_to_string(path).unwrap();
        let begin = text.find("| Flag | Variable |").unwrap();
        let table = &text[begin..];
        let table = &table[..table.find("\n\n").unwrap() + 1];
        if std::env::var_os("EVSWARM_WRITE_DOCS").is_some() {
            std::fs::write(path, text.replacen(table, &documented(), 1)).unwrap();
            return;
        }
        assert!(
            table == documented(),
            "docs/operations/README.md has another table of settings: write it anew with \
             EVSWARM_WRITE_DOCS=1 cargo test --release -p server cli::config"
        );
    }
}

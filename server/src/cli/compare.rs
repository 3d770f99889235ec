//! `evswarm compare`: a job's groups against each other.

use super::client::{Client, Server, job_path};
use super::{Failure, output};

#[derive(Debug, clap::Args)]
pub struct CompareArguments {
    /// Id of the job.
    id: String,
    /// What is compared: a measure of the summary [default: p1_fraction].
    #[arg(long)]
    measure: Option<String>,
    /// A field that the job varies, such as controller.method: its values are compared, all else is
    /// pooled.
    #[arg(long, value_name = "FIELD")]
    by: Option<String>,
    #[command(flatten)]
    server: Server,
}

pub fn compare(arguments: &CompareArguments) -> Result<(), Failure> {
    let client = Client::new(&arguments.server);
    let asked = [("measure", &arguments.measure), ("by", &arguments.by)];
    let asked: Vec<String> = asked
        .into_iter()
        .filter_map(|(name, value)| Some(format!("{name}={}", encoded(value.as_ref()?))))
        .collect();
    let path = job_path(&arguments.id)?;
    let text = client.text(&format!("{path}/comparison.md?{}", asked.join("&")))?;
    output::say(text.trim_end())
}

/// A value in a query: what is no plain letter is given by its bytes.
fn encoded(value: &str) -> String {
    let bytes = value.bytes();
    bytes.fold(String::new(), |text, byte| {
        if byte.is_ascii_alphanumeric() || b"-_.".contains(&byte) {
            text + &char::from(byte).to_string()
        } else {
            format!("{text}%{byte:02X}")
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn queries_hold_nothing_that_ends_a_value() {
        assert_eq!(encoded("controller.method"), "controller.method");
        assert_eq!(encoded("a&b=c ä"), "a%26b%3Dc%20%C3%A4");
    }
}

//! `evswarm submit`, `status` and `cancel`: a client of the HTTP service.

use std::fs::File;
use std::net::IpAddr;
use std::path::PathBuf;
use std::time::Duration;

use anyhow::{Context, anyhow, bail};
use api::{Job, JobPage, Problem, State};
use serde::de::DeserializeOwned;
use serde_json::Value;
use ureq::http::Uri;

use super::progress::Meter;
use super::{Failure, output};

/// Time between two looks at a watched job.
const POLL_EVERY: Duration = Duration::from_millis(500);
/// Looks that may fail in a row before watching ends.
const PATIENCE: u32 = 20;
/// Longest wait for an answer; the largest jobs take a while to be checked and stored.
const TIMEOUT: Duration = Duration::from_secs(120);

#[derive(Debug, clap::Args)]
pub struct Server {
    /// The service; its token, if it asks for one, is read from the variable EVSWARM_TOKEN.
    #[arg(
        long = "server",
        value_name = "URL",
        env = "EVSWARM_SERVER",
        default_value = "http://127.0.0.1:8080"
    )]
    url: String,
}

#[derive(Debug, clap::Args)]
pub struct SubmitArguments {
    /// The job, a JSON file; - reads standard input.
    job: PathBuf,
    /// Stay until the job is done: exit code 0 if it is, 1 if it failed or was cancelled.
    #[arg(long)]
    watch: bool,
    #[command(flatten)]
    server: Server,
}

#[derive(Debug, clap::Args)]
pub struct StatusArguments {
    /// Id of a job; without it, the newest jobs.
    id: Option<String>,
    #[command(flatten)]
    server: Server,
}

#[derive(Debug, clap::Args)]
pub struct SummaryArguments {
    /// Id of a job.
    id: String,
    #[command(flatten)]
    server: Server,
}

#[derive(Debug, clap::Args)]
pub struct CancelArguments {
    /// Id of the job.
    id: String,
    #[command(flatten)]
    server: Server,
}

pub fn submit(arguments: &SubmitArguments) -> Result<(), Failure> {
    let text = super::run::read(&arguments.job)?;
    let job = crate::documents::parse(&text).map_err(Failure::WrongSpec)?;
    let client = Client::new(&arguments.server);
    let job: Job = client.post("/v1/jobs", Some(&job))?;
    output::say(line(&job))?;
    if arguments.watch {
        watch(&client, job)
    } else {
        Ok(())
    }
}

pub fn status(arguments: &StatusArguments) -> Result<(), Failure> {
    let client = Client::new(&arguments.server);
    match &arguments.id {
        Some(id) => output::say(line(&client.get::<Job>(&job_path(id)?)?)),
        None => {
            let page: JobPage = client.get("/v1/jobs")?;
            page.items.iter().try_for_each(|job| output::say(line(job)))
        }
    }
}

pub fn summary(arguments: &SummaryArguments) -> Result<(), Failure> {
    let client = Client::new(&arguments.server);
    let text = client.text(&format!("{}/summary.md", job_path(&arguments.id)?))?;
    output::say(text.trim_end())
}

pub fn cancel(arguments: &CancelArguments) -> Result<(), Failure> {
    let client = Client::new(&arguments.server);
    let path = format!("{}/cancel", job_path(&arguments.id)?);
    output::say(line(&client.post::<Job>(&path, None)?))
}

/// Shows a job's progress until it ends.
fn watch(client: &Client, mut job: Job) -> Result<(), Failure> {
    let path = job_path(&job.id)?;
    let mut meter = Meter::of_share(job.progress);
    let mut failures = 0;
    while !job.state.is_final() {
        std::thread::sleep(POLL_EVERY);
        match client.get::<Job>(&path) {
            Ok(news) => {
                job = news;
                failures = 0;
            }
            Err(Failure::Other(error)) if failures < PATIENCE => {
                failures += 1;
                tracing::warn!("no news of the job: {error:#}");
            }
            Err(failure) => return Err(failure),
        }
        let runs = job.runs;
        let what = format!("{} {}/{} runs", job.state, runs.done, runs.total);
        meter.show_share(job.progress, &what);
    }
    meter.finish();
    output::say(line(&job))?;
    match job.state {
        State::Done => Ok(()),
        state => Err(anyhow!("the job is {state}").into()),
    }
}

/// A job on one line.
fn line(job: &Job) -> String {
    let runs = job.runs;
    let name = if job.name.is_empty() {
        String::new()
    } else {
        format!(" {:?}", job.name)
    };
    let left = job
        .eta_s
        .map_or(String::new(), |eta_s| format!(", about {eta_s:.0} s left"));
    format!(
        "{}{name} {}: {:.1} %, {} of {} runs done, {} running, {} failed{left}",
        job.id,
        job.state,
        100.0 * job.progress,
        runs.done,
        runs.total,
        runs.running,
        runs.failed,
    )
}

/// The route of a job.
pub fn job_path(id: &str) -> anyhow::Result<String> {
    let plain = |letter: char| letter.is_ascii_alphanumeric() || "-_".contains(letter);
    if id.is_empty() || !id.chars().all(plain) {
        bail!("{id:?} is no id of a job");
    }
    Ok(format!("/v1/jobs/{id}"))
}

/// Whether a URL names this very machine.
fn is_loopback(url: &str) -> bool {
    let uri: Option<Uri> = url.parse().ok();
    let host = uri.as_ref().and_then(Uri::host).unwrap_or_default();
    let address = host.trim_start_matches('[').trim_end_matches(']');
    host.eq_ignore_ascii_case("localhost")
        || (address.parse::<IpAddr>()).is_ok_and(|address| address.is_loopback())
}

pub struct Client {
    agent: ureq::Agent,
    url: String,
    /// Value of the `authorization` header.
    bearer: Option<String>,
    /// Host and port of the proxy between here and there.
    proxy: Option<String>,
}

impl Client {
    pub fn new(server: &Server) -> Self {
        let mut config = ureq::Agent::config_builder()
            .http_status_as_error(false)
            .timeout_global(Some(TIMEOUT));
        // Nobody but this machine itself knows the way to it.
        if is_loopback(&server.url) {
            config = config.proxy(None);
        }
        let config = config.build();
        let url = server.url.trim_end_matches('/').to_owned();
        let proxy = config.proxy().filter(|proxy| {
            let uri = url.parse::<Uri>();
            !uri.is_ok_and(|uri| proxy.is_no_proxy(&uri))
        });
        Self {
            proxy: proxy.map(|proxy| format!("{}:{}", proxy.host(), proxy.port())),
            agent: config.into(),
            url,
            bearer: super::token::of_environment().map(|token| format!("Bearer {token}")),
        }
    }

    /// That nobody answers, and by what way nobody was reached.
    fn silence(&self) -> String {
        match &self.proxy {
            Some(proxy) => format!(
                "no answer from {} through the proxy {proxy}, which the environment names \
                 (HTTPS_PROXY, HTTP_PROXY, ALL_PROXY; NO_PROXY lists hosts to reach without it)",
                self.url
            ),
            None => format!("no answer from {}", self.url),
        }
    }

    /// Saves what is answered.
    pub fn save(&self, path: &str, file: &mut File) -> Result<(), Failure> {
        let request = self.agent.get(format!("{}{path}", self.url));
        let response = self.signed(request).call();
        if response
            .as_ref()
            .is_ok_and(|response| !response.status().is_success())
        {
            return self.body(response).map(drop);
        }
        let mut response = response.with_context(|| self.silence())?;
        std::io::copy(&mut response.body_mut().as_reader(), file)
            .with_context(|| format!("the answer of {} broke off", self.url))?;
        Ok(())
    }

    pub fn get<T: DeserializeOwned>(&self, path: &str) -> Result<T, Failure> {
        let request = self.agent.get(format!("{}{path}", self.url));
        self.answer(self.signed(request).call())
    }

    pub fn text(&self, path: &str) -> Result<String, Failure> {
        let request = self.agent.get(format!("{}{path}", self.url));
        self.body(self.signed(request).call())
    }

    fn post<T: DeserializeOwned>(&self, path: &str, body: Option<&Value>) -> Result<T, Failure> {
        let request = self.signed(self.agent.post(format!("{}{path}", self.url)));
        self.answer(match body {
            Some(body) => request.send_json(body),
            None => request.send_empty(),
        })
    }

    fn signed<B>(&self, request: ureq::RequestBuilder<B>) -> ureq::RequestBuilder<B> {
        match &self.bearer {
            Some(bearer) => request.header("authorization", bearer),
            None => request,
        }
    }

    fn answer<T: DeserializeOwned>(
        &self,
        response: Result<ureq::http::Response<ureq::Body>, ureq::Error>,
    ) -> Result<T, Failure> {
        let document = serde_json::from_str(&self.body(response)?)
            .with_context(|| format!("{} does not answer like this service", self.url))?;
        Ok(document)
    }

    /// The body of an answer that is no refusal.
    fn body(
        &self,
        response: Result<ureq::http::Response<ureq::Body>, ureq::Error>,
    ) -> Result<String, Failure> {
        let mut response = response.with_context(|| self.silence())?;
        let status = response.status();
        let body = response
            .body_mut()
            .read_to_string()
            .with_context(|| format!("the answer of {} broke off", self.url))?;
        if status.is_success() {
            return Ok(body);
        }
        match serde_json::from_str::<Problem>(&body) {
            Ok(problem) if !problem.errors.is_empty() => Err(Failure::WrongSpec(problem.errors)),
            Ok(problem) => {
                let detail = problem
                    .detail
                    .map_or(String::new(), |detail| format!(": {detail}"));
                Err(anyhow!("{} ({status}){detail}", problem.title).into())
            }
            Err(_) => Err(anyhow!("{} answers {status}", self.url).into()),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    #[test]
    fn this_machine_is_known_by_its_names() {
        for url in [
            "http://127.0.0.1:8080",
            "http://127.3.2.1/",
            "http://localhost:1",
            "http://LOCALHOST",
            "http://[::1]:8080/v1",
        ] {
            assert!(is_loopback(url), "{url}");
        }
        for url in [
            "http://10.0.0.1",
            "http://localhost.example",
            "http://[::2]",
            "127",
            "",
        ] {
            assert!(!is_loopback(url), "{url}");
        }
    }

    #[test]
    fn ids_cannot_leave_their_route() {
        assert_eq!(job_path("01J-a_b").unwrap(), "/v1/jobs/01J-a_b");
        for id in ["", "a/b", "..", "a?b", "a b"] {
            assert!(job_path(id).is_err(), "{id:?}");
        }
    }
}

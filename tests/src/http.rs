//! A client of the service, without anything of the service's own code but the types in `api`.

use std::time::Duration;

use api::{Job, Problem, RunPage, RunSummary, State};
use serde::de::DeserializeOwned;
use serde_json::Value;
use ureq::http::{HeaderMap, Request};

use crate::events::Listener;
use crate::wait;

/// An answer, whatever its status.
#[derive(Debug)]
pub struct Answer {
    /// Status code.
    pub status: u16,
    /// Its headers.
    pub headers: HeaderMap,
    /// Its body.
    pub body: Vec<u8>,
}

impl Answer {
    /// A header as text; empty when absent.
    pub fn header(&self, name: &str) -> &str {
        self.headers
            .get(name)
            .map_or("", |value| value.to_str().unwrap())
    }

    /// The body as text.
    pub fn text(&self) -> &str {
        std::str::from_utf8(&self.body).unwrap()
    }

    /// The body as JSON of a type.
    pub fn json<T: DeserializeOwned>(&self) -> T {
        serde_json::from_slice(&self.body)
            .unwrap_or_else(|error| panic!("{error}: {} {}", self.status, self.text()))
    }

    /// The body of a refusal, which must have this status and be a problem document.
    pub fn problem(&self, status: u16) -> Problem {
        let media_type = self.header("content-type");
        assert_eq!(
            (self.status, media_type),
            (status, Problem::MEDIA_TYPE),
            "{}",
            String::from_utf8_lossy(&self.body)
        );
        let problem: Problem = self.json();
        assert_eq!(problem.status, status);
        problem
    }
}

/// A client of one server.
#[derive(Clone, Debug)]
pub struct Client {
    agent: ureq::Agent,
    url: String,
}

impl Client {
    /// A client of the server at this address, such as `http://127.0.0.1:8080`.
    pub fn new(url: &str) -> Self {
        let config = ureq::Agent::config_builder()
            .http_status_as_error(false)
            .allow_non_standard_methods(true)
            .timeout_global(Some(Duration::from_secs(60)))
            .build();
        Self {
            agent: config.into(),
            url: url.to_owned(),
        }
    }

    /// Opens a stream of events; `heard` is the id of the last one that is known.
    pub fn listen(&self, path: &str, heard: Option<&str>) -> Listener {
        let mut request = self.agent.get(format!("{}{path}", self.url));
        if let Some(heard) = heard {
            request = request.header("last-event-id", heard);
        }
        let answer = request.call().unwrap();
        assert_eq!(answer.status(), 200);
        let media_type = answer.headers()["content-type"].to_str().unwrap();
        assert_eq!(media_type, "text/event-stream");
        Listener::new(answer.into_body().into_reader())
    }

    /// The address of the server.
    pub fn url(&self) -> &str {
        &self.url
    }

    /// Sends a request with these headers and body.
    pub fn send(&self, method: &str, path: &str, headers: &[(&str, &str)], body: &[u8]) -> Answer {
        self.try_send(method, path, headers, body)
            .unwrap_or_else(|error| panic!("{method} {path}: {error}"))
    }

    /// Sends a request that may not be answered.
    ///
    /// # Errors
    /// Why there is no answer.
    pub fn try_send(
        &self,
        method: &str,
        path: &str,
        headers: &[(&str, &str)],
        body: &[u8],
    ) -> Result<Answer, ureq::Error> {
        let mut request = Request::builder()
            .method(method)
            .uri(format!("{}{path}", self.url));
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        let answer = if body.is_empty() {
            self.agent.run(request.body(()).unwrap())
        } else {
            self.agent.run(request.body(body).unwrap())
        };
        let (parts, mut body) = answer?.into_parts();
        Ok(Answer {
            status: parts.status.as_u16(),
            headers: parts.headers,
            body: body.read_to_vec()?,
        })
    }

    /// `GET`.
    pub fn get(&self, path: &str) -> Answer {
        self.send("GET", path, &[], b"")
    }

    /// `GET`, which must work.
    pub fn read<T: DeserializeOwned>(&self, path: &str) -> T {
        let answer = self.get(path);
        assert_eq!(answer.status, 200, "{path}: {}", answer.text());
        answer.json()
    }

    /// `POST` of a JSON document.
    pub fn post(&self, path: &str, document: &Value) -> Answer {
        let headers = [("content-type", "application/json")];
        self.send("POST", path, &headers, document.to_string().as_bytes())
    }

    /// Posts a job, which must be accepted.
    pub fn submit(&self, job: &Value) -> Job {
        let answer = self.post("/v1/jobs", job);
        assert_eq!(answer.status, 201, "{}", answer.text());
        answer.json()
    }

    /// The runs of a job that has no more than a page of them.
    pub fn runs(&self, job: &Job) -> Vec<RunSummary> {
        let page: RunPage = self.read(&format!("/v1/jobs/{}/runs", job.id));
        assert_eq!(page.next, None);
        page.items
    }

    /// The methods of the template of chapter 5.
    pub fn chapter_5_methods(&self) -> Value {
        let listing: Value = self.get("/v1/templates").json();
        let templates = listing["items"].as_array().unwrap();
        let chapter = templates.iter().find(|item| item["name"] == "chapter-5");
        chapter.unwrap()["job"]["parts"][0]["matrix"]["controller.method"].clone()
    }

    /// The only run of a job.
    pub fn only_run(&self, job: &Job) -> RunSummary {
        let mut runs = self.runs(job);
        assert_eq!(runs.len(), 1);
        runs.remove(0)
    }

    /// Waits until a job is done.
    pub fn wait_for(&self, job: &Job) -> Job {
        wait::until("the job", || {
            let job: Job = self.read(&format!("/v1/jobs/{}", job.id));
            match job.state {
                State::Done => Some(job),
                State::Failed | State::Cancelled => panic!("{:?}", self.runs(&job)),
                State::Queued | State::Running | State::Paused => None,
            }
        })
    }
}

//! A client with one connection that is kept, and reopened when the server closes it.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use http_body_util::{BodyExt, Full};
use hyper::body::{Bytes, Incoming};
use hyper::client::conn::http1::{SendRequest, handshake};
use hyper::{Method, Request, Response, StatusCode};
use hyper_util::rt::TokioIo;
use tokio::net::TcpStream;

/// Longest that an answer is waited for.
pub const LIMIT: Duration = Duration::from_secs(30);

/// Time between two looks for the end of a job.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// An answer and how long it took.
pub struct Answer {
    /// Its status.
    pub status: StatusCode,
    /// Its body.
    pub body: Bytes,
    /// From the first byte sent to the last received.
    pub took: Duration,
}

impl Answer {
    /// The body as JSON.
    pub fn json(&self) -> Result<serde_json::Value> {
        serde_json::from_slice(&self.body).context("an answer that is not JSON")
    }
}

/// A client of one server.
pub struct Client {
    address: SocketAddr,
    sender: Option<SendRequest<Full<Bytes>>>,
}

impl Client {
    /// A client that is not connected yet.
    pub fn new(address: SocketAddr) -> Self {
        Self {
            address,
            sender: None,
        }
    }

    /// Reads.
    pub async fn get(&mut self, path: &str) -> Result<Answer> {
        self.ask(Method::GET, path, None).await
    }

    /// Posts JSON, or nothing.
    pub async fn post(&mut self, path: &str, body: Option<String>) -> Result<Answer> {
        self.ask(Method::POST, path, body).await
    }

    /// Deletes.
    pub async fn delete(&mut self, path: &str) -> Result<Answer> {
        self.ask(Method::DELETE, path, None).await
    }

    /// Waits until the newest job is done, which is taken up after all others.
    pub async fn newest_job_is_done(&mut self) -> Result<()> {
        loop {
            let page = self.get("/v1/jobs?limit=1").await?.json()?;
            let state = &page["items"].get(0).context("no list of jobs")?["state"];
            ensure!(state != "failed", "the job failed");
            if state == "done" {
                return Ok(());
            }
            tokio::time::sleep(LOOK_EVERY).await;
        }
    }

    async fn ask(&mut self, method: Method, path: &str, body: Option<String>) -> Result<Answer> {
        let started = Instant::now();
        let answer = tokio::time::timeout(LIMIT, async {
            let response = self.send(method, path, body).await?;
            let status = response.status();
            let body = response.into_body().collect().await?.to_bytes();
            anyhow::Ok((status, body))
        });
        let outcome = answer.await.context("no answer in time").flatten();
        if outcome.is_err() {
            self.sender = None;
        }
        let (status, body) = outcome?;
        Ok(Answer {
            status,
            body,
            took: started.elapsed(),
        })
    }

    /// Sends a request; the answer's body is still to come.
    pub async fn send(
        &mut self,
        method: Method,
        path: &str,
        body: Option<String>,
    ) -> Result<Response<Incoming>> {
        let mut request = Request::builder()
            .method(method)
            .uri(path)
            .header("host", self.address.to_string());
        if body.is_some() {
            request = request.header("content-type", "application/json");
        }
        let body = Full::new(Bytes::from(body.unwrap_or_default()));
        let request = request.body(body)?;
        let ready = match &mut self.sender {
            Some(sender) => sender.ready().await.is_ok(),
            None => false,
        };
        if !ready {
            self.sender = Some(self.connect().await?);
        }
        let sender = self.sender.as_mut().context("not connected")?;
        Ok(sender.send_request(request).await?)
    }

    async fn connect(&self) -> Result<SendRequest<Full<Bytes>>> {
        let stream = TcpStream::connect(self.address).await?;
        stream.set_nodelay(true)?;
        let (sender, connection) = handshake(TokioIo::new(stream)).await?;
        // The connection ends by itself when either side closes it.
        tokio::spawn(connection);
        Ok(sender)
    }
}

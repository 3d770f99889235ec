//! The real server as a process of its own, on a free port of this machine, with its own data.

use std::io::{BufRead, BufReader};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use anyhow::{Context, Result, ensure};

/// A server, killed when this is dropped.
pub struct Server {
    child: Child,
    address: SocketAddr,
    /// Its own data, deleted with it.
    home: Option<tempfile::TempDir>, // held for its end
}

/// Beside this very program.
pub fn program() -> Result<PathBuf> {
    let own = std::env::current_exe().context("where this program is")?;
    let path = own.with_file_name("evswarm");
    ensure!(path.is_file(), "{} is missing: make build", path.display());
    Ok(path)
}

impl Server {
    /// Starts a server with so many worker threads, on data of its own.
    pub fn start(threads: usize) -> Result<Self> {
        let home = tempfile::tempdir()?;
        let mut server = Self::start_at(home.path(), threads, None)?;
        server.home = Some(home);
        Ok(server)
    }

    /// Starts a server on the data below `home`; `break_at` is its `EVSWARM_BREAK`.
    pub fn start_at(home: &Path, threads: usize, break_at: Option<&str>) -> Result<Self> {
        Self::start_program(&program()?, home, threads, break_at)
    }

    /// The same of another program than the one beside this.
    pub fn start_program(
        program: &Path,
        home: &Path,
        threads: usize,
        break_at: Option<&str>,
    ) -> Result<Self> {
        let mut child = Command::new(program)
            .args(["serve", "--listen", "127.0.0.1:0", "--threads"])
            .arg(threads.to_string())
            .arg("--data")
            .arg(home.join("data"))
            .env("XDG_RUNTIME_DIR", home)
            .env_remove("EVSWARM_TOKEN")
            .env_remove("EVSWARM_BREAK")
            .envs(break_at.map(|place| ("EVSWARM_BREAK", place)))
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .context("starting evswarm")?;
        let output = child.stdout.take().context("the server's output")?;
        let mut server = Self {
            child,
            address: SocketAddr::from(([127, 0, 0, 1], 0)),
            home: None,
        };
        let mut lines = BufReader::new(output).lines();
        let line = lines.next().context("the server ended at once")??;
        // A server must not meet a closed standard output.
        std::thread::spawn(move || lines.for_each(drop));
        server.address = line
            .rsplit("http://")
            .next()
            .and_then(|rest| rest.trim_end_matches('/').parse().ok())
            .with_context(|| format!("no address in {line:?}"))?;
        Ok(server)
    }

    /// Whether it has ended by itself.
    pub fn has_ended(&mut self) -> Result<bool> {
        Ok(self.child.try_wait()?.is_some())
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Processor time of its threads that step runs, seconds.
    pub fn stepping_cpu_s(&self) -> Result<f64> {
        let tasks = PathBuf::from(format!("/proc/{}/task", self.child.id()));
        let mut ticks = 0;
        for task in std::fs::read_dir(&tasks)? {
            // A thread may end between the list and the look.
            ticks += worker_ticks(&task?.path()).unwrap_or(0);
        }
        Ok(ticks as f64 / TICKS_A_SECOND)
    }

    /// Memory that it holds right now, bytes.
    pub fn resident_bytes(&self) -> Result<u64> {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.child.id()))?;
        let line = status.lines().find(|line| line.starts_with("VmRSS:"));
        let kib = line.and_then(|line| line.split_whitespace().nth(1)?.parse::<u64>().ok());
        Ok(kib.context("no VmRSS")? * 1024)
    }
}

/// `USER_HZ`, which is 100 on every Linux that this runs on.
pub const TICKS_A_SECOND: f64 = 100.0;

/// User and system time of a worker thread; `None` of any other thread.
fn worker_ticks(task: &Path) -> Option<u64> {
    let name = std::fs::read_to_string(task.join("comm")).ok()?;
    if !name.starts_with("worker") {
        return None;
    }
    ticks(&task.join("stat"), [14, 15])
}

/// The sum of two fields of a `stat` below `/proc`, by their numbers in `man proc`, after the name.
pub fn ticks(stat: &Path, fields: [usize; 2]) -> Option<u64> {
    let stat = std::fs::read_to_string(stat).ok()?;
    // The name in brackets, the second field, may hold spaces.
    let rest: Vec<&str> = stat.rsplit(") ").next()?.split(' ').collect();
    let field = |number: usize| rest.get(number - 3)?.parse::<u64>().ok();
    Some(field(fields[0])? + field(fields[1])?)
}

impl Drop for Server {
    #[allow(clippy::let_underscore_must_use, reason = "it may have ended already")]
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

//! `evswarm serve` as a process of its own, ended when the test is.

use std::fs::{self, File};
use std::io::{BufRead, BufReader};
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc;
use std::time::Duration;

use rustix::process::{Pid, Signal, kill_process};

use crate::http::Client;
use crate::{program, wait};

/// A server on a free port.
pub struct Server {
    child: Child,
    client: Client,
    log: PathBuf,
}

impl Server {
    /// Starts a server with two threads on this data directory. Its channels are under the same
    /// directory, apart from those of all other servers.
    pub fn start(data: &Path) -> Self {
        Self::start_with(data, &["--threads", "2"])
    }

    /// Starts a server with further arguments.
    pub fn start_with(data: &Path, arguments: &[&str]) -> Self {
        Self::try_start(data, arguments, &[]).unwrap_or_else(|log| panic!("no server: {log}"))
    }

    /// Starts a server that asks for this token.
    pub fn start_with_token(data: &Path, token: &str) -> Self {
        let environment = [("EVSWARM_TOKEN", token)];
        Self::try_start(data, &[], &environment).unwrap_or_else(|log| panic!("no server: {log}"))
    }

    /// Starts a server with further arguments and environment variables.
    ///
    /// # Errors
    /// What it logged, when it ended instead of listening.
    pub fn try_start(
        data: &Path,
        arguments: &[&str],
        environment: &[(&str, &str)],
    ) -> Result<Self, String> {
        Self::launch(
            Command::new(program("evswarm")),
            data,
            arguments,
            environment,
        )
    }

    /// Starts a server whose data directory is on a file system of its own, of so many bytes: in a
    /// namespace of mounts, which any user may have where the system allows it. From here it is
    /// seen below [`Self::disk`].
    pub fn start_on_a_small_disk(home: &Path, bytes: u64) -> Self {
        let disk = home.join("data");
        fs::create_dir(&disk).unwrap();
        let mut command = Command::new("unshare");
        let script = "mount -t tmpfs -o size=\"$0\" tmpfs \"$1\" && shift && exec \"$@\"";
        command
            .args(["--map-root-user", "--mount", "sh", "-c", script])
            .arg(bytes.to_string())
            .arg(&disk)
            .arg(program("evswarm"));
        Self::launch(command, home, &["--threads", "1"], &[]).unwrap_or_else(|log| {
            panic!("no server on a disk of its own, which needs a namespace of users: {log}")
        })
    }

    /// What it has logged.
    pub fn log(&self) -> String {
        fs::read_to_string(&self.log).unwrap()
    }

    /// The directory of a server that was started on a small disk.
    pub fn disk(&self, home: &Path) -> PathBuf {
        let home = home.canonicalize().unwrap();
        let inside = home.join("data");
        let root = PathBuf::from(format!("/proc/{}/root", self.child.id()));
        root.join(inside.strip_prefix("/").unwrap())
    }

    fn launch(
        mut command: Command,
        data: &Path,
        arguments: &[&str],
        environment: &[(&str, &str)],
    ) -> Result<Self, String> {
        let log = data.join("server.log");
        let mut child = command
            .args(["serve", "--listen", "127.0.0.1:0", "--data"])
            .arg(data.join("data"))
            .args(arguments)
            .env("XDG_RUNTIME_DIR", data)
            .env_remove("EVSWARM_TOKEN")
            .env_remove("RUST_LOG")
            .envs(environment.iter().copied())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(
                File::options()
                    .create(true)
                    .append(true)
                    .open(&log)
                    .unwrap(),
            )
            .spawn()
            .unwrap();
        let output = BufReader::new(child.stdout.take().unwrap());
        let (sender, receiver) = mpsc::channel();
        // Reads on after the first line: a server must not meet a closed standard output.
        std::thread::spawn(move || {
            for line in output.lines().map_while(Result::ok) {
                #[allow(
                    clippy::let_underscore_must_use,
                    reason = "the test may have all it wants to know"
                )]
                let _ = sender.send(line);
            }
        });
        let line = receiver.recv_timeout(Duration::from_secs(30));
        let Ok(line) = line else {
            drop(child.kill());
            drop(child.wait());
            return Err(fs::read_to_string(&log).unwrap());
        };
        let url = line.strip_prefix("evswarm listens on ").unwrap();
        Ok(Self {
            client: Client::new(url.trim_end_matches('/')),
            child,
            log,
        })
    }

    /// Waits until the server has killed itself at the place that `EVSWARM_BREAK` names.
    pub fn wait_until_killed(&mut self) {
        let status = wait::for_exit(&mut self.child);
        assert_eq!(status.code(), None, "it was not killed but ended: {status}");
    }

    /// Ends the server at once, as a crash or a power cut does.
    pub fn kill(mut self) {
        self.child.kill().unwrap();
        wait::for_exit(&mut self.child);
    }

    /// Asks the server to end.
    pub fn ask_to_end(&self) {
        self.signal(Signal::TERM);
    }

    /// Asks the server to end, and waits until it has.
    pub fn terminate(self) -> ExitStatus {
        self.ask_to_end();
        self.end()
    }

    /// Sends a signal to the server.
    pub fn signal(&self, signal: Signal) {
        self::signal(&self.child, signal);
    }

    /// Waits until the server has ended.
    pub fn end(mut self) -> ExitStatus {
        wait::for_exit(&mut self.child)
    }
}

/// Sends a signal to a process that was started here.
pub fn signal(child: &Child, signal: Signal) {
    kill_process(Pid::from_child(child), signal).unwrap();
}

impl Deref for Server {
    type Target = Client;

    fn deref(&self) -> &Client {
        &self.client
    }
}

impl Drop for Server {
    #[allow(clippy::let_underscore_must_use, reason = "it may have ended already")]
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        let log = fs::read_to_string(&self.log).unwrap_or_default();
        if std::thread::panicking() {
            eprintln!("the server's log:\n{log}");
        } else {
            assert!(!log.contains("panicked"), "{log}");
        }
    }
}

//! The thread that compresses blocks and writes them: the run's thread waits for it only when two
//! blocks are waiting already.

use std::fs::{self, File};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

use recording::{Raw, RecordingError, Writer};

use super::paths::{Paths, remove};

/// Blocks that wait to be written.
const WAITING: usize = 2;

/// Bytes that recordings leave on the disk, or an eighth of a small one.
const LEAST_ROOM_BYTES: u64 = 256 << 20;

/// What the thread is to do.
pub enum Job {
    /// The next block.
    Block(Raw),
    /// Keep a block that is begun, durably; whether that worked is said.
    Tail(Box<Raw>, Sender<bool>),
    /// All blocks are there.
    End(Sender<bool>),
}

/// What both threads see.
#[derive(Debug, Default)]
pub struct Shared {
    failed: AtomicBool,
    why: Mutex<Option<String>>,
    bytes: AtomicU64,
}

impl Shared {
    /// Why no more is written, where that is so.
    pub fn failure(&self) -> Option<String> {
        if !self.failed.load(Ordering::Relaxed) {
            return None;
        }
        let why = self.why.lock().unwrap_or_else(PoisonError::into_inner);
        why.clone()
    }

    /// Bytes written so far.
    pub fn bytes(&self) -> u64 {
        self.bytes.load(Ordering::Relaxed)
    }

    fn fail(&self, why: String) {
        *self.why.lock().unwrap_or_else(PoisonError::into_inner) = Some(why);
        self.failed.store(true, Ordering::Relaxed);
    }
}

/// The run's side of the thread.
pub struct Sink {
    pub jobs: Option<SyncSender<Job>>,
    /// Blocks to be filled again.
    pub spare: Receiver<Raw>,
    pub shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

/// What the thread has.
struct Work {
    writer: Writer,
    file: File,
    paths: Paths,
    most_bytes: u64,
    shared: Arc<Shared>,
    spare: Sender<Raw>,
}

impl Sink {
    /// Goes on with a file that ends where the writer says.
    ///
    /// # Errors
    /// When no thread can be had.
    pub fn start(writer: Writer, file: File, paths: Paths, most_bytes: u64) -> io::Result<Self> {
        let (jobs, todo) = sync_channel(WAITING);
        let (give_back, spare) = channel();
        let shared = Arc::new(Shared::default());
        shared.bytes.store(writer.length(), Ordering::Relaxed);
        let mut work = Work {
            writer,
            file,
            paths,
            most_bytes,
            shared: Arc::clone(&shared),
            spare: give_back,
        };
        let thread = std::thread::Builder::new().name("recording".to_owned());
        let thread = thread.spawn(move || {
            for job in todo {
                work.take(job);
            }
        })?;
        Ok(Self {
            jobs: Some(jobs),
            spare,
            shared,
            thread: Some(thread),
        })
    }

    /// Writes the end of the recording. Returns whether all of it is there.
    pub fn end(&mut self) -> bool {
        let (told, done) = channel();
        let asked = self
            .jobs
            .as_ref()
            .map(|jobs| jobs.send(Job::End(told)).is_ok());
        let ended = asked == Some(true) && done.recv().unwrap_or(false);
        self.join();
        ended
    }

    fn join(&mut self) {
        drop(self.jobs.take());
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            self.shared
                .fail("the thread that writes it panicked".to_owned());
        }
    }
}

/// What was handed over is written before whoever had it goes on.
impl Drop for Sink {
    fn drop(&mut self) {
        self.join();
    }
}

impl Work {
    fn take(&mut self, job: Job) {
        match job {
            Job::Block(raw) => {
                self.unless_failed(|work| work.block(&raw));
                // Nobody wants it back at the end.
                drop(self.spare.send(raw));
            }
            Job::Tail(raw, told) => {
                let kept = self.unless_failed(|work| work.tail(&raw));
                tell(&told, kept);
            }
            Job::End(told) => {
                let ended = self.unless_failed(Self::end);
                tell(&told, ended);
            }
        }
    }

    fn unless_failed(
        &mut self,
        task: impl FnOnce(&mut Self) -> Result<(), RecordingError>,
    ) -> bool {
        if self.shared.failed.load(Ordering::Relaxed) {
            return false;
        }
        match task(self) {
            Ok(()) => true,
            Err(error) => {
                self.give_up(error.to_string());
                false
            }
        }
    }

    /// Writes no more. What there is stays, under a name that says that no more will come.
    fn give_up(&mut self, why: String) {
        if let Err(error) = fs::rename(&self.paths.part, &self.paths.cut) {
            let path = self.paths.part.display();
            tracing::warn!(%path, %error, "a cut recording cannot be renamed");
        }
        if let Err(error) = File::create(&self.paths.given_up) {
            tracing::warn!(%error, "that a recording was given up cannot be kept");
        }
        remove(&self.paths.tail);
        self.shared.fail(why);
    }

    fn block(&mut self, raw: &Raw) -> Result<(), RecordingError> {
        let block = self.writer.encode(raw)?;
        if leaves_no_room(&self.file) {
            self.give_up("the disk has hardly any room left".to_owned());
            return Ok(());
        }
        let length = self.writer.length() + block.len() as u64;
        if length > self.most_bytes {
            let why = format!("it would take more than {} bytes", self.most_bytes);
            self.give_up(why);
            return Ok(());
        }
        self.file.write_all(&block)?;
        self.writer.add(&block);
        self.shared.bytes.store(length, Ordering::Relaxed);
        Ok(())
    }

    fn tail(&mut self, raw: &Raw) -> Result<(), RecordingError> {
        let block = self.writer.encode(raw)?;
        self.file.sync_data()?;
        write_tail(&self.paths, &block)?;
        Ok(())
    }

    fn end(&mut self) -> Result<(), RecordingError> {
        self.file.write_all(&self.writer.end())?;
        self.file.sync_all()?;
        fs::rename(&self.paths.part, &self.paths.whole)?;
        if let Some(directory) = self.paths.whole.parent() {
            File::open(directory)?.sync_all()?;
        }
        remove(&self.paths.tail);
        Ok(())
    }
}

/// Whether recordings would fill the disk, on which what runs find is to be stored.
fn leaves_no_room(file: &File) -> bool {
    let Ok(disk) = rustix::fs::fstatvfs(file) else {
        return false;
    };
    let bytes = |blocks: u64| blocks.saturating_mul(disk.f_frsize);
    bytes(disk.f_bavail) < LEAST_ROOM_BYTES.min(bytes(disk.f_blocks) / 8)
}

/// Whoever asked may have given up.
fn tell(told: &Sender<bool>, what: bool) {
    #[allow(
        clippy::let_underscore_must_use,
        reason = "then there is nobody to tell"
    )]
    let _ = told.send(what);
}

/// Replaces the block that is begun, durably.
pub fn write_tail(paths: &Paths, block: &[u8]) -> io::Result<()> {
    let directory = paths.tail.parent().unwrap_or(Path::new("."));
    let mut file = tempfile::NamedTempFile::new_in(directory)?;
    file.write_all(block)?;
    file.as_file().sync_all()?;
    file.persist(&paths.tail)?;
    File::open(directory)?.sync_all()
}

/// Cuts a file and goes to its end.
pub fn cut(file: &mut File, length: u64) -> io::Result<()> {
    file.set_len(length)?;
    file.seek(SeekFrom::Start(length))?;
    Ok(())
}

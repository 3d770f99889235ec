//! Why a recording cannot be read or written.

/// What is wrong.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// It does not begin as a recording does.
    #[error("this is no recording, or one of another version")]
    Foreign,
    /// Its header or a block of it was changed or cut.
    #[error("the recording is damaged: {0}")]
    Damaged(&'static str),
    /// It ends before what is asked for.
    #[error("the recording ends before sample {0}")]
    Beyond(u64),
    /// The file cannot be read or written.
    #[error("the recording cannot be read or written: {0}")]
    Io(#[from] std::io::Error),
}

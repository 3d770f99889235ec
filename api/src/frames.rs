//! Frames: where every robot of a run stands at a moment, and every movable object, as local
//! programs read it from shared memory. A frame is a moment of the simulation, not every step: at most 60 a second of wall
//! time, latest wins, so a viewer never slows a run down and two frames may be many steps apart.

use std::path::{Path, PathBuf};

use iceoryx2::prelude::{Config, FileName, Path as IpcPath, SemanticString, ZeroCopySend};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Version of [`RobotState`], [`ObjectState`] and [`FrameHeader`]; part of their type names, so that a reader of
/// another version is refused when it opens the channel instead of reading nonsense.
pub const FRAMES_VERSION: u32 = 1;

/// Names of the phases of a run; [`FrameHeader::phase`] is an index into them.
pub const PHASES: [&str; 5] = ["babbling", "evolution", "repository", "exploration", "done"];

/// A field of a shared-memory type, for programs in other languages.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct FieldLayout {
    /// Name of the field.
    pub name: String,
    /// Rust type: a number type or an array of one, in the machine's byte order.
    pub kind: String,
    /// Bytes from the start of the type.
    pub offset_bytes: usize,
    /// Bytes of the field.
    pub size_bytes: usize,
}

/// A shared-memory type as C sees it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct TypeLayout {
    /// Name under which the channel checks the type; holds its version.
    pub type_name: String,
    /// Bytes of one value, padding included.
    pub size_bytes: usize,
    /// Alignment in bytes.
    pub alignment_bytes: usize,
    /// Every field, in order.
    pub fields: Vec<FieldLayout>,
}

/// Defines a shared-memory type together with its layout table, so that the two cannot differ.
macro_rules! shared_type {
    ($(#[$meta:meta])* $name:ident as $type_name:literal {
        $($(#[$field_meta:meta])* $field:ident: $kind:ty,)+
    }) => {
        $(#[$meta])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default, PartialEq, ZeroCopySend)]
        #[type_name($type_name)]
        pub struct $name { $($(#[$field_meta])* pub $field: $kind,)+ }

        impl $name {
            /// The layout of this type.
            pub fn layout() -> TypeLayout {
                TypeLayout {
                    type_name: $type_name.to_owned(),
                    size_bytes: size_of::<Self>(),
                    alignment_bytes: align_of::<Self>(),
                    fields: vec![$($crate::frames::FieldLayout {
                        name: stringify!($field).to_owned(),
                        kind: stringify!($kind).to_owned(),
                        offset_bytes: std::mem::offset_of!(Self, $field),
                        size_bytes: size_of::<$kind>(),
                    }),+],
                }
            }
        }
    };
}

pub(crate) use shared_type;

shared_type! {
    /// One robot in a frame.
    RobotState as "swarm.RobotState.v1" {
        /// Number of the robot in its run, from 0.
        number: u32,
        /// Position, metres from the arena's lower left corner.
        x_m: f32,
        /// Position, metres upwards.
        y_m: f32,
        /// Cosine of the heading (counter-clockwise from the x axis).
        heading_cos: f32,
        /// Sine of the heading.
        heading_sin: f32,
        /// Raw proximity values of ps0 to ps7, 0 to 4095.
        sensors: [f32; 8],
        /// Wheel commands, left and right, -1 to 1 of the top speed.
        commands: [f32; 2],
    }
}

shared_type! {
    /// One movable object in a frame; its place in the slice is its number in the arena that robots
    /// are in.
    ObjectState as "swarm.ObjectState.v1" {
        /// Centre, metres from the arena's lower left corner.
        x_m: f32,
        /// Centre, metres upwards.
        y_m: f32,
        /// Counter-clockwise from the x axis, above -pi to pi.
        heading_rad: f32,
        /// Way that it has been moved while visits counted, metres.
        moved_m: f32,
    }
}

shared_type! {
    /// What a frame shows, beside the robots or objects. Robots and objects of one moment come with
    /// the same header, each on a channel of its own: pair them by `arena_step`.
    FrameHeader as "swarm.FrameHeader.v1" {
        /// Frames of the run sent before this one.
        sequence: u64,
        /// Steps of the arena since the run began, all phases; each moves every robot once.
        arena_step: u64,
        /// Robot-steps done, all phases.
        robot_steps_done: u64,
        /// Robot-steps that the whole run has.
        robot_steps_total: u64,
        /// Simulated seconds since the run began, all phases.
        sim_time_s: f64,
        /// Control step, simulated seconds.
        step_s: f64,
        /// [`FRAMES_VERSION`] of the sender.
        version: u32,
        /// What the run is doing, an index into [`PHASES`]; up to `repository` the robots are in
        /// the training arena if the method has one.
        phase: u32,
        /// Counted epochs that are complete.
        epochs_done: u32,
        /// Counted epochs in all.
        epochs_total: u32,
        /// Robots in the frame: the length of their slice.
        robots: u32,
        /// Always 0: keeps the type free of padding.
        reserved: u32,
    }
}

impl FrameHeader {
    /// Name of the phase; `unknown` when a later version added one.
    pub fn phase_name(&self) -> &'static str {
        PHASES
            .get(self.phase as usize)
            .copied()
            .unwrap_or("unknown")
    }
}

/// Name of the service on which a run's frames are sent.
pub fn frames_service(run_id: &str) -> String {
    format!("swarm/{run_id}/frames")
}

/// Name of the service on which the movable objects of a run's frames are sent, before the robots
/// of the same moment are.
pub fn objects_service(run_id: &str) -> String {
    format!("swarm/{run_id}/objects")
}

/// The folder that servers and readers of one user share unless told otherwise:
/// `$XDG_RUNTIME_DIR/evswarm`, else `evswarm-<user>` in the folder for temporary files.
pub fn default_root() -> PathBuf {
    match std::env::var_os("XDG_RUNTIME_DIR") {
        Some(folder) if Path::new(&folder).is_absolute() => Path::new(&folder).join("evswarm"),
        _ => std::env::temp_dir().join(format!("evswarm-{}", user())),
    }
}

/// The user's number where the system shows it, else the user's name.
fn user() -> String {
    #[cfg(target_os = "linux")]
    if let Ok(me) = std::fs::metadata("/proc/self") {
        return std::os::unix::fs::MetadataExt::uid(&me).to_string();
    }
    let name = std::env::var("USER")
        .or_else(|_| std::env::var("USERNAME"))
        .unwrap_or_default();
    name.chars().filter(char::is_ascii_alphanumeric).collect()
}

/// A root path that the transport cannot use.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the channels' root path {path:?} cannot be used: it must be absolute and at most \
     {MAX_ROOT_BYTES} bytes long"
)]
pub struct RootError {
    /// The path.
    pub path: PathBuf,
}

/// Longest root path; with the transport's own file names it stays within the 255 bytes that the
/// transport can hold.
pub const MAX_ROOT_BYTES: usize = 120;

/// The transport's settings for servers and readers that meet under `root`.
///
/// The prefix of all names is derived from the path: shared memory has one name space for the
/// whole machine, and users must not meet in it.
///
/// # Errors
/// [`RootError`] when the path is relative, too long or not fit for the transport.
pub fn transport_config(root: &Path) -> Result<Config, RootError> {
    let refused = || RootError {
        path: root.to_owned(),
    };
    let bytes = root.as_os_str().as_encoded_bytes();
    if !root.is_absolute() || bytes.len() > MAX_ROOT_BYTES {
        return Err(refused());
    }
    let mut config = Config::default();
    config
        .global
        .set_root_path(&IpcPath::new(bytes).map_err(|_| refused())?);
    let prefix = format!("evswarm_{:016x}_", fnv1a(bytes));
    config.global.prefix = FileName::new(prefix.as_bytes()).map_err(|_| refused())?;
    Ok(config)
}

/// FNV-1a, 64 bits: the standard library's hash may change from version to version.
fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    fn without_padding(layout: &TypeLayout) {
        let mut next = 0;
        for field in &layout.fields {
            assert_eq!(
                field.offset_bytes, next,
                "{} of {}",
                field.name, layout.type_name
            );
            next += field.size_bytes;
        }
        assert_eq!(next, layout.size_bytes, "{}", layout.type_name);
    }

    #[test]
    fn version_1_never_changes_its_layout() {
        let (robot, header) = (RobotState::layout(), FrameHeader::layout());
        let object = ObjectState::layout();
        without_padding(&robot);
        without_padding(&object);
        without_padding(&header);
        assert_eq!((robot.size_bytes, robot.alignment_bytes), (60, 4));
        assert_eq!((object.size_bytes, object.alignment_bytes), (16, 4));
        assert_eq!((header.size_bytes, header.alignment_bytes), (72, 8));
        let suffix = format!(".v{FRAMES_VERSION}");
        for layout in [&robot, &object, &header] {
            assert!(layout.type_name.ends_with(&suffix));
        }
        // SAFETY: reads a constant; the trait marks it unsafe for those who implement it.
        let sent = unsafe { <RobotState as ZeroCopySend>::type_name() };
        assert_eq!(sent, robot.type_name);
        // SAFETY: as above.
        let sent = unsafe { <ObjectState as ZeroCopySend>::type_name() };
        assert_eq!(sent, object.type_name);
    }

    #[test]
    fn roots_have_prefixes_of_their_own() {
        let prefix = |root: &str| transport_config(Path::new(root)).unwrap().global.prefix;
        assert_eq!(prefix("/tmp/a"), prefix("/tmp/a"));
        assert_ne!(prefix("/tmp/a"), prefix("/tmp/b"));
    }

    #[test]
    fn roots_that_cannot_work_are_refused() {
        let long = format!("/{}", "x".repeat(MAX_ROOT_BYTES));
        for root in ["relative", long.as_str()] {
            assert_eq!(
                transport_config(Path::new(root)).unwrap_err().path,
                Path::new(root)
            );
        }
        assert!(transport_config(&default_root()).is_ok());
    }

    #[test]
    fn phases_have_names() {
        assert_eq!(
            FrameHeader {
                phase: 4,
                ..Default::default()
            }
            .phase_name(),
            "done"
        );
        assert_eq!(
            FrameHeader {
                phase: 99,
                ..Default::default()
            }
            .phase_name(),
            "unknown"
        );
    }
}

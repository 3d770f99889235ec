//! Frames and controllers for programs in C: `include/evswarm.h` says what each function does. The
//! structures are those of the crate `api`, checked field by field against the header.

use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::ptr::null_mut;
use std::time::Duration;

use api::channels::run_service;
use api::controller::Controller;
use api::external::{Asked, RobotSense, WheelCommand};
use api::frames::{FrameHeader, RobotState, default_root};
use api::reader::FrameReader;

/// Sets commands.
pub type Act =
    extern "C" fn(*const Asked, *const RobotSense, *mut WheelCommand, usize, *mut c_void);
/// Sees a frame.
pub type See = extern "C" fn(*const FrameHeader, *const RobotState, usize, *mut c_void);

thread_local! {
    static ERROR: RefCell<CString> = RefCell::default();
}

/// Does something; a failure is kept for [`evswarm_error`].
fn attempt<T>(failed: T, act: impl FnOnce() -> Result<T, String>) -> T {
    let done = catch_unwind(AssertUnwindSafe(act));
    let done = done.unwrap_or_else(|_| Err("the library panicked".to_owned()));
    done.unwrap_or_else(|why| {
        let why = CString::new(why.replace('\0', " ")).unwrap_or_default();
        ERROR.with(|error| *error.borrow_mut() = why);
        failed
    })
}

/// A text of the caller; `None` where there is none.
///
/// # Safety
/// `text` is null or ends with a zero.
unsafe fn text(text: *const c_char) -> Result<Option<String>, String> {
    if text.is_null() {
        return Ok(None);
    }
    // SAFETY: it ends with a zero, as whoever calls says.
    let text = unsafe { CStr::from_ptr(text) };
    let text = text.to_str().map_err(|_| "a text is not UTF-8")?;
    Ok(Some(text.to_owned()))
}

/// Root folder and run.
///
/// # Safety
/// As [`text`].
unsafe fn place(root: *const c_char, run_id: *const c_char) -> Result<(PathBuf, String), String> {
    // SAFETY: as whoever calls says.
    let (root, run_id) = unsafe { (text(root)?, text(run_id)?) };
    let root = root.map_or_else(default_root, PathBuf::from);
    Ok((root, run_id.ok_or("no run")?))
}

/// Why the last function of this thread failed.
#[unsafe(no_mangle)]
pub extern "C" fn evswarm_error() -> *const c_char {
    ERROR.with(|error| error.borrow().as_ptr())
}

/// Opens a controller.
///
/// # Safety
/// Texts are null or end with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn evswarm_controller_open(
    root: *const c_char,
    run_id: *const c_char,
    number: usize,
) -> *mut Controller {
    attempt(null_mut(), || {
        // SAFETY: as whoever calls says.
        let (root, run_id) = unsafe { place(root, run_id)? };
        let controller = Controller::open(&root, &run_id, number);
        let controller = controller.map_err(|error| error.to_string())?;
        Ok(Box::into_raw(Box::new(controller)))
    })
}

/// Waits for a question and answers it.
///
/// # Safety
/// `controller` is null or comes from `evswarm_controller_open`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn evswarm_controller_answer(
    controller: *mut Controller,
    wait_ms: u64,
    act: Option<Act>,
    context: *mut c_void,
) -> c_int {
    attempt(-1, || {
        // SAFETY: null, or made by `evswarm_controller_open` and used by one thread.
        let controller = unsafe { controller.as_mut() }.ok_or("no controller")?;
        let act = act.ok_or("no function that acts")?;
        let wait = Duration::from_millis(wait_ms);
        let answered = controller.answer(wait, |asked, robots, commands| {
            act(
                asked,
                robots.as_ptr(),
                commands.as_mut_ptr(),
                robots.len(),
                context,
            );
        });
        answered.map(c_int::from).map_err(|error| error.to_string())
    })
}

/// Closes a controller.
///
/// # Safety
/// `controller` is null or comes from `evswarm_controller_open`, and is not used any more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn evswarm_controller_close(controller: *mut Controller) {
    if !controller.is_null() {
        // SAFETY: made by `Box::into_raw`, and given back once.
        attempt((), || unsafe {
            drop(Box::from_raw(controller));
            Ok(())
        });
    }
}

/// Opens a reader of frames.
///
/// # Safety
/// Texts are null or end with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn evswarm_frames_open(
    root: *const c_char,
    run_id: *const c_char,
    lossless: c_int,
) -> *mut FrameReader {
    attempt(null_mut(), || {
        // SAFETY: as whoever calls says.
        let (root, run_id) = unsafe { place(root, run_id)? };
        let name = if lossless == 0 { "frames" } else { "lossless" };
        let frames = FrameReader::open(&root, &run_service(&run_id, name));
        let frames = frames.map_err(|error| error.to_string())?;
        Ok(Box::into_raw(Box::new(frames)))
    })
}

/// Waits for a frame.
///
/// # Safety
/// `frames` is null or comes from `evswarm_frames_open`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn evswarm_frames_next(
    frames: *mut FrameReader,
    wait_ms: u64,
    see: Option<See>,
    context: *mut c_void,
) -> c_int {
    attempt(-1, || {
        // SAFETY: null, or made by `evswarm_frames_open` and used by one thread.
        let frames = unsafe { frames.as_mut() }.ok_or("no reader")?;
        let see = see.ok_or("no function that sees")?;
        let frame = frames.wait(Duration::from_millis(wait_ms));
        let Some(frame) = frame.map_err(|error| error.to_string())? else {
            return Ok(0);
        };
        let robots = frame.payload();
        see(frame.user_header(), robots.as_ptr(), robots.len(), context);
        Ok(1)
    })
}

/// Closes a reader.
///
/// # Safety
/// `frames` is null or comes from `evswarm_frames_open`, and is not used any more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn evswarm_frames_close(frames: *mut FrameReader) {
    if !frames.is_null() {
        // SAFETY: made by `Box::into_raw`, and given back once.
        attempt((), || unsafe {
            drop(Box::from_raw(frames));
            Ok(())
        });
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use std::fmt::Write;
    use std::process::Command;

    use api::frames::TypeLayout;

    use super::*;

    /// C that does not compile where a structure of the header differs.
    fn assertions(name: &str, layout: &TypeLayout) -> String {
        let size = layout.size_bytes;
        let mut text = format!("_Static_assert(sizeof({name}) == {size}, \"{name}\");\n");
        for field in &layout.fields {
            let (at, size) = (field.offset_bytes, field.size_bytes);
            let field = &field.name;
            writeln!(
                text,
                "_Static_assert(offsetof({name}, {field}) == {at}, \"{name}.{field}\");\n\
                 _Static_assert(sizeof((({name} *)0)->{field}) == {size}, \"{name}.{field}\");"
            )
            .unwrap();
        }
        text
    }

    #[test]
    fn the_header_has_the_structures_that_lie_in_shared_memory() {
        let text = [
            ("evswarm_robot_state", RobotState::layout()),
            ("evswarm_frame_header", FrameHeader::layout()),
            ("evswarm_asked", Asked::layout()),
            ("evswarm_robot_sense", RobotSense::layout()),
            ("evswarm_wheel_command", WheelCommand::layout()),
        ]
        .map(|(name, layout)| assertions(name, &layout))
        .concat();
        let folder = tempfile::tempdir().unwrap();
        let source = folder.path().join("layouts.c");
        let compile = |text: &str| {
            std::fs::write(&source, format!("#include \"evswarm.h\"\n{text}")).unwrap();
            let mut compiler = Command::new("cc");
            let include = concat!(env!("CARGO_MANIFEST_DIR"), "/include");
            compiler.args([
                "-std=c11",
                "-Wall",
                "-Werror",
                "-fsyntax-only",
                "-I",
                include,
            ]);
            compiler.arg(&source).output().unwrap()
        };
        let compiled = compile(&text);
        let errors = String::from_utf8_lossy(&compiled.stderr);
        assert!(compiled.status.success(), "{errors}");
        let wrong = text.replacen("== 60", "== 61", 1);
        assert!(
            !compile(&wrong).status.success(),
            "a wrong size was not noticed"
        );
    }

    #[test]
    fn failures_are_said() {
        // SAFETY: null is allowed everywhere.
        unsafe {
            assert!(evswarm_controller_open(null_mut(), null_mut(), 0).is_null());
            assert_eq!(CStr::from_ptr(evswarm_error()).to_str().unwrap(), "no run");
            assert_eq!(
                evswarm_controller_answer(null_mut(), 0, None, null_mut()),
                -1
            );
            evswarm_controller_close(null_mut());
            let folder = tempfile::tempdir().unwrap();
            let root = CString::new(folder.path().to_str().unwrap()).unwrap();
            assert!(evswarm_frames_open(root.as_ptr(), c"no-run".as_ptr(), 0).is_null());
            let why = CStr::from_ptr(evswarm_error()).to_str().unwrap();
            assert!(
                why.contains("there is no channel swarm/no-run/frames"),
                "{why}"
            );
            evswarm_frames_close(null_mut());
        }
    }
}

//! Arenas of a spec: by name from a source, or written out in place.

use std::collections::BTreeMap;
use std::sync::{Arc, LazyLock};

use api::{ArenaRef, FieldError};
use arenas::{Arena, ArenaFormat, Pose, SquaresFormat, Tiling};
use serde_json::Value;
use serde_path_to_error::Segment;

use super::domains::SCHEMA_LINK;
use super::fields::{Errors, Object, did_you_mean, join, kind};

/// Fields of an arena object.
pub(super) const FIELDS: [&str; 9] = [
    SCHEMA_LINK,
    "name",
    "width_m",
    "height_m",
    "squares",
    "walls_m",
    "generate",
    "starts",
    "objects",
];
/// Fields of an arena made of another.
pub(super) const TILED_FIELDS: [&str; 7] = [
    SCHEMA_LINK,
    "from",
    "tile",
    "scale",
    "doorway_m",
    "squares",
    "name",
];
/// Deepest that such objects may hold each other.
const MAX_DEPTH: u32 = 4;
/// Most walls and starts of all arenas of a job together: 128 MB.
const MAX_PARTS: usize = 4_000_000;
/// Most walls and starts that the runs of a job show, each combination of the matrix for itself:
/// half a kilobyte of document each.
const MAX_SHOWN_PARTS: usize = 500_000;
/// Fields of a start pose.
const POSE_FIELDS: [&str; 3] = ["x_m", "y_m", "heading_rad"];

/// Where arenas are looked up by name.
pub trait ArenaSource {
    /// The arena of this name.
    fn arena(&self, name: &str) -> Option<Arc<Arena>>;
    /// Every name, for error messages.
    fn names(&self) -> Vec<String>;
}

/// The arenas that ship with the program.
#[derive(Clone, Copy, Debug, Default)]
pub struct BuiltinArenas;

static BUILTIN: LazyLock<Vec<(String, Arc<Arena>)>> = LazyLock::new(|| {
    arenas::builtin_names()
        .iter()
        .filter_map(|name| Some((name.to_string(), Arc::new(arenas::builtin(name)?))))
        .collect()
});

impl ArenaSource for BuiltinArenas {
    fn arena(&self, name: &str) -> Option<Arc<Arena>> {
        let (_, arena) = BUILTIN.iter().find(|(known, _)| known == name)?;
        Some(Arc::clone(arena))
    }

    fn names(&self) -> Vec<String> {
        BUILTIN.iter().map(|(name, _)| name.clone()).collect()
    }
}

/// An arena that a spec names or holds, and how the resolved spec shows it.
#[derive(Clone, Debug)]
pub struct Found {
    /// The arena.
    pub arena: Arc<Arena>,
    /// Its name, or the object with every default and with generated walls written out.
    pub shown: ArenaRef,
    /// Walls and starts that are written out there.
    shown_parts: usize,
}

/// Reads arenas, each but once however many runs of a job use it.
pub struct Arenas<'a> {
    source: &'a dyn ArenaSource,
    /// By the JSON text of the value; errors have pointers relative to it.
    read: BTreeMap<String, Result<Found, Vec<FieldError>>>,
    /// Walls and starts of all of them.
    parts: usize,
    /// Walls and starts that are written out wherever one of them was asked for.
    shown_parts: usize,
}

impl<'a> Arenas<'a> {
    /// Nothing read yet.
    pub fn new(source: &'a dyn ArenaSource) -> Self {
        Self {
            source,
            read: BTreeMap::new(),
            parts: 0,
            shown_parts: 0,
        }
    }

    /// The arena that `value` names or holds.
    pub fn read(&mut self, value: &Value, pointer: &str, errors: &mut Errors) -> Option<Found> {
        let (source, parts) = (self.source, &mut self.parts);
        let outcome = self.read.entry(value.to_string()).or_insert_with(|| {
            if *parts > MAX_PARTS {
                return Err(vec![too_many_parts()]);
            }
            let found = find(value, source, MAX_DEPTH)?;
            *parts += parts_of(&found.arena);
            Ok(found)
        });
        let wrong = match outcome {
            Ok(found) => {
                let shown_parts = self.shown_parts + found.shown_parts;
                // One arena is let through however large: it has limits of its own.
                if self.shown_parts == 0 || shown_parts <= MAX_SHOWN_PARTS {
                    self.shown_parts = shown_parts;
                    return Some(found.clone());
                }
                &vec![too_many_shown()]
            }
            Err(wrong) => wrong,
        };
        errors.extend(wrong.iter().map(|error| FieldError {
            pointer: format!("{pointer}{}", error.pointer),
            ..error.clone()
        }));
        None
    }
}

/// Walls and starts, and objects, which are twice as long to write out.
fn parts_of(arena: &Arena) -> usize {
    arena.walls().len() + arena.starts().len() + 2 * arena.objects().len()
}

fn too_many_shown() -> FieldError {
    FieldError::new(
        "",
        "the job's combinations write out too many walls",
        format!(
            "at most {MAX_SHOWN_PARTS} walls and starts, an object for two, counted for each \
             combination of the matrix; an arena that was uploaded can be named instead of \
             written out"
        ),
    )
}

fn too_many_parts() -> FieldError {
    FieldError::new(
        "",
        "the arenas of the job are too many or too large",
        format!("at most {MAX_PARTS} walls and starts in all, each arena counted once"),
    )
}

fn find(value: &Value, source: &dyn ArenaSource, depth: u32) -> Result<Found, Vec<FieldError>> {
    match value {
        Value::String(name) => by_name(name, source),
        Value::Object(map) if map.contains_key("from") => tiled(value, source, depth),
        Value::Object(_) => inline(value),
        _ => {
            let message = format!("must be a name or an arena object, not {}", kind(value));
            let allowed = format!("{}, or an arena object", source.names().join(", "));
            Err(vec![FieldError::new("", message, allowed)])
        }
    }
}

/// An arena made of copies of another: `{"from": "easy", "tile": [3, 3]}`.
fn tiled(value: &Value, source: &dyn ArenaSource, depth: u32) -> Result<Found, Vec<FieldError>> {
    let mut errors = Errors::default();
    let Some(object) = Object::open(value, "", TILED_FIELDS, &mut errors) else {
        return Err(errors.into_vec());
    };
    let tiling = Tiling {
        tile: field(
            &object,
            "tile",
            "[columns, rows], whole numbers",
            &mut errors,
        )
        .unwrap_or([1, 1]),
        scale: field(&object, "scale", "a number", &mut errors).unwrap_or(1.0),
        doorway_m: field(&object, "doorway_m", "a number of metres", &mut errors),
        squares: field(
            &object,
            "squares",
            "a whole number a side, or [columns, rows]",
            &mut errors,
        )
        .map(SquaresFormat::sides),
        name: field(&object, "name", "a string", &mut errors),
    };
    let from = match object.get("from") {
        Some(_) if depth == 0 => Err(vec![FieldError::new(
            "",
            "too many arenas made of arenas",
            format!("at most {MAX_DEPTH}, one in the other"),
        )]),
        Some(from) => find(from, source, depth - 1),
        None => Err(vec![FieldError::new("", "missing", "an arena")]),
    };
    let from = from.map_err(|wrong| {
        errors.extend(wrong.into_iter().map(|error| FieldError {
            pointer: format!("/from{}", error.pointer),
            ..error
        }));
    });
    let Ok(from) = from else {
        return Err(errors.into_vec());
    };
    if !errors.is_empty() {
        return Err(errors.into_vec());
    }
    let arena = from
        .arena
        .tiled(&tiling)
        .map_err(|errors| errors.into_iter().map(arena_error).collect::<Vec<_>>())?;
    check_name(&arena)?;
    let per_tile = tiling.squares.unwrap_or(from.arena.squares());
    let shown = serde_json::json!({
        "from": from.shown,
        "tile": tiling.tile,
        "scale": tiling.scale,
        "doorway_m": tiling.doorway_m,
        "squares": SquaresFormat::from(per_tile),
        "name": arena.name(),
    });
    let Value::Object(shown) = shown else {
        return Err(Vec::new());
    };
    Ok(Found {
        arena: Arc::new(arena),
        shown: ArenaRef::Inline(shown),
        shown_parts: from.shown_parts,
    })
}

/// Results of an arena that only has the name of a built-in one would be taken for the latter's.
fn check_name(arena: &Arena) -> Result<(), Vec<FieldError>> {
    match BuiltinArenas.arena(arena.name()) {
        Some(builtin) if builtin.content_key() != arena.content_key() => {
            let name = arena.name();
            let message = format!("{name:?} is the name of a built-in arena, which is another");
            Err(vec![FieldError::new("/name", message, "a name of its own")])
        }
        _ => Ok(()),
    }
}

/// A field of an arena made of another; `None` when it is absent or null, or wrong.
fn field<T: serde::de::DeserializeOwned>(
    object: &Object<'_>,
    name: &str,
    allowed: &str,
    errors: &mut Errors,
) -> Option<T> {
    let value = object.get(name).filter(|value| !value.is_null())?;
    let read = T::deserialize(value);
    if read.is_err() {
        errors.add(
            object.pointer(name),
            format!("{value} is not that"),
            allowed,
        );
    }
    read.ok()
}

fn by_name(name: &str, source: &dyn ArenaSource) -> Result<Found, Vec<FieldError>> {
    match source.arena(name) {
        Some(arena) => Ok(Found {
            arena,
            shown: ArenaRef::Name(name.to_owned()),
            shown_parts: 0,
        }),
        None => {
            let names = source.names();
            let message = format!("there is no arena {name:?}{}", did_you_mean(name, &names));
            let allowed = format!("{}, or an arena object", names.join(", "));
            Err(vec![FieldError::new("", message, allowed)])
        }
    }
}

/// Reads an arena that is written out.
///
/// # Errors
/// Every wrong field, with pointers into `value`.
pub fn read_arena(value: &Value) -> Result<Arena, Vec<FieldError>> {
    let mut errors = Errors::default();
    let object = Object::open(value, "", FIELDS, &mut errors);
    if let Some(Value::Array(starts)) = object.and_then(|object| object.get("starts")) {
        for (number, start) in starts.iter().enumerate() {
            Object::open(
                start,
                &format!("/starts/{number}"),
                POSE_FIELDS,
                &mut errors,
            );
        }
    }
    if !errors.is_empty() {
        return Err(errors.into_vec());
    }
    let mut plain = std::borrow::Cow::Borrowed(value);
    if value.get(SCHEMA_LINK).is_some() {
        plain
            .to_mut()
            .as_object_mut()
            .map(|arena| arena.remove(SCHEMA_LINK));
    }
    let format: ArenaFormat = serde_path_to_error::deserialize(&*plain).map_err(|error| {
        let pointer = pointer_of(error.path());
        vec![FieldError::new(
            pointer,
            error.inner().to_string(),
            FIELDS.join(", "),
        )]
    })?;
    format.build().map_err(|wrong| {
        errors.extend(wrong.into_iter().map(arena_error));
        errors.into_vec()
    })
}

fn inline(value: &Value) -> Result<Found, Vec<FieldError>> {
    let arena = read_arena(value)?;
    check_name(&arena)?;
    Ok(Found {
        shown: ArenaRef::Inline(shown(&arena)),
        shown_parts: parts_of(&arena),
        arena: Arc::new(arena),
    })
}

/// The arena as an object with every field; `objects` only where there are some.
fn shown(arena: &Arena) -> serde_json::Map<String, Value> {
    let wall = |s: &arenas::Segment| Value::from(vec![s.a.x, s.a.y, s.b.x, s.b.y]);
    let start = |Pose {
                     x_m,
                     y_m,
                     heading_rad,
                 }: &Pose| {
        serde_json::json!({ "x_m": x_m, "y_m": y_m, "heading_rad": heading_rad })
    };
    let objects = serde_json::json!(arena.objects());
    let objects = (!arena.objects().is_empty()).then_some(("objects", objects));
    [
        ("name", Value::from(arena.name())),
        ("width_m", Value::from(arena.width_m())),
        ("height_m", Value::from(arena.height_m())),
        (
            "squares",
            serde_json::json!(SquaresFormat::from(arena.squares())),
        ),
        ("walls_m", arena.walls().iter().map(wall).collect()),
        ("starts", arena.starts().iter().map(start).collect()),
    ]
    .into_iter()
    .chain(objects)
    .map(|(name, value)| (name.to_owned(), value))
    .collect()
}

/// An error of the `arenas` crate as one of the service's.
pub fn arena_error(error: arenas::ArenaError) -> FieldError {
    FieldError::new(error.pointer, error.message, error.allowed)
}

fn pointer_of(path: &serde_path_to_error::Path) -> String {
    path.iter()
        .fold(String::new(), |pointer, segment| match segment {
            Segment::Seq { index } => format!("{pointer}/{index}"),
            Segment::Map { key } => join(&pointer, key),
            Segment::Enum { variant } => join(&pointer, variant),
            Segment::Unknown => pointer,
        })
}

//! What a field of a document may be, and what it is when it is absent: one value checks it, fills
//! it in and describes it in the JSON Schemas.

use serde_json::{Value, json};

/// Where an editor finds the JSON Schema of a document; not read.
pub const SCHEMA_LINK: &str = "$schema";

/// A whole number.
#[derive(Clone, Copy, Debug)]
pub struct Whole {
    /// Name of the field.
    pub name: &'static str,
    /// Smallest.
    pub min: u64,
    /// Largest.
    pub max: u64,
    /// When it is absent.
    pub default: u64,
}

impl Whole {
    /// Its JSON Schema.
    pub fn schema(&self) -> Value {
        json!({
            "type": "integer", "minimum": self.min, "maximum": self.max, "default": self.default,
        })
    }
}

/// `true` or `false`.
#[derive(Clone, Copy, Debug)]
pub struct Flag {
    /// Name of the field.
    pub name: &'static str,
    /// When it is absent.
    pub default: bool,
}

impl Flag {
    /// Its JSON Schema.
    pub fn schema(&self) -> Value {
        json!({ "type": "boolean", "default": self.default })
    }
}

/// One of some names.
#[derive(Clone, Copy, Debug)]
pub struct Choice<T: 'static> {
    /// Name of the field.
    pub name: &'static str,
    /// The names.
    pub names: &'static [&'static str],
    /// What a name stands for.
    pub read: fn(&str) -> Option<T>,
    /// The name of it.
    pub shown: fn(T) -> &'static str,
    /// When it is absent.
    pub default: T,
}

impl<T: Copy> Choice<T> {
    /// Its JSON Schema.
    pub fn schema(&self) -> Value {
        json!({ "enum": self.names, "default": (self.shown)(self.default) })
    }
}

//! One table for every open parameter: its name in a spec, default, range, unit and source.
//!
//! The same table fills defaults, checks values and documents itself (`GET /v1/controllers`,
//! `evswarm controllers`), so a parameter cannot be settable and undocumented, or the reverse.

use serde::Serialize;

/// A value as it stands in a spec.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<'a> {
    /// A JSON number.
    Number(f64),
    /// A JSON string: one of the named choices.
    Text(&'a str),
}

/// What a parameter may be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Domain {
    /// A real number in `[min, max]`.
    Real {
        /// Smallest allowed value.
        min: f64,
        /// Largest allowed value.
        max: f64,
    },
    /// A whole number in `[min, max]`.
    Whole {
        /// Smallest allowed value.
        min: u64,
        /// Largest allowed value.
        max: u64,
    },
    /// One of a list of names.
    Choice {
        /// The names.
        names: &'static [&'static str],
    },
}

impl Domain {
    /// The allowed values, in words fit for an error message.
    pub fn allowed(&self) -> String {
        match self {
            Domain::Real { min, max } => format!("a number from {min} to {max}"),
            Domain::Whole { min, max } => format!("a whole number from {min} to {max}"),
            Domain::Choice { names } => format!("one of {}", names.join(", ")),
        }
    }
}

/// Why a value was refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ParameterError {
    /// No parameter has this name.
    #[error("there is no parameter of this name")]
    Unknown,
    /// The value is outside the domain; holds what is allowed.
    #[error("must be {0}")]
    Domain(String),
}

/// The documentation of a parameter, default included.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Parameter {
    /// Name in a spec.
    pub name: &'static str,
    /// What it may be.
    pub domain: Domain,
    /// SI unit, or empty.
    pub unit: &'static str,
    /// What it does.
    pub about: &'static str,
    /// Equation, section or data sheet.
    pub source: &'static str,
}

/// A field type that a parameter can be stored in.
pub trait Field: Sized {
    /// Parses a value that has already been checked against the domain.
    fn read(value: Value<'_>) -> Option<Self>;
    /// The value as JSON would show it.
    fn show(&self) -> Shown;
}

/// A parameter's current value, for a fully resolved spec.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Shown {
    /// A whole number.
    Whole(u64),
    /// A real number.
    Real(f64),
    /// A name.
    Name(&'static str),
}

impl Field for f64 {
    fn read(value: Value<'_>) -> Option<Self> {
        match value {
            Value::Number(x) if x.is_finite() => Some(x),
            _ => None,
        }
    }
    fn show(&self) -> Shown {
        Shown::Real(*self)
    }
}

impl Field for u32 {
    fn read(value: Value<'_>) -> Option<Self> {
        match value {
            Value::Number(x) if x.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&x) => {
                Some(x as u32)
            }
            _ => None,
        }
    }
    fn show(&self) -> Shown {
        Shown::Whole(u64::from(*self))
    }
}

impl Domain {
    /// Whether the value lies in the domain.
    pub fn admits(&self, value: Value<'_>) -> bool {
        match (self, value) {
            (Domain::Real { min, max }, Value::Number(x)) => x >= *min && x <= *max,
            (Domain::Whole { min, max }, Value::Number(x)) => {
                x.fract() == 0.0 && x >= *min as f64 && x <= *max as f64
            }
            (Domain::Choice { names }, Value::Text(t)) => names.contains(&t),
            _ => false,
        }
    }
}

/// Makes an enum whose variants have names in a spec.
macro_rules! named_choice {
    ($(#[$meta:meta])* $name:ident { $($(#[$vmeta:meta])* $variant:ident = $text:literal),+ $(,)? }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
        pub enum $name { $($(#[$vmeta])* $variant),+ }
        impl $name {
            /// Every name, in order of declaration.
            pub const NAMES: &'static [&'static str] = &[$($text),+];
            /// Every variant, in order of declaration.
            pub const ALL: &'static [$name] = &[$($name::$variant),+];
            /// The variant of this name.
            pub fn from_name(name: &str) -> Option<Self> {
                match name { $($text => Some(Self::$variant),)+ _ => None }
            }
            /// The name in a spec.
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $text),+ }
            }
        }
        impl $crate::parameters::Field for $name {
            fn read(value: $crate::parameters::Value<'_>) -> Option<Self> {
                match value { $crate::parameters::Value::Text(t) => Self::from_name(t), _ => None }
            }
            fn show(&self) -> $crate::parameters::Shown {
                $crate::parameters::Shown::Name(self.name())
            }
        }
    };
}

/// Makes a parameter struct with its table: field, type, default, domain, unit, text, source.
/// Its `Debug` tells specs apart (`run/snapshot.rs`).
macro_rules! parameter_table {
    ($(#[$meta:meta])* $name:ident {
        $($field:ident: $ty:ty = $default:expr, $domain:expr, $unit:literal, $about:literal, $source:literal;)+
    }) => {
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        pub struct $name {
            $(#[doc = $about] #[doc = ""] #[doc = concat!("Unit: `", $unit, "`. Source: ", $source)] pub $field: $ty,)+
        }
        impl Default for $name {
            fn default() -> Self { Self { $($field: $default),+ } }
        }
        impl $name {
            /// Every parameter, in the order in which it is documented.
            pub const TABLE: &'static [$crate::parameters::Parameter] = &[$($crate::parameters::Parameter {
                name: stringify!($field), domain: $domain, unit: $unit, about: $about, source: $source,
            }),+];
            /// Sets one parameter by its name in a spec.
            ///
            /// # Errors
            /// `Unknown` when there is none of this name, `Domain` when the value is not allowed.
            pub fn set(&mut self, name: &str, value: $crate::parameters::Value<'_>)
                -> Result<(), $crate::parameters::ParameterError> {
                use $crate::parameters::{Field, ParameterError};
                match name {
                    $(stringify!($field) => {
                        let domain: $crate::parameters::Domain = $domain;
                        let refused = || ParameterError::Domain(domain.allowed());
                        if !domain.admits(value) { return Err(refused()); }
                        self.$field = <$ty as Field>::read(value).ok_or_else(refused)?;
                        Ok(())
                    })+
                    _ => Err(ParameterError::Unknown),
                }
            }
            /// Every parameter with its current value, in table order.
            pub fn shown(&self) -> Vec<(&'static str, $crate::parameters::Shown)> {
                vec![$((stringify!($field), $crate::parameters::Field::show(&self.$field))),+]
            }
        }
    };
}

pub(crate) use {named_choice, parameter_table};

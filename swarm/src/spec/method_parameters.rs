//! Parameters that one method alone has, as plain data: a table and a value for each of its rows.

use crate::parameters::{Domain, Parameter, ParameterError, Shown, Value};

/// A method's own parameters; none for most methods.
#[derive(Clone, Debug, Default)]
pub struct MethodParameters {
    table: &'static [Parameter],
    values: Vec<(&'static str, Shown)>,
}

impl MethodParameters {
    /// A table with its defaults, in table order.
    pub fn new(table: &'static [Parameter], defaults: Vec<(&'static str, Shown)>) -> Self {
        Self {
            table,
            values: defaults,
        }
    }

    /// What there is to set.
    pub fn table(&self) -> &'static [Parameter] {
        self.table
    }

    /// Whether the method has none.
    pub fn is_empty(&self) -> bool {
        self.table.is_empty()
    }

    /// Every parameter with its current value, in table order.
    pub fn shown(&self) -> &[(&'static str, Shown)] {
        &self.values
    }

    /// Sets one parameter by its name in a spec.
    ///
    /// # Errors
    /// `Unknown` when there is none of this name, `Domain` when the value is not allowed.
    pub fn set(&mut self, name: &str, value: Value<'_>) -> Result<(), ParameterError> {
        let mut known = self.table.iter().zip(&mut self.values);
        let (parameter, (_, shown)) = known
            .find(|(parameter, _)| parameter.name == name)
            .ok_or(ParameterError::Unknown)?;
        *shown = read(&parameter.domain, value)
            .ok_or_else(|| ParameterError::Domain(parameter.domain.allowed()))?;
        Ok(())
    }

    /// Hands every parameter to a typed table's `set`, which has the same names and domains.
    pub fn hand_to(&self, mut set: impl FnMut(&str, Value<'_>) -> Result<(), ParameterError>) {
        for (name, shown) in &self.values {
            let value = match *shown {
                // Whole numbers of a table are of 32 bits.
                Shown::Whole(number) => Value::Number(number as f64),
                Shown::Real(number) => Value::Number(number),
                Shown::Name(text) => Value::Text(text),
            };
            let set = set(name, value);
            debug_assert!(set.is_ok(), "{name}: {set:?}");
        }
    }
}

/// A value as its domain has it; `None` where it is outside.
fn read(domain: &Domain, value: Value<'_>) -> Option<Shown> {
    if !domain.admits(value) {
        return None;
    }
    match (domain, value) {
        (Domain::Real { .. }, Value::Number(number)) => Some(Shown::Real(number)),
        (Domain::Whole { .. }, Value::Number(number)) => Some(Shown::Whole(number as u64)),
        (Domain::Choice { names }, Value::Text(text)) => {
            let name = names.iter().find(|name| **name == text);
            name.copied().map(Shown::Name)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;
    use crate::parameters::Domain::{Choice, Real, Whole};
    use crate::parameters::parameter_table;
    use crate::spec::Ties;

    parameter_table! {
        /// One of each kind.
        Own {
            length_m: f64 = 0.5, Real { min: 0.0, max: 1.0 }, "m", "A length", "none";
            count: u32 = 3, Whole { min: 1, max: 9 }, "1", "A count", "none";
            ties: Ties = Ties::First, Choice { names: Ties::NAMES }, "", "A choice", "none";
        }
    }

    #[test]
    fn values_are_checked_shown_and_handed_on() {
        let mut own = MethodParameters::new(Own::TABLE, Own::default().shown());
        own.set("length_m", Value::Number(0.25)).unwrap();
        own.set("count", Value::Number(7.0)).unwrap();
        own.set("ties", Value::Text("keep")).unwrap();
        for (name, value) in [
            ("length_m", Value::Number(1.5)),
            ("length_m", Value::Text("0.5")),
            ("count", Value::Number(2.5)),
            ("ties", Value::Text("none")),
        ] {
            let refused = own.set(name, value);
            assert!(matches!(refused, Err(ParameterError::Domain(_))), "{name}");
        }
        let unknown = own.set("lenght_m", Value::Number(0.5));
        assert_eq!(unknown, Err(ParameterError::Unknown));
        let mut typed = Own::default();
        own.hand_to(|name, value| typed.set(name, value));
        assert_eq!(
            (typed.length_m, typed.count, typed.ties),
            (0.25, 7, Ties::Keep)
        );
        assert_eq!(own.shown(), typed.shown());
        assert!(MethodParameters::default().is_empty());
    }
}

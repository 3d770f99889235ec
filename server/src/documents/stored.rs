//! Specs as they are stored: with every parameter that there was then, and no later one.

use api::FieldError;
use serde_json::{Value, json};

use super::{ArenaSource, ResolvedRun, parse, resolve};

/// Parameters of the learner that came after the first stored specs, each as it was before it came.
fn before_they_came() -> [(&'static str, Value); 3] {
    [
        ("cluster_scale", json!("as-sensed")),
        ("epsilon_is", json!("radius")),
        ("command_levels", json!(0)),
    ]
}

/// The run of a stored spec, whatever the defaults have become.
///
/// # Errors
/// A spec that is damaged, or not valid any more.
pub fn resolve_stored(
    text: &str,
    arenas: &dyn ArenaSource,
) -> Result<ResolvedRun, Vec<FieldError>> {
    let mut spec = parse(text)?;
    if let Some(Value::Object(controller)) = spec.get_mut("controller") {
        for (name, value) in before_they_came() {
            controller.entry(name).or_insert(value);
        }
    }
    resolve(&spec, arenas)
}

/// A stored spec with what it lacks, so that it means the same when it is posted again; one that
/// is not valid any more as it is.
pub fn complete(text: String, arenas: &dyn ArenaSource) -> String {
    let has = |name: &str| text.contains(&format!("\"{name}\":"));
    if before_they_came().iter().all(|(name, _)| has(name)) {
        return text;
    }
    match resolve_stored(&text, arenas) {
        Ok(run) => run.canonical_json(),
        Err(_) => text,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;
    use crate::documents::BuiltinArenas;
    use crate::documents::testing::resolved;

    #[test]
    fn a_parameter_that_was_not_there_is_not_at_a_default_of_today() {
        let run = resolved(json!({ "controller": { "method": "im" } }));
        let mut spec: Value = serde_json::from_str(&run.canonical_json()).unwrap();
        let same = resolve_stored(&spec.to_string(), &BuiltinArenas).unwrap();
        assert_eq!(same.key(), run.key());
        let controller = spec["controller"].as_object_mut().unwrap();
        for (name, _) in before_they_came() {
            controller.remove(name).unwrap();
        }
        let older = resolve_stored(&spec.to_string(), &BuiltinArenas).unwrap();
        let shown = complete(spec.to_string(), &BuiltinArenas);
        let posted_again = resolve(&parse(&shown).unwrap(), &BuiltinArenas).unwrap();
        assert_eq!(posted_again.key(), older.key());
        assert_eq!(complete(shown.clone(), &BuiltinArenas), shown);
        assert_eq!(complete("{".into(), &BuiltinArenas), "{");
        let parameters = &older.run_spec().controller.parameters;
        assert_eq!(parameters.cluster_scale.name(), "as-sensed");
        assert_eq!(parameters.command_levels, 0);
    }
}

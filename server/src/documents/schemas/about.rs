//! What fields are for, from the documentation of the types that documents are.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::{Map, Value, json};

/// The schema of an object whose fields these are, each with what the type `T` says of it. A field
/// that `T` does not have says for itself.
pub fn object<T: JsonSchema>(fields: impl IntoIterator<Item = (&'static str, Value)>) -> Value {
    let settings = SchemaSettings::draft2020_12().with(|settings| {
        settings.inline_subschemas = true;
    });
    let told = settings.into_generator().into_root_schema_for::<T>();
    let about = |place: &str| {
        let text = told.pointer(place)?.as_str()?;
        Some(Value::from(plain(text)))
    };
    let properties: Map<String, Value> = fields
        .into_iter()
        .map(|(name, mut schema)| {
            if let Some(text) = about(&format!("/properties/{name}/description")) {
                schema["description"] = text;
            }
            (name.to_owned(), schema)
        })
        .collect();
    let mut object = json!({
        "type": "object", "properties": properties, "additionalProperties": false,
    });
    if let Some(text) = about("/description") {
        object["description"] = text;
    }
    object
}

/// Documentation as it reads outside of Rust.
pub fn plain(text: &str) -> String {
    let paragraphs: Vec<String> = text
        .split("\n\n")
        .map(|paragraph| paragraph.replace('\n', " "))
        .collect();
    let text = paragraphs.join("\n\n");
    text.replace("[`", "`").replace("`]", "`")
}

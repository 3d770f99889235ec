//! `/docs`: the OpenAPI document for people, as one page without a script, readable offline.

use serde_json::{Map, Value};

const STYLE: &str = "
body { font: 15px/1.5 system-ui, sans-serif; margin: 0 auto; max-width: 60rem; padding: 1rem; }
code { font: 13px ui-monospace, monospace; }
h2 { margin-top: 2.5rem; }
summary { cursor: pointer; padding: 0.2rem 0; }
summary b { display: inline-block; font: bold 12px ui-monospace, monospace; width: 4rem; }
details > :not(summary) { margin-left: 1.2rem; }
table { border-collapse: collapse; margin: 0.5rem 0 1rem 1.2rem; }
td, th { border-top: 1px solid #8884; padding: 0.2rem 0.8rem 0.2rem 0; text-align: left;
  vertical-align: top; }
@media (prefers-color-scheme: dark) {
  body { background: #181818; color: #ddd; }
  a { color: #8bf; }
}
";

/// The page.
pub fn html(document: &Value) -> String {
    let info = &document["info"];
    let mut page = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width\">\
         <title>{title}: the HTTP interface</title><style>{STYLE}</style></head><body>\n\
         <h1>{title} {version}: the HTTP interface</h1>\n<p>{about}</p>\n\
         <p>For programs: <a href=\"/openapi.json\">openapi.json</a> (OpenAPI 3.1). For editors, \
         as <code>$schema</code> of a document: <a href=\"/schemas/run.json\">run</a>, \
         <a href=\"/schemas/job.json\">job</a>, <a href=\"/schemas/arena.json\">arena</a>.</p>\n",
        title = text(&info["title"]),
        version = text(&info["version"]),
        about = text(&info["description"]),
    );
    for tag in list(&document["tags"]) {
        let name = &tag["name"];
        page += &format!(
            "<h2 id=\"{0}\">{0}</h2>\n<p>{1}</p>\n",
            text(name),
            text(&tag["description"])
        );
        for (path, methods) in fields(&document["paths"]) {
            for (method, operation) in fields(methods) {
                if operation["tags"][0] == *name {
                    page += &told(document, path, method, operation);
                }
            }
        }
    }
    page += "<h2 id=\"schemas\">schemas</h2>\n";
    for (name, schema) in fields(&document["components"]["schemas"]) {
        page += &format!(
            "<details id=\"schema-{0}\"><summary><code>{0}</code></summary>{1}</details>\n",
            escaped(name),
            shape(schema)
        );
    }
    page + "</body></html>\n"
}

fn told(document: &Value, path: &str, method: &str, operation: &Value) -> String {
    let mut page = format!(
        "<details id=\"{}\"><summary><b>{}</b> <code>{}</code> {}</summary>\n",
        text(&operation["operationId"]),
        method.to_uppercase(),
        escaped(path),
        text(&operation["summary"])
    );
    if let Some(description) = operation.get("description") {
        page += &format!("<p>{}</p>\n", text(description));
    }
    let rows: String = list(&operation["parameters"])
        .map(|parameter| {
            row([
                format!("<code>{}</code>", text(&parameter["name"])),
                text(&parameter["in"]),
                kind(&parameter["schema"]),
                text(&parameter["description"]),
            ])
        })
        .collect();
    page += &table(["Parameter", "In", "Value", "What it does"], &rows);
    for (_, content) in fields(&operation["requestBody"]["content"]) {
        page += &format!("<p>Takes JSON: {}</p>\n", kind(&content["schema"]));
    }
    let rows: String = fields(&operation["responses"])
        .map(|(status, response)| {
            let response = resolved(document, response);
            let kinds: Vec<String> = fields(&response["content"])
                .map(|(media_type, content)| match content.get("schema") {
                    Some(schema) => format!("<code>{media_type}</code> {}", kind(schema)),
                    None => format!("<code>{media_type}</code>"),
                })
                .collect();
            row([
                escaped(status),
                text(&response["description"]),
                kinds.join("<br>"),
            ])
        })
        .collect();
    page + &table(["Status", "What it says", "Content"], &rows) + "</details>\n"
}

/// What a schema says of the fields of an object, or what else it is.
fn shape(schema: &Value) -> String {
    let mut page = match schema.get("description") {
        Some(description) => format!("<p>{}</p>", text(description)),
        None => String::new(),
    };
    let required: Vec<&Value> = list(&schema["required"]).collect();
    let rows: String = fields(&schema["properties"])
        .map(|(name, field)| {
            let is_required = required.iter().any(|required| *required == name);
            row([
                format!("<code>{}</code>", escaped(name)),
                kind(field),
                if is_required { "always" } else { "" }.to_owned(),
                text(&field["description"]),
            ])
        })
        .collect();
    if rows.is_empty() {
        page += &format!("<p>{}</p>", kind(schema));
    } else {
        page += &table(["Field", "Value", "There", "What it is"], &rows);
    }
    let forms = ["oneOf", "anyOf"].iter().flat_map(|of| list(&schema[*of]));
    for form in forms.filter(|form| form.get("properties").is_some()) {
        page += &shape(form);
    }
    page
}

/// A value in a few words, with links to what it refers to.
fn kind(schema: &Value) -> String {
    if let Some(reference) = schema["$ref"].as_str() {
        let name = escaped(reference.rsplit('/').next().unwrap_or_default());
        return format!("<a href=\"#schema-{name}\">{name}</a>");
    }
    let mut words = match () {
        () if schema.get("const").is_some() => code(&schema["const"]),
        () if schema.get("enum").is_some() => {
            let names: Vec<String> = list(&schema["enum"]).map(code).collect();
            names.join(", ")
        }
        () if schema["items"].is_object() => format!("list of {}", kind(&schema["items"])),
        () => match &schema["type"] {
            Value::String(name) => escaped(name),
            Value::Array(names) => {
                let names: Vec<String> = names.iter().map(text).collect();
                names.join(" or ")
            }
            _ => {
                let forms = ["anyOf", "oneOf", "allOf"].iter();
                let forms: Vec<String> = forms
                    .flat_map(|of| list(&schema[*of]))
                    .map(kind)
                    .filter(|words| !words.is_empty())
                    .collect();
                forms.join(" or ")
            }
        },
    };
    if words == "object" && schema["additionalProperties"].is_object() {
        words += &format!(" of {}", kind(&schema["additionalProperties"]));
    }
    for (name, before) in [
        ("minimum", " from "),
        ("exclusiveMinimum", " above "),
        ("maximum", " to "),
        ("default", "; else "),
    ] {
        if let Some(value) = schema.get(name) {
            words += &format!("{before}{}", code(value));
        }
    }
    words
}

fn resolved<'a>(document: &'a Value, response: &'a Value) -> &'a Value {
    let reference = response["$ref"]
        .as_str()
        .and_then(|place| place.strip_prefix('#'));
    reference
        .and_then(|place| document.pointer(place))
        .unwrap_or(response)
}

fn fields(value: &Value) -> impl Iterator<Item = (&String, &Value)> {
    value.as_object().into_iter().flat_map(Map::iter)
}

fn list(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten()
}

fn table<const N: usize>(heads: [&str; N], rows: &str) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let heads: String = heads
        .iter()
        .map(|head| format!("<th>{head}</th>"))
        .collect();
    format!("<table><tr>{heads}</tr>\n{rows}</table>\n")
}

fn row<const N: usize>(cells: [String; N]) -> String {
    let cells: String = cells
        .iter()
        .map(|cell| format!("<td>{cell}</td>"))
        .collect();
    format!("<tr>{cells}</tr>\n")
}

fn code(value: &Value) -> String {
    let shown = match value {
        Value::String(text) => text.clone(),
        value => value.to_string(),
    };
    format!("<code>{}</code>", escaped(&shown))
}

/// A text, with code where it has that.
fn text(value: &Value) -> String {
    let escaped = escaped(value.as_str().unwrap_or_default());
    let parts = escaped.split('`').enumerate();
    let shown: String = parts
        .map(|(number, part)| match number % 2 {
            0 => part.to_owned(),
            _ => format!("<code>{part}</code>"),
        })
        .collect();
    shown.replace("\n\n", "<br>")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn what_a_document_says_is_shown_and_nothing_in_it_is_markup() {
        let page = html(&json!({
            "info": { "title": "a<b", "version": "1", "description": "Says `x < y`." },
            "tags": [{ "name": "jobs", "description": "Jobs." }],
            "paths": { "/v1/jobs": { "post": {
                "tags": ["jobs"], "operationId": "createJob", "summary": "Post \"it\"",
                "parameters": [{ "name": "limit", "in": "query", "description": "Most <i>.",
                    "schema": { "type": "integer", "minimum": 1, "maximum": 9, "default": 5 } }],
                "requestBody": { "content": { "application/json": { "schema": {
                    "$ref": "#/components/schemas/JobSpec" } } } },
                "responses": { "201": { "$ref": "#/components/responses/Made" } },
            } } },
            "components": {
                "responses": { "Made": { "description": "It is made." } },
                "schemas": { "JobSpec": {
                    "type": "object", "required": ["name"],
                    "properties": { "name": { "type": ["string", "null"], "description": "Any." } },
                } },
            },
        }));
        for shown in [
            "<title>a&lt;b: the HTTP interface</title>",
            "Says <code>x &lt; y</code>.",
            "<details id=\"createJob\"><summary><b>POST</b> <code>/v1/jobs</code> Post &quot;it&quot;",
            "<td>integer from <code>1</code> to <code>9</code>; else <code>5</code></td><td>Most &lt;i&gt;.",
            "Takes JSON: <a href=\"#schema-JobSpec\">JobSpec</a>",
            "<td>201</td><td>It is made.</td>",
            "<td><code>name</code></td><td>string or null</td><td>always</td><td>Any.</td>",
        ] {
            assert!(page.contains(shown), "{shown} is not in {page}");
        }
        assert!(!page.contains("<script"));
    }
}

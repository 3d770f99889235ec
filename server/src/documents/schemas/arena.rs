//! Schemas of arenas: written out, generated, or made of another.

use arenas::{
    DEFAULT_OBJECT_FRICTION, DEFAULT_OBJECT_MASS_KG, DEFAULT_SQUARES, GeneratorKind,
    MAX_NAME_LENGTH, MAX_OBJECTS, MAX_STARTS, MAX_WALLS, OBJECT_FRICTION_RANGE,
    OBJECT_HEADING_RANGE_RAD, OBJECT_MASS_RANGE_KG, OBJECT_PLACE_RANGE_M, OBJECT_SIZE_RANGE_M,
    SCALE_RANGE, SIDE_RANGE_M, SQUARES_RANGE,
};
use serde_json::{Map, Value, json};

use super::common::{or_null, reference, schema_link};

/// `Arena`, `TiledArena`, `ArenaRef` and what they are made of.
pub fn definitions(prefix: &str) -> Map<String, Value> {
    [
        ("ArenaRef", arena_ref(prefix)),
        ("Arena", arena(prefix)),
        ("TiledArena", tiled(prefix)),
        ("Pose", pose()),
        ("Movable", movable()),
        ("Generate", generate()),
    ]
    .into_iter()
    .map(|(name, schema)| (name.to_owned(), schema))
    .collect()
}

fn arena_ref(prefix: &str) -> Value {
    json!({
        "description": "The name of an arena, built in or uploaded, or an arena in place.",
        "anyOf": [
            { "enum": arenas::builtin_names() },
            { "type": "string", "pattern": name_pattern() },
            { "type": "object", "required": ["from"], "$ref": format!("{prefix}TiledArena") },
            { "type": "object", "$ref": format!("{prefix}Arena") },
        ],
    })
}

/// Names of arenas.
fn name_pattern() -> String {
    format!("^[a-z0-9][a-z0-9._-]{{0,{}}}$", MAX_NAME_LENGTH - 1)
}

fn name() -> Value {
    or_null(json!({ "type": "string", "pattern": name_pattern() }))
}

fn number([least, most]: [f64; 2], about: &str) -> Value {
    json!({ "type": "number", "minimum": least, "maximum": most, "description": about })
}

fn squares(default: Value) -> Value {
    let [least, most] = SQUARES_RANGE;
    let side = json!({ "type": "integer", "minimum": least, "maximum": most });
    json!({
        "description": "Squares that visits are counted in, along each side, or [columns, rows].",
        "default": default,
        "anyOf": [side, { "type": "array", "items": side, "minItems": 2, "maxItems": 2 }, { "type": "null" }],
    })
}

fn arena(prefix: &str) -> Value {
    let with = |schema: Value, about: &str| {
        let mut schema = schema;
        schema["description"] = json!(about);
        schema
    };
    json!({
        "type": "object",
        "description": "An arena. The origin is the lower left corner, y points up; outer walls are \
            implied. It has `walls_m` and `starts`, or says by `generate` how they are made.",
        "properties": {
            "$schema": schema_link(),
            "name": with(name(), "1 to 64 characters of a-z 0-9 . _ -, the first a letter or a digit."),
            "width_m": number(SIDE_RANGE_M, "Extent along x, metres."),
            "height_m": number(SIDE_RANGE_M, "Extent along y, metres."),
            "squares": squares(json!(DEFAULT_SQUARES)),
            "walls_m": with(
                or_null(json!({
                    "type": "array", "maxItems": MAX_WALLS,
                    "items": {
                        "type": "array", "items": { "type": "number" }, "minItems": 4, "maxItems": 4,
                    },
                })),
                "Inner walls without thickness: x1, y1, x2, y2 in metres.",
            ),
            "generate": with(or_null(reference(prefix, "Generate")), "How to make the walls, in place of walls_m."),
            "starts": with(
                or_null(json!({
                    "type": "array", "minItems": 1, "maxItems": MAX_STARTS,
                    "items": reference(prefix, "Pose"),
                })),
                "Start poses, the first for the first robot.",
            ),
            "objects": {
                "type": "array", "maxItems": MAX_OBJECTS, "items": reference(prefix, "Movable"),
                "description": "Boxes and discs that robots can push; engine rapier alone.",
            },
        },
        "required": ["width_m", "height_m"],
        "anyOf": [{ "required": ["name", "walls_m", "starts"] }, { "required": ["generate"] }],
        "additionalProperties": false,
    })
}

fn tiled(prefix: &str) -> Value {
    let tiles = json!({ "type": "integer", "minimum": 1, "maximum": u32::MAX });
    json!({
        "type": "object",
        "description": "An arena made of copies of another, side by side.",
        "properties": {
            "$schema": schema_link(),
            "from": reference(prefix, "ArenaRef"),
            "tile": {
                "description": "[columns, rows]", "default": [1, 1],
                "anyOf": [
                    { "type": "array", "items": tiles, "minItems": 2, "maxItems": 2 },
                    { "type": "null" },
                ],
            },
            "scale": {
                "description": "Factor on all lengths of a tile.", "default": 1,
                "anyOf": [
                    { "type": "number", "minimum": SCALE_RANGE[0], "maximum": SCALE_RANGE[1] },
                    { "type": "null" },
                ],
            },
            "doorway_m": {
                "description": "Width of the opening in the middle of each side that tiles share, \
                    metres; without it they have no wall between them.",
                "anyOf": [{ "type": "number", "exclusiveMinimum": 0 }, { "type": "null" }],
            },
            "squares": squares(Value::Null),
            "name": name(),
        },
        "required": ["from"],
        "additionalProperties": false,
    })
}

fn pose() -> Value {
    json!({
        "type": "object",
        "description": "Where a robot starts.",
        "properties": {
            "x_m": { "type": "number", "minimum": 0, "description": "Metres from the left wall." },
            "y_m": { "type": "number", "minimum": 0, "description": "Metres from the bottom wall." },
            "heading_rad": { "type": "number", "description": "Counter-clockwise from the x axis." },
        },
        "required": ["x_m", "y_m", "heading_rad"],
        "additionalProperties": false,
    })
}

fn movable() -> Value {
    let place = |axis: &str| {
        number(
            OBJECT_PLACE_RANGE_M,
            &format!("Centre along {axis}, metres."),
        )
    };
    let mut mass = number(OBJECT_MASS_RANGE_KG, "Kilograms.");
    mass["default"] = json!(DEFAULT_OBJECT_MASS_KG);
    let mut friction = number(
        OBJECT_FRICTION_RANGE,
        "Coefficient of friction with the floor.",
    );
    friction["default"] = json!(DEFAULT_OBJECT_FRICTION);
    let mut heading = number(
        OBJECT_HEADING_RANGE_RAD,
        "Counter-clockwise from the x axis.",
    );
    heading["default"] = json!(0.0);
    let radius = OBJECT_SIZE_RANGE_M.map(|size_m| 0.5 * size_m);
    json!({
        "description": "An object at its start pose.",
        "oneOf": [
            {
                "type": "object",
                "properties": {
                    "kind": { "const": "box" },
                    "x_m": place("x"), "y_m": place("y"), "heading_rad": heading,
                    "width_m": number(OBJECT_SIZE_RANGE_M, "Along the heading, metres."),
                    "height_m": number(OBJECT_SIZE_RANGE_M, "Across the heading, metres."),
                    "mass_kg": mass, "friction": friction,
                },
                "required": ["kind", "x_m", "y_m", "width_m", "height_m"],
                "additionalProperties": false,
            },
            {
                "type": "object",
                "properties": {
                    "kind": { "const": "disc" },
                    "x_m": place("x"), "y_m": place("y"),
                    "radius_m": number(radius, "Metres."),
                    "mass_kg": mass, "friction": friction,
                },
                "required": ["kind", "x_m", "y_m", "radius_m"],
                "additionalProperties": false,
            },
        ],
    })
}

fn generate() -> Value {
    let kinds: Vec<Value> = GeneratorKind::ALL.iter().copied().map(generator).collect();
    json!({
        "description": "Walls from a seed: the same on every machine.",
        "oneOf": kinds,
    })
}

fn generator(kind: GeneratorKind) -> Value {
    let mut properties = Map::new();
    properties.insert("kind".into(), json!({ "const": kind.as_str() }));
    let seed = json!({
        "type": "integer", "minimum": 0, "maximum": u64::MAX, "default": 1,
        "description": "Every seed makes another arena.",
    });
    properties.insert("seed".into(), seed);
    for parameter in kind.parameters() {
        let told = json!({
            "description": parameter.doc, "default": parameter.default,
            "anyOf": [
                { "type": "number", "minimum": parameter.min, "maximum": parameter.max },
                { "type": "null" },
            ],
        });
        properties.insert(parameter.name.to_owned(), told);
    }
    if kind == GeneratorKind::RandomObstacles {
        let shape = json!({
            "enum": ["wall", "box", null], "default": "wall", "description": "Outline of an obstacle.",
        });
        properties.insert("shape".into(), shape);
    }
    json!({
        "type": "object", "properties": properties, "required": ["kind"],
        "additionalProperties": false,
    })
}

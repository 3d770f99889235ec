//! `/v1/arenas`: list, upload, show, draw, delete.

use api::ProblemCode::{ArenaBuiltIn, ArenaInUse, ArenaNameTaken, ArenaNotFound, ArenasFull};
use api::{ArenaList, ArenaListing};
use arenas::{Arena, SvgOptions, render_svg};
use axum::Json;
use axum::body::Bytes;
use axum::extract::{Path, State};
use axum::http::header::{CONTENT_TYPE, LOCATION};
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};

use super::App;
use super::operation::{JSON, Operation, Shape};
use super::refusal::Refusal;
use super::request::said_to_be_json;
use super::routes::Routes;
use crate::documents::{ArenaSource, BuiltinArenas, read_arena};
use crate::scheduler::StoredArenas;
use crate::store::{ArenaDeletion, StoredArena};

/// The one name that is a route of its own.
const GENERATE: &str = "generate";
/// Most arenas that are kept.
const MAX_UPLOADED: u32 = 1_000;

pub fn routes() -> Routes {
    let arena = Some(Shape::Document("Arena"));
    Routes::new()
        .get(
            "/arenas",
            list,
            Operation::new(
                "listArenas",
                "Arenas: built-in ones, then uploaded ones by name",
            )
            .shows::<ArenaList>("All of them."),
        )
        .post(
            "/arenas",
            create,
            Operation::new("createArena", "Upload an arena")
                .details("Generated walls are written out. The very same arena again is no error.")
                .takes(Shape::Document("Arena"))
                .creates::<ArenaListing>(201, "The arena is stored.")
                .creates::<ArenaListing>(200, "The very same arena was stored already.")
                .refuses(&[ArenaNameTaken, ArenasFull]),
        )
        .post(
            "/arenas/generate",
            generate,
            Operation::new(
                "generateArena",
                "An arena with its walls written out, not stored",
            )
            .details("Of `generate` and a seed: to look at, to change, to upload.")
            .takes(Shape::Document("Arena"))
            .answers(200, "The arena.", JSON, arena),
        )
        .get(
            "/arenas/{name}",
            show,
            Operation::new("getArena", "An arena as it would be written")
                .answers(200, "The arena.", JSON, arena)
                .refuses(&[ArenaNotFound]),
        )
        .also_read_as(
            "/arenas/{name}.svg",
            Operation::new("getArenaSvg", "An arena drawn")
                .details("Unless an arena has this very name, `.svg` included.")
                .answers(200, "The drawing.", "image/svg+xml", None)
                .refuses(&[ArenaNotFound]),
        )
        .delete(
            "/arenas/{name}",
            delete,
            Operation::new(
                "deleteArena",
                "Delete an uploaded arena that no stored run uses",
            )
            .answers_nothing("It is deleted.")
            .refuses(&[ArenaNotFound, ArenaInUse, ArenaBuiltIn]),
        )
}

/// `GET /v1/arenas`: those that ship with the program, then uploaded ones by name.
async fn list(State(app): State<App>) -> Result<Json<ArenaList>, Refusal> {
    app.blocking(|app| {
        let mut items: Vec<ArenaListing> = BuiltinArenas
            .names()
            .iter()
            .filter_map(|name| BuiltinArenas.arena(name))
            .map(|arena| listing(&arena, true, reachable(app, &arena)))
            .collect();
        items.extend(app.store.arenas()?);
        Ok(Json(ArenaList { items }))
    })
    .await
}

/// `POST /v1/arenas`: generated walls are written out. The very same arena again is no error.
async fn create(
    State(app): State<App>,
    headers: HeaderMap,
    body: Bytes,
) -> Result<Response, Refusal> {
    said_to_be_json(&headers)?;
    app.blocking(move |app| {
        let document = app.read(&body)?;
        let arena = read_arena(&document).map_err(Refusal::fields)?;
        let name = arena.name().to_owned();
        if name == GENERATE {
            let detail = format!("{name} is the name of a route");
            return Err(Refusal::new(ArenaNameTaken, detail));
        }
        if BuiltinArenas.arena(&name).is_some() {
            let detail = format!("{name} is the name of a built-in arena");
            return Err(Refusal::new(ArenaNameTaken, detail));
        }
        let listing = listing(&arena, false, reachable(app, &arena));
        let body = text(&arena)?;
        let stored = StoredArena {
            name,
            body,
            listing,
        };
        let is_new = app.store.save_arena(&stored, MAX_UPLOADED)?;
        let status = if is_new {
            StatusCode::CREATED
        } else {
            StatusCode::OK
        };
        let location = [(LOCATION, format!("/v1/arenas/{}", stored.name))];
        Ok((status, location, Json(stored.listing)).into_response())
    })
    .await
}

/// `POST /v1/arenas/generate`: what would be stored, for whoever wants to see it first.
async fn generate(
    State(app): State<App>,
    headers: HeaderMap,
    body: Bytes,
) -> Result<Response, Refusal> {
    said_to_be_json(&headers)?;
    app.blocking(move |app| {
        let document = app.read(&body)?;
        let arena = read_arena(&document).map_err(Refusal::fields)?;
        Ok(([(CONTENT_TYPE, JSON)], text(&arena)?).into_response())
    })
    .await
}

/// `GET /v1/arenas/{name}` as JSON, `GET /v1/arenas/{name}.svg` as a drawing.
async fn show(State(app): State<App>, Path(name): Path<String>) -> Result<Response, Refusal> {
    app.blocking(move |app| {
        let arenas = StoredArenas::new(&app.store);
        // Names may hold dots, so an arena called `x.svg` comes before the drawing of `x`.
        if let Some(arena) = arenas.arena(&name) {
            return Ok(([(CONTENT_TYPE, JSON)], text(&arena)?).into_response());
        }
        match name
            .strip_suffix(".svg")
            .and_then(|name| arenas.arena(name))
        {
            Some(arena) => {
                let svg = render_svg(&arena, &SvgOptions::default());
                Ok(([(CONTENT_TYPE, "image/svg+xml")], svg).into_response())
            }
            None => Err(Refusal::not_found(ArenaNotFound, "arena", &name)),
        }
    })
    .await
}

/// `DELETE /v1/arenas/{name}`: of an uploaded arena that no stored run uses.
async fn delete(State(app): State<App>, Path(name): Path<String>) -> Result<StatusCode, Refusal> {
    app.blocking(move |app| {
        if BuiltinArenas.arena(&name).is_some() {
            let detail = "a built-in arena cannot be deleted";
            return Err(Refusal::new(ArenaBuiltIn, detail));
        }
        match app.store.delete_arena(&name)? {
            ArenaDeletion::Deleted => Ok(StatusCode::NO_CONTENT),
            ArenaDeletion::Unknown => Err(Refusal::not_found(ArenaNotFound, "arena", &name)),
            ArenaDeletion::Lent => Err(Refusal::new(
                ArenaInUse,
                "a job with this arena is being made; try again",
            )),
            ArenaDeletion::InUse { runs } => Err(Refusal::new(
                ArenaInUse,
                format!("{runs} stored runs use this arena; delete their jobs first"),
            )),
        }
    })
    .await
}

/// Squares that the default robot can reach from the arena's first start.
fn reachable(app: &App, arena: &Arena) -> u32 {
    let mask = app
        .findings
        .mask(arena, SvgOptions::default().body_radius_m);
    let reachable = mask.map_or(0, |mask| mask.iter().filter(|&&reached| reached).count());
    // An arena has at most 1,000 x 1,000 squares.
    reachable as u32
}

/// An arena in a list.
pub(super) fn listing(arena: &Arena, builtin: bool, reachable: u32) -> ArenaListing {
    ArenaListing {
        name: arena.name().to_owned(),
        builtin,
        width_m: arena.width_m(),
        height_m: arena.height_m(),
        walls: arena.walls().len() as u64,
        starts: arena.starts().len() as u64,
        squares: arena.squares().into(),
        reachable,
    }
}

/// The arena as it would be written.
pub(super) fn text(arena: &Arena) -> Result<String, Refusal> {
    serde_json::to_string(&arena.to_format()).map_err(|error| Refusal::internal(&error))
}

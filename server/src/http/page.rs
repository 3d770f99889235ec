//! `/`: the page for people, made of files inside the binary; it needs nothing from elsewhere.

use axum::http::header::{CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE};
use std::borrow::Cow;

use super::files;
use super::operation::Operation;
use super::routes::Routes;

const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; \
    img-src 'self' blob: data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const JS: &str = "text/javascript; charset=utf-8";

/// A file of the page.
struct Asset {
    path: &'static str,
    id: &'static str,
    media_type: &'static str,
    text: fn() -> Cow<'static, str>,
}

/// Every file of the page.
const ASSETS: &[Asset] = &[
    Asset {
        path: "/",
        id: "getPage",
        media_type: HTML,
        text: || include_str!("../../dashboard/dist/index.html").into(),
    },
    Asset {
        path: "/dashboard.css",
        id: "getPageStyle",
        media_type: CSS,
        text: || include_str!("../../dashboard/dist/dashboard.css").into(),
    },
    Asset {
        path: "/dashboard.js",
        id: "getPageScript",
        media_type: JS,
        text: || include_str!("../../dashboard/dist/dashboard.js").into(),
    },
    Asset {
        path: "/files.js",
        id: "getPageFiles",
        media_type: JS,
        text: || files::script().into(),
    },
];

pub fn routes() -> Routes {
    ASSETS.iter().fold(Routes::new(), |routes, asset| {
        let headers = [
            (CONTENT_TYPE, asset.media_type),
            (CACHE_CONTROL, "no-cache"),
            (CONTENT_SECURITY_POLICY, POLICY),
        ];
        let told = Operation::new(asset.id, "The page for people, or a file of it");
        let told = told
            .answers(200, "The file.", asset.media_type, None)
            .open();
        let show = async move || (headers, (asset.text)());
        routes.get(asset.path, show, told)
    })
}

/// Whether this is the path of a file of the page, which tells nothing of jobs.
pub fn is_asset(path: &str) -> bool {
    ASSETS.iter().any(|asset| asset.path == path)
}

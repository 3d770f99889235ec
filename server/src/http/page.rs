//! `/`: the page for people, made of files inside the binary; it needs nothing from elsewhere.

use axum::http::HeaderName;
use axum::http::header::{CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE};
use axum::response::IntoResponse;

const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; \
    img-src 'self' blob: data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

fn headers(media_type: &'static str) -> [(HeaderName, &'static str); 3] {
    [
        (CONTENT_TYPE, media_type),
        (CACHE_CONTROL, "no-cache"),
        (CONTENT_SECURITY_POLICY, POLICY),
    ]
}

/// `GET /`.
pub async fn html() -> impl IntoResponse {
    (
        headers("text/html; charset=utf-8"),
        include_str!("../../assets/page.html"),
    )
}

/// `GET /page.css`.
pub async fn css() -> impl IntoResponse {
    (
        headers("text/css; charset=utf-8"),
        include_str!("../../assets/page.css"),
    )
}

/// `GET /page.js`.
pub async fn js() -> impl IntoResponse {
    (
        headers("text/javascript; charset=utf-8"),
        include_str!("../../assets/page.js"),
    )
}

/// `GET /chart.js`.
pub async fn chart() -> impl IntoResponse {
    (
        headers("text/javascript; charset=utf-8"),
        include_str!("../../assets/chart.js"),
    )
}

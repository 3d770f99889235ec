//! The HTTP service: routes over store and scheduler. Handlers only translate; whatever may block
//! or compute runs on threads made for that.

mod access;
mod answers;
mod app;
mod arenas;
mod asked_recordings;
mod body;
mod catalog;
mod channels;
mod checkpoints;
mod checks;
mod comparison;
mod compression;
mod conditional;
mod connections;
mod contract;
mod control;
mod docs;
mod events;
mod explain;
mod exports;
mod extract;
mod files;
mod guard;
mod health;
mod job_findings;
mod jobs;
mod learning;
mod listen;
mod metrics;
mod openapi;
mod operation;
mod page;
mod partial;
mod parts;
mod problems;
mod query;
mod recordings;
mod refusal;
mod request;
mod request_id;
mod router;
mod routes;
mod runs;
mod scrape;
mod serve;
mod table_lengths;
#[cfg(test)]
mod tests;
mod turns;
mod watching;
mod workers;

pub use access::{Right, line as token_line};
use app::App;
pub use serve::{ServeOptions, serve};

//! Arenas by name: those that ship with the program, then uploaded ones.

use std::sync::Arc;

use arenas::Arena;

use crate::documents::{ArenaSource, BuiltinArenas};
use crate::store::Store;

/// Every arena that a run spec may name.
pub struct StoredArenas<'a> {
    store: &'a Store,
}

impl<'a> StoredArenas<'a> {
    /// The arenas of this store.
    pub fn new(store: &'a Store) -> Self {
        Self { store }
    }
}

impl ArenaSource for StoredArenas<'_> {
    fn arena(&self, name: &str) -> Option<Arc<Arena>> {
        if let Some(arena) = BuiltinArenas.arena(name) {
            return Some(arena);
        }
        let body = self
            .store
            .arena(name)
            .inspect_err(|error| tracing::error!(arena = name, %error, "the arena cannot be read"))
            .ok()??;
        match Arena::from_json(&body) {
            Ok(arena) => Some(Arc::new(arena)),
            Err(errors) => {
                tracing::error!(
                    arena = name,
                    ?errors,
                    "the stored arena is not valid any more"
                );
                None
            }
        }
    }

    fn names(&self) -> Vec<String> {
        let uploaded = self.store.arenas().unwrap_or_else(|error| {
            tracing::error!(%error, "the uploaded arenas cannot be listed");
            Vec::new()
        });
        let mut names = BuiltinArenas.names();
        names.extend(uploaded.into_iter().map(|arena| arena.name));
        names
    }
}

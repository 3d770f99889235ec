//! Arenas by name: those that ship with the program, then uploaded ones.

use std::cell::RefCell;
use std::sync::Arc;

use arenas::Arena;

use crate::documents::{ArenaSource, BuiltinArenas};
use crate::store::{LentArena, Store};

/// Every arena that a run spec may name.
pub struct StoredArenas<'a> {
    store: &'a Store,
    /// Those that were asked for, where they are to stay meanwhile.
    lent: Option<RefCell<Vec<LentArena<'a>>>>,
}

impl<'a> StoredArenas<'a> {
    /// The arenas of this store.
    pub fn new(store: &'a Store) -> Self {
        Self { store, lent: None }
    }

    /// The same for a job that is made of them: as long as this is there, none that was asked for is
    /// deleted.
    pub fn to_keep(store: &'a Store) -> Self {
        Self {
            store,
            lent: Some(RefCell::default()),
        }
    }
}

impl ArenaSource for StoredArenas<'_> {
    fn arena(&self, name: &str) -> Option<Arc<Arena>> {
        if let Some(arena) = BuiltinArenas.arena(name) {
            return Some(arena);
        }
        if let Some(lent) = &self.lent {
            lent.borrow_mut().push(self.store.lend_arena(name));
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;
    use crate::store::{ArenaDeletion, StoredArena};

    #[test]
    fn an_arena_stays_while_a_job_is_made_of_it() {
        let dir = tempfile::tempdir().unwrap();
        let store = Store::open(dir.path()).unwrap();
        let arena = StoredArena::example();
        let kept = StoredArenas::to_keep(&store);
        for deletion in [ArenaDeletion::Lent, ArenaDeletion::Deleted] {
            store.save_arena(&arena, 1).unwrap();
            let arenas = match deletion {
                ArenaDeletion::Lent => &kept,
                _ => &StoredArenas::new(&store),
            };
            assert!(arenas.arena("mine").is_some());
            if deletion == ArenaDeletion::Deleted {
                kept.lent.as_ref().unwrap().borrow_mut().clear();
            }
            assert_eq!(store.delete_arena("mine").unwrap(), deletion);
        }
    }
}

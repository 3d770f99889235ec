//! Uploaded arenas, by name.

use api::ArenaListing;
use rusqlite::{OptionalExtension, params};

use super::{Store, StoreError, from_sql};

/// An uploaded arena.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredArena {
    /// Name.
    pub name: String,
    /// The arena as JSON.
    pub body: String,
    /// Its figures, for lists.
    pub listing: ArenaListing,
}

#[cfg(test)]
impl StoredArena {
    /// An empty square of a metre, by the name `mine`.
    pub fn example() -> Self {
        let body = r#"{"name": "mine", "width_m": 1, "height_m": 1, "walls_m": [],
            "starts": [{"x_m": 0.5, "y_m": 0.5, "heading_rad": 0}]}"#;
        Self {
            name: "mine".to_owned(),
            body: body.to_owned(),
            listing: ArenaListing {
                name: "mine".to_owned(),
                builtin: false,
                width_m: 1.0,
                height_m: 1.0,
                walls: 0,
                starts: 1,
                squares: api::Squares::Side(100),
                reachable: 9_000,
            },
        }
    }
}

/// What became of an arena to be deleted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArenaDeletion {
    /// It is gone.
    Deleted,
    /// There is none of this name.
    Unknown,
    /// Stored runs use it.
    InUse {
        /// How many.
        runs: u64,
    },
    /// A job with it is being made.
    Lent,
}

/// An uploaded arena that cannot be deleted as long as this is there.
pub struct LentArena<'a> {
    store: &'a Store,
    name: String,
}

impl Drop for LentArena<'_> {
    fn drop(&mut self) {
        let mut lent = self.store.lent_arenas.lock();
        if let Some(times) = lent.get_mut(&self.name) {
            *times -= 1;
            if *times == 0 {
                lent.remove(&self.name);
            }
        }
    }
}

/// Why an arena was not stored.
#[derive(Debug, thiserror::Error)]
pub enum SaveArenaError {
    /// Another arena has this name.
    #[error("another arena has this name")]
    NameTaken,
    /// There are as many as are allowed.
    #[error("{0} arenas are stored already, as many as are allowed")]
    Full(u32),
    /// The store failed.
    #[error(transparent)]
    Store(#[from] StoreError),
}

impl From<rusqlite::Error> for SaveArenaError {
    fn from(error: rusqlite::Error) -> Self {
        Self::Store(error.into())
    }
}

impl Store {
    /// Stores an arena. Returns whether it is new: storing the very same again changes nothing.
    ///
    /// # Errors
    /// `NameTaken`, `Full`, or `Store` when the database fails.
    pub fn save_arena(&self, arena: &StoredArena, limit: u32) -> Result<bool, SaveArenaError> {
        let listing = serde_json::to_string(&arena.listing)
            .map_err(|error| StoreError::unreadable("listing", error))?;
        let mut connection = self.connection();
        let transaction = connection.transaction()?;
        let earlier: Option<String> = transaction
            .prepare_cached("SELECT body FROM arenas WHERE name = ?1")?
            .query_row([&arena.name], |row| row.get(0))
            .optional()?;
        match earlier {
            Some(body) if body == arena.body => return Ok(false),
            Some(_) => return Err(SaveArenaError::NameTaken),
            None => {}
        }
        let stored: u32 =
            transaction.query_row("SELECT count(*) FROM arenas", [], |row| row.get(0))?;
        if stored >= limit {
            return Err(SaveArenaError::Full(limit));
        }
        transaction
            .prepare_cached("INSERT INTO arenas (name, listing, body) VALUES (?1, ?2, ?3)")?
            .execute(params![arena.name, listing, arena.body])?;
        transaction.commit()?;
        Ok(true)
    }

    /// An uploaded arena as JSON; `None` when there is none of this name.
    ///
    /// # Errors
    /// When the database fails.
    pub fn arena(&self, name: &str) -> Result<Option<String>, StoreError> {
        Ok(self
            .reader()
            .prepare_cached("SELECT body FROM arenas WHERE name = ?1")?
            .query_row([name], |row| row.get(0))
            .optional()?)
    }

    /// Bytes of an uploaded arena; 0 when there is none of this name.
    ///
    /// # Errors
    /// When the database fails.
    pub fn arena_bytes(&self, name: &str) -> Result<u64, StoreError> {
        let bytes = self
            .reader()
            .prepare_cached("SELECT octet_length(body) FROM arenas WHERE name = ?1")?
            .query_row([name], |row| row.get(0))
            .optional()?;
        Ok(bytes.map_or(0, from_sql))
    }

    /// The figures of every uploaded arena, by name.
    ///
    /// # Errors
    /// When the database fails or holds what cannot be read.
    pub fn arenas(&self) -> Result<Vec<ArenaListing>, StoreError> {
        self.reader()
            .prepare_cached("SELECT listing FROM arenas ORDER BY name")?
            .query_map([], |row| row.get(0))?
            .filter_map(|listing: rusqlite::Result<String>| {
                let listing = match listing {
                    Ok(listing) => serde_json::from_str(&listing),
                    Err(error) => return Some(Err(error.into())),
                };
                // One that cannot be read does not take the list with it.
                listing
                    .inspect_err(|error| tracing::error!(%error, "an arena cannot be listed"))
                    .ok()
                    .map(Ok)
            })
            .collect()
    }

    /// Keeps an uploaded arena, if there is one of this name, from being deleted while a job with it
    /// is being made: the job's runs would have none, or another one of that name.
    pub fn lend_arena(&self, name: &str) -> LentArena<'_> {
        *self.lent_arenas.lock().entry(name.to_owned()).or_default() += 1;
        LentArena {
            store: self,
            name: name.to_owned(),
        }
    }

    /// Deletes an uploaded arena that no stored run uses, nor a job that is being made.
    ///
    /// # Errors
    /// When the database fails.
    pub fn delete_arena(&self, name: &str) -> Result<ArenaDeletion, StoreError> {
        let mut connection = self.connection();
        let transaction = connection.transaction()?;
        let runs = from_sql(transaction.query_row(
            "SELECT count(*) FROM run_arenas WHERE arena = ?1",
            [name],
            |row| row.get(0),
        )?);
        if runs > 0 {
            return Ok(ArenaDeletion::InUse { runs });
        }
        // Nobody is lent it until it is gone.
        let lent = self.lent_arenas.lock();
        if lent.contains_key(name) {
            return Ok(ArenaDeletion::Lent);
        }
        let deleted = transaction.execute("DELETE FROM arenas WHERE name = ?1", [name])?;
        transaction.commit()?;
        drop(lent);
        Ok(if deleted > 0 {
            ArenaDeletion::Deleted
        } else {
            ArenaDeletion::Unknown
        })
    }
}

//! The built-in arenas, data files compiled in: the three of the experiments and, as `hard-maze`,
//! the one that `easy` is adapted from (Lehman and Stanley 2008), whose gates are barely passable.

use crate::arena::Arena;

const SOURCES: [(&str, &str); 4] = [
    ("easy", include_str!("../data/easy.json")),
    ("graph", include_str!("../data/graph.json")),
    ("maze", include_str!("../data/maze.json")),
    ("hard-maze", include_str!("../data/hard-maze.json")),
];

/// Names that [`builtin`] knows, easiest arena first.
pub fn builtin_names() -> &'static [&'static str] {
    const NAMES: [&str; SOURCES.len()] = [SOURCES[0].0, SOURCES[1].0, SOURCES[2].0, SOURCES[3].0];
    &NAMES
}

/// The built-in arena of this name, if there is one.
pub fn builtin(name: &str) -> Option<Arena> {
    let (_, json) = SOURCES.iter().find(|(known, _)| *known == name)?;
    // The text is compiled in and a test loads each: it cannot fail here.
    Some(Arena::from_json(json).unwrap_or_else(|errors| unreachable!("{name}: {errors:?}")))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    #[test]
    fn each_loads_under_its_name_with_clear_starts() {
        for (name, walls) in [("easy", 8), ("graph", 16), ("maze", 17), ("hard-maze", 7)] {
            let arena = builtin(name).unwrap();
            assert_eq!(arena.name(), name);
            assert_eq!(arena.walls().len(), walls);
            assert_eq!(arena.check_starts(0.037), []);
        }
        assert_eq!(builtin_names(), ["easy", "graph", "maze", "hard-maze"]);
        assert!(builtin("no-such-arena").is_none());
    }
}

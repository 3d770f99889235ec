//! Lists which file of a crate imports which, and fails on a circle; `make lint` runs it.
//!
//! An import is a `use`, a `pub use` or a path in code, also within macros; through a re-export it
//! is one of the file that defines the name. `mod child;` is none. Tests are left out.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Write};
use std::path::Path;
use std::{env, fs};

use proc_macro2::{TokenStream, TokenTree};
use syn::visit::{self, Visit};
use syn::{Attribute, ImplItemFn, Item, ItemUse, Macro, UseTree, Visibility};

/// Names are re-exported over fewer modules than this.
const MOST_HOPS: usize = 16;

/// A module: a file, or `mod name { }` within one.
#[derive(Default)]
struct Module {
    file: String,
    parent: usize,
    children: BTreeMap<String, usize>,
    /// Names that it defines.
    items: BTreeSet<String>,
    /// Names that it has from elsewhere, and modules of which it has all names.
    uses: BTreeMap<String, Vec<String>>,
    globs: Vec<Vec<String>>,
    /// Every path in its code.
    mentions: BTreeSet<Vec<String>>,
}

/// The modules of a crate; the first is its root.
struct Crate<'a> {
    sources: &'a BTreeMap<String, String>,
    modules: Vec<Module>,
}

fn for_tests(attributes: &[Attribute]) -> bool {
    let test = |attribute: &Attribute| {
        let list = attribute.meta.require_list();
        list.is_ok_and(|list| list.path.is_ident("cfg") && list.tokens.to_string() == "test")
    };
    attributes.iter().any(test)
}

impl Crate<'_> {
    /// Reads a module's file and all below it.
    fn read(&mut self, file: &str, parent: usize, path: Vec<String>) -> Result<usize, String> {
        let syntax = syn::parse_file(&self.sources[file]).map_err(|e| format!("{file}: {e}"))?;
        self.add(file, parent, path, &syntax.items)
    }

    fn add(
        &mut self,
        file: &str,
        parent: usize,
        path: Vec<String>,
        items: &[Item],
    ) -> Result<usize, String> {
        let number = self.modules.len();
        let mut module = Module {
            file: file.to_owned(),
            parent,
            ..Module::default()
        };
        items.iter().for_each(|item| module.visit_item(item));
        self.modules.push(module);
        for item in items {
            let Item::Mod(child) = item else { continue };
            let name = child.ident.to_string();
            if for_tests(&child.attrs) || name == "tests" || name.ends_with("_tests") {
                continue;
            }
            let path: Vec<String> = path.iter().cloned().chain([name.clone()]).collect();
            let place = path.join("/");
            let files = [format!("{place}.rs"), format!("{place}/mod.rs")];
            let child = match (
                &child.content,
                files.iter().find(|f| self.sources.contains_key(*f)),
            ) {
                (Some((_, items)), _) => self.add(file, number, path, items)?,
                (None, Some(below)) => self.read(below, number, path)?,
                (None, None) => return Err(format!("{file}: no file for mod {name}")),
            };
            self.modules[number].children.insert(name, child);
        }
        Ok(number)
    }

    /// How far a path of a module leads through modules, and what is left of it.
    fn walk<'p>(&self, mut at: usize, mut path: &'p [String]) -> (usize, &'p [String]) {
        while let Some((first, others)) = path.split_first() {
            at = match first.as_str() {
                "crate" => 0,
                "self" => at,
                "super" => self.modules[at].parent,
                name => match self.modules[at].children.get(name) {
                    Some(child) => *child,
                    None => break,
                },
            };
            path = others;
        }
        (at, path)
    }

    /// The file that a path of a module leads to; `None` when that is another crate's.
    fn resolve(&self, module: usize, path: &[String], hops: usize) -> Option<&str> {
        let (at, rest) = self.walk(module, path);
        let here = &self.modules[at];
        let Some(name) = rest.first() else {
            return Some(&here.file);
        };
        let found = hops
            .checked_sub(1)
            .and_then(|hops| self.name(at, name, rest, hops));
        found.or((rest.len() < path.len()).then_some(&here.file))
    }

    /// The file that defines a name of a module, with what of the path is left.
    fn name(&self, at: usize, name: &String, rest: &[String], hops: usize) -> Option<&str> {
        let here = &self.modules[at];
        if here.items.contains(name) {
            return Some(&here.file);
        }
        if let Some(target) = here.uses.get(name) {
            return self.resolve(at, &[target, &rest[1..]].concat(), hops);
        }
        here.globs
            .iter()
            .find_map(|glob| match self.walk(at, glob) {
                (module, []) => self.name(module, name, rest, hops.checked_sub(1)?),
                _ => None,
            })
    }
}

impl Module {
    fn import(&mut self, tree: &UseTree, path: &[String]) {
        let below = |name: &dyn ToString| [path, &[name.to_string()]].concat();
        let (name, target) = match tree {
            UseTree::Path(inner) => {
                return self.import(&inner.tree, &below(&inner.ident));
            }
            UseTree::Group(group) => {
                let each = |tree| self.import(tree, path);
                return group.items.iter().for_each(each);
            }
            UseTree::Glob(_) => {
                self.globs.push(path.to_vec());
                self.mentions.insert(path.to_vec());
                return;
            }
            UseTree::Name(name) if name.ident == "self" => {
                (path.last().cloned().unwrap_or_default(), path.to_vec())
            }
            UseTree::Name(name) => (name.ident.to_string(), below(&name.ident)),
            UseTree::Rename(rename) => (rename.rename.to_string(), below(&rename.ident)),
        };
        self.mentions.insert(target.clone());
        self.uses.insert(name, target);
    }

    fn tokens(&mut self, tokens: TokenStream) {
        let mut path: Vec<String> = Vec::new();
        let mut colons = 0;
        for token in tokens {
            match token {
                TokenTree::Punct(punct) if punct.as_char() == ':' => colons += 1,
                TokenTree::Ident(ident) => {
                    if colons != 2 {
                        self.mention(std::mem::take(&mut path));
                    }
                    path.push(ident.to_string());
                    colons = 0;
                }
                TokenTree::Group(group) => {
                    self.tokens(group.stream());
                    colons = 0;
                }
                _ => colons = 0,
            }
        }
        self.mention(path);
    }

    /// A path among tokens; a word of a visibility, such as `pub(crate)`, imports nothing.
    fn mention(&mut self, path: Vec<String>) {
        let words = path.iter().map(String::as_str).collect::<Vec<_>>();
        if !matches!(words[..], ["crate" | "super" | "self"]) {
            self.mentions.insert(path);
        }
    }
}

impl<'ast> Visit<'ast> for Module {
    fn visit_item(&mut self, item: &'ast Item) {
        let (name, attributes) = match item {
            Item::Const(item) => (Some(&item.ident), &item.attrs),
            Item::Enum(item) => (Some(&item.ident), &item.attrs),
            Item::Fn(item) => (Some(&item.sig.ident), &item.attrs),
            Item::Macro(item) => (item.ident.as_ref(), &item.attrs),
            Item::Static(item) => (Some(&item.ident), &item.attrs),
            Item::Struct(item) => (Some(&item.ident), &item.attrs),
            Item::Trait(item) => (Some(&item.ident), &item.attrs),
            Item::Type(item) => (Some(&item.ident), &item.attrs),
            Item::Impl(item) => (None, &item.attrs),
            Item::Use(item) => (None, &item.attrs),
            // A module of its own.
            _ => return,
        };
        if !for_tests(attributes) {
            self.items.extend(name.map(ToString::to_string));
            visit::visit_item(self, item);
        }
    }

    fn visit_impl_item_fn(&mut self, item: &'ast ImplItemFn) {
        if !for_tests(&item.attrs) {
            visit::visit_impl_item_fn(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        self.import(&item.tree, &[]);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names = path
            .segments
            .iter()
            .map(|segment| segment.ident.to_string());
        self.mentions.insert(names.collect());
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, call: &'ast Macro) {
        self.visit_path(&call.path);
        self.tokens(call.tokens.clone());
    }

    // Neither `pub(super)` nor `#[derive]` imports anything.
    fn visit_visibility(&mut self, _: &'ast Visibility) {}
    fn visit_attribute(&mut self, _: &'ast Attribute) {}
}

/// Which file imports which, of a crate's files by their paths below `src`.
fn imports(sources: &BTreeMap<String, String>) -> Result<BTreeSet<(String, String)>, String> {
    let mut found = BTreeSet::new();
    for root in ["lib.rs", "main.rs"]
        .into_iter()
        .filter(|root| sources.contains_key(*root))
    {
        let mut all = Crate {
            sources,
            modules: Vec::new(),
        };
        all.read(root, 0, Vec::new())?;
        for (number, module) in all.modules.iter().enumerate() {
            let targets = module.mentions.iter().filter(|path| !path.is_empty());
            let files = targets.filter_map(|path| all.resolve(number, path, MOST_HOPS));
            let others = files.filter(|file| *file != module.file);
            found.extend(others.map(|file| (module.file.clone(), file.to_owned())));
        }
    }
    Ok(found)
}

/// Files that import each other, directly or through others; each group once.
fn circles(imports: &BTreeSet<(String, String)>) -> BTreeSet<BTreeSet<&str>> {
    let mut reach: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for (from, to) in imports {
        reach.entry(from).or_default().insert(to);
    }
    loop {
        let before: usize = reach.values().map(BTreeSet::len).sum();
        for from in reach.keys().copied().collect::<Vec<_>>() {
            let beyond = reach[from].iter().filter_map(|to| reach.get(to));
            let beyond: Vec<&str> = beyond.flatten().copied().collect();
            reach.entry(from).or_default().extend(beyond);
        }
        if reach.values().map(BTreeSet::len).sum::<usize>() == before {
            break;
        }
    }
    let circle = |from: &&str| -> BTreeSet<&str> {
        let back = |to: &&&str| reach.get(**to).is_some_and(|onward| onward.contains(from));
        reach[from].iter().filter(back).copied().collect()
    };
    let groups = reach.keys().map(circle);
    groups.filter(|group| !group.is_empty()).collect()
}

fn sources(folder: &Path, below: &str, found: &mut BTreeMap<String, String>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let place = format!("{below}{name}");
        if path.is_dir() {
            sources(&path, &format!("{place}/"), found)?;
        } else if name.ends_with(".rs") {
            found.insert(place, fs::read_to_string(&path)?);
        }
    }
    Ok(())
}

/// `import_circles [--list] FOLDER...`: folders of crates.
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (options, folders): (Vec<String>, Vec<String>) = env::args()
        .skip(1)
        .partition(|argument| argument.starts_with("--"));
    let mut out = io::stdout().lock();
    let mut number = 0;
    for folder in folders {
        let mut files = BTreeMap::new();
        sources(&Path::new(&folder).join("src"), "", &mut files)?;
        let imports = imports(&files)?;
        if options.iter().any(|option| option == "--list") {
            for (from, to) in &imports {
                writeln!(out, "{folder}: {from} -> {to}")?;
            }
        }
        for circle in circles(&imports) {
            number += 1;
            writeln!(out, "{folder}: a circle of {} files", circle.len())?;
            let within = |(from, to): &&(String, String)| {
                circle.contains(from.as_str()) && circle.contains(to.as_str())
            };
            for (from, to) in imports.iter().filter(within) {
                writeln!(out, "    {from} -> {to}")?;
            }
        }
    }
    match number {
        0 => Ok(()),
        _ => Err(format!("{number} circles of imports").into()),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    fn listed(files: &[(&str, &str)]) -> BTreeSet<(String, String)> {
        let owned = |(name, text): &(&str, &str)| ((*name).to_owned(), (*text).to_owned());
        imports(&files.iter().map(owned).collect()).unwrap()
    }

    fn check(files: &[(&str, &str)], expected: &[(&str, &str)]) {
        let expected = expected
            .iter()
            .map(|(from, to)| (from.to_string(), to.to_string()));
        assert_eq!(listed(files), expected.collect());
    }

    #[test]
    fn declaring_a_module_is_no_import() {
        check(
            &[("lib.rs", "mod a; mod b;"), ("a.rs", ""), ("b/mod.rs", "")],
            &[],
        );
    }

    #[test]
    fn uses_are_imports_however_they_are_written() {
        let a = "use crate::b::{self, c::{C, D as E}, F}; use super::g::*; use std::fmt;";
        check(
            &[
                ("lib.rs", "mod a; mod b; mod g;"),
                ("a.rs", a),
                ("b/mod.rs", "pub mod c; pub struct F; use self::c::C;"),
                ("b/c.rs", "pub struct C; pub struct D;"),
                ("g.rs", "pub fn g() {}"),
            ],
            &[
                ("a.rs", "b/mod.rs"),
                ("a.rs", "b/c.rs"),
                ("a.rs", "g.rs"),
                ("b/mod.rs", "b/c.rs"),
            ],
        );
    }

    #[test]
    fn paths_in_code_and_in_macros_are_imports() {
        let root = "mod a; mod b; mod c; mod d; use d::f;";
        let a = "fn a() -> crate::b::B { assert!(crate::c::f(1) == (2)); crate::f() }";
        check(
            &[
                ("lib.rs", root),
                ("a.rs", a),
                ("b.rs", "pub struct B; impl B { pub(super) fn b() {} }"),
                ("c.rs", "pub fn f(x: u8) {}"),
                // A visibility is no import, among the tokens of a macro either.
                (
                    "d.rs",
                    "pub fn f() {} macro_rules! m { () => { pub(crate) enum E {} } }",
                ),
            ],
            &[
                ("lib.rs", "d.rs"),
                ("a.rs", "b.rs"),
                ("a.rs", "c.rs"),
                ("a.rs", "d.rs"),
            ],
        );
    }

    #[test]
    fn through_a_re_export_the_defining_file_is_imported() {
        let files = [
            ("lib.rs", "mod a; pub mod b;"),
            (
                "a.rs",
                "use crate::b::{Deep, Kind::One}; fn f(g: crate::b::Glob) {}",
            ),
            (
                "b/mod.rs",
                "mod c; mod d; pub use c::Deep as Deep; pub use c::*; pub use d::Kind;",
            ),
            ("b/c.rs", "pub use super::d::Deep; pub struct Glob;"),
            ("b/d.rs", "pub struct Deep; pub enum Kind { One }"),
        ];
        let found = listed(&files);
        let of_a = found
            .iter()
            .filter(|(from, _)| from == "a.rs")
            .map(|(_, to)| to.as_str());
        assert_eq!(of_a.collect::<Vec<_>>(), ["b/c.rs", "b/d.rs"]);
        assert!(circles(&found).is_empty(), "{found:?}");
    }

    #[test]
    fn what_cannot_be_resolved_counts_as_the_file_named() {
        check(
            &[
                ("lib.rs", "mod a; mod b;"),
                ("a.rs", "use crate::b::made_by_a_macro;"),
                ("b.rs", ""),
            ],
            &[("a.rs", "b.rs")],
        );
    }

    #[test]
    fn tests_are_left_out() {
        let root = "mod a; mod b; #[cfg(test)] mod testing; #[cfg(test)] use b::B;";
        let a = "#[cfg(test)] mod tests { use crate::b::B; } #[cfg(test)] fn f() { crate::b::g() }";
        check(
            &[
                ("lib.rs", root),
                ("a.rs", a),
                ("b.rs", "pub struct B; mod b_tests;"),
            ],
            &[],
        );
    }

    #[test]
    fn circles_are_found_and_what_leads_into_them_is_not_one() {
        let found = listed(&[
            ("lib.rs", "mod a; mod b; mod c; mod d; use a::A;"),
            ("a.rs", "use crate::b::B; pub struct A;"),
            ("b.rs", "use crate::c::C; use crate::d::D; pub struct B;"),
            ("c.rs", "pub struct C(super::a::A);"),
            ("d.rs", "pub struct D;"),
        ]);
        assert_eq!(
            circles(&found),
            [BTreeSet::from(["a.rs", "b.rs", "c.rs"])].into()
        );
        let pair = listed(&[
            ("main.rs", "mod a; use a::A; struct B;"),
            ("a.rs", "pub struct A(super::B);"),
        ]);
        assert_eq!(circles(&pair), [BTreeSet::from(["a.rs", "main.rs"])].into());
    }

    #[test]
    fn files_that_do_not_parse_or_do_not_exist_are_told() {
        let read = |text: &str| imports(&[("lib.rs".to_owned(), text.to_owned())].into());
        assert!(read("mod missing;").unwrap_err().contains("missing"));
        assert!(read("fn (").unwrap_err().starts_with("lib.rs"));
    }
}

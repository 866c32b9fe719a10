//! The files of every crate form layers: following imports from one file to the next never leads back to a file.
//!
//! A name that a module re-exports counts as imported from the file that defines it; one of another crate, from the module. A module that only re-exports a name does not import
//! it. Tests within a file do not count.

#![expect(clippy::expect_used, reason = "a test may panic")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use syn::visit::{self, Visit};

/// The root file of every library crate, relative to the repository.
const CRATES: [&str; 9] = [
    "messages/src/lib.rs",
    "plant/src/lib.rs",
    "controller/src/lib.rs",
    "controller/foreign/c/src/lib.rs",
    "launch/shared/src/lib.rs",
    "launch/records/src/lib.rs",
    "launch/sessions/src/lib.rs",
    "launch/laboratory/src/lib.rs",
    "launch/python/src/lib.rs",
];

/// A path of names, such as `port::sender::Sender`.
type Names = Vec<String>;
/// The files that each file imports.
type Imports = BTreeMap<PathBuf, BTreeSet<PathBuf>>;

/// A module of a crate.
#[derive(Default)]
struct Module {
    file: PathBuf,
    /// Names that it defines.
    defined: BTreeSet<String>,
    /// Names that it imports or re-exports, each with the path as written.
    imported: BTreeMap<String, Names>,
    /// Names that it re-exports.
    re_exported: BTreeSet<String>,
    /// Modules from which it imports every name.
    globs: Vec<Names>,
    /// All other paths.
    mentioned: BTreeSet<Names>,
}

/// The modules of a crate, by their paths from its root.
struct Crate(BTreeMap<Names, Module>);

impl Crate {
    /// The crate with this root file. `read` returns the text of a file, if there is one.
    fn of(root: &Path, read: &dyn Fn(&Path) -> Option<String>) -> Crate {
        let mut crate_ = Crate(BTreeMap::new());
        crate_.add_file(root, root.parent().expect("a folder"), vec![], read);
        crate_
    }

    /// Adds the module of a file, and the modules below it, whose files are in `folder`.
    fn add_file(&mut self, file: &Path, folder: &Path, path: Names, read: &dyn Fn(&Path) -> Option<String>) {
        let text = read(file).expect("every module has a file");
        self.add_items(file, folder, path, syn::parse_file(&text).expect("Rust").items, read);
    }

    fn add_items(
        &mut self,
        file: &Path,
        folder: &Path,
        path: Names,
        items: Vec<syn::Item>,
        read: &dyn Fn(&Path) -> Option<String>,
    ) {
        let mut module = Module { file: file.into(), ..Module::default() };
        for item in items {
            match item {
                syn::Item::Mod(inner) if is_test(&inner.attrs) => (),
                syn::Item::Mod(inner) => {
                    let name = inner.ident.to_string();
                    let path = [path.clone(), vec![name.clone()]].concat();
                    match inner.content {
                        Some((_, items)) => self.add_items(file, &folder.join(name), path, items, read),
                        None => self.add_file(&folder.join(format!("{name}.rs")), &folder.join(name), path, read),
                    }
                }
                item => {
                    module.defined.extend(name_of(&item));
                    module.visit_item(&item);
                }
            }
        }
        self.0.insert(path, module);
    }

    /// The path from the root of the crate for a path as a module writes it; `None` if it leads to another crate.
    fn absolute(&self, from: &Names, written: &Names) -> Option<Names> {
        let (first, rest) = written.split_first()?;
        let below = [from.clone(), vec![first.clone()]].concat();
        match first.as_str() {
            "crate" => Some(rest.to_vec()),
            "self" => Some([from.clone(), rest.to_vec()].concat()),
            "super" => {
                let ups = written.iter().take_while(|name| *name == "super").count();
                Some([from[..from.len().checked_sub(ups)?].to_vec(), written[ups..].to_vec()].concat())
            }
            _ if !rest.is_empty() && self.0.contains_key(&below) => Some([below, rest.to_vec()].concat()),
            _ => {
                let module = &self.0[from];
                match module.imported.get(first).filter(|import| import.first() != Some(first)) {
                    Some(import) => Some([self.absolute(from, import)?, rest.to_vec()].concat()),
                    None => module.defined.contains(first).then_some(below),
                }
            }
        }
    }

    /// The file that defines the item of an absolute path.
    fn file_of(&self, path: &Names) -> Option<&PathBuf> {
        let depth = (0..=path.len()).rev().find(|depth| self.0.contains_key(&path[..*depth]))?;
        let (place, rest) = path.split_at(depth);
        let (place, module) = (place.to_vec(), &self.0[place]);
        let Some(name) = rest.first().filter(|name| !module.defined.contains(*name)) else { return Some(&module.file) };
        let follow = |written: &Names| self.absolute(&place, written).filter(|next| next != path);
        match module.imported.get(name) {
            Some(import) => match follow(import) {
                Some(next) => self.file_of(&next),
                None => module.re_exported.contains(name).then_some(&module.file),
            },
            None => module
                .globs
                .iter()
                .filter_map(follow)
                .find(|glob| self.0.get(glob).is_some_and(|module| module.defined.contains(name)))
                .and_then(|glob| self.file_of(&glob)),
        }
    }

    fn imports(&self) -> Imports {
        let mut imports = Imports::new();
        for (path, module) in &self.0 {
            let imported = module.imported.iter().filter(|(name, _)| !module.re_exported.contains(*name));
            let written = imported.map(|(_, path)| path).chain(&module.globs).chain(&module.mentioned);
            let found = written.filter_map(|written| self.file_of(&self.absolute(path, written)?));
            let others = found.filter(|file| **file != module.file).cloned();
            imports.entry(module.file.clone()).or_default().extend(others);
        }
        imports
    }
}

impl<'ast> Visit<'ast> for Module {
    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        let known: BTreeSet<String> = self.imported.keys().cloned().collect();
        self.add_use(vec![], &item.tree);
        if !matches!(item.vis, syn::Visibility::Inherited) {
            self.re_exported.extend(self.imported.keys().filter(|name| !known.contains(*name)).cloned());
        }
    }

    /// `pub(super)` imports nothing.
    fn visit_visibility(&mut self, _: &'ast syn::Visibility) {}

    /// Nor do attributes.
    fn visit_attribute(&mut self, _: &'ast syn::Attribute) {}

    fn visit_path(&mut self, path: &'ast syn::Path) {
        if path.leading_colon.is_none() {
            self.mentioned.insert(path.segments.iter().map(|segment| segment.ident.to_string()).collect());
        }
        visit::visit_path(self, path);
    }
}

impl Module {
    fn add_use(&mut self, mut before: Names, tree: &syn::UseTree) {
        let mut add = |before: Names, original: String, name: String| {
            let is_module = original == "self";
            let name = if is_module { before.last().cloned().unwrap_or(name) } else { name };
            let path = if is_module { before } else { [before, vec![original]].concat() };
            self.imported.insert(name, path);
        };
        match tree {
            syn::UseTree::Path(path) => {
                before.push(path.ident.to_string());
                self.add_use(before, &path.tree);
            }
            syn::UseTree::Name(name) => add(before, name.ident.to_string(), name.ident.to_string()),
            syn::UseTree::Rename(name) => add(before, name.ident.to_string(), name.rename.to_string()),
            syn::UseTree::Glob(_) => self.globs.push(before),
            syn::UseTree::Group(group) => group.items.iter().for_each(|tree| self.add_use(before.clone(), tree)),
        }
    }
}

fn is_test(attributes: &[syn::Attribute]) -> bool {
    let is_cfg_test = |list: &syn::MetaList| list.path.is_ident("cfg") && list.tokens.to_string() == "test";
    attributes.iter().any(|attribute| attribute.meta.require_list().is_ok_and(is_cfg_test))
}

/// The name that an item defines in its module.
fn name_of(item: &syn::Item) -> Option<String> {
    use syn::Item::{Const, Enum, Fn, Macro, Static, Struct, Trait, Type, Union};
    match item {
        Const(item) => Some(item.ident.to_string()),
        Enum(item) => Some(item.ident.to_string()),
        Fn(item) => Some(item.sig.ident.to_string()),
        Macro(item) => item.ident.as_ref().map(ToString::to_string),
        Static(item) => Some(item.ident.to_string()),
        Struct(item) => Some(item.ident.to_string()),
        Trait(item) => Some(item.ident.to_string()),
        Type(item) => Some(item.ident.to_string()),
        Union(item) => Some(item.ident.to_string()),
        _ => None,
    }
}

/// A cycle of imports: each file imports the next one, and the last one imports the first.
fn circle(imports: &Imports) -> Option<Vec<&PathBuf>> {
    fn search<'a>(
        imports: &'a Imports,
        way: &mut Vec<&'a PathBuf>,
        done: &mut BTreeSet<&'a PathBuf>,
    ) -> Option<Vec<&'a PathBuf>> {
        let last = *way.last()?;
        for next in &imports[last] {
            if let Some(start) = way.iter().position(|file| *file == next) {
                return Some(way[start..].to_vec());
            }
            if done.insert(next) {
                way.push(next);
                let found = search(imports, way, done);
                if found.is_some() {
                    return found;
                }
                way.pop();
            }
        }
        None
    }
    let mut done = BTreeSet::new();
    imports.keys().find_map(|file| search(imports, &mut vec![file], &mut done))
}

#[test]
fn no_circle_of_imports() {
    for root in CRATES {
        let imports = Crate::of(Path::new(root), &|file| std::fs::read_to_string(file).ok()).imports();
        let count: usize = imports.values().map(BTreeSet::len).sum();
        println!("{root}: {} files, {count} imports", imports.len());
        assert!(imports.len() < 3 || count >= imports.len() - 2, "{root}: hardly an import was found");
        assert_eq!(circle(&imports), None, "{root}");
    }
}

/// A crate of three files, made up for the test.
fn imports_of([lib, a, b]: [&str; 3]) -> Imports {
    let read = |file: &Path| match file.to_str() {
        Some("made/lib.rs") => Some(lib.to_string()),
        Some("made/a.rs") => Some(a.to_string()),
        Some("made/b.rs") => Some(b.to_string()),
        _ => None,
    };
    Crate::of(Path::new("made/lib.rs"), &read).imports()
}

#[test]
fn a_circle_is_found_also_behind_a_name_that_is_re_exported() {
    let lib = "mod a; mod b; pub use a::A; pub use b::B;";
    let b = "pub struct B; fn f() -> crate::A { todo!() }";
    for a in ["use crate::b::B; pub struct A;", "use super::B as Other; pub struct A;"] {
        let imports = imports_of([lib, a, b]);
        assert_eq!(circle(&imports).map(|circle| circle.len()), Some(2), "{a}: {imports:?}");
        assert_eq!(circle(&imports_of([lib, a, "pub struct B;"])), None, "one direction is no circle");
    }
    let foreign = "pub use other::A; fn f(_: crate::B) {}";
    let imports = imports_of([lib, foreign, b]);
    assert_eq!(circle(&imports).map(|circle| circle.len()), Some(2), "A is imported from a: {imports:?}");
    let in_test = "pub struct B; #[cfg(test)] mod tests { use crate::a::A; }";
    assert_eq!(circle(&imports_of([lib, "use crate::B; pub struct A;", in_test])), None, "tests do not count");
}

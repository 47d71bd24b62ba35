//! Finds all paths in the sources, starting at the root of the crate.

use proc_macro2::{TokenStream, TokenTree};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use syn::visit::{self, Visit};

#[derive(Debug)]
pub struct Used {
    pub file: String,
    /// Paths such as `engine::audit::Meeting`. Paths into other crates are left out.
    pub paths: BTreeSet<String>,
}

/// Returns the paths in all sources below `src`, except for unit tests, which may import everything.
pub fn of_sources() -> Vec<Used> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    find(&root, &mut files);
    let parsed: Vec<(PathBuf, Visitor)> = files
        .into_iter()
        .map(|path| {
            let below = path.strip_prefix(&root).unwrap().to_owned();
            let visitor = Visitor::of(&fs::read_to_string(&path).unwrap(), module(&below));
            (below, visitor)
        })
        .collect();
    // `#[cfg(test)] mod tests;` also excludes the modules in the folder `tests`.
    let tests: BTreeSet<Vec<String>> = parsed.iter().flat_map(|(_, visitor)| visitor.tests.iter().cloned()).collect();
    let is_test = |path: &Path| tests.iter().any(|test| module(path).starts_with(test));
    let others = parsed.into_iter().filter(|(path, _)| !is_test(path));
    others.map(|(path, visitor)| Used { file: path.display().to_string(), paths: visitor.paths }).collect()
}

fn find(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            find(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
}

fn module(below: &Path) -> Vec<String> {
    let path = below.with_extension("");
    let names = path.components().map(|part| part.as_os_str().to_string_lossy().into_owned());
    names.filter(|name| name != "lib" && name != "main").collect()
}

#[derive(Debug)]
pub struct Visitor {
    /// The path of the current module in the crate.
    module: Vec<String>,
    pub paths: BTreeSet<String>,
    tests: BTreeSet<Vec<String>>,
}

impl Visitor {
    pub fn of(text: &str, module: Vec<String>) -> Self {
        let file = syn::parse_file(text).unwrap();
        let mut visitor = Self { module, paths: BTreeSet::new(), tests: BTreeSet::new() };
        visitor.visit_file(&file);
        visitor
    }

    /// Adds a path if it begins with `crate`, `carom`, `self` or `super`.
    fn add(&mut self, names: &[String]) {
        let mut base = self.module.clone();
        let mut rest = names;
        match names.first().map(String::as_str) {
            // In the program, the library has the name `carom`.
            Some("crate" | "carom") => base.clear(),
            Some("self" | "super") => {}
            _ => return,
        }
        while let Some((first, others)) = rest.split_first() {
            match first.as_str() {
                "crate" | "carom" | "self" => {}
                "super" => drop(base.pop()),
                _ => break,
            }
            rest = others;
        }
        base.extend_from_slice(rest);
        if !base.is_empty() {
            self.paths.insert(base.join("::"));
        }
    }

    /// Adds all paths in a list of tokens. A path consists of names separated by two colons.
    fn add_tokens(&mut self, tokens: TokenStream) {
        let mut names: Vec<String> = Vec::new();
        let mut colons = 0;
        for token in tokens {
            match token {
                TokenTree::Punct(punct) if punct.as_char() == ':' => colons += 1,
                TokenTree::Ident(name) if colons == 2 => {
                    names.push(name.to_string());
                    colons = 0;
                }
                TokenTree::Ident(name) => {
                    self.add(&std::mem::replace(&mut names, vec![name.to_string()]));
                    colons = 0;
                }
                token => {
                    self.add(&std::mem::take(&mut names));
                    if let TokenTree::Group(group) = token {
                        self.add_tokens(group.stream());
                    }
                }
            }
        }
        self.add(&names);
    }

    fn add_tree(&mut self, tree: &syn::UseTree, names: &mut Vec<String>) {
        match tree {
            syn::UseTree::Path(path) => {
                names.push(path.ident.to_string());
                self.add_tree(&path.tree, names);
                names.pop();
            }
            syn::UseTree::Group(group) => group.items.iter().for_each(|tree| self.add_tree(tree, names)),
            syn::UseTree::Name(syn::UseName { ident }) | syn::UseTree::Rename(syn::UseRename { ident, .. }) => {
                names.push(ident.to_string());
                self.add(names);
                names.pop();
            }
            syn::UseTree::Glob(_) => self.add(names),
        }
    }
}

fn is_for_tests(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let is_test = |list: &syn::MetaList| list.path.is_ident("cfg") && list.tokens.to_string() == "test";
        attribute.meta.require_list().is_ok_and(is_test)
    })
}

impl<'ast> Visit<'ast> for Visitor {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        let attributes = match item {
            syn::Item::Mod(it) => &it.attrs,
            syn::Item::Use(it) => &it.attrs,
            syn::Item::Fn(it) => &it.attrs,
            syn::Item::Impl(it) => &it.attrs,
            syn::Item::Struct(it) => &it.attrs,
            syn::Item::Const(it) => &it.attrs,
            _ => return visit::visit_item(self, item),
        };
        if !is_for_tests(attributes) {
            visit::visit_item(self, item);
        } else if let syn::Item::Mod(it) = item {
            let mut module = self.module.clone();
            module.push(it.ident.to_string());
            self.tests.insert(module);
        }
    }

    fn visit_impl_item_fn(&mut self, function: &'ast syn::ImplItemFn) {
        if !is_for_tests(&function.attrs) {
            visit::visit_impl_item_fn(self, function);
        }
    }

    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        self.module.push(item.ident.to_string());
        visit::visit_item_mod(self, item);
        self.module.pop();
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        self.add_tree(&item.tree, &mut Vec::new());
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names: Vec<String> = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        self.add(&names);
        visit::visit_path(self, path);
    }

    /// The path in `pub(in path)` is not an import.
    fn visit_visibility(&mut self, _: &'ast syn::Visibility) {}

    /// Macro arguments are not parsed, so paths are found in the tokens.
    fn visit_macro(&mut self, call: &'ast syn::Macro) {
        self.add_tokens(call.tokens.clone());
        visit::visit_macro(self, call);
    }
}

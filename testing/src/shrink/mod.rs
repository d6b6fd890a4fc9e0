//! Makes a network file that shows a failure as small as it can be while the failure stays.
//!
//! Delta debugging (Zeller and Hildebrandt, *Simplifying and Isolating Failure-Inducing Input*, IEEE Trans. Softw. Eng. 28,
//! 2002) on the tree of the file. Four passes in turn, until none of them finds anything more: entries of tables, many at
//! once and ever fewer, with everything that refers to them; keys and items wherever they are; members made straight, or of one
//! section; digits of numbers.

mod network;
mod numbers;
mod paths;

use serde_json::Value;

use crate::tree::{parse, print};
use paths::{at, has, paths, remove};

/// A file and what it took to find it.
#[derive(Clone, Debug, PartialEq)]
pub struct Shrunk {
    /// The file, which fails as the one that was given.
    pub text: String,
    /// Files that were tried.
    pub tried: usize,
}

/// The smallest file that was found, of this one's parts, on which `fails` is still true.
///
/// # Errors
/// Where the text is no TOML, or does not fail to begin with.
pub fn shrink(text: &str, fails: impl FnMut(&str) -> bool) -> Result<Shrunk, String> {
    let mut search = Search { tree: parse(text)?, fails, tried: 0 };
    if !search.still(search.tree.clone()) {
        return Err("the file does not fail to begin with".to_owned());
    }
    loop {
        let before = search.tree.clone();
        search.entries();
        search.keys();
        search.shapes();
        search.numbers();
        if search.tree == before {
            return Ok(Shrunk { text: print(&search.tree), tried: search.tried });
        }
    }
}

struct Search<F> {
    tree: Value,
    fails: F,
    tried: usize,
}

impl<F: FnMut(&str) -> bool> Search<F> {
    /// Takes a tree if it fails too.
    fn still(&mut self, tree: Value) -> bool {
        self.tried += 1;
        let fails = (self.fails)(&print(&tree));
        if fails {
            self.tree = tree;
        }
        fails
    }

    /// Takes away entries of the tables at the top: half of a table, a quarter, down to one by one.
    fn entries(&mut self) {
        let tables: Vec<String> = self.tree.as_object().into_iter().flat_map(|top| top.keys().cloned()).collect();
        for table in tables {
            let mut size = self.names(&table).len();
            while size > 0 {
                let mut first = 0;
                while first < self.names(&table).len() {
                    let names = self.names(&table);
                    let some = &names[first..names.len().min(first + size)];
                    if !self.still(network::without(&self.tree, &table, some)) {
                        first += size;
                    }
                }
                size /= 2;
            }
        }
    }

    /// Names of the entries of a table at the top, or places of those of a list.
    fn names(&self, table: &str) -> Vec<String> {
        match &self.tree[table] {
            Value::Object(map) => map.keys().cloned().collect(),
            Value::Array(items) => (0..items.len()).map(|index| index.to_string()).collect(),
            _ => Vec::new(),
        }
    }

    /// Takes away whatever can be, one by one, the last first: what holds others goes after them only if it has to.
    fn keys(&mut self) {
        for path in paths(&self.tree) {
            if has(&self.tree, &path) {
                let mut tree = self.tree.clone();
                remove(&mut tree, &path);
                self.still(tree);
            }
        }
    }

    /// Makes members simpler than taking a key away can.
    fn shapes(&mut self) {
        for simpler in network::SIMPLER {
            for name in self.names("members") {
                let tree = simpler(&self.tree, &name);
                if let Some(tree) = tree.filter(|tree| *tree != self.tree) {
                    self.still(tree);
                }
            }
        }
    }

    /// Writes every number with as few digits as will do.
    fn numbers(&mut self) {
        for path in paths(&self.tree) {
            let Some(value) = at(&self.tree, &path).and_then(Value::as_f64) else { continue };
            for shorter in numbers::shorter(value) {
                let mut tree = self.tree.clone();
                if let Some(place) = paths::at_mut(&mut tree, &path) {
                    *place = crate::tree::number(shorter);
                }
                network::fit(&mut tree, &self.tree);
                if self.still(tree) {
                    break;
                }
            }
        }
    }
}

//! Paths of keys and indices to the values of a scene.

use std::borrow::Cow;
use std::fmt;

/// A step of a [`ConfigPath`]: a key or an index.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PathStep {
    /// Key of a value in a table.
    Key(Cow<'static, str>),
    /// Index of an element in an array, from 0.
    Index(usize),
}

/// Config path of a value in a scene, such as `interaction[0].restitution`.
///
/// Scenes from code and from a file have the same paths and error messages. For a file, errors also show the line.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub struct ConfigPath(Vec<PathStep>);

impl ConfigPath {
    /// The whole scene.
    #[must_use]
    pub fn root() -> Self {
        Self::default()
    }

    /// Path of the value of `key` in the table at this path.
    #[must_use]
    pub fn key(&self, key: impl Into<Cow<'static, str>>) -> Self {
        self.step(PathStep::Key(key.into()))
    }

    /// Path of element `index` of the array at this path.
    #[must_use]
    pub fn index(&self, index: usize) -> Self {
        self.step(PathStep::Index(index))
    }

    /// Path of an entry in a top-level array of tables, such as `interaction[0]`.
    #[must_use]
    pub fn entry(table: &'static str, index: usize) -> Self {
        Self::root().key(table).index(index)
    }

    /// In a path into the top-level array `table`, replaces the index `k` by `indices[k]`.
    #[must_use]
    pub(crate) fn entry_moved(&self, table: &str, indices: &[usize]) -> Self {
        let mut steps = self.0.clone();
        if let [PathStep::Key(key), PathStep::Index(index), ..] = &mut steps[..]
            && key == table
            && let Some(moved) = indices.get(*index)
        {
            *index = *moved;
        }
        Self(steps)
    }

    /// Steps of the path, beginning at the root.
    #[must_use]
    pub fn steps(&self) -> &[PathStep] {
        &self.0
    }

    pub(crate) fn is_in(&self, key: &str) -> bool {
        matches!(self.0.first(), Some(PathStep::Key(first)) if first == key)
    }

    fn step(&self, step: PathStep) -> Self {
        let mut steps = self.0.clone();
        steps.push(step);
        Self(steps)
    }
}

impl fmt::Display for ConfigPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (depth, step) in self.0.iter().enumerate() {
            match step {
                PathStep::Key(key) if depth == 0 => f.write_str(key)?,
                PathStep::Key(key) => write!(f, ".{key}")?,
                PathStep::Index(index) => write!(f, "[{index}]")?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn config_path_prints_keys_and_indices() {
        assert_eq!(ConfigPath::entry("mesh", 2).key("edge_1").index(0).to_string(), "mesh[2].edge_1[0]");
        assert_eq!(ConfigPath::root().to_string(), "");
    }
}

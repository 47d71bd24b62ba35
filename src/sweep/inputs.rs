//! Input files of a sweep. Their content must be the same for all runs.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use super::plan::Sweep;
use crate::io::inputs::present;
use crate::model::{InputFile, Scene};
use crate::scene::NamedInput;

/// Checksums by absolute path.
pub(super) type Inputs = BTreeMap<String, String>;

impl Sweep {
    /// Checksums of the input files of all points, including checkpoints of earlier runs. Missing files are left out.
    pub(super) fn inputs(&self) -> Inputs {
        let is_table = |table: &str| Scene::TABLES_WITH_INPUTS.contains(&table.trim());
        let is_naming = |key: &str| key.split('.').next().is_some_and(is_table);
        // The inputs of the points only differ if a varied key names files or runs.
        let differing = if self.keys().into_iter().any(is_naming) { self.points().len() } else { 1 };
        let mut named: BTreeSet<(PathBuf, NamedInput)> = BTreeSet::new();
        for point in self.points().iter().take(differing) {
            named.extend(self.inputs_at(point).unwrap_or_default());
        }
        let inputs = named.into_iter().filter_map(|(path, kind)| present(&path, kind));
        inputs.map(|InputFile { path, checksum, .. }| (path, checksum)).collect()
    }
}

/// Returns the first changed input: path, current checksum and earlier checksum.
pub(super) fn replaced(scene: &Scene, begun_with: &Inputs) -> Option<(String, String, String)> {
    scene.inputs().iter().find_map(|input| {
        let expected = begun_with.get(&input.path).filter(|expected| **expected != input.checksum)?;
        Some((input.path.clone(), input.checksum.clone(), expected.clone()))
    })
}

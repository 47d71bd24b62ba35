//! Input files of a sweep. All runs must start from the content at the beginning of the sweep.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use super::plan::Sweep;
use crate::io::inputs::present;
use crate::model::{InputFile, Scene};
use crate::scene::NamedInput;

/// Checksums of files by their absolute paths.
pub(super) type Inputs = BTreeMap<String, String>;

impl Sweep {
    /// Checksums of the input files of all points: files named in the scenes, and checkpoints of earlier runs. Missing
    /// files are left out.
    pub(super) fn inputs(&self) -> Inputs {
        let is_table = |table: &str| Scene::TABLES_WITH_INPUTS.contains(&table.trim());
        let is_naming = |key: &str| key.split('.').next().is_some_and(is_table);
        // All points have the same inputs, unless a varied key names files or runs.
        let differing = if self.keys().into_iter().any(is_naming) { self.points().len() } else { 1 };
        let mut named: BTreeSet<(PathBuf, NamedInput)> = BTreeSet::new();
        for point in self.points().iter().take(differing) {
            named.extend(self.inputs_at(point).unwrap_or_default());
        }
        let inputs = named.into_iter().filter_map(|(path, kind)| present(&path, kind));
        inputs.map(|InputFile { path, checksum, .. }| (path, checksum)).collect()
    }
}

/// Returns the first changed input: its path, current checksum and earlier checksum.
pub(super) fn replaced(scene: &Scene, begun_with: &Inputs) -> Option<(String, String, String)> {
    scene.inputs().iter().find_map(|input| {
        let expected = begun_with.get(&input.path).filter(|expected| **expected != input.checksum)?;
        Some((input.path.clone(), input.checksum.clone(), expected.clone()))
    })
}

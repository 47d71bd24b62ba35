//! Sweeps of a scene: axes and points.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::axis::{Axis, MOST};
use super::error::SweepError;
use super::names::{folder_name, short_names};
use super::value::{has_key, meaning, value_of};
use crate::base::checksum::checksum;
use crate::io::estimate::SizeEstimate;
use crate::io::read_scene_text;
use crate::model::Scene;
use crate::model::input_file::spelled;
use crate::run::foreseen_rate;
use crate::scene::{NamedInput, SceneError, read_text};

const SEED: &str = "seed";

/// Scenes with a barostat also measure quantities that other scenes prescribe, such as the density.
const BAROSTAT: &str = "barostat";

/// Sweep of a scene: axes and points. The last axis varies fastest.
#[derive(Debug, Clone)]
pub struct Sweep {
    scene: PathBuf,
    /// Whether the scene comes from a file. Otherwise, the folder of the sweep contains the text of the scene.
    has_file: bool,
    text: String,
    set: Vec<(String, String)>,
    axes: Vec<Axis>,
    points: Vec<Point>,
}

/// Point of a sweep: a value for each varied key.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Point {
    settings: Vec<(String, String)>,
    folder: String,
}

impl Point {
    /// Keys and values of the point, in the order of the axes.
    #[must_use]
    pub fn settings(&self) -> &[(String, String)] {
        &self.settings
    }

    /// Name of the folder of the point, made from the keys and values.
    #[must_use]
    pub fn folder(&self) -> &str {
        &self.folder
    }

    /// Keys and values that identify a state point: all except the seed.
    pub fn state_point(&self) -> impl Iterator<Item = &(String, String)> {
        self.settings.iter().filter(|(key, _)| key != SEED)
    }
}

impl Sweep {
    /// Creates a sweep of the scene in a file. `set` overrides values at all points, as in
    /// [`read_scene`](crate::io::read_scene). Axes override the scene.
    ///
    /// # Errors
    /// [`SweepError::Scene`] if the file cannot be read, [`SweepError::NoAxis`], [`SweepError::Twice`],
    /// [`SweepError::SamePlace`], [`SweepError::SameValue`] or [`SweepError::TooMany`]. The scene itself is not
    /// validated.
    pub fn new(scene: impl AsRef<Path>, set: &[(&str, &str)], axes: Vec<Axis>) -> Result<Self, SweepError> {
        let scene = scene.as_ref().to_owned();
        let text = read_text(&scene)?;
        Self::of(scene, true, text, set, axes)
    }

    /// Creates a sweep of a scene without a file. The text is stored in the folder of the sweep. `name` is the path of
    /// the scene in messages. Relative paths in the text are relative to the folder of this path.
    ///
    /// # Errors
    /// The errors of [`Sweep::new`], except errors of reading the file.
    pub fn of_text(
        text: impl Into<String>,
        name: impl AsRef<Path>,
        set: &[(&str, &str)],
        axes: Vec<Axis>,
    ) -> Result<Self, SweepError> {
        Self::of(name.as_ref().to_owned(), false, text.into(), set, axes)
    }

    fn of(
        scene: PathBuf,
        has_file: bool,
        text: String,
        set: &[(&str, &str)],
        axes: Vec<Axis>,
    ) -> Result<Self, SweepError> {
        let set = set.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
        let mut sweep = Self { scene, has_file, text, set, axes, points: Vec::new() };
        sweep.check_keys()?;
        sweep.points = sweep.combinations()?;
        Ok(sweep)
    }

    fn check_keys(&self) -> Result<(), SweepError> {
        if self.axes.is_empty() {
            return Err(SweepError::NoAxis);
        }
        let mut known = BTreeSet::new();
        let set = self.set.iter().map(|(key, _)| key.as_str());
        if let Some(key) = self.keys().into_iter().chain(set).find(|key| !known.insert(*key)) {
            return Err(SweepError::Twice(key.to_owned()));
        }
        // A later setting must not override an earlier setting.
        let set: Vec<(&str, &str)> = self.set.iter().map(|(key, value)| (key.as_str(), value.as_str())).collect();
        let keys: Vec<&str> = set.iter().map(|(key, _)| *key).chain(self.keys()).collect();
        let places = Scene::places(&self.text, &set, &keys);
        for (later, place) in places.iter().enumerate() {
            if let Some(earlier) = places[..later].iter().position(|earlier| earlier.starts_with(place)) {
                let [first, second] = [earlier, later].map(|at| keys[at].to_owned());
                return Err(SweepError::SamePlace { first, second });
            }
        }
        Ok(())
    }

    fn combinations(&self) -> Result<Vec<Point>, SweepError> {
        let number = self.axes.iter().try_fold(1_usize, |number, axis| number.checked_mul(axis.len()));
        let number =
            number.filter(|number| *number <= MOST).ok_or(SweepError::TooMany(number.unwrap_or(usize::MAX)))?;
        for axis in &self.axes {
            let mut known = BTreeSet::new();
            for at in 0..axis.len() {
                let settings: Vec<(String, String)> = axis.settings(at).collect();
                let meanings: Vec<String> = settings.iter().map(|(_, value)| meaning(value)).collect();
                if let (false, Some((key, value))) = (known.insert(meanings), settings.into_iter().next()) {
                    return Err(SweepError::SameValue { key, value });
                }
            }
        }
        let names = self.short_names();
        let mut taken = BTreeSet::new();
        let point = |number: usize| {
            let (mut rest, mut places) = (number, vec![0; self.axes.len()]);
            for (axis, place) in self.axes.iter().zip(&mut places).rev() {
                (rest, *place) = (rest / axis.len(), rest % axis.len());
            }
            let settings: Vec<_> = self.axes.iter().zip(places).flat_map(|(axis, at)| axis.settings(at)).collect();
            let mut folder = folder_name(&names, &settings, false);
            // Some file systems ignore case.
            if !taken.insert(folder.to_lowercase()) {
                folder = folder_name(&names, &settings, true);
            }
            Point { settings, folder }
        };
        Ok((0..number).map(point).collect())
    }

    /// Path of the scene.
    #[must_use]
    pub fn scene(&self) -> &Path {
        &self.scene
    }

    pub(super) fn text_alone(&self) -> Option<&str> {
        (!self.has_file).then_some(&self.text)
    }

    /// Overrides of the scene at all points.
    #[must_use]
    pub fn set(&self) -> &[(String, String)] {
        &self.set
    }

    /// The axes.
    #[must_use]
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// Combinations of the values of all axes. The last axis varies fastest.
    #[must_use]
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// Keys of all axes, in order.
    #[must_use]
    pub fn keys(&self) -> Vec<&str> {
        self.axes.iter().flat_map(|axis| axis.keys().iter().map(String::as_str)).collect()
    }

    /// Names of the keys in tables and folders. A name is the last word of a key with its indices, such as `gravity_1`.
    /// If this name is also a measured quantity, the preceding word is added, as in `barostat_pressure`. If names
    /// coincide, the whole key is used, as in `fill_0_packing_fraction`.
    #[must_use]
    pub fn short_names(&self) -> Vec<String> {
        short_names(&self.keys(), self.has_barostat())
    }

    fn has_barostat(&self) -> bool {
        let is_key = |key: &str| key.split('.').any(|part| part.trim() == BAROSTAT);
        let scene = self.text.parse().is_ok_and(|table| has_key(&toml::Value::Table(table), BAROSTAT));
        let set = self.set.iter().any(|(key, value)| is_key(key) || has_key(&value_of(value), BAROSTAT));
        scene || set || self.keys().into_iter().any(is_key)
    }

    /// Names of all keys except the seed, see [`Self::short_names`].
    #[must_use]
    pub fn state_point_names(&self) -> Vec<String> {
        let names = self.short_names().into_iter().zip(self.keys());
        names.filter_map(|(name, key)| (key != SEED).then_some(name)).collect()
    }

    /// Index of the axis of each name in [`Self::state_point_names`].
    pub(crate) fn state_point_axes(&self) -> Vec<usize> {
        let keys = self.axes.iter().enumerate().flat_map(|(at, axis)| axis.keys().iter().map(move |key| (at, key)));
        keys.filter_map(|(at, key)| (key != SEED).then_some(at)).collect()
    }

    pub(super) fn checksum(&self) -> String {
        spelled(checksum(self.text.as_bytes()))
    }

    /// Reads the scene at a point.
    ///
    /// # Errors
    /// [`SceneError`] with the first error.
    pub fn scene_at(&self, point: &Point) -> Result<Scene, SceneError> {
        read_scene_text(self.text.clone(), &self.scene, &self.overrides(point))
    }

    /// Checks the keys and the types of values at a point of the sweep. This is fast, because no particles are placed.
    ///
    /// # Errors
    /// [`SceneError`] with the first error.
    pub fn check_keys_at(&self, point: &Point) -> Result<(), SceneError> {
        Scene::check_keys(&self.text, &self.scene, &self.overrides(point))
    }

    pub(super) fn inputs_at(&self, point: &Point) -> Result<Vec<(PathBuf, NamedInput)>, SceneError> {
        Scene::inputs_named(&self.text, &self.scene, &self.overrides(point))
    }

    /// Checks the keys and types at all points, and one complete scene. Returns the scene.
    ///
    /// # Errors
    /// [`SweepError::Scene`] with the first error, [`SweepError::SameRuns`] if the seed varies without effect.
    pub fn check(&self) -> Result<Scene, SweepError> {
        self.points.iter().try_for_each(|point| self.check_keys_at(point))?;
        // One end of an axis may be invalid, so only the first or the last point must be valid.
        let (first, last) = (&self.points[0], &self.points[self.points.len() - 1]);
        let (point, scene) = match self.scene_at(first) {
            Ok(scene) => (first, scene),
            Err(error) => (last, self.scene_at(last).map_err(|_| error)?),
        };
        self.check_seeds(point, &scene)?;
        Ok(scene)
    }

    fn check_seeds(&self, point: &Point, scene: &Scene) -> Result<(), SweepError> {
        // Replica exchanges are not checked, because sweeps reject them.
        let is_driven = scene.run().has_andersen()
            || scene.has_thermal_walls()
            || scene.exchange().is_some()
            || !scene.inlets().is_empty();
        let is_repetition = |other: &&Point| *other != point && other.state_point().eq(point.state_point());
        let Some(other) = self.points.iter().find(is_repetition).filter(|_| !is_driven) else { return Ok(()) };
        // If the scene is invalid, its run reports the error.
        let Ok(again) = self.scene_at(other) else { return Ok(()) };
        if again.particles() == scene.particles() {
            return Err(SweepError::SameRuns { first: point.folder.clone(), second: other.folder.clone() });
        }
        Ok(())
    }

    /// Expected size of all files `[bytes]`, if all runs resemble `scene`. The estimate is accurate within a factor of
    /// two. If the size of some files is unknown, the estimate is a lower bound.
    #[must_use]
    pub fn expected_bytes(&self, scene: &Scene) -> f64 {
        SizeEstimate::of(scene, foreseen_rate(scene).ok()).bytes * self.points.len() as f64
    }

    pub(super) fn record_at(&self, point: &Point, scene: &Scene) -> Result<String, SceneError> {
        scene.record_of(self.text.clone(), &self.scene, &self.overrides(point))
    }

    fn overrides<'s>(&'s self, point: &'s Point) -> Vec<(&'s str, &'s str)> {
        self.set.iter().chain(&point.settings).map(|(key, value)| (key.as_str(), value.as_str())).collect()
    }
}

#[cfg(test)]
mod tests;

//! A validated scene: everything that determines a trajectory, in reduced units.
//!
//! A [`Scene`] is read from a file ([`Scene::from_file`], [`Scene::from_toml`]) or built in code with a
//! [`SceneBuilder`]. Every scene is checked, so a simulation needs no further validation. [`schema`](fn@schema)
//! describes all keys of a scene file.
//!
//! The module `file` reads the keys of a text, `parse` converts them to a [`SceneBuilder`], and `validate` checks the
//! builder and returns the [`Scene`]. The module `prepare` generates positions and velocities. A [`SceneError`] has the
//! [`ConfigPath`] of the wrong value, and `source` finds the line.

mod brought;
mod builder;
mod classes;
mod compatibility;
mod config_path;
mod continuation;
mod coordinates;
mod diagnostic;
mod file;
mod filling;
mod given;
mod groups;
mod inlet_draft;
mod interactions;
mod limits;
pub(crate) mod names;
mod parse;
mod record;
mod region;
mod schema;
mod source;
mod surface;
mod surface_draft;
mod unvalidated;
mod validate;

use std::path::{Path, PathBuf};

pub use crate::model::FillRegion;
pub use crate::prepare::surface::BoxSide;
pub use crate::prepare::surface::leak::{Gap, Leak};
#[cfg(target_family = "wasm")]
pub use brought::bring;
pub use builder::SceneBuilder;
pub use compatibility::{EXCLUSIONS, Exclusion, Feature};
pub use config_path::{ConfigPath, PathStep};
pub(crate) use continuation::LastRun;
pub use diagnostic::{SceneError, SceneErrorKind};
pub use given::{GivenParticles, KeptParticles};
pub use inlet_draft::InletDraft;
pub(crate) use record::{with_limit, without_limit};
pub use schema::schema;
pub(crate) use schema::schema_value;
#[cfg(feature = "cli")]
pub(crate) use source::Source;
pub use surface_draft::SurfaceDraft;
pub use unvalidated::{
    Amount, Arrangement, Chain, Fill, InteractionDraft, Lattice, Model, SpeciesDraft, Surface, SurfaceFill,
};
pub(crate) use validate::measurement_times;

use crate::model::Scene;

impl Scene {
    /// Reads a scene from a file.
    ///
    /// # Errors
    /// [`SceneError`] if the file cannot be read, or for the first error in its content.
    pub fn from_file(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        Self::from_file_with(path, &[])
    }

    /// Reads a scene from a file, with some of its values replaced.
    ///
    /// An override is a dotted key and a value, such as `("seed", "5")`, `("interaction.0.restitution", "0.1")` or
    /// `("species.A.mass", "2")`. A key may contain indices or names of list entries. The value is TOML or a bare word.
    /// Keys that are not in the file are added.
    ///
    /// # Errors
    /// As for [`Scene::from_file`]. An error in an override shows the override instead of a line of the file.
    pub fn from_file_with(path: impl AsRef<Path>, overrides: &[(&str, &str)]) -> Result<Self, SceneError> {
        let path = path.as_ref();
        Self::from_toml_with(read_text(path)?, path, overrides)
    }

    /// Reads a scene from the text of a scene file.
    ///
    /// `name` is the path of the file. The path appears in messages and provides the default name of the scene. Paths
    /// in the text are relative to the folder of `name`.
    ///
    /// # Errors
    /// [`SceneError`] for the first error in the text; [`SceneError::others`] has the other errors.
    pub fn from_toml(text: impl Into<String>, name: impl AsRef<Path>) -> Result<Self, SceneError> {
        Self::from_toml_with(text, name, &[])
    }

    /// Reads a scene from the text of a scene file, with some of its values replaced as in [`Scene::from_file_with`].
    ///
    /// # Errors
    /// [`SceneError`] for the first error in the text; [`SceneError::others`] has the other errors.
    pub fn from_toml_with(
        text: impl Into<String>,
        name: impl AsRef<Path>,
        overrides: &[(&str, &str)],
    ) -> Result<Self, SceneError> {
        let needs_run = |path: &Path| Err(SceneErrorKind::NeedsRun { path: path.to_owned() });
        Self::from_toml_and_run(text.into(), name.as_ref(), overrides, None, &needs_run)
    }

    /// Reads a scene from a text. The particles may also come from a program (`given`) or from an earlier run (`open`).
    pub(crate) fn from_toml_and_run(
        text: String,
        path: &Path,
        overrides: &[(&str, &str)],
        given: Option<&GivenParticles>,
        open: &dyn Fn(&Path) -> Result<LastRun, SceneErrorKind>,
    ) -> Result<Self, SceneError> {
        let source = source::Source::new(&path.to_string_lossy(), text, overrides);
        let file = source.read()?;
        let stem: String = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        // The name of the scene is also the name of the run folder.
        let plain: String =
            stem.chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' }).take(100).collect();
        let name = if plain.is_empty() { "scene" } else { &plain };
        let directory = path.parent().unwrap_or(Path::new(""));
        let parts = parse::parts(file, name, directory, given);
        Self::of_builder(parts, open).map_err(|error| {
            // Particles passed by a program are not in the text, so an error in them has no line.
            let is_in_text = given.is_none_or(|given| !error.config_path().is_in(&given.name));
            if is_in_text { source.located(error) } else { error }
        })
    }

    fn of_builder(
        parts: Result<SceneBuilder, SceneError>,
        open: &dyn Fn(&Path) -> Result<LastRun, SceneErrorKind>,
    ) -> Result<Self, SceneError> {
        let builder = parts?;
        match &builder.start {
            None => builder.build(),
            Some(start) => builder.continued(start, open),
        }
    }

    pub(crate) fn check_keys(text: &str, name: &Path, overrides: &[(&str, &str)]) -> Result<(), SceneError> {
        source::Source::new(&name.to_string_lossy(), text.to_owned(), overrides).read().map(|_| ())
    }

    /// Tables of a scene file that may contain paths of files or runs.
    pub(crate) const TABLES_WITH_INPUTS: [&str; 4] = ["file", "output", "start", "surface"];

    pub(crate) fn inputs_named(
        text: &str,
        name: &Path,
        overrides: &[(&str, &str)],
    ) -> Result<Vec<(PathBuf, NamedInput)>, SceneError> {
        let file = source::Source::new(&name.to_string_lossy(), text.to_owned(), overrides).read()?;
        let directory = name.parent().unwrap_or(Path::new(""));
        let meshes = file.surface.iter().flatten().filter_map(|surface| surface.path.as_ref());
        let counts = file.output.count.iter().filter_map(|count| count.path.as_ref());
        let files = file.file.iter().map(|file| &file.path).chain(meshes).chain(counts);
        let files = files.map(|path| (directory.join(path), NamedInput::File));
        let run = file.start.iter().map(|start| (directory.join(&start.from), NamedInput::Run));
        Ok(files.chain(run).collect())
    }

    /// Returns the names of the species in the text of a scene, in order.
    ///
    /// # Errors
    /// [`SceneError`] if the text is not a scene.
    pub fn species_named_in(text: &str, name: &Path, overrides: &[(&str, &str)]) -> Result<Vec<String>, SceneError> {
        let file = source::Source::new(&name.to_string_lossy(), text.to_owned(), overrides).read()?;
        Ok(file.species.into_iter().map(|species| species.name).collect())
    }

    /// Splits dotted keys into steps, and replaces names of list entries by indices.
    pub(crate) fn places(text: &str, set: &[(&str, &str)], keys: &[&str]) -> Vec<Vec<String>> {
        let source = source::Source::new("", text.to_owned(), set);
        keys.iter().map(|key| source.place(key)).collect()
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum NamedInput {
    File,
    Run,
}

pub(crate) fn read_text(path: &Path) -> Result<String, SceneError> {
    let bytes = std::fs::read(path).map_err(|source| {
        SceneError::new(ConfigPath::root(), SceneErrorKind::Unreadable { path: path.to_owned(), source })
    })?;
    String::from_utf8(bytes).map_err(|error| {
        let offset = error.utf8_error().valid_up_to();
        // The text only has to show the line of the error.
        let text = String::from_utf8_lossy(error.as_bytes()).into_owned();
        SceneError::new(ConfigPath::root(), SceneErrorKind::NotText { offset }).in_source(
            &path.to_string_lossy(),
            std::sync::Arc::new(text),
            offset..offset,
        )
    })
}

//! The record of a scene: its file with all overrides applied.

use std::path::Path;

use serde::Deserialize;
use toml::de::Deserializer;
use toml::{Table, Value};

use crate::model::input_file::word;
use crate::model::{Scene, Until};
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, SceneErrorKind};
use crate::scene::given::KeptParticles;
use crate::scene::read_text;
use crate::scene::source::Source;

const HEADER: &str = "\
# The scene of this run, with the values of the command line, absolute paths, and the checksums of its input files.
";

impl Scene {
    /// Returns TOML from which this scene can be read again in any folder.
    ///
    /// The scene was read from `path` with `overrides`. The record contains the overrides, the name and the limits of
    /// the scene. Relative paths of files and runs become absolute, and checksums are added. Comments are lost.
    ///
    /// # Errors
    /// The errors of [`Scene::from_file_with`], if the file has changed.
    pub fn record(&self, path: impl AsRef<Path>, overrides: &[(&str, &str)]) -> Result<String, SceneError> {
        let path = path.as_ref();
        self.record_of(read_text(path)?, path, overrides)
    }

    /// Like [`Self::record`], but takes the scene from `text` instead of reading the file at `path`.
    ///
    /// # Errors
    /// The errors of [`Scene::from_toml_with`], if `text` is not the text of this scene.
    pub fn record_of(&self, text: String, path: &Path, overrides: &[(&str, &str)]) -> Result<String, SceneError> {
        self.record_with(text, path, overrides, None)
    }

    /// Like [`Self::record_of`], but also stores the particles that a program passed to the scene.
    ///
    /// # Errors
    /// The errors of [`Self::record_of`]. [`SceneErrorKind::Particles`] for [`KeptParticles::InTables`] if the images
    /// of a sheared box are displaced, because tables cannot contain this displacement.
    pub fn record_with(
        &self,
        text: String,
        path: &Path,
        overrides: &[(&str, &str)],
        given: Option<KeptParticles<'_>>,
    ) -> Result<String, SceneError> {
        let source = Source::new(&path.to_string_lossy(), text, overrides);
        let failed = |message: String| SceneError::new(ConfigPath::root(), SceneErrorKind::Syntax { message });
        let tree = source.tree()?;
        let mut table = Table::deserialize(Deserializer::from(tree)).map_err(|error| failed(error.to_string()))?;
        table.insert("name".to_owned(), Value::String(self.name.clone()));
        record_limit(self.run.limit, &mut table);
        let directory = path.parent().unwrap_or(Path::new(""));
        for (index, file) in table.get_mut("file").and_then(Value::as_array_mut).into_iter().flatten().enumerate() {
            if let (Some(file), Some(input)) = (file.as_table_mut(), self.inputs.get(index)) {
                file.insert("checksum".to_owned(), Value::String(input.checksum.clone()));
            }
            if let Some(Value::String(name)) = file.get_mut("path") {
                make_absolute(name, directory);
            }
        }
        let [mut surfaces, mut counts] = [Vec::new(), Vec::new()];
        for (key, value) in table.iter_mut() {
            match key.as_str() {
                "surface" => surfaces = with_path(value),
                "output" => counts = value.get_mut("count").map(with_path).unwrap_or_default(),
                _ => {}
            }
        }
        let meshes: Vec<&mut Table> = surfaces.into_iter().chain(counts).collect();
        // In `inputs`, mesh files come after all other files.
        let first = self.inputs.len().saturating_sub(meshes.len());
        for (mesh, input) in meshes.into_iter().zip(&self.inputs[first..]) {
            mesh.insert("checksum".to_owned(), Value::String(input.checksum.clone()));
            if let Some(Value::String(name)) = mesh.get_mut("path") {
                make_absolute(name, directory);
            }
        }
        if let (Some(start), Some(run)) = (table.get_mut("start").and_then(Value::as_table_mut), &self.predecessor) {
            start.insert("checksum".to_owned(), Value::String(run.checkpoint.checksum.clone()));
            if let Some(Value::String(from)) = start.get_mut("from") {
                make_absolute(from, directory);
            }
        }
        let listed = given.map(|given| self.put_particles(given, &mut table)).transpose()?.unwrap_or_default();
        let text = toml::to_string(&table).map_err(|error| failed(error.to_string()))?;
        Ok(format!("{HEADER}{text}{listed}"))
    }

    /// Adds the particles to the table, or returns text with tables to be appended to the record.
    fn put_particles(&self, given: KeptParticles<'_>, table: &mut Table) -> Result<String, SceneError> {
        match given {
            KeptParticles::InFile(name, content) => {
                let pairs = [("path", name.to_owned()), ("checksum", word(content))];
                let file: Table =
                    pairs.map(|(key, value)| (key.to_owned(), Value::String(value))).into_iter().collect();
                let files = table.entry("file").or_insert_with(|| Value::Array(Vec::new()));
                if let Some(files) = files.as_array_mut() {
                    files.insert(0, Value::Table(file));
                }
                Ok(String::new())
            }
            KeptParticles::InTables(given) => {
                if self.displacement != 0.0 {
                    let problem = "the periodic images of a sheared box are displaced, which tables of particles \
                                   cannot describe: use a file of particles, as in the scene.toml of a run";
                    let kind = SceneErrorKind::Particles { problem: problem.to_owned() };
                    return Err(SceneError::new(ConfigPath::root().key(given.name.clone()), kind));
                }
                given.put_box(self, table);
                let first = table.get("particle").and_then(Value::as_array).map_or(0, Vec::len);
                // TOML cannot extend a list that is written as `[]`, so empty lists are removed.
                table.retain(|key, value| {
                    !["particle", "bond"].contains(&key) || value.as_array().is_none_or(|it| !it.is_empty())
                });
                Ok(given.tables(self, first))
            }
        }
    }
}

fn with_path(list: &mut Value) -> Vec<&mut Table> {
    let tables = list.as_array_mut().into_iter().flatten().filter_map(Value::as_table_mut);
    tables.filter(|table| table.contains_key("path")).collect()
}

fn make_absolute(name: &mut String, directory: &Path) {
    if let Ok(absolute) = std::path::absolute(directory.join(&*name))
        && let Some(absolute) = absolute.to_str()
    {
        *name = absolute.to_owned();
    }
}

pub(crate) fn with_limit(record: &str, limit: Until) -> Result<String, toml::de::Error> {
    let mut table: Table = record.parse()?;
    record_limit(limit, &mut table);
    Ok(format!("{HEADER}{table}"))
}

/// Removes the limit from a record. Text that is not TOML is returned unchanged.
pub(crate) fn without_limit(record: &str) -> String {
    with_limit(record, Until::default()).unwrap_or_else(|_| record.to_owned())
}

fn record_limit(limit: Until, table: &mut Table) {
    let run = table.entry("run").or_insert_with(|| Value::Table(Table::new()));
    let Some(run) = run.as_table_mut() else { return };
    run.remove("until_time");
    run.remove("until_events");
    if let Some(time) = limit.time {
        run.insert("until_time".to_owned(), Value::Float(time));
    }
    if let Some(events) = limit.events {
        run.insert("until_events".to_owned(), Value::Integer(i64::try_from(events).unwrap_or(i64::MAX)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recorded_scene_rebuilds_identically() {
        let overrides = [("seed", "5"), ("species.sphere.diameter", "1.25")];
        let path = "configs/hard_sphere_fluid.toml";
        let mut scene = Scene::from_file_with(path, &overrides).unwrap();
        scene.run.limit = Until::time(0.1);
        let record = scene.record(path, &overrides).unwrap();
        let again = Scene::from_toml(record, "elsewhere/scene.toml").unwrap();
        assert_eq!(again, scene);
    }

    #[test]
    fn recorded_scene_finds_its_files_from_another_folder() {
        let directory = tempfile::tempdir().unwrap();
        let scene = directory.path().join("scene.toml");
        let text = "[[species]]\nname = \"A\"\nmass = 1.0\ndiameter = 1.0\n\
            [[interaction]]\nspecies = [\"A\", \"A\"]\npotential = \"hard-sphere\"\n\
            [space]\nsize = [9.0, 9.0, 9.0]\n[[file]]\npath = \"start.xyz\"\n[run]\nuntil_time = 1.0\n";
        std::fs::write(&scene, text).unwrap();
        let coordinates = "2\nProperties=species:S:1:pos:R:3:velo:R:3\nA 1 1 1 0 0 0\nA 4 4 4 1 0 0\n";
        std::fs::write(directory.path().join("start.xyz"), coordinates).unwrap();
        let built = Scene::from_file(&scene).unwrap();
        let record = built.record(&scene, &[]).unwrap();
        let again = Scene::from_toml(record.clone(), "elsewhere/scene.toml").unwrap();
        assert_eq!(again, built);
        // The record rejects the changed coordinate file. The original scene has no checksum and accepts the file.
        std::fs::write(directory.path().join("start.xyz"), coordinates.replace("4 4 4 1", "4 4 4 2")).unwrap();
        let error = Scene::from_toml(record, "elsewhere/scene.toml").unwrap_err().to_string();
        assert!(error.contains("start.xyz has changed: its checksum is crc32:"), "{error}");
        assert_ne!(Scene::from_file(&scene).unwrap().inputs, built.inputs);
        assert!(built.inputs[0].changed().unwrap().is_some());
        std::fs::write(directory.path().join("start.xyz"), coordinates).unwrap();
        assert_eq!(built.inputs[0].changed().unwrap(), None);
    }
}

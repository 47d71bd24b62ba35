//! Parses the regions in which particles are counted, and reads the files of their meshes.

use std::path::Path;

use super::surface::{MeshSource, mesh};
use super::vector;
use crate::model::{CountRegion, CountSpace, InputFile, Region};
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, missing, refuse};
use crate::scene::file::CountFile;

pub(super) fn parse_count(
    file: CountFile,
    at: &ConfigPath,
    directory: &Path,
) -> Result<(CountRegion, Option<InputFile>), SceneError> {
    let Some(path) = file.path else {
        let given = [
            ("weld", file.weld.is_some()),
            ("scale", file.scale.is_some()),
            ("rotation", file.rotation.is_some()),
            ("translation", file.translation.is_some()),
            ("checksum", file.checksum.is_some()),
        ];
        let of_mesh = given.into_iter().find(|(_, given)| *given);
        if let Some((key, _)) = of_mesh {
            return refuse(
                at.key(key),
                "given without a path",
                "`path`, the file of a mesh; a box does not have this key",
            );
        }
        let corner = |given: Option<[f64; 3]>, key| {
            given
                .map(vector)
                .ok_or_else(|| missing(at, key, "give it, or `path`, the file of a closed mesh".to_owned()))
        };
        let region = Region { lower: corner(file.lower, "lower")?, upper: corner(file.upper, "upper")? };
        return Ok((CountRegion { name: file.name, space: CountSpace::Box(region) }, None));
    };
    if let Some(key) = [("lower", file.lower), ("upper", file.upper)].iter().find_map(|(key, it)| it.map(|_| *key)) {
        return refuse(at.key(key), "given with a path", "either a box or the file of a mesh");
    }
    let source = MeshSource {
        path,
        closed: Some("whose inside is counted"),
        weld: file.weld,
        scale: file.scale,
        rotation: file.rotation,
        translation: file.translation,
        checksum: file.checksum.as_deref(),
    };
    let (mesh, input) = mesh(&source, at, directory)?;
    Ok((CountRegion { name: file.name, space: CountSpace::Mesh(mesh) }, Some(input)))
}

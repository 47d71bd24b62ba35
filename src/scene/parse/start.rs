use std::path::Path;

use crate::model::input_file::is_checksum;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, missing, refuse};
use crate::scene::file::{SceneFile, StartFile};
use crate::scene::given::GivenParticles;
use crate::scene::unvalidated::UnvalidatedStart;

pub(super) fn parse_start(
    start: &StartFile,
    file: &SceneFile,
    directory: &Path,
    given: Option<&GivenParticles>,
) -> Result<UnvalidatedStart, SceneError> {
    let tables = [
        ("particle", file.particle.len()),
        ("file", file.file.len()),
        ("chain", file.chain.len()),
        ("fill", file.fill.len()),
        ("mesh", file.mesh.len()),
        ("bond", file.bond.len()),
    ];
    if let Some((table, _)) = tables.iter().find(|(_, count)| *count > 0) {
        let expected = "none: particles and bonds come from the run in [start], so remove all [[particle]], [[file]], [[chain]], \
                        [[fill]], [[mesh]] and [[bond]]";
        return refuse(ConfigPath::entry(table, 0), "given", expected);
    }
    if let Some(given) = given {
        let expected = "none: the particles come from the run in [start], so remove either these particles or [start]";
        return refuse(ConfigPath::root().key(given.name.clone()), "given", expected);
    }
    if file.separate_overlaps.is_some() {
        let expected = "no separate_overlaps: the particles of the run given by [start] keep their positions";
        return refuse(ConfigPath::root().key("separate_overlaps"), "given", expected);
    }
    if file.start_time.is_some() {
        let expected = "no start_time: time continues from the run given by [start]";
        return refuse(ConfigPath::root().key("start_time"), "given", expected);
    }
    if file.interaction.is_empty() && !file.species.is_empty() {
        return Err(missing(
            &ConfigPath::root(),
            "interaction",
            "a scene with its own species needs interactions; leave out both to keep the species and interactions of the run",
        ));
    }
    let at = ConfigPath::root().key("start");
    if let Some(checksum) = start.checksum.as_ref().filter(|checksum| !is_checksum(checksum)) {
        return refuse(at.key("checksum"), format!("{checksum:?}"), "`crc32:` and eight hexadecimal digits");
    }
    Ok(UnvalidatedStart {
        from: directory.join(&start.from),
        checksum: start.checksum.clone(),
        has_seed: file.seed.is_some(),
        has_space: file.space.is_some(),
        has_lower: file.space.as_ref().is_some_and(|space| space.lower.is_some()),
        has_dynamics: file.dynamics.is_some(),
    })
}

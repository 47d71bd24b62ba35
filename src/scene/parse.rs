//! Converts the tables of a scene file to an unvalidated scene.

mod contact_law;
mod count;
pub(crate) mod diameter;
mod inlet;
pub(crate) mod interaction;
pub(crate) mod live;
mod materials;
pub(crate) mod motion;
pub(crate) mod particles;
pub(crate) mod plan;
pub(crate) mod space;
mod start;
pub(crate) mod surface;

use std::path::Path;

use materials::Materials;
use serde::Serialize;
use serde::de::DeserializeOwned;
use toml::Table;

use crate::Vector;
use crate::model::{AuditPlan, Format, InputFile, OutputPlan, Particle, Sleep, SpeciesId, TcRule, Units};
use crate::prepare::polydispersity::Class;
use crate::scene::builder::SceneBuilder;
use crate::scene::classes::{self, Distributed};
use crate::scene::config_path::ConfigPath;
use crate::scene::coordinates::{self, Frames};
use crate::scene::diagnostic::{SceneError, SceneErrorKind, missing, unknown};
use crate::scene::file::{
    AuditFile, DiameterFile, DynamicsFile, OutputFile, SceneFile, SleepFile, SpeciesFile, UnitsFile,
};
use crate::scene::given::GivenParticles;
pub(crate) use crate::scene::schema::words;
use crate::scene::unvalidated::{Group, Listed, SpeciesDraft, UnvalidatedBond};

/// Kinds of a table, such as `hard-sphere` for an interaction, and the keys that each kind allows.
type Kinds = [(&'static str, &'static [&'static str])];

/// Keys of a table with a kind, such as the potential of an interaction. The kind determines which keys are allowed.
pub(super) struct Keys<'k> {
    pub at: &'k ConfigPath,
    pub context: String,
    all: Vec<&'static str>,
    values: Table,
}

impl<'k> Keys<'k> {
    /// Finds the kind with the name `word`. Rejects unknown kinds, and keys that only other kinds allow.
    pub fn of_kind(
        kinds: &Kinds,
        what: &'static str,
        word: &str,
        at: &'k ConfigPath,
        entry: &impl Serialize,
    ) -> Result<(&'static str, Self), SceneError> {
        let Some(&(word, known)) = kinds.iter().find(|(known, _)| *known == word) else {
            return Err(unknown(&at.key(what), what, word, words(kinds)));
        };
        // This cannot fail, because the entry was read from TOML.
        let values = Table::try_from(entry).unwrap_or_default();
        let all = kinds.iter().flat_map(|(_, keys)| *keys).copied().collect();
        let keys = Self { at, context: format!("{what} = \"{word}\""), all, values };
        keys.allow(known)?;
        Ok((word, keys))
    }

    /// Rejects keys that this kind does not allow. The allowed keys are `known`.
    pub fn allow(&self, known: &[&'static str]) -> Result<(), SceneError> {
        match self.all.iter().copied().find(|key| self.has(key) && !known.contains(key)) {
            None => Ok(()),
            Some(key) => {
                let (context, known) = (self.context.clone(), known.to_vec());
                Err(SceneError::new(self.at.key(key), SceneErrorKind::Misplaced { key, context, known }))
            }
        }
    }

    pub fn has(&self, key: &str) -> bool {
        self.values.contains_key(key)
    }

    pub fn need<T: DeserializeOwned>(&self, key: &'static str) -> Result<T, SceneError> {
        let value = self.values.get(key).and_then(|value| value.clone().try_into().ok());
        value.ok_or_else(|| missing(self.at, key, format!("{} needs it", self.context)))
    }

    pub fn vector(&self, key: &'static str) -> Result<Vector, SceneError> {
        self.need(key).map(vector)
    }

    pub fn radii_of_ends(&self, word: &str) -> Result<[f64; 2], SceneError> {
        if word == "cone" { self.need("radii") } else { Ok([self.need("radius")?; 2]) }
    }
}

fn sleep(file: &SleepFile) -> Sleep {
    let SleepFile { interval, distance, wake_speed } = *file;
    Sleep { interval, distance, wake_speed }
}

fn units(file: &UnitsFile) -> Units {
    Units::new(&file.length, &file.mass, &file.time)
}

fn add_dynamics(dynamics: &DynamicsFile, scene: &mut SceneBuilder) -> Result<(), SceneError> {
    scene.gravity = vector(dynamics.gravity.unwrap_or_default());
    scene.parts.contact_time = dynamics.contact_time;
    scene.parts.tc_rule = tc_rule(dynamics)?;
    scene.parts.sleep = dynamics.sleep.as_ref().map(sleep);
    Ok(())
}

fn tc_rule(dynamics: &DynamicsFile) -> Result<TcRule, SceneError> {
    let Some(word) = &dynamics.tc_rule else { return Ok(TcRule::default()) };
    let at = ConfigPath::root().key("dynamics");
    if dynamics.contact_time.is_none() {
        return Err(missing(&at, "contact_time", "the TC model needs it"));
    }
    variant(&TC_RULES, "rule", word, &at.key("tc_rule")).copied()
}

/// Words for the rule of the TC model.
pub(crate) const TC_RULES: [(&str, TcRule); 2] =
    [("resting", TcRule::Resting), ("luding-mcnamara", TcRule::LudingMcNamara)];

fn variant<'t, T>(
    table: &'t [(&'static str, T)],
    what: &'static str,
    word: &str,
    at: &ConfigPath,
) -> Result<&'t T, SceneError> {
    let found = table.iter().find(|(known, _)| *known == word).map(|(_, variant)| variant);
    found.ok_or_else(|| unknown(at, what, word, words(table)))
}

fn vector(components: [f64; 3]) -> Vector {
    Vector::from(components)
}

fn parse_audit(file: &AuditFile) -> AuditPlan {
    AuditPlan { energy: file.energy, momentum: file.momentum, overlap: file.overlap }
}

/// Converts a scene file to an unvalidated scene. Relative paths are relative to `directory`.
pub(crate) fn parts(
    file: SceneFile,
    name: &str,
    directory: &Path,
    given: Option<&GivenParticles>,
) -> Result<SceneBuilder, SceneError> {
    let mut scene = SceneBuilder::new(file.name.as_deref().unwrap_or(name));
    scene.start = file.start.as_ref().map(|start| start::parse_start(start, &file, directory, given)).transpose()?;
    let (dynamics, space) = (file.dynamics.unwrap_or_default(), file.space.unwrap_or_default());
    scene.parts.seed = file.seed.unwrap_or(scene.parts.seed);
    scene.parts.start_time = file.start_time.unwrap_or(0.0);
    scene.parts.allow_invalid_start = file.allow_invalid_start;
    scene.parts.separate_overlaps = file.separate_overlaps;
    scene.parts.units = file.units.as_ref().map_or_else(Units::default, units);
    add_dynamics(&dynamics, &mut scene)?;
    scene.parts.live = live::parse_live(file.description, file.live)?;
    scene.parts.audit = parse_audit(&file.audit);
    let materials = Materials::parse(file.material, &file.species)?;
    space::parse_space(&space, &materials, &mut scene)?;
    let distributed = add_species(file.species, &mut scene)?;
    for (index, file) in file.interaction.into_iter().enumerate() {
        let at = ConfigPath::entry("interaction", index);
        scene.interactions.push(interaction::parse_interaction(file, &materials, &at)?);
    }
    for particle in file.particle {
        let [position, velocity, spin] = [particle.position, particle.velocity, particle.spin].map(vector);
        let own =
            Particle { diameter: particle.diameter, ..Particle::new(SpeciesId(0), position, velocity).spin(spin) };
        scene.push("particle", Group::Listed(Listed::one(&particle.species, own)));
    }
    // A coordinate file may give the box only if there is no fill.
    let frames = Frames { given, files: &file.file, directory, space: &space, may_give_box: file.fill.is_empty() };
    let sizes = coordinates::add(&frames, &mut scene)?;
    for (index, chain) in file.chain.into_iter().enumerate() {
        scene.push("chain", Group::Chain(particles::parse_chain(chain, &ConfigPath::entry("chain", index))?));
    }
    for (index, fill) in file.fill.into_iter().enumerate() {
        let at = ConfigPath::entry("fill", index);
        let fill = particles::parse_fill(fill, &at, scene.size.is_some())?;
        scene.push("fill", Group::Fill(fill));
    }
    for (index, surface) in file.mesh.into_iter().enumerate() {
        scene.push("mesh", Group::Surface(particles::parse_surface(surface, &ConfigPath::entry("mesh", index))?));
    }
    scene.has_surfaces = file.surface.is_some();
    for (index, surface) in file.surface.into_iter().flatten().enumerate() {
        let (surface, input) = surface::parse_surface(surface, &materials, index, directory)?;
        scene.surfaces.push(surface);
        scene.parts.inputs.extend(input);
    }
    materials.check_use()?;
    let inlets = file.inlet.into_iter().enumerate().map(|(index, inlet)| inlet::parse_inlet(inlet, index));
    scene.inlets = inlets.collect::<Result<_, _>>()?;
    for (index, bond) in file.bond.into_iter().enumerate() {
        let at = ConfigPath::entry("bond", index);
        scene.bonds.push(UnvalidatedBond { pair: bond.particles, interaction: bond.interaction, at });
    }
    scene.parts.run = plan::parse_run(file.run, file.stage)?;
    scene.parts.measure = file.measure.into();
    scene.parts.exchange = file.exchange.map(plan::parse_exchange).transpose()?;
    let inputs;
    (scene.parts.output, inputs) = parse_output(file.output, directory)?;
    scene.parts.inputs.extend(inputs);
    classes::expand(&mut scene, &distributed)?;
    sizes.iter().try_for_each(|sizes| sizes.agree(&scene))?;
    sizes.iter().for_each(|sizes| sizes.set_velocities(&mut scene));
    Ok(scene)
}

/// Adds the species. Returns the size classes of those whose diameters have a distribution.
fn add_species(files: Vec<SpeciesFile>, scene: &mut SceneBuilder) -> Result<Vec<Distributed>, SceneError> {
    let mut distributed = Vec::new();
    for (index, species) in files.into_iter().enumerate() {
        let (draft, classes) = parse_species(species, &ConfigPath::entry("species", index))?;
        distributed.extend(classes.map(|classes| Distributed { index, name: draft.name.clone(), classes }));
        scene.species.push(draft);
    }
    Ok(distributed)
}

/// Parses `[output]`. Also returns the mesh files of the regions in which particles are counted.
fn parse_output(output: OutputFile, directory: &Path) -> Result<(OutputPlan, Vec<InputFile>), SceneError> {
    let format = |(index, word): (usize, &String)| {
        let at = ConfigPath::root().key("output").key("formats").index(index);
        let found = Format::ALL.into_iter().find(|format| format.name() == word);
        found.ok_or_else(|| unknown(&at, "format", word, Format::ALL.map(Format::name)))
    };
    let (mut regions, mut inputs) = (Vec::new(), Vec::new());
    for (index, count) in output.count.into_iter().enumerate() {
        let at = ConfigPath::root().key("output").key("count").index(index);
        let (region, input) = count::parse_count(count, &at, directory)?;
        regions.push(region);
        inputs.extend(input);
    }
    let plan = OutputPlan {
        thermo_interval: output.thermo_interval,
        frame_interval: output.frame_interval,
        regions,
        has_contacts: output.contacts,
        has_event_log: output.events,
        formats: output.formats.iter().enumerate().map(format).collect::<Result<_, _>>()?,
    };
    Ok((plan, inputs))
}

/// Parses a species. Also returns the size classes if the diameter has a distribution.
fn parse_species(species: SpeciesFile, at: &ConfigPath) -> Result<(SpeciesDraft, Option<Vec<Class>>), SceneError> {
    let SpeciesFile {
        name,
        diameter,
        diameters,
        mass,
        masses,
        is_static,
        acceleration,
        moment_of_inertia,
        material: _,
    } = species;
    let is_individual = diameters.is_some();
    let individual = diameter::parse_individual(diameters, masses, &diameter, at)?;
    let (diameter, classes) = match diameter {
        DiameterFile::Number(diameter) => (diameter, None),
        DiameterFile::Distribution(_) if is_individual => {
            let distribution = individual.as_ref().and_then(|individual| individual.distribution.as_ref());
            (distribution.map_or(0.0, |distribution| distribution.mean_of(|diameter| diameter)), None)
        }
        // The classes replace this species, so its own diameter is never used.
        DiameterFile::Distribution(file) => (0.0, Some(diameter::parse_classes(file, &at.key("diameter"))?)),
    };
    let acceleration = acceleration.map(vector);
    let draft = SpeciesDraft { name, mass, diameter, is_static, acceleration, moment_of_inertia, individual };
    draft.check_mass(at)?;
    Ok((draft, classes))
}

//! Particles that a program passes to a scene.

use std::collections::HashMap;

use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use crate::Vector;
use crate::model::space::{AXES, Boundary, Space};
use crate::model::{Scene, Species, SpeciesId};
use crate::trajectory::Frame;
use crate::trajectory::extended_xyz::{WriteError, write_frame};
use crate::trajectory::frame::FrameParticle;

/// Particles that a program passes to a scene, like the particles of a `[[file]]`. Their ids are after the ids of
/// single particles and before the ids of files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct GivenParticles {
    /// Name of the particles in error messages.
    pub name: String,
    /// The particles, their bonds and their box.
    pub frame: Frame,
    /// Whether the frame has a box, which the scene uses if it has no size.
    pub has_box: bool,
    /// Whether the frame has radii. They must equal the radii of the species, unless the species has individual
    /// diameters.
    pub has_radii: bool,
    /// Whether the positions have only x and y. The z axis must then be flat.
    pub is_plane: bool,
    /// Name of the interaction of all bonds; `None` if the frame names the interactions.
    pub bond: Option<String>,
}

/// How the record of a scene stores particles from a program.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub enum KeptParticles<'a> {
    /// The particles are in a file with this name and content, next to the record.
    InFile(&'a str, &'a [u8]),
    /// The particles are tables in the record.
    InTables(&'a GivenParticles),
}

impl GivenParticles {
    /// Uses the particles and bonds of a frame, but not the box and the radii.
    #[must_use]
    pub fn new(name: &str, frame: Frame) -> Self {
        Self { name: name.to_owned(), frame, has_box: false, has_radii: false, is_plane: false, bond: None }
    }

    /// Content of an extended XYZ file with the same particles, bit for bit.
    ///
    /// # Errors
    /// [`WriteError`] if the scene was not made from these particles.
    pub fn file_for(&self, scene: &Scene) -> Result<Vec<u8>, WriteError> {
        let known: HashMap<&str, u32> =
            scene.species.iter().zip(0..).map(|(species, number)| (species.name.as_str(), number)).collect();
        // Unused species may be missing from the scene.
        let numbers: Vec<u32> =
            self.frame.species.iter().map(|it| known.get(it.name.as_str()).copied().unwrap_or(u32::MAX)).collect();
        let in_scene = |particle: &FrameParticle| {
            let number = numbers.get(particle.species.0 as usize).copied().unwrap_or(u32::MAX);
            let of_species = |species: &Species| {
                if species.individual.is_some() { particle.radius } else { 0.5 * species.diameter }
            };
            let radius = scene.species.get(number as usize).map_or(0.0, of_species);
            let position = self.placed(particle.position, &scene.space);
            FrameParticle { species: SpeciesId(number), position, radius, ..*particle }
        };
        let Frame { bonds, bond_names, bond_kinds, images, particles, .. } = &self.frame;
        let (bond_names, bond_kinds) = match &self.bond {
            Some(name) if !bonds.is_empty() => (vec![name.clone()], vec![0; bonds.len()]),
            _ => (bond_names.clone(), bond_kinds.clone()),
        };
        let frame = Frame {
            particles: particles.iter().map(in_scene).collect(),
            bonds: bonds.clone(),
            bond_names,
            bond_kinds,
            images: images.clone(),
            ..Frame::without_particles(scene)
        };
        let mut content = Vec::with_capacity(128 * frame.particles.len());
        write_frame(&mut content, &frame)?;
        Ok(content)
    }

    /// Position of a particle in a scene. Without a z coordinate, z is the coordinate of the flat axis.
    pub(super) fn placed(&self, position: Vector, space: &Space) -> Vector {
        if self.is_plane { Vector::new(position.x, position.y, space.lower.z) } else { position }
    }

    /// Returns TOML with a table for each particle and each bond. `first` is the id of the first particle.
    pub(super) fn tables(&self, scene: &Scene, first: usize) -> String {
        let frame = &self.frame;
        let name = |number: usize| frame.species.get(number).map_or("", |species| species.name.as_str());
        let mut text = String::with_capacity(160 * frame.particles.len());
        let is_individual = |number: usize| {
            let named = scene.species.iter().find(|species| species.name == name(number));
            named.is_some_and(|species| species.individual.is_some())
        };
        for FrameParticle { species, position, velocity, radius, .. } in &frame.particles {
            let position = self.placed(*position, &scene.space);
            let (position, velocity) = (position.as_slice(), velocity.as_slice());
            let is_sized = is_individual(species.0 as usize);
            let species = Value::from(name(species.0 as usize));
            text += &format!("\n[[particle]]\nspecies = {species}\nposition = {position:?}\nvelocity = {velocity:?}\n");
            if is_sized {
                text += &format!("diameter = {:?}\n", 2.0 * radius);
            }
        }
        if frame.bonds.is_empty() {
            return text;
        }
        let places: HashMap<u32, usize> = frame.particles.iter().map(|it| it.id.0).zip(first..).collect();
        for (index, ends) in frame.bonds.iter().enumerate() {
            let [a, b] = ends.map(|id| places.get(&id.0).copied().unwrap_or_default());
            let kind = frame.bond_kinds.get(index).and_then(|kind| frame.bond_names.get(*kind as usize));
            let interaction = Value::from(self.bond.as_ref().or(kind).map_or("", String::as_str));
            text += &format!("\n[[bond]]\nparticles = [{a}, {b}]\ninteraction = {interaction}\n");
        }
        text
    }

    /// Adds the box passed by the program, if any, to the tables of a scene that has neither a size nor a fill.
    pub(super) fn put_box(&self, scene: &Scene, table: &mut Table) {
        let has_fill = table.get("fill").and_then(Value::as_array).is_some_and(|fills| !fills.is_empty());
        let space = table.entry("space").or_insert_with(|| Value::Table(Table::new()));
        let Some(space) = space.as_table_mut().filter(|space| !space.contains_key("size")) else { return };
        if has_fill || !self.has_box {
            return;
        }
        let vector = |vector: &Vector| Value::Array(vector.iter().copied().map(Value::Float).collect());
        space.insert("size".to_owned(), vector(&scene.space.size));
        space.entry("lower").or_insert_with(|| vector(&scene.space.lower));
        for (axis, boundary) in AXES.into_iter().zip(&scene.space.boundary) {
            let word = if *boundary == Boundary::Flat { "flat" } else { "periodic" };
            space.entry(axis).or_insert_with(|| Value::from(word));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::{read_scene_text, read_scene_with};
    use crate::model::ParticleId;
    use crate::scene::ConfigPath;
    use crate::trajectory::frame::FrameSpecies;

    const BEADS: &str = r#"
name = "beads"
[[species]]
name = "floor"
static = true
diameter = 1.0
[[species]]
name = "bead"
mass = 2.0
diameter = 0.9
[[interaction]]
species = ["bead", "bead"]
potential = "hard-sphere"
[[interaction]]
species = ["bead", "floor"]
potential = "hard-sphere"
[[interaction]]
name = "link"
potential = "bond"
lambda = 1.5
[[particle]]
species = "floor"
position = [0.5, 0.5, 0.5]
[run]
until_time = 1.0
"#;

    /// Two beads. The second bead is outside a periodic side of the box.
    fn given() -> GivenParticles {
        let particle = |id: u32, x: f64| FrameParticle {
            id: ParticleId(id),
            species: SpeciesId(0),
            position: Vector::new(x, 2.1, 2.3),
            velocity: Vector::new(0.1, -0.2, 0.0),
            radius: 0.45,
        };
        let bead = FrameSpecies { name: "bead".to_owned(), is_static: false, mass: None };
        let frame = Frame {
            time: 3.0,
            lower: Vector::new(0.0, 0.0, -1.0),
            size: Vector::new(5.0, 6.0, 7.0),
            periodic: [true; 3],
            species: vec![bead],
            particles: vec![particle(7, 4.4), particle(3, 5.5)],
            bonds: vec![[ParticleId(7), ParticleId(3)]],
            ..Frame::default()
        };
        let bond = Some("link".to_owned());
        GivenParticles { has_box: true, has_radii: true, bond, ..GivenParticles::new("frame", frame) }
    }

    #[test]
    fn given_particles_are_recorded_in_a_file_or_in_tables() {
        let given = given();
        let scene = read_scene_with(BEADS, "beads.toml", &[], &given).unwrap();
        assert_eq!((scene.particles.len(), scene.space.size.x, scene.space.lower.z), (3, 5.0, -1.0));
        assert_eq!((scene.particles[2].position.x, scene.bonds[0].pair[0].0), (0.5, 1));
        let record = |kept| scene.record_with(BEADS.to_owned(), "beads.toml".as_ref(), &[], Some(kept)).unwrap();
        let listed = read_scene_text(record(KeptParticles::InTables(&given)), "elsewhere.toml", &[]).unwrap();
        assert_eq!(listed, scene);
        let folder = tempfile::tempdir().unwrap();
        let content = given.file_for(&scene).unwrap();
        let text = record(KeptParticles::InFile("start.xyz", &content));
        std::fs::write(folder.path().join("start.xyz"), content).unwrap();
        let of_file = read_scene_text(text, folder.path().join("scene.toml"), &[]).unwrap();
        assert_eq!(of_file.inputs.len(), 1);
        assert_eq!((of_file.particles, of_file.bonds, of_file.space), (scene.particles, scene.bonds, scene.space));
    }

    #[test]
    fn errors_in_given_particles_name_the_array_and_row() {
        let error = |given: &GivenParticles| read_scene_with(BEADS, "beads.toml", &[], given).unwrap_err();
        let mut wrong = given();
        wrong.frame.particles[1].velocity.y = f64::NAN;
        let found = error(&wrong);
        assert_eq!(*found.config_path(), ConfigPath::root().key("frame").key("velocities").index(1).index(1));
        assert_eq!(
            (found.line(), found.to_string().contains("NaN, expected a finite number")),
            (None, true),
            "{found}"
        );
        let mut wrong = given();
        wrong.frame.particles[1].species = SpeciesId(4);
        assert_eq!(error(&wrong).to_string(), "frame.species[1] is 4, expected a number below 1");
        let wrong = GivenParticles { bond: None, ..given() };
        assert!(
            error(&wrong).to_string().contains("set `bond` to the name of an [[interaction]]"),
            "{}",
            error(&wrong)
        );
        let mut wrong = given();
        wrong.frame.particles[0].radius = 0.5;
        assert!(error(&wrong).to_string().contains("a radius of 0.5, but the species `bead`"), "{}", error(&wrong));
        wrong = given();
        (wrong.frame.bond_names, wrong.frame.bond_kinds, wrong.bond) = (vec!["link".to_owned()], vec![1], None);
        assert!(error(&wrong).to_string().contains("has the kind 1, which has no name"), "{}", error(&wrong));
    }

    #[test]
    fn axes_that_the_scene_calls_flat_have_no_extent() {
        let mut plane = given();
        plane.is_plane = true;
        let flat = [("space.z", "flat"), ("space.lower", "[0.0, 0.0, 0.5]")];
        let scene = read_scene_with(BEADS, "beads.toml", &flat, &plane).unwrap();
        assert_eq!((scene.space.size.z, scene.particles[1].position.z), (0.0, 0.5));
        let error = read_scene_with(BEADS, "beads.toml", &[], &plane).unwrap_err().to_string();
        assert!(error.contains("positions have two columns, but z is not flat"), "{error}");
    }
}

//! Parses `[[material]]`: contact laws for pairs of materials. Species, walls and surfaces refer to materials by name.

use super::contact_law::contact_law;
use crate::model::ContactLaw;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, refuse};
use crate::scene::file::{MaterialFile, SpeciesFile};
use crate::scene::limits;
use crate::scene::unvalidated::Model;
use std::cell::RefCell;
use std::collections::BTreeSet;

#[derive(Debug, Default)]
pub(super) struct Materials {
    laws: Vec<([String; 2], ContactLaw)>,
    species: Vec<Made>,
    /// Materials of species, walls and surfaces.
    named: RefCell<BTreeSet<String>>,
}

#[derive(Debug)]
struct Made {
    species: String,
    /// The material of the species, if it has one.
    of: Option<String>,
    is_static: bool,
}

impl Materials {
    pub fn parse(files: Vec<MaterialFile>, species: &[SpeciesFile]) -> Result<Self, SceneError> {
        let mut materials = Self::default();
        for (index, file) in files.into_iter().enumerate() {
            let at = ConfigPath::entry("material", index);
            let [a, b] = &file.between;
            if materials.law(a, b).is_some() {
                return refuse(at.key("between"), format!("[\"{a}\", \"{b}\"] again"), "one entry for each pair");
            }
            let law = contact_law(file.restitution.as_ref(), file.tangential_restitution, file.friction, &at)?;
            limits::contact_law(&law, &at)?;
            materials.laws.push((file.between, law));
        }
        for (index, species) in species.iter().enumerate() {
            if let Some(material) = &species.material {
                materials.check_name(material, &ConfigPath::entry("species", index))?;
            }
            materials.species.push(Made {
                species: species.name.clone(),
                of: species.material.clone(),
                is_static: species.is_static,
            });
        }
        Ok(materials)
    }

    fn law(&self, a: &str, b: &str) -> Option<ContactLaw> {
        let is_it = |[first, second]: &[String; 2]| (first == a && second == b) || (first == b && second == a);
        self.laws.iter().find(|(between, _)| is_it(between)).map(|(_, law)| *law)
    }

    /// Rejects a material that occurs in no `[[material]]`.
    fn check_name(&self, name: &str, at: &ConfigPath) -> Result<(), SceneError> {
        self.named.borrow_mut().insert(name.to_owned());
        let mut known: Vec<&str> = self.laws.iter().flat_map(|(between, _)| between).map(String::as_str).collect();
        if known.contains(&name) {
            return Ok(());
        }
        known.sort_unstable();
        known.dedup();
        let expected = match known.as_slice() {
            [] => "a [[material]] with its contact law, such as `between = [\"glass\", \"glass\"]`".to_owned(),
            known => format!("a material in a [[material]]: {}", known.join(", ")),
        };
        refuse(at.key("material"), format!("\"{name}\""), expected)
    }

    /// Rejects a `[[material]]` that has no effect, because no species, wall or surface has one of its materials.
    pub fn check_use(&self) -> Result<(), SceneError> {
        let named = self.named.borrow();
        for (index, (between, _)) in self.laws.iter().enumerate() {
            let at = ConfigPath::entry("material", index).key("between");
            let of_species = |name: &String| self.species.iter().any(|made| made.of.as_ref() == Some(name));
            if !between.iter().any(of_species) && between.iter().all(|name| named.contains(name)) {
                let expected = "the material of at least one species: walls and surfaces do not meet each other";
                return refuse(at, format!("{between:?}"), expected);
            }
            if let Some(unused) = between.iter().find(|name| !named.contains(*name)) {
                let expected = "the `material` of a species, wall or surface in this scene";
                return refuse(at, format!("\"{unused}\""), expected);
            }
        }
        Ok(())
    }

    fn between(&self, a: &str, b: &str, what: &str, at: ConfigPath) -> Result<ContactLaw, SceneError> {
        let expected = || format!("a [[material]] with between = [\"{a}\", \"{b}\"]");
        self.law(a, b).map_or_else(|| refuse(at, what, expected()), Ok)
    }

    /// Returns the law of an interaction without keys of its own; `None` if one of the species has no material.
    pub fn of_pair(
        &self,
        species: &[String; 2],
        model: &Model,
        at: &ConfigPath,
    ) -> Result<Option<ContactLaw>, SceneError> {
        let of = |name: &String| self.species.iter().find(|made| made.species == *name)?.of.as_deref();
        let (Some(a), Some(b)) = (of(&species[0]), of(&species[1])) else { return Ok(None) };
        if !model.has_core() {
            return Ok(None);
        }
        self.between(a, b, "of two materials without a contact law", at.key("species")).map(Some)
    }

    /// Returns the law of a wall or surface of this material, which the given species touch. All species touch it if the
    /// list is empty.
    pub fn of_surface(&self, material: &str, touching: &[String], at: &ConfigPath) -> Result<ContactLaw, SceneError> {
        self.check_name(material, at)?;
        let at = at.key("material");
        let touches = |made: &&Made| !made.is_static && (touching.is_empty() || touching.contains(&made.species));
        let mut found: Option<(&Made, ContactLaw)> = None;
        for made in self.species.iter().filter(touches) {
            let Some(of) = &made.of else {
                let expected = format!("a `material` of the species {}, which touches it", made.species);
                return refuse(at, format!("\"{material}\""), expected);
            };
            let law = self.between(of, material, &format!("\"{material}\""), at.clone())?;
            match found {
                Some((first, other)) if other != law => {
                    let value =
                        format!("\"{material}\", with different laws for {} and {}", first.species, made.species);
                    return refuse(at, value, "one surface for each law, with `species`");
                }
                _ => found = Some((made, law)),
            }
        }
        let expected = "a species with a material in this scene";
        found.map_or_else(|| refuse(at, format!("\"{material}\""), expected), |(_, law)| Ok(law))
    }
}

#[cfg(test)]
mod tests {
    use crate::model::space::{Boundary, Face};
    use crate::model::{ContactLaw, Scene};

    fn scene(more: &str) -> Result<Scene, String> {
        let toml = format!(
            "
            space = {{ size = [9.0, 9.0, 9.0], z = {{ lower = {{ material = 'steel' }}, upper = 'open' }} }}
            species = [
                {{ name = 'bead', mass = 1.3, diameter = {{ distribution = 'uniform', lower = 0.9, upper = 1.1, classes = 2 }},
                   material = 'glass' }},
                {{ name = 'ball', mass = 1.0, diameter = 1.0, material = 'steel' }},
                {{ name = 'fixed', diameter = 1.0, static = true }},
            ]
            interaction = [
                {{ species = ['bead', 'bead'], potential = 'hard-sphere' }},
                {{ species = ['ball', 'bead'], potential = 'square-well', lambda = 1.5, well_depth = 1.0 }},
                {{ species = ['ball', 'ball'], potential = 'hard-sphere', friction = 0.7 }},
                {{ species = ['bead', 'fixed'], potential = 'hard-sphere' }},
                {{ species = ['ball', 'fixed'], potential = 'penetrable', height = 1.0 }},
            ]
            fill = [{{ species = 'bead', arrangement = 'random', count = 5 }}]
            run = {{ until_time = 1.0 }}
            surface = [{{ name = 'plate', shape = 'plane', point = [0.0, 0.0, 0.5], normal = [0.0, 0.0, 1.0],
                          species = ['ball'], material = 'glass' }}]
            {more}
            "
        );
        Scene::from_toml(toml, "materials.toml").map_err(|error| error.to_string())
    }

    const EQUAL: &str = "
        [[material]]
        between = ['glass', 'glass']
        restitution = 0.9
        [[material]]
        between = ['steel', 'glass']
        restitution = 0.8
        friction = 0.2
        [[material]]
        between = ['steel', 'steel']
        restitution = 0.8
        friction = 0.2
        ";

    #[test]
    fn laws_follow_from_the_materials_of_both_bodies() {
        let scene = scene(EQUAL).unwrap();
        let rough = ContactLaw::smooth(0.8).with_friction(0.2);
        let law = |a: &str, b: &str| {
            let index = |name: &str| scene.species().iter().position(|species| species.name == name).unwrap();
            scene.table().get(index(a), index(b)).map(|id| scene.interactions()[id.0 as usize].law)
        };
        assert_eq!(law("bead-1", "bead-2"), Some(ContactLaw::smooth(0.9)));
        assert_eq!(law("ball", "bead-2"), Some(rough));
        assert_eq!(law("ball", "ball"), Some(ContactLaw::smooth(1.0).with_friction(0.7)), "a law of its own");
        assert_eq!(law("bead-1", "fixed"), Some(ContactLaw::smooth(1.0)), "a species without a material");
        let Boundary::Bounded { lower: Face::Wall(wall), .. } = scene.space().boundary[2] else { panic!() };
        assert_eq!(wall, rough);
        assert_eq!(scene.surfaces()[0].law.contact(), Some(rough));
    }

    #[test]
    fn a_wall_has_one_law_for_all_species() {
        let error = scene(&EQUAL.replacen("friction = 0.2", "friction = 0.3", 1)).unwrap_err();
        assert!(error.contains("\"steel\", with different laws for bead and ball"), "{error}");
        assert!(error.contains("one surface for each law"), "{error}");
    }
}

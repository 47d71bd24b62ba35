//! Replaces a species with distributed diameters by classes. Each class is a species with one diameter.

use crate::prepare::polydispersity::{Class, mass_of, mean_diameter, spread};
use crate::scene::SceneBuilder;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, SceneErrorKind, refuse};
use crate::scene::limits::positive;
use crate::scene::unvalidated::{Fill, Group, InteractionDraft, LocatedGroup, Model, SpeciesDraft};
use crate::scene::validate::measure;

/// Maximum number of species. Each of the `256 * 257 / 2` pairs may have an interaction, numbered with 16 bits.
const MOST_SPECIES: usize = 256;

#[derive(Debug)]
pub(crate) struct Distributed {
    /// Index of the species in the scene file.
    pub index: usize,
    pub name: String,
    pub classes: Vec<Class>,
}

impl Distributed {
    fn class(&self, k: usize) -> String {
        format!("{}-{}", self.name, k + 1)
    }

    fn names(&self) -> Vec<String> {
        (0..self.classes.len()).map(|k| self.class(k)).collect()
    }
}

pub(crate) fn expand(scene: &mut SceneBuilder, distributed: &[Distributed]) -> Result<(), SceneError> {
    if distributed.is_empty() {
        return Ok(());
    }
    expand_species(scene, distributed)?;
    expand_interactions(scene, distributed)?;
    for LocatedGroup { at, group } in &mut scene.groups {
        let (name, what) = match group {
            Group::Fill(fill) => {
                expand_fill(fill, distributed, at)?;
                continue;
            }
            Group::Listed(listed) => {
                let is_distributed: Vec<bool> =
                    listed.names.iter().map(|it| named(distributed, it).is_some()).collect();
                let mut numbers = listed.particles.iter().map(|particle| particle.species.0 as usize);
                let Some(number) = numbers.find(|number| is_distributed.get(*number) == Some(&true)) else { continue };
                (&listed.names[number], "a particle has one diameter")
            }
            Group::Chain(chain) => (&chain.species, "the beads of a chain are equal"),
            Group::Surface(mesh) => (&mesh.species, "the spheres of a mesh are equal"),
        };
        if let Some(distributed) = named(distributed, name) {
            return Err(refused(distributed, what, &at.key("species")));
        }
    }
    for (index, inlet) in scene.inlets.iter_mut().enumerate() {
        expand_composition(&mut inlet.composition, distributed, &ConfigPath::entry("inlet", index))?;
    }
    for surface in &mut scene.surfaces {
        let names = std::mem::take(&mut surface.species);
        surface.species = names
            .into_iter()
            .flat_map(|name| match named(distributed, &name) {
                Some(of) => of.names(),
                None => vec![name],
            })
            .collect();
    }
    for measured in scene.parts.measure.requested() {
        if let Some(distributed) = measured.species.and_then(|name| named(distributed, name)) {
            return Err(refused(distributed, "one species is measured", &measure::position(&measured).key("species")));
        }
    }
    Ok(())
}

/// Replaces a species with distributed diameters in interactions by its classes, such as `grain-1` and `grain-2`.
pub(crate) fn expand_families(scene: &mut SceneBuilder) -> Result<(), SceneError> {
    let is_known = |name: &str| scene.species.iter().any(|species| species.name == name);
    let is_new = |names: &[Distributed], name: &str| named(names, name).is_none() && !is_known(name);
    let mut families: Vec<Distributed> = Vec::new();
    for name in scene.interactions.iter().filter_map(|draft| draft.species.as_ref()).flatten() {
        let class = |k: usize| scene.species.iter().find(|species| species.name == format!("{name}-{k}"));
        let classes = (1..).map_while(class).map(|species| Class { diameter: species.diameter, share: 0.0 });
        let classes: Vec<Class> = classes.collect();
        if !classes.is_empty() && is_new(&families, name) {
            families.push(Distributed { index: families.len(), name: name.clone(), classes });
        }
    }
    if families.is_empty() { Ok(()) } else { expand_interactions(scene, &families) }
}

fn named<'d>(distributed: &'d [Distributed], name: &str) -> Option<&'d Distributed> {
    distributed.iter().find(|candidate| candidate.name == name)
}

fn refused(distributed: &Distributed, what: &str, at: &ConfigPath) -> SceneError {
    let last = distributed.class(distributed.classes.len() - 1);
    let first = distributed.class(0);
    let expected =
        format!("a species with one diameter, because {what}: choose one of its classes, `{first}` to `{last}`");
    let value = format!("`{}`, which has a distribution of diameters", distributed.name);
    SceneError::new(at.clone(), SceneErrorKind::value(value, expected))
}

/// The given mass is the mass of a particle of the mean diameter.
fn expand_species(scene: &mut SceneBuilder, distributed: &[Distributed]) -> Result<(), SceneError> {
    let dimensions = scene.parts.space.dimensions();
    let mut species = Vec::new();
    for (index, draft) in std::mem::take(&mut scene.species).into_iter().enumerate() {
        let at = ConfigPath::entry("species", index);
        let Some(of) = distributed.iter().find(|it| it.index == index) else {
            species.push(draft);
            scene.origins.species.push(index);
            continue;
        };
        let Some(mass) = draft.mass else {
            return refuse(at.key("static"), "true", "false: a species with a distribution of diameters must move");
        };
        positive(mass, at.key("mass"))?;
        let mean = mean_diameter(&of.classes);
        for (k, class) in of.classes.iter().enumerate() {
            let mass = Some(mass_of(class, mean, mass, dimensions));
            species.push(SpeciesDraft { name: of.class(k), mass, diameter: class.diameter, ..draft.clone() });
            scene.origins.species.push(index);
        }
        if species.len() > MOST_SPECIES {
            return refuse(
                at.key("diameter"),
                species.len(),
                format!("at most {MOST_SPECIES} species, where each class counts as one"),
            );
        }
    }
    scene.species = species;
    Ok(())
}

fn expand_interactions(scene: &mut SceneBuilder, distributed: &[Distributed]) -> Result<(), SceneError> {
    let mut interactions = Vec::new();
    for (index, draft) in std::mem::take(&mut scene.interactions).into_iter().enumerate() {
        let parts = draft.species.as_ref().map(|species| species.each_ref().map(|name| named(distributed, name)));
        let (Some(species), Some(parts)) = (&draft.species, parts.filter(|parts| parts.iter().any(Option::is_some)))
        else {
            interactions.push(draft);
            scene.origins.interactions.push(index);
            continue;
        };
        check_diameter(&draft, &ConfigPath::entry("interaction", index))?;
        let names = |k: usize| parts[k].map_or_else(|| vec![species[k].clone()], Distributed::names);
        let is_alike = species[0] == species[1];
        let (first, second) = (names(0), names(1));
        // Only one expanded draft keeps the name, because names are unique. Bonds find this draft by its name.
        let mut name = draft.name.clone();
        for (k, a) in first.iter().enumerate() {
            for b in second.iter().skip(if is_alike { k } else { 0 }) {
                let pair = Some([a.clone(), b.clone()]);
                interactions.push(InteractionDraft { name: name.take(), species: pair, ..draft.clone() });
                scene.origins.interactions.push(index);
            }
        }
    }
    scene.interactions = interactions;
    Ok(())
}

/// Rejects an explicit contact distance for species with distributed diameters.
fn check_diameter(draft: &InteractionDraft, at: &ConfigPath) -> Result<(), SceneError> {
    let expected =
        "no lengths: with a distribution of diameters, they follow from the diameters of each pair of classes";
    let (key, value) = match (&draft.model, draft.diameter) {
        (_, Some(diameter)) => ("diameter", diameter.to_string()),
        (Model::Exact(_), None) => ("potential", "given by its radii".to_owned()),
        _ => return Ok(()),
    };
    refuse(at.key(key), value, expected)
}

fn expand_fill(fill: &mut Fill, distributed: &[Distributed], at: &ConfigPath) -> Result<(), SceneError> {
    expand_composition(&mut fill.composition, distributed, at)
}

fn expand_composition(
    given: &mut Vec<(String, f64)>,
    distributed: &[Distributed],
    at: &ConfigPath,
) -> Result<(), SceneError> {
    let mut composition = Vec::new();
    for (name, share) in std::mem::take(given) {
        let Some(of) = named(distributed, &name) else {
            composition.push((name, share));
            continue;
        };
        positive(share, at.key("composition").key(name))?;
        composition.extend(spread(of.classes.len()).map(|k| (of.class(k), share * of.classes[k].share)));
    }
    *given = composition;
    Ok(())
}

/// The index of each species and interaction in the scene file; empty if no species is replaced by classes.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Origins {
    species: Vec<usize>,
    interactions: Vec<usize>,
}

impl Origins {
    /// Replaces the indices in an error by the indices in the file.
    pub(crate) fn located(&self, error: SceneError) -> SceneError {
        error.moved(|at| at.entry_moved("species", &self.species).entry_moved("interaction", &self.interactions))
    }
}

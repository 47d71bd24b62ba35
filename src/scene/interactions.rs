//! The interaction of each pair of species.

use std::borrow::Cow;
use std::collections::HashMap;

use crate::base::numbers::id;
use crate::model::diameters::{Diameters, scaled_distance};
use crate::model::error::PotentialError;
use crate::model::scene::{kinds_of_bond, potential_for};
use crate::model::species_pairs::SpeciesPairs;
use crate::model::{Bond, Interaction, InteractionId, Particle, Potential, Species, SpeciesId};
use crate::prepare::packing::occupancy::Contacts;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, SceneErrorKind, refuse, unknown};
use crate::scene::limits::{above_one, contact_law, finite, positive, positive_if_given};
use crate::scene::names::{self, Taken};
use crate::scene::unvalidated::{InteractionDraft, Model};

/// Maximum number of steps of a stepped potential. More steps are probably a typing error.
pub(crate) const MOST_STEPS: usize = 10_000;

/// Maximum number of species and of interactions, which have 16-bit numbers. An `[[interaction]]` needs a number for
/// each of its contact distances.
pub(crate) const MOST_KINDS: usize = 1 << 16;

/// Interactions of a scene. An `[[interaction]]` becomes several interactions if its contact distances differ.
pub(crate) struct Interactions<'a> {
    drafts: &'a [InteractionDraft],
    pub species: &'a [Species],
    list: Vec<Interaction>,
    made: HashMap<(usize, u64), Option<InteractionId>>,
    /// Interaction of each pair of species, if any. `Some(None)` is the potential `none`.
    table: SpeciesPairs<Option<InteractionId>>,
}

impl<'a> Interactions<'a> {
    pub(crate) fn new(drafts: &'a [InteractionDraft], species: &'a [Species]) -> Result<Self, SceneError> {
        let table = SpeciesPairs::new(species.len());
        let mut these = Self { drafts, species, list: Vec::new(), made: HashMap::new(), table };
        let mut given_by: HashMap<[usize; 2], usize> = HashMap::new();
        let mut taken = Taken::default();
        for (index, draft) in drafts.iter().enumerate() {
            let at = ConfigPath::entry("interaction", index);
            check(draft, &at)?;
            if let Some(name) = &draft.name {
                names::word(name, &at.key("name"))?;
                taken.take(name, &at)?;
            }
            let Some(words) = &draft.species else { continue };
            let mut pair = [0; 2];
            for (k, word) in words.iter().enumerate() {
                pair[k] = species_named(species, word, &at.key("species").index(k))?.0 as usize;
            }
            pair.sort_unstable();
            if let Some(first) = given_by.insert(pair, index) {
                let name = format!("{} and {}", words[0], words[1]);
                let kind = SceneErrorKind::Duplicate { name, first: ConfigPath::entry("interaction", first) };
                return Err(SceneError::new(at.key("species"), kind));
            }
            these.enter(index, pair, &at)?;
        }
        Ok(these)
    }

    fn enter(&mut self, index: usize, pair: [usize; 2], at: &ConfigPath) -> Result<(), SceneError> {
        let [a, b] = pair;
        if self.species[a].is_static() && self.species[b].is_static() {
            let expected = "at least one species that moves: static particles never meet";
            return refuse(at.key("species"), "static", expected);
        }
        let id = self.make(index, a, b)?;
        if let Some(id) = id
            && self.list[id.0 as usize].potential.is_bond()
        {
            let expected = "a potential with a finite range; for bonds, give the interaction a name instead of species, \
                            and use the name in [[bond]] or [[chain]]";
            return refuse(at.key("potential"), "a bond", expected);
        }
        self.table.set(a, b, id);
        Ok(())
    }

    /// Returns the interaction of a pair of species. Pairs with the same contact distance share an interaction.
    fn make(&mut self, index: usize, a: usize, b: usize) -> Result<Option<InteractionId>, SceneError> {
        let draft = &self.drafts[index];
        let additive = 0.5 * (self.species[a].diameter + self.species[b].diameter);
        let diameter = draft.diameter.unwrap_or(additive);
        let key = if matches!(draft.model, Model::Exact(_)) { 0 } else { diameter.to_bits() };
        if let Some(&made) = self.made.get(&(index, key)) {
            return Ok(made);
        }
        let potential = draft.model.potential(diameter).map_err(|error| {
            let key = match error {
                PotentialError::Order { .. } if matches!(draft.model, Model::SteppedLennardJones { .. }) => "cutoff",
                _ => "potential",
            };
            SceneError::new(ConfigPath::entry("interaction", index).key(key), error)
        })?;
        if potential.is_some() && self.list.len() == MOST_KINDS {
            return refuse(
                ConfigPath::entry("interaction", index),
                "one interaction too many",
                format!("at most {MOST_KINDS}, where each contact distance of an [[interaction]] counts as one"),
            );
        }
        if draft.law.roughness.is_some() && potential.as_ref().is_some_and(|potential| potential.core().is_none()) {
            let expected = "a potential with a hard core: only bodies that touch are rough";
            let at = ConfigPath::entry("interaction", index);
            return refuse(at.key("potential"), "without a hard core in a rough interaction", expected);
        }
        let steps = potential.as_ref().map_or(0, |potential| potential.radii().len());
        // A stepped Lennard-Jones potential has an additional radius at its core.
        if steps > MOST_STEPS + 1 {
            let expected = format!("a number of radii from 1 to {}", MOST_STEPS + 1);
            let at = ConfigPath::entry("interaction", index).key("radii");
            return refuse(at, steps, expected);
        }
        let id = potential.map(|potential| {
            self.list.push(Interaction { potential, law: draft.law, name: draft.name.clone() });
            InteractionId(id(self.list.len() - 1))
        });
        self.made.insert((index, key), id);
        Ok(id)
    }

    /// Uses existing interactions and their table of species pairs.
    pub(crate) fn given(
        list: Vec<Interaction>,
        table: &SpeciesPairs<InteractionId>,
        species: &'a [Species],
    ) -> Result<Self, SceneError> {
        for (index, interaction) in list.iter().enumerate() {
            contact_law(&interaction.law, &ConfigPath::entry("interaction", index))?;
        }
        let is_in_list = table.iter().all(|(_, id)| (id.0 as usize) < list.len());
        if table.species() != species.len() || !is_in_list {
            let expected = format!("a table of {} species and {} interactions", species.len(), list.len());
            return refuse(
                ConfigPath::root().key("interaction"),
                "a table with a different number of species or interactions",
                expected,
            );
        }
        Ok(Self { drafts: &[], species, list, made: HashMap::new(), table: table.map(|id| Some(Some(id))) })
    }

    pub(crate) fn bond(
        &mut self,
        name: &str,
        a: SpeciesId,
        b: SpeciesId,
        at: &ConfigPath,
    ) -> Result<InteractionId, SceneError> {
        let Some(index) = self.drafts.iter().position(|draft| draft.name.as_deref() == Some(name)) else {
            let known = self.drafts.iter().filter_map(|draft| draft.name.as_deref());
            return Err(unknown(at, "interaction", name, known));
        };
        self.make(index, a.0 as usize, b.0 as usize)?.ok_or_else(|| {
            let expected = "an interaction with a potential";
            SceneError::new(at.clone(), SceneErrorKind::value(format!("`{name}`, which has no potential"), expected))
        })
    }

    pub(crate) fn has(&self, id: InteractionId) -> bool {
        (id.0 as usize) < self.list.len()
    }

    pub(crate) fn len(&self) -> usize {
        self.list.len()
    }

    pub(crate) fn pairs(&self) -> impl Iterator<Item = ([usize; 2], InteractionId)> + '_ {
        self.table.iter().filter_map(|(pair, id)| Some((pair, id?)))
    }

    pub(crate) fn get(&self, id: InteractionId) -> &Interaction {
        &self.list[id.0 as usize]
    }

    /// Returns the potential of a bond between its two particles.
    pub(crate) fn potential_of_bond(&self, bond: &Bond, particles: &[Particle]) -> Cow<'_, Potential> {
        let kinds = kinds_of_bond(bond, self.species, particles);
        potential_for(&self.get(bond.interaction).potential, self.species, kinds)
    }

    pub(crate) fn contacts(&self) -> Contacts {
        Contacts::of(self.table.map(|id| self.get(id?).potential.core()))
    }

    pub(crate) fn list(&self) -> &[Interaction] {
        &self.list
    }

    /// Returns the longest range of the interactions between species that can meet. `diameters` contains the range of
    /// diameters of each species.
    pub(crate) fn longest_range(&self, diameters: &[Diameters], can_meet: impl Fn(usize, usize) -> bool) -> f64 {
        let is_sized = self.species.iter().any(|species| species.individual.is_some());
        let range = |([a, b], id): ([usize; 2], Option<InteractionId>)| {
            let range = self.get(id?).potential.range();
            let of_species = 0.5 * (self.species[a].diameter + self.species[b].diameter);
            let of_pair = 0.5 * (diameters[a].largest + diameters[b].largest);
            Some(if is_sized { scaled_distance(range, of_species, of_pair) } else { range })
        };
        self.table.iter().filter(|([a, b], _)| can_meet(*a, *b)).filter_map(range).fold(0.0, f64::max)
    }

    /// Rejects a scene in which two species can meet without an interaction. `counts` are the particles of each
    /// species.
    pub(crate) fn check_complete(&self, counts: &[usize]) -> Result<(), SceneError> {
        let present: Vec<usize> = (0..counts.len()).filter(|&species| counts[species] > 0).collect();
        for (k, &a) in present.iter().enumerate() {
            for &b in &present[k..] {
                let (first, second) = (&self.species[a], &self.species[b]);
                let can_meet = (a != b || counts[a] > 1) && !(first.is_static() && second.is_static());
                if can_meet && self.table.get(a, b).is_none() {
                    let kind = SceneErrorKind::NoInteraction { first: first.name.clone(), second: second.name.clone() };
                    return Err(SceneError::new(ConfigPath::entry("species", a), kind));
                }
            }
        }
        Ok(())
    }

    pub(crate) fn finish(self) -> (Vec<Interaction>, SpeciesPairs<InteractionId>) {
        (self.list, self.table.map(|id| id))
    }
}

pub(crate) fn species_named(species: &[Species], name: &str, at: &ConfigPath) -> Result<SpeciesId, SceneError> {
    let found = species.iter().position(|candidate| candidate.name == name);
    let known = || species.iter().map(|candidate| candidate.name.as_str());
    found.map(|index| SpeciesId(id(index))).ok_or_else(|| unknown(at, "species", name, known()))
}

fn check(draft: &InteractionDraft, at: &ConfigPath) -> Result<(), SceneError> {
    contact_law(&draft.law, at)?;
    positive_if_given(draft.diameter, at.key("diameter"))?;
    match draft.model {
        Model::SquareWell { lambda, well_depth } => {
            above_one(lambda, at.key("lambda"))?;
            positive(well_depth, at.key("well_depth"))?;
        }
        Model::SquareShoulder { lambda, height } => {
            above_one(lambda, at.key("lambda"))?;
            positive(height, at.key("height"))?;
        }
        Model::Penetrable { height } => {
            finite(height, at.key("height"))?;
        }
        Model::Bond { lambda } => {
            above_one(lambda, at.key("lambda"))?;
        }
        Model::SteppedLennardJones { well_depth, cutoff, steps, core_energy } => {
            positive(well_depth, at.key("well_depth"))?;
            positive(cutoff, at.key("cutoff"))?;
            positive(core_energy, at.key("core_energy"))?;
            if !(1..=MOST_STEPS).contains(&steps) {
                let expected = format!("a number of steps from 1 to {MOST_STEPS}");
                return refuse(at.key("steps"), steps, expected);
            }
        }
        Model::None | Model::HardSphere | Model::Exact(_) => {}
    }
    Ok(())
}

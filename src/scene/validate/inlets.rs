//! Validates inlets.

use crate::Vector;
use crate::model::diameters::diameters_of_newcomers;
use crate::model::limits::MOST_PARTICLES;
use crate::model::space::{Boundary, Space};
use crate::model::{FillRegion, Inlet, Region, Scene, Species};
use crate::scene::builder::SceneBuilder;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, missing, refuse};
use crate::scene::filling::shares_of;
use crate::scene::inlet_draft::{InletDraft, RATE, Rate};
use crate::scene::limits::{finite, not_negative, on_flat_axes, positive};
use crate::scene::names::{self, Taken};
use crate::scene::region::region_of;
use crate::scene::validate::measure::{check_no_arrays, check_supported};

impl SceneBuilder {
    pub(in crate::scene) fn checked_inlets(
        &self,
        species: &[Species],
        space: &Space,
    ) -> Result<Vec<Inlet>, SceneError> {
        let first = self.parts.inlets.len();
        let drafted = self
            .inlets
            .iter()
            .zip(first..)
            .map(|(draft, index)| self.resolved_inlet(draft, index, species, space.dimensions()));
        let inlets = self.parts.inlets.iter().cloned().map(Ok).chain(drafted).collect::<Result<Vec<_>, _>>()?;
        let mut taken = Taken::default();
        for (index, inlet) in inlets.iter().enumerate() {
            let at = ConfigPath::entry("inlet", index);
            names::words(&inlet.name, &at.key("name"))?;
            taken.take(&inlet.name, &at)?;
            check_composition(inlet, species, &at)?;
            self.check_times(inlet, &at)?;
            on_flat_axes(&inlet.velocity, &Vector::zeros(), space, &at.key("velocity"))?;
            not_negative(inlet.temperature, at.key("temperature"))?;
            region_of(Some(inlet.region), space, &at)?;
            let equal = inlet.species().filter(|id| species[id.0 as usize].individual.is_none());
            let diameters = equal.map(|id| species[id.0 as usize].diameter);
            let individual = diameters_of_newcomers(species, inlet.species()).map(|(_, diameter)| diameter);
            let largest = diameters.chain(individual).fold(0.0, f64::max);
            if !has_room(&inlet.region, largest, space) {
                let expected = format!("one in which a particle of diameter {largest} has room");
                return refuse(at.key("region"), "too small", expected);
            }
        }
        Ok(inlets)
    }

    /// Replaces names of species by ids, a mass rate by a rate, and times since a stage by simulated times.
    fn resolved_inlet(
        &self,
        draft: &InletDraft,
        index: usize,
        species: &[Species],
        dimensions: usize,
    ) -> Result<Inlet, SceneError> {
        let at = ConfigPath::entry("inlet", index);
        refuse_keys_of_new_particles(draft, &at)?;
        let is_single = draft.rate.is_none() && !draft.recirculate.is_empty();
        let shares = if is_single { Vec::new() } else { shares_of(&draft.composition, species, &at, "an inlet")? };
        let total: f64 = shares.iter().map(|(_, share)| share).sum();
        let composition: Vec<_> = shares.iter().map(|(id, share)| (*id, share / total)).collect();
        let mean_mass: f64 =
            composition.iter().map(|(id, share)| share * mean_mass_of(&species[id.0 as usize], dimensions)).sum();
        let rate = match draft.rate {
            Some(Rate::Number(rate)) => rate,
            Some(Rate::Mass(rate)) => positive(rate, at.key("mass_rate"))? / mean_mass,
            None if is_single => 0.0,
            None => return Err(missing(&at, "rate", RATE)),
        };
        let begin = match &draft.stage {
            Some(stage) => Some(self.start_of_stage(stage, &at.key("stage"))?),
            None => None,
        };
        let since =
            |time: f64, key: &'static str| Ok::<_, SceneError>(begin.unwrap_or(0.0) + finite(time, at.key(key))?);
        let first = begin.unwrap_or(self.parts.start_time);
        Ok(Inlet {
            name: draft.name.clone(),
            composition,
            region: draft.region,
            rate,
            velocity: draft.velocity,
            temperature: draft.temperature,
            from: draft.from.map_or(Ok(first), |time| since(time, "from"))?,
            until: draft.until.map_or(Ok(f64::INFINITY), |time| since(time, "until"))?,
            count: draft.count,
            keep: draft.keep,
            recirculate: draft.recirculate.clone(),
        })
    }

    fn check_times(&self, inlet: &Inlet, at: &ConfigPath) -> Result<(), SceneError> {
        let Inlet { rate, from, until, count, keep, .. } = *inlet;
        if rate != 0.0 || inlet.recirculate.is_empty() {
            positive(rate, at.key("rate"))?;
        }
        let start = self.parts.start_time;
        if finite(from, at.key("from"))? < start {
            return refuse(at.key("from"), from, format!("at least {start}, the time at which the scene starts"));
        }
        if until.is_nan() || until < from {
            return refuse(at.key("until"), until, format!("at least {from}, the time of the first particle"));
        }
        for (key, number) in [("count", count), ("keep", keep)] {
            if number == Some(0) {
                return refuse(at.key(key), 0, "at least 1");
            }
        }
        let last = until.min(self.parts.run.latest_end(start).unwrap_or(f64::INFINITY));
        let are_too_many = last.is_finite() && (last - from) * rate > MOST_PARTICLES as f64;
        // Below the round-off of `from`, the interval would not advance time.
        if are_too_many || (inlet.has_new_particles() && from + 1.0 / rate <= from) {
            let expected = format!("a rate at which at most {MOST_PARTICLES} particles are due");
            return refuse(at.key("rate"), rate, expected);
        }
        if count.is_some_and(|count| count > MOST_PARTICLES) {
            return refuse(at.key("count"), count.unwrap_or(0), format!("at most {MOST_PARTICLES}"));
        }
        Ok(())
    }
}

/// Mean mass of the new particles of a species in a space of the given number of dimensions `[mass]`.
fn mean_mass_of(species: &Species, dimensions: usize) -> f64 {
    let distribution = species.individual.as_ref().and_then(|individual| individual.distribution.as_ref());
    distribution.map_or(species.mass, |it| it.mean_of(|diameter| species.own_mass(diameter, dimensions)))
}

/// Whether a particle of this diameter fits into a region. A box that fills a periodic axis has no sides along it.
pub(super) fn has_room(region: &FillRegion, diameter: f64, space: &Space) -> bool {
    let FillRegion::Box(Region { lower, upper }) = region else { return region.has_room(0.5 * diameter) };
    (0..3).all(|k| match space.boundary[k] {
        Boundary::Flat => true,
        Boundary::Periodic if upper[k] - lower[k] >= space.size[k] => true,
        // The corners are given in decimal digits.
        _ => upper[k] - lower[k] >= diameter * (1.0 - 1e-12),
    })
}

/// Rejects keys about new particles in an inlet at which particles only return.
fn refuse_keys_of_new_particles(draft: &InletDraft, at: &ConfigPath) -> Result<(), SceneError> {
    if draft.rate.is_some() || draft.recirculate.is_empty() {
        return Ok(());
    }
    let keys = [
        (if draft.composition.len() > 1 { "composition" } else { "species" }, !draft.composition.is_empty()),
        ("stage", draft.stage.is_some()),
        ("from", draft.from.is_some()),
        ("until", draft.until.is_some()),
        ("count", draft.count.is_some()),
    ];
    match keys.into_iter().find(|(_, is_given)| *is_given) {
        Some((key, _)) => refuse(at.key(key), "given without a rate", "a rate of new particles, or no such key"),
        None => Ok(()),
    }
}

fn check_composition(inlet: &Inlet, species: &[Species], at: &ConfigPath) -> Result<(), SceneError> {
    if !inlet.has_new_particles() && inlet.composition.is_empty() {
        return Ok(());
    }
    let key = at.key(if inlet.composition.len() > 1 { "composition" } else { "species" });
    if inlet.composition.is_empty() {
        return Err(missing(at, "species", "an inlet needs species or composition"));
    }
    for (id, share) in &inlet.composition {
        let Some(kind) = species.get(id.0 as usize) else {
            return refuse(key, id.0, format!("below {}, the number of species", species.len()));
        };
        positive(*share, key.clone())?;
        if kind.is_static() {
            return refuse(key, format!("\"{}\", which is static", kind.name), "a species that moves");
        }
        if kind.individual.as_ref().is_some_and(|individual| individual.distribution.is_none()) {
            let value = format!("`{}`, which has individual diameters", kind.name);
            return refuse(
                key,
                value,
                "a species whose `diameter` is a distribution, because the inlet draws each diameter from it",
            );
        }
    }
    let sum: f64 = inlet.composition.iter().map(|(_, share)| share).sum();
    if (sum - 1.0).abs() > 1e-9 {
        return refuse(key, format!("shares with the sum {sum}"), "shares with the sum 1");
    }
    Ok(())
}

/// Rejects instruments that need the same particles at all times.
pub(super) fn check_instruments(scene: &Scene) -> Result<(), SceneError> {
    if !scene.has_flow() {
        return Ok(());
    }
    check_no_arrays(scene, "the same particles in all frames")?;
    check_supported(
        scene,
        |kind| kind.any_number,
        |supported| format!("to be absent if particles enter or leave: such runs allow only {supported}"),
    )
}

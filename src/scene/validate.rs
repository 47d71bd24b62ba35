//! Validates the parts of an unvalidated scene, and makes a [`Scene`] of them.

mod exchange;
pub(crate) mod instruments;
mod measure;
mod parts;
pub(crate) mod plan;
pub(crate) mod start;

use std::collections::HashMap;

use crate::Vector;
use crate::model::space::{Boundary, Face, Space, displacement_within_period};
use crate::model::{AuditPlan, CountRegion, Interaction, InteractionId, Scene, Species, SpeciesPairs};
use crate::prepare::velocity::set_velocities;
use crate::scene::builder::SceneBuilder;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, SceneErrorKind};
use crate::scene::groups::Groups;
use crate::scene::interactions::{Interactions, MOST_KINDS};
use crate::scene::limits::{AXES, affordable_species, finite, finite_vector, on_flat_axes, positive, restitution};
use crate::scene::names;
use crate::scene::unvalidated::{Group, SurfaceFill};

impl SceneBuilder {
    /// Checks the parts and places the particles.
    ///
    /// # Errors
    /// [`SceneError`] with the first mistake: its kind, and the config path of the value.
    pub fn build(&self) -> Result<Scene, SceneError> {
        self.checked().map_err(|error| self.origins.located(error))
    }

    fn checked(&self) -> Result<Scene, SceneError> {
        self.check_header()?;
        let mut species = self.checked_species()?;
        let space = self.checked_space(&species)?;
        self.set_accelerations(&mut species, &space)?;
        let mut interactions = Interactions::new(&self.interactions, &species)?;
        let groups = Groups::place(self, &species, &space, &mut interactions)?;
        let counts = groups.counts(species.len());
        affordable_species(counts.iter().filter(|count| **count > 0).count())?;
        interactions.check_complete(&counts)?;
        start::check_ranges(&space, &species, &interactions, &groups)?;
        self.check_drive(&space, &species, &interactions, interactions.longest_range(|_, _| true))?;
        self.check_measure(&space, &species)?;
        self.check_displacement()?;
        // A flat x has no period, and nothing slides along it.
        let displacement =
            if self.displacement == 0.0 { 0.0 } else { displacement_within_period(self.displacement, space.size.x) };
        let contacts = interactions.contacts();
        if !self.allow_invalid_start {
            start::check_walls(&groups, &species, &space)?;
            start::check_bonds(&groups, &space, displacement, &interactions)?;
            start::check_overlaps(&groups, &contacts, &space, displacement)?;
        }
        let drawn = groups.drawn(self);
        let finished = interactions.finish();
        let mut scene = self.assembled(space, species, finished, groups, displacement);
        set_velocities(&drawn, &mut scene);
        plan::check_growth_fits(&scene)?;
        plan::settle_thermostats(&mut scene)?;
        self.check_equilibrium(&scene)?;
        instruments::check_measurable(&scene)?;
        Ok(scene)
    }

    /// The scene of parts that have been checked.
    pub(super) fn assembled(
        &self,
        space: Space,
        species: Vec<Species>,
        (interactions, table): (Vec<Interaction>, SpeciesPairs<InteractionId>),
        groups: Groups,
        displacement: f64,
    ) -> Scene {
        Scene {
            name: self.name.clone(),
            seed: self.seed,
            start_time: self.start_time,
            species,
            interactions,
            table,
            bonds: groups.bonds.into_iter().map(|(bond, _)| bond).collect(),
            particles: groups.particles,
            static_surfaces: groups.static_surfaces,
            wall_temperatures: space.of_walls(self.wall_temperatures),
            space,
            shear_rate: self.shear_rate,
            displacement,
            contact_time: self.contact_time,
            allow_invalid_start: self.allow_invalid_start,
            audit: self.audit,
            run: self.run.clone(),
            output: self.output.clone(),
            measure: self.measure.clone(),
            exchange: self.exchange.clone(),
            inputs: self.inputs.clone(),
            predecessor: None,
        }
    }

    /// Names besides those of the scene, the species and the regions.
    fn check_names(&self) -> Result<(), SceneError> {
        for (index, stage) in self.run.stages.iter().enumerate() {
            names::words(&stage.name, &ConfigPath::entry("stage", index).key("name"))?;
        }
        for placed in &self.groups {
            if let Group::Surface(SurfaceFill { name: Some(name), .. }) = &placed.group {
                names::words(name, &placed.at.key("name"))?;
            }
        }
        Ok(())
    }

    pub(super) fn check_displacement(&self) -> Result<(), SceneError> {
        finite(self.displacement, ConfigPath::root().key("space").key("shear_rate"))?;
        if self.displacement != 0.0 && self.shear_rate.is_none() {
            let why =
                format!("images of this start are displaced by {} along x, as in a sheared box", self.displacement);
            let kind = SceneErrorKind::Missing { key: "shear_rate", why };
            return Err(SceneError::new(ConfigPath::root().key("space"), kind));
        }
        Ok(())
    }

    pub(super) fn check_header(&self) -> Result<(), SceneError> {
        let is_good = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        if self.name.is_empty() || self.name.len() > 100 || !self.name.chars().all(is_good) {
            let expected = "up to 100 letters, digits, - and _: it becomes a folder";
            let kind = SceneErrorKind::value(format!("{:?}", self.name), expected);
            return Err(SceneError::new(ConfigPath::root().key("name"), kind));
        }
        finite(self.start_time, ConfigPath::root().key("start_time"))?;
        if let Some(time) = self.contact_time {
            positive(time, ConfigPath::root().key("dynamics").key("contact_time"))?;
        }
        let audit = ConfigPath::root().key("audit");
        let AuditPlan { energy, momentum, overlap } = self.audit;
        for (limit, key) in [(energy, "energy"), (momentum, "momentum"), (overlap, "overlap")] {
            if let Some(limit) = limit {
                positive(limit, audit.key(key))?;
            }
        }
        self.check_names()?;
        self.check_run()?;
        let output = ConfigPath::root().key("output");
        for (interval, key) in
            [(self.output.thermo_interval, "thermo_interval"), (self.output.frame_interval, "frame_interval")]
        {
            if let Some(interval) = interval {
                positive(interval, output.key(key))?;
            }
        }
        check_regions(&self.output.regions)?;
        self.check_exchange()
    }

    /// The species, with no acceleration yet.
    pub(super) fn checked_species(&self) -> Result<Vec<Species>, SceneError> {
        if self.species.is_empty() {
            let kind = SceneErrorKind::Missing { key: "species", why: "a scene needs at least one [[species]]".into() };
            return Err(SceneError::new(ConfigPath::root(), kind));
        }
        if self.species.len() > MOST_KINDS {
            let kind = SceneErrorKind::value(self.species.len(), format!("at most {MOST_KINDS} species"));
            return Err(SceneError::new(ConfigPath::entry("species", MOST_KINDS), kind));
        }
        let mut taken = HashMap::new();
        let mut species = Vec::with_capacity(self.species.len());
        for (index, draft) in self.species.iter().enumerate() {
            let at = ConfigPath::entry("species", index);
            names::word(&draft.name, &at.key("name"))?;
            if let Some(first) = taken.insert(&draft.name, index) {
                let kind =
                    SceneErrorKind::Duplicate { name: draft.name.clone(), first: ConfigPath::entry("species", first) };
                return Err(SceneError::new(at.key("name"), kind));
            }
            positive(draft.diameter, at.key("diameter"))?;
            let mass = draft.mass.map_or(Ok(f64::INFINITY), |mass| positive(mass, at.key("mass")))?;
            species.push(Species {
                name: draft.name.clone(),
                mass,
                diameter: draft.diameter,
                acceleration: Vector::zeros(),
            });
        }
        Ok(species)
    }

    pub(super) fn set_accelerations(&self, species: &mut [Species], space: &Space) -> Result<(), SceneError> {
        let zero = Vector::zeros();
        on_flat_axes(&self.gravity, &zero, space, &ConfigPath::root().key("dynamics").key("gravity"))?;
        for (index, (species, draft)) in species.iter_mut().zip(&self.species).enumerate() {
            let at = ConfigPath::entry("species", index).key("acceleration");
            let acceleration = draft.acceleration.unwrap_or(self.gravity);
            if !species.is_static() {
                on_flat_axes(&acceleration, &zero, space, &at)?;
                species.acceleration = acceleration;
            } else if draft.acceleration.is_some_and(|given| given != zero) {
                return Err(SceneError::new(at, SceneErrorKind::value("given", "none: a static species stays")));
            }
        }
        Ok(())
    }

    pub(super) fn checked_space(&self, species: &[Species]) -> Result<Space, SceneError> {
        let at = ConfigPath::root().key("space");
        finite_vector(&self.lower, &at.key("lower"))?;
        for (k, boundary) in self.boundary.iter().enumerate() {
            for temperature in self.wall_temperatures[k].into_iter().flatten() {
                positive(temperature, at.key(["x", "y", "z"][k]).key("temperature"))?;
            }
            if let Boundary::Bounded { lower, upper } = boundary {
                for face in [lower, upper] {
                    if let Face::Wall { restitution: value } = face {
                        restitution(*value, at.key(["x", "y", "z"][k]).key("restitution"))?;
                    }
                }
            }
        }
        let unsized_space = Space { lower: self.lower, size: Vector::zeros(), boundary: self.boundary };
        if unsized_space.dimensions() == 0 {
            let kind = SceneErrorKind::value("flat along every axis", "an axis along which particles can move");
            return Err(SceneError::new(at, kind));
        }
        let size = match self.size {
            Some(size) => size,
            None => self.derived_size(species, &unsized_space)?,
        };
        for k in 0..3 {
            let at = at.key("size").index(k);
            if self.boundary[k] != Boundary::Flat {
                positive(size[k], at)?;
            } else if size[k] != 0.0 {
                let kind = SceneErrorKind::value(size[k], format!("0 because {} is flat", AXES[k]));
                return Err(SceneError::new(at, kind));
            }
        }
        Ok(Space { size, ..unsized_space })
    }
}

/// Boxes with an inside, whose names can stand at the head of a column.
fn check_regions(regions: &[CountRegion]) -> Result<(), SceneError> {
    let mut taken = HashMap::new();
    for (index, CountRegion { name, region }) in regions.iter().enumerate() {
        let at = ConfigPath::root().key("output").key("count").index(index);
        names::words(name, &at.key("name"))?;
        if let Some(first) = taken.insert(name, index) {
            let first = ConfigPath::root().key("output").key("count").index(first);
            return Err(SceneError::new(at.key("name"), SceneErrorKind::Duplicate { name: name.clone(), first }));
        }
        finite_vector(&region.lower, &at.key("lower"))?;
        finite_vector(&region.upper, &at.key("upper"))?;
        if let Some(k) = (0..3).find(|&k| region.upper[k] < region.lower[k]) {
            let expected = format!("at least {}, the lower corner's", region.lower[k]);
            let kind = SceneErrorKind::value(region.upper[k], expected);
            return Err(SceneError::new(at.key("upper").index(k), kind));
        }
    }
    Ok(())
}

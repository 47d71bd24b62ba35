//! Validates the parts of a scene and creates a [`Scene`].

mod barostat;
pub(crate) mod diameters;
mod exchange;
mod inlets;
pub(crate) mod measure;
mod motions;
mod parts;
pub(crate) mod plan;
mod recirculation;
mod sleep;
pub(crate) mod start;
mod surfaces;
mod swap;
mod units;

pub(crate) use measure::measurement_times;

use crate::Vector;
use crate::engine::pairs::rows::bands;
use crate::model::space::{Boundary, Space, displacement_within_period};
use crate::model::{AuditPlan, CountRegion, CountSpace, Scene, SceneParts, Separated, Species};
use crate::prepare::velocity::set_velocities;
use crate::scene::builder::SceneBuilder;
use crate::scene::compatibility;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, missing, refuse};
use crate::scene::groups::Groups;
use crate::scene::interactions::{Interactions, MOST_KINDS};
use crate::scene::limits::{
    AXES, affordable_species, contact_law, finite, finite_vector, on_flat_axes, positive, positive_if_given,
};
use crate::scene::names::{self, Taken};
use crate::scene::unvalidated::{Group, SurfaceFill};
use crate::scene::validate::diameters::check_distribution;
use crate::scene::validate::start::Configuration;

impl SceneBuilder {
    /// Validates the parts and places the particles.
    ///
    /// # Errors
    /// [`SceneError`] for the first error.
    pub fn build(&self) -> Result<Scene, SceneError> {
        if let Some(at) = &self.unnumbered {
            let expected = "a place before that fill or surface, or a `count` in it: otherwise the ids of the particles are unknown";
            return refuse(at.clone(), "given after a fill or a surface with an unknown number of particles", expected);
        }
        self.checked().map_err(|error| self.origins.located(error))
    }

    fn checked(&self) -> Result<Scene, SceneError> {
        self.check_header()?;
        let mut species = self.checked_species()?;
        let space = self.checked_space(&species)?;
        self.set_accelerations(&mut species, &space)?;
        let mut interactions = Interactions::new(&self.interactions, &species)?;
        let surfaces = self.checked_surfaces(&species, &space)?;
        let groups = Groups::place(self, &species, (&space, &surfaces), &mut interactions)?;
        let inlets = self.checked_inlets(&species, &space)?;
        interactions.check_complete(&groups.counts(species.len(), &inlets))?;
        // A flat x axis has no period, so images cannot slide along it.
        let displacement = if self.parts.displacement == 0.0 {
            0.0
        } else {
            displacement_within_period(self.parts.displacement, space.size.x)
        };
        let mut start = Configuration { groups, interactions, space, displacement, surfaces, inlets };
        if !compatibility::is_rough(self, &start) {
            start.groups.forget_spins_of_files();
        }
        self.check_plan(&start)?;
        let separated = self.separate(&mut start)?;
        self.check_places(&start)?;
        let drawn = start.groups.drawn(self);
        let mut scene = self.assembled(start);
        scene.separated = separated;
        set_velocities(&drawn, &mut scene);
        self.settled(scene)
    }

    /// Checks that the box and the plan of the scene fit its particles and interactions.
    pub(super) fn check_plan(&self, start: &Configuration<'_>) -> Result<(), SceneError> {
        let species = start.interactions.species;
        let counts = start.groups.counts(species.len(), &start.inlets);
        let diameters = start.groups.ranges_with(species, &start.inlets);
        let occurring = counts.iter().zip(&diameters).filter(|(count, _)| **count > 0);
        let rows = occurring.map(|(_, range)| bands(range).len()).sum();
        // Sleeping grains have their own row in the tables.
        affordable_species(if self.parts.sleep.is_some() { 2 * rows } else { rows })?;
        start::check_ranges(start)?;
        surfaces::check_newcomers(start)?;
        sleep::check_sleep(&self.parts, species, &diameters)?;
        units::check_units(&self.parts.units)?;
        compatibility::check(self, start)?;
        recirculation::check_recirculation(start, &self.parts)?;
        self.parts.check_shear(&start.space, start.interactions.longest_range(&diameters, |_, _| true))?;
        self.parts.check_measure(&start.space, species)?;
        self.check_displacement()
    }

    /// Moves overlapping particles apart if the scene has `separate_overlaps`.
    pub(super) fn separate(&self, start: &mut Configuration<'_>) -> Result<Separated, SceneError> {
        let Some(limit) = self.parts.separate_overlaps else { return Ok(self.parts.separated) };
        let found = start::separate(start, limit)?;
        // If the particles come from a scene in which they were moved apart, there are no overlaps now.
        Ok(if found.overlaps > 0 { found } else { self.parts.separated })
    }

    pub(super) fn check_places(&self, start: &Configuration<'_>) -> Result<(), SceneError> {
        if self.parts.allow_invalid_start {
            return Ok(());
        }
        start::check_surfaces(&start.groups, start.interactions.species, &start.surfaces)?;
        start::check_bonds(start)?;
        start::check_overlaps(start)
    }

    /// Completes the gravity and the thermostats of the stages. Rejects a plan that does not fit the rest of the scene.
    pub(super) fn settled(&self, mut scene: Scene) -> Result<Scene, SceneError> {
        plan::check_start_time(&scene)?;
        plan::settle_gravity(&mut scene)?;
        plan::check_growth_fits(&scene)?;
        plan::settle_thermostats(&mut scene)?;
        barostat::check_barostats(&scene)?;
        swap::check_output(&scene)?;
        inlets::check_instruments(&scene)?;
        self.check_equilibrium(&scene)?;
        Ok(scene)
    }

    pub(super) fn assembled(&self, start: Configuration<'_>) -> Scene {
        let Configuration { groups, interactions, space, displacement, surfaces, inlets } = start;
        let species = interactions.species.to_vec();
        let (interactions, table) = interactions.finish();
        Scene::of_parts(SceneParts {
            species,
            interactions,
            table,
            bonds: groups.bonds.into_iter().map(|(bond, _)| bond).collect(),
            particles: groups.particles,
            static_surfaces: groups.static_surfaces,
            surfaces: surfaces.of_scene().to_vec(),
            inlets,
            wall_temperatures: space.of_walls(self.parts.wall_temperatures),
            space,
            displacement,
            ..self.parts.clone()
        })
    }

    fn check_names(&self) -> Result<(), SceneError> {
        for (index, stage) in self.parts.run.stages.iter().enumerate() {
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
        finite(self.parts.displacement, ConfigPath::root().key("space").key("shear_rate"))?;
        if self.parts.displacement != 0.0 && self.parts.shear_rate.is_none() {
            let why = format!(
                "the periodic images are displaced by {} along x, as in a sheared box",
                self.parts.displacement
            );
            return Err(missing(&ConfigPath::root().key("space"), "shear_rate", why));
        }
        Ok(())
    }

    pub(super) fn check_header(&self) -> Result<(), SceneError> {
        let is_good = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        if self.parts.name.is_empty() || self.parts.name.len() > 100 || !self.parts.name.chars().all(is_good) {
            let expected = "up to 100 letters, digits, - and _: it names a folder";
            return refuse(ConfigPath::root().key("name"), format!("{:?}", self.parts.name), expected);
        }
        finite(self.parts.start_time, ConfigPath::root().key("start_time"))?;
        positive_if_given(self.parts.separate_overlaps, ConfigPath::root().key("separate_overlaps"))?;
        positive_if_given(self.parts.contact_time, ConfigPath::root().key("dynamics").key("contact_time"))?;
        let audit = ConfigPath::root().key("audit");
        let AuditPlan { energy, momentum, overlap } = self.parts.audit;
        for (limit, key) in [(energy, "energy"), (momentum, "momentum"), (overlap, "overlap")] {
            positive_if_given(limit, audit.key(key))?;
        }
        self.check_names()?;
        self.parts.check_run()?;
        let output = ConfigPath::root().key("output");
        positive_if_given(self.parts.output.thermo_interval, output.key("thermo_interval"))?;
        positive_if_given(self.parts.output.frame_interval, output.key("frame_interval"))?;
        check_regions(&self.parts.output.regions)?;
        self.parts.check_exchange()
    }

    /// Validates the species. Their accelerations are set later.
    pub(super) fn checked_species(&self) -> Result<Vec<Species>, SceneError> {
        if self.species.is_empty() {
            return Err(missing(&ConfigPath::root(), "species", "a scene needs at least one [[species]]"));
        }
        if self.species.len() > MOST_KINDS {
            return refuse(
                ConfigPath::entry("species", MOST_KINDS),
                self.species.len(),
                format!("at most {MOST_KINDS} species"),
            );
        }
        let mut taken = Taken::default();
        let mut species = Vec::with_capacity(self.species.len());
        for (index, draft) in self.species.iter().enumerate() {
            let at = ConfigPath::entry("species", index);
            names::word(&draft.name, &at.key("name"))?;
            taken.take(&draft.name, &at)?;
            draft.check_mass(&at)?;
            positive(draft.diameter, at.key("diameter"))?;
            let mass = draft.mass.map_or(Ok(f64::INFINITY), |mass| positive(mass, at.key("mass")))?;
            positive_if_given(draft.moment_of_inertia, at.key("moment_of_inertia"))?;
            let uniform = Species::new(&draft.name, mass, draft.diameter);
            let individual = draft.individual.clone();
            if let Some(distribution) = individual.as_ref().and_then(|individual| individual.distribution.as_ref()) {
                check_distribution(distribution, &at.key("diameter"))?;
            }
            species.push(Species { moment_of_inertia: draft.moment_of_inertia, individual, ..uniform });
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
                return refuse(at, "given", "none: a static species does not move");
            }
        }
        Ok(())
    }

    pub(super) fn checked_space(&self, species: &[Species]) -> Result<Space, SceneError> {
        let at = ConfigPath::root().key("space");
        finite_vector(&self.parts.space.lower, &at.key("lower"))?;
        for (k, boundary) in self.parts.space.boundary.iter().enumerate() {
            for temperature in self.parts.wall_temperatures[k].into_iter().flatten() {
                positive(temperature, at.key(["x", "y", "z"][k]).key("temperature"))?;
            }
            for law in boundary.contact_laws().into_iter().flatten() {
                contact_law(&law, &at.key(["x", "y", "z"][k]))?;
            }
        }
        let unsized_space = &self.parts.space;
        if unsized_space.dimensions() == 0 {
            return refuse(at, "flat along every axis", "an axis along which particles can move");
        }
        let size = match self.size {
            Some(size) => size,
            None => self.derived_size(species, unsized_space)?,
        };
        for k in 0..3 {
            let at = at.key("size").index(k);
            if self.parts.space.boundary[k] != Boundary::Flat {
                if size[k] == 0.0 {
                    let expected = format!("a length above 0, or `{} = \"flat\"` in [space] for a flat axis", AXES[k]);
                    return refuse(at, size[k], expected);
                }
                positive(size[k], at)?;
            } else if size[k] != 0.0 {
                return refuse(at, size[k], format!("0 because {} is flat", AXES[k]));
            }
        }
        Ok(Space { size, ..*unsized_space })
    }
}

/// Requires that the corners of each box are in order, and that the names are unique and can be column headings.
fn check_regions(regions: &[CountRegion]) -> Result<(), SceneError> {
    let mut taken = Taken::default();
    for (index, CountRegion { name, space }) in regions.iter().enumerate() {
        let at = ConfigPath::root().key("output").key("count").index(index);
        names::words(name, &at.key("name"))?;
        taken.take(name, &at)?;
        let CountSpace::Box(region) = space else { continue };
        finite_vector(&region.lower, &at.key("lower"))?;
        finite_vector(&region.upper, &at.key("upper"))?;
        if let Some(k) = (0..3).find(|&k| region.upper[k] < region.lower[k]) {
            let expected = format!("at least {}, the value of the lower corner", region.lower[k]);
            return refuse(at.key("upper").index(k), region.upper[k], expected);
        }
    }
    Ok(())
}

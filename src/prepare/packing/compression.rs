//! Lubachevsky-Stillinger compression: small moving spheres grow to a dense random packing.
//!
//! B. D. Lubachevsky and F. H. Stillinger, J. Stat. Phys. 60, 561 (1990), [doi:10.1007/BF01025983](https://doi.org/10.1007/BF01025983).

use std::f64::consts::FRAC_1_SQRT_2;

use crate::Vector;
use crate::base::numbers::id;
use crate::engine::{Simulation, Until};
use crate::model::FillRegion;
use crate::model::random::{Purpose, Random};
use crate::model::scene::own_volume;
use crate::model::{
    ContactLaw, Growth, GrowthTarget, IndividualDiameters, Interaction, InteractionId, MassRule, Particle, Potential,
    Region, Scene, SceneParts, Species, SpeciesId, SpeciesPairs,
};
use crate::prepare::NoPlace;
use crate::prepare::packing::RandomFill;
use crate::prepare::packing::insertion::{insert, no_room};
use crate::prepare::packing::occupancy::{Contacts, Kind, Occupancy};
use crate::prepare::velocity::maxwell;

/// Packing fractions in one, two and three dimensions at which spheres start to grow.
const LOOSE: [f64; 3] = [0.4, 0.3, 0.2];

/// Packing fractions in one, two and three dimensions above which random insertion is not tried. In a large box, random
/// insertion jams at 0.75, 0.55 and 0.38, but a small box can be filled more densely.
const HOPELESS: [f64; 3] = [0.9, 0.65, 0.46];

/// Largest packing fraction of disordered equal spheres: 0.64 in large systems, and slightly more in small systems.
const RANDOM_CLOSE: f64 = 0.66;

/// Growth speeds of the mean diameter in thermal speeds, in the order of the attempts. Slower growth gives denser
/// packings, but very slow growth would crystallize equal spheres.
const SPEEDS: [f64; 4] = [0.03, 0.01, 0.003, 0.001];

/// Fraction of the target packing fraction up to which spheres grow faster, because the fluid relaxes quickly.
const FLUID: f64 = 0.8;

/// Growth speed below the fraction [`FLUID`] of the target, in thermal speeds.
const FAST: f64 = 0.1;

/// Compressibility factor of a jammed packing. The packing fraction is then within 0.3 % of the limit `phi_J`.
const JAMMED: f64 = 1000.0;

/// Above this compressibility factor, the limit `phi_J` can be estimated within [`TOLERANCE`].
const CLOSE: f64 = 60.0;

/// Maximum error factor of an estimate of `phi_J`.
const TOLERANCE: f64 = 1.01;

/// Slower growth raises the jamming fraction by less than this relative amount.
const GAIN: f64 = 0.06;

/// Number of events per particle between two measurements of temperature and pressure.
const STRETCH: u64 = 5;

/// Largest number of measurements during one growth, far more than needed.
const MOST_STRETCHES: u64 = 20_000;

/// Spheres grow beyond their target by this factor, so that rounding leaves no overlap in a box of 10^5 diameters.
const BEYOND: f64 = 1.0 + 1e-10;

/// Maximum number of attempts to insert small spheres at random. The diameters are halved after each failure.
const LOOSER: i32 = 6;

pub(crate) struct Compression<'a> {
    pub fill: &'a RandomFill<'a>,
    /// Packing fraction of the particles, from the diameters of their species.
    pub packing_fraction: f64,
}

impl Compression<'_> {
    /// Packing fraction computed from contact distances instead of the diameters of species.
    fn core_fraction(&self) -> f64 {
        let core = |kind: &Kind| self.fill.contacts.between(kind, kind);
        let volumes = self.fill.kinds.iter().map(|kind| own_volume(core(kind), self.fill.space.dimensions()));
        volumes.sum::<f64>() / self.fill.space.volume()
    }

    fn of_dimensions(&self, values: [f64; 3]) -> f64 {
        values[self.fill.space.dimensions().clamp(1, 3) - 1]
    }

    pub(crate) fn is_too_dense_to_insert(&self) -> bool {
        self.core_fraction() > self.of_dimensions(HOPELESS)
    }

    pub(crate) fn positions(&self) -> Result<Vec<Vector>, NoPlace> {
        self.check_room()?;
        let is_equal = self.fill.kinds.iter().all(|kind| Some(kind) == self.fill.kinds.first());
        let fraction = self.core_fraction();
        if is_equal && self.fill.space.dimensions() == 3 && fraction > RANDOM_CLOSE {
            return Err(self.jammed(self.packing_fraction / fraction * RANDOM_CLOSE));
        }
        let (start, factor) = self.loose()?;
        let mut densest = 0.0_f64;
        for speed in SPEEDS {
            match self.grown(&start, factor, speed) {
                Ok(positions) => return Ok(positions),
                Err(part) => densest = densest.max(part),
            }
            if densest * (1.0 + GAIN) < 1.0 {
                break;
            }
        }
        Err(self.jammed(self.packing_fraction * densest.min(1.0)))
    }

    fn jammed(&self, reached: f64) -> NoPlace {
        NoPlace::Jammed { wanted: self.packing_fraction, reached }
    }

    fn check_room(&self) -> Result<(), NoPlace> {
        let range = self.fill.contacts.largest();
        let periods = self.fill.space.periods();
        match (0..3).find(|&k| periods[k] < 2.0 * range) {
            None => Ok(()),
            Some(axis) => Err(NoPlace::SmallBox { axis, size: periods[axis], range }),
        }
    }

    /// Creates small hard spheres at a temperature of 1 for random insertion. Also returns the factor of the diameters.
    fn loose(&self) -> Result<(Scene, f64), NoPlace> {
        let mut random = Random::new(self.fill.seed, Purpose::Growth, self.fill.group);
        let region = FillRegion::Box(Region { lower: self.fill.space.lower, upper: self.fill.space.upper() });
        let share = self.of_dimensions(LOOSE) / self.core_fraction();
        let largest = libm::pow(share, 1.0 / self.fill.space.dimensions() as f64).min(FRAC_1_SQRT_2);
        let mut tried = None;
        for halvings in 0..LOOSER {
            let factor = largest * libm::scalbn(1.0, -halvings);
            let contacts = self.fill.contacts.scaled(factor);
            let mut occupancy = Occupancy::new(self.fill.space, &contacts, self.fill.kinds.len());
            // A periodic box has no sides to keep away from, so the radius is irrelevant.
            let sizes = self.fill.kinds.iter().map(|kind| (0.0, *kind));
            let positions = insert(sizes, &region, &mut occupancy, &mut random);
            if positions.len() == self.fill.kinds.len() {
                return Ok((self.scene(&positions, (&contacts, factor), &mut random)?, factor));
            }
            tried = Some(no_room(positions.len(), self.fill.kinds.len()));
        }
        Err(tried.unwrap_or_else(|| self.jammed(0.0)))
    }

    /// Creates a scene of hard spheres at a temperature of 1. The scene needs no validation: insertion leaves no
    /// overlaps, and [`Self::check_room`] has checked the size of the box.
    fn scene(
        &self,
        positions: &[Vector],
        (contacts, factor): (&Contacts, f64),
        random: &mut Random,
    ) -> Result<Scene, NoPlace> {
        let mut used: Vec<SpeciesId> = self.fill.kinds.iter().map(|kind| kind.species).collect();
        used.sort_unstable();
        used.dedup();
        let mut spheres = hard_spheres(&used, contacts)?;
        let of_fill = |species: &SpeciesId| &self.fill.species[species.0 as usize];
        if used.iter().any(|species| of_fill(species).individual.is_some()) {
            for (sphere, of_fill) in spheres.species.iter_mut().zip(used.iter().map(of_fill)) {
                // Contact distances scale with the diameters of the species.
                sphere.diameter = of_fill.diameter * factor;
                let individual = of_fill.individual.as_ref();
                sphere.individual =
                    individual.map(|_| IndividualDiameters { masses: MassRule::Constant, distribution: None });
            }
        }
        let particle = |(kind, position): (&Kind, &Vector)| {
            let species = SpeciesId(id(used.partition_point(|other| *other < kind.species)));
            let diameter = kind.diameter.map(|diameter| diameter * factor);
            Particle { diameter, ..Particle::new(species, *position, Vector::zeros()) }
        };
        let mut particles: Vec<Particle> = self.fill.kinds.iter().zip(positions).map(particle).collect();
        maxwell(&mut particles, &spheres.species, self.fill.space, 1.0, random);
        let (name, seed, space) = ("growth".to_owned(), self.fill.seed, self.fill.space.clone());
        Ok(Scene::of_parts(SceneParts { name, seed, space, particles, ..spheres }))
    }

    /// Grows the spheres of a scene to full size. On failure, returns the fraction of the target at which they jam.
    fn grown(&self, start: &Scene, factor: f64, speed: f64) -> Result<Vec<Vector>, f64> {
        let mut simulation = Simulation::without_plan(start.clone());
        let half_way = libm::pow(FLUID, 1.0 / self.fill.space.dimensions() as f64);
        self.grow_to(half_way, FAST.max(speed), factor, &mut simulation)?;
        simulation.end_growth();
        self.grow_to(BEYOND, speed, factor, &mut simulation)?;
        let positions = simulation.snapshot().positions;
        Ok(positions.into_iter().map(|position| self.fill.space.wrapped(position)).collect())
    }

    /// Grows spheres to `size` times the full diameters. Fails with the fraction of the target at which they jam.
    fn grow_to(&self, size: f64, speed: f64, factor: f64, simulation: &mut Simulation) -> Result<(), f64> {
        let scene = simulation.scene();
        let count = scene.particles.len() as u64;
        let diameters = scene.particles.iter().map(|particle| scene.diameter(particle));
        let (rate, largest) = (speed * count as f64 / diameters.sum::<f64>(), size / (factor * simulation.scale()));
        let end = simulation.time() + (largest - 1.0) / rate;
        let dimensions = self.fill.space.dimensions() as f64;
        let degrees = dimensions * count.saturating_sub(1).max(1) as f64;
        simulation.grow(&Growth { rate, until: GrowthTarget::PackingFraction(1.0) }, largest);
        let part = |simulation: &Simulation| libm::pow(factor * simulation.scale(), dimensions);
        for _ in 0..MOST_STRETCHES {
            let (time, before) = (simulation.time(), *simulation.event_counts());
            let until = Until::time(end).or_events(before.physical() + STRETCH * count);
            if simulation.advance(until).is_err() {
                break;
            }
            if simulation.time() >= end {
                return Ok(());
            }
            let temperature = 2.0 * simulation.energy().kinetic / degrees;
            // The virial theorem uses the degrees of freedom of all particles, although the centre of mass is at rest.
            let all = dimensions * count as f64;
            let exchanged =
                (simulation.event_counts().virial.total() - before.virial.total()) / (all * 0.5 * (1.0 + temperature));
            let factor = 1.0 + exchanged / (simulation.time() - time);
            let jams_at = part(simulation) / (1.0 - dimensions / factor);
            if factor > JAMMED || (factor > CLOSE && jams_at * TOLERANCE < 1.0) {
                return Err(jams_at);
            }
            simulation.scale_velocities((1.0 / temperature).sqrt(), &Vector::zeros());
        }
        Err(part(simulation))
    }
}

/// Creates hard spheres of mass 1 for the species in `used`. Species without a contact pass through each other.
fn hard_spheres(used: &[SpeciesId], contacts: &Contacts) -> Result<SceneParts, NoPlace> {
    let contact = |a: SpeciesId, b: SpeciesId| contacts.of_species(a.0 as usize, b.0 as usize);
    let mut spheres = SceneParts { table: SpeciesPairs::new(used.len()), ..SceneParts::default() };
    for (number, &kind) in used.iter().enumerate() {
        let reach = used.iter().map(|&other| contact(kind, other)).fold(0.0, f64::max);
        let diameter = if reach > 0.0 { reach } else { contacts.largest() };
        spheres.species.push(Species::new(&kind.0.to_string(), 1.0, diameter));
        for (other, &partner) in used[..=number].iter().enumerate() {
            let contact = contact(kind, partner);
            if contact > 0.0 {
                spheres.table.set(other, number, InteractionId(id(spheres.interactions.len())));
                let potential = Potential::hard_sphere(contact).map_err(NoPlace::Potential)?;
                spheres.interactions.push(Interaction { potential, law: ContactLaw::smooth(1.0), name: None });
            }
        }
    }
    Ok(spheres)
}

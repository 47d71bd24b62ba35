//! Coordination numbers from collisions that repeat within a time window.

use std::collections::BTreeMap;

use super::block_times::feasible;
use super::instrument::{Instrument, Setup};
use super::quantity::{Curve, Measured, Normalisation, Number};
use super::system::{Sample, SystemDescription};
use crate::analysis::sampling_times::SamplingTimes;
use crate::analysis::statistics::{BlockAverage, CurveAverage, Estimate};
use crate::base::numbers::id;
use crate::engine::event::{Event, EventKind, Other, Outcome};
use crate::model::ParticleId;
use crate::model::measurement_plan::Contacts as Plan;
use serde::{Deserialize, Serialize};

/// Intended number of windows in a run. Fewer windows fit into a short run.
const WINDOWS: u32 = 1000;

/// Smallest number of collisions in a window that makes a contact.
const COLLISIONS: u32 = 2;

/// Number of bins of the distribution. The last bin includes all larger coordination numbers.
const BINS: usize = 21;

/// Coordination numbers, averaged over time windows.
///
/// Hard particles at rest have no lasting contacts: with the TC model, they collide about once per contact time. Two
/// particles are in contact during a window if their cores collide at least twice in this window, and likewise a
/// particle and a surface. With `N` moving particles at the end of a window, `P` contacts between two of them and `F`
/// contacts with static particles and surfaces, the mean coordination number is `Z = (2 P + F) / N`.
///
/// A rattler has fewer than `D + 1` contacts in `D` dimensions. Rattlers and their contacts are removed until no
/// further particle is a rattler.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Contacts {
    /// Ends of the windows.
    ends: SamplingTimes,
    /// Length of a window `[time]`.
    duration: f64,
    collisions: Collisions,
    coordination: BlockAverage,
    on_surfaces: BlockAverage,
    without_rattlers: BlockAverage,
    rattlers: BlockAverage,
    distribution: CurveAverage,
}

/// Number of collisions in the current window of each particle with each partner. In a pair, the smaller id comes
/// first.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(from = "Vec<(u32, Partner, u32)>", into = "Vec<(u32, Partner, u32)>")]
struct Collisions(BTreeMap<(u32, Partner), u32>);

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
enum Partner {
    Particle(u32),
    Surface(u32),
}

impl From<Vec<(u32, Partner, u32)>> for Collisions {
    fn from(entries: Vec<(u32, Partner, u32)>) -> Self {
        Self(entries.into_iter().map(|(particle, partner, count)| ((particle, partner), count)).collect())
    }
}

impl From<Collisions> for Vec<(u32, Partner, u32)> {
    fn from(Collisions(counts): Collisions) -> Self {
        counts.into_iter().map(|((particle, partner), count)| (particle, partner, count)).collect()
    }
}

impl Contacts {
    pub fn new(plan: &Plan, setup: &Setup<'_>) -> Self {
        let start = setup.sample.time;
        // The reader of scenes rejects a plan without a window.
        let duration = plan.window(setup.system.contact_time).unwrap_or(setup.duration);
        let ends = match plan.interval {
            Some(interval) => SamplingTimes::given(start, feasible(interval.max(duration), setup.duration)),
            None => SamplingTimes::expecting(start, setup.duration, WINDOWS, duration),
        };
        Self {
            ends,
            duration,
            collisions: Collisions::default(),
            coordination: BlockAverage::new(1.0),
            on_surfaces: BlockAverage::new(1.0),
            without_rattlers: BlockAverage::new(1.0),
            rattlers: BlockAverage::new(1.0),
            distribution: CurveAverage::new(BINS),
        }
    }

    /// Adds the contacts of a window. Ignores the contacts of particles that have left.
    fn add(&mut self, network: &Network) {
        let moving = network.moving.len();
        if moving == 0 {
            return;
        }
        let per_particle = |count: usize| count as f64 / moving as f64;
        let numbers = network.coordination_numbers();
        self.coordination.add(per_particle(numbers.iter().sum()), 1.0);
        self.on_surfaces.add(per_particle(network.on_surfaces), 1.0);
        let mut bins = [0; BINS];
        numbers.iter().for_each(|&number| bins[number.min(BINS - 1)] += 1);
        self.distribution.add_all(bins.map(per_particle));
        let left = network.without_rattlers();
        self.rattlers.add(per_particle(moving - left.len()), 1.0);
        if !left.is_empty() {
            self.without_rattlers.add(left.iter().sum::<usize>() as f64 / left.len() as f64, 1.0);
        }
    }
}

/// Contacts of the moving particles in one window.
struct Network {
    /// Smallest coordination number of a particle that is no rattler.
    fewest: usize,
    moving: Vec<Particle>,
    /// Number of contacts with surfaces.
    on_surfaces: usize,
}

#[derive(Default)]
struct Particle {
    /// Moving particles in contact, as indices into the list of the moving particles.
    neighbours: Vec<u32>,
    /// Number of contacts with static particles and surfaces.
    fixed: usize,
}

impl Network {
    fn new(collisions: &Collisions, sample: &Sample<'_>, system: &SystemDescription) -> Self {
        let is_moving = |index: usize| system.species_masses[sample.species[index].0 as usize].is_finite();
        let mut places: Vec<Option<u32>> = Vec::with_capacity(sample.ids.len());
        let mut count = 0;
        for index in 0..sample.ids.len() {
            places.push(is_moving(index).then_some(count));
            count += u32::from(is_moving(index));
        }
        // `None` for particles that have left, and `Some(None)` for static particles.
        let place = |particle: u32| Some(places[sample.ids.binary_search(&ParticleId(particle)).ok()?]);
        let mut moving: Vec<Particle> = (0..count).map(|_| Particle::default()).collect();
        let mut on_surfaces = 0;
        let contacts = collisions.0.iter().filter(|(_, count)| **count >= COLLISIONS).map(|(contact, _)| *contact);
        for (particle, partner) in contacts {
            let partners = match partner {
                Partner::Particle(other) => place(particle).zip(place(other)),
                Partner::Surface(_) => place(particle).zip(Some(None)),
            };
            match partners {
                Some((Some(one), Some(other))) => {
                    moving[one as usize].neighbours.push(other);
                    moving[other as usize].neighbours.push(one);
                }
                Some((Some(one), None) | (None, Some(one))) => {
                    moving[one as usize].fixed += 1;
                    on_surfaces += usize::from(matches!(partner, Partner::Surface(_)));
                }
                Some((None, None)) | None => {}
            }
        }
        Self { fewest: system.space.dimensions() + 1, moving, on_surfaces }
    }

    fn coordination_numbers(&self) -> Vec<usize> {
        self.moving.iter().map(|particle| particle.neighbours.len() + particle.fixed).collect()
    }

    /// Returns the coordination numbers of the particles that are left after all rattlers are removed.
    fn without_rattlers(&self) -> Vec<usize> {
        let mut numbers = self.coordination_numbers();
        let is_rattler = |numbers: &[usize], particle: u32| numbers[particle as usize] < self.fewest;
        let mut is_removed = vec![false; numbers.len()];
        let mut found: Vec<u32> = (0..id(numbers.len())).filter(|&particle| is_rattler(&numbers, particle)).collect();
        while let Some(rattler) = found.pop() {
            is_removed[rattler as usize] = true;
            for &neighbour in &self.moving[rattler as usize].neighbours {
                let was_rattler = is_rattler(&numbers, neighbour);
                numbers[neighbour as usize] -= 1;
                if !was_rattler && is_rattler(&numbers, neighbour) {
                    found.push(neighbour);
                }
            }
        }
        numbers.into_iter().zip(is_removed).filter(|(_, is_removed)| !is_removed).map(|(number, _)| number).collect()
    }
}

impl Instrument for Contacts {
    fn next_sample(&self) -> f64 {
        self.ends.next()
    }

    fn sample(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        if self.ends.is_due(sample.time) {
            let collisions = std::mem::take(&mut self.collisions);
            self.add(&Network::new(&collisions, sample, system));
        }
    }

    fn has_events(&self) -> bool {
        true
    }

    fn event(&mut self, event: &Event, _: &SystemDescription) {
        if event.time < self.ends.next() - self.duration {
            return;
        }
        let one = event.particle.0;
        let contact = match (event.kind, event.other) {
            (EventKind::Pair(Outcome::Core), Other::Particle(ParticleId(other))) => {
                (one.min(other), Partner::Particle(one.max(other)))
            }
            (EventKind::Surface, Other::Surface { surface, .. }) => (one, Partner::Surface(surface)),
            _ => return,
        };
        let count = self.collisions.0.entry(contact).or_default();
        *count = count.saturating_add(1);
    }

    fn report(&self, system: &SystemDescription, measured: &mut Measured) {
        let mut number = |name: &str, title: &str, estimate: Option<Estimate>, method: &str| {
            measured.numbers.push(Number::estimated(name, title, "1", estimate, method));
        };
        number("coordination_number", "Coordination number", self.coordination.estimate(), COORDINATION);
        let title = "Coordination number without rattlers";
        number("coordination_number_without_rattlers", title, self.without_rattlers.estimate(), WITHOUT_RATTLERS);
        number("rattler_fraction", "Fraction of rattlers", self.rattlers.estimate(), RATTLERS);
        if !system.surfaces.is_empty() {
            let title = "Contacts with surfaces per particle";
            number("surface_coordination", title, self.on_surfaces.estimate(), ON_SURFACES);
        }
        let windows = self.distribution.count(0);
        measured.curves.push(
            Curve::new("contacts", "Distribution of coordination numbers", DISTRIBUTION)
                .variable("z", "1", (0..id(BINS)).map(f64::from).collect())
                .series("P(z)", "1", &self.distribution.estimates(0..BINS))
                .normalised(
                    Normalisation::of("fraction of the moving particles with z contacts, over all windows")
                        .by("windows", "1", windows),
                ),
        );
    }
}

const COORDINATION: &str = "Z = (2 P + F) / N over windows of time: P pairs of moving particles, and F pairs of a \
    moving particle and a static particle or surface, that collide at least twice in a window, for N moving particles.";
const WITHOUT_RATTLERS: &str = "Z as above after all rattlers are removed with their contacts: particles with fewer \
    than D + 1 contacts in D dimensions, repeatedly, until no rattler is left.";
const RATTLERS: &str = "Removed rattlers divided by the number of moving particles, averaged over windows of time.";
const ON_SURFACES: &str = "Pairs of a moving particle and a surface that collide at least twice in a window, divided by the number of \
    moving particles.";
const DISTRIBUTION: &str = "P(z): fraction of the moving particles with z contacts, averaged over windows of time. \
    The last row includes all larger z.";

#[cfg(test)]
mod tests;

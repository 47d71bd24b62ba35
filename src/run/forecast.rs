//! Warns about runs that take longer than a user may expect.

use super::stage::{Settings, Stage};
use crate::analysis::published::{contact_value, contact_value_of_disks};
use crate::base::numbers::trunc_to_usize;
use crate::engine::{EngineChoice, Search};
use crate::model::potential::Potential;
use crate::model::space::Boundary;
use crate::model::{Barostat, Growth, GrowthTarget, Scene, Species, Swap, Thermostat};
use crate::physics::kinetics::cross_section;

/// Typical number of engine steps per second. A step is an event, a new velocity, or a test of a particle.
const STEPS_PER_SECOND: f64 = 1e6;

/// Number of neighbours that can be tested in the time of one step.
const OTHERS_PER_STEP: f64 = 300.0;

/// The cost of a thermostat, a barostat, swap moves, shear flow or a moving surface is reported if it exceeds this wall time `[seconds]`.
const LONG: f64 = 600.0;

/// The number of events is reported if the run takes longer than this wall time `[seconds]`.
const VERY_LONG: f64 = 10_800.0;

/// The cost of a thermostat, a barostat, swap moves or shear flow is reported if there are more steps per event than this.
const OUT_OF_PROPORTION: f64 = 10.0;

/// Events are slow if a particle has more neighbours than this.
const CROWD: f64 = 10_000.0;

/// A reason why a run takes a long time.
#[derive(Debug, Clone, PartialEq)]
pub struct Burden {
    /// Description for the user.
    pub cause: String,
    /// Estimated wall time `[seconds]`.
    pub seconds: f64,
}

/// Returns the reasons why a run takes longer than a user may expect.
///
/// Event rates are estimated from Enskog's kinetic theory. The list is empty for a scene without moving particles.
#[must_use]
pub fn burdens(scene: &Scene) -> Vec<Burden> {
    let mut burdens = Vec::new();
    if scene.moving().next().is_none() {
        return burdens;
    }
    let pace = Pace::of(scene);
    let plan = &scene.run;
    for Settings { limit, thermostat, barostat, swap, growth, .. } in Stage::all(plan).map(|stage| stage.settings(plan))
    {
        let by_events = limit.events.map_or(f64::INFINITY, |events| events as f64 / pace.events);
        let grown = growth.map_or(f64::INFINITY, |growth| duration_of(scene, &growth));
        let by_time = limit.time.unwrap_or(f64::INFINITY).min(grown);
        let duration = by_time.min(by_events);
        if !duration.is_finite() || (limit.time.is_none() && limit.events.is_none() && growth.is_none()) {
            continue;
        }
        let seconds = pace.events * duration / STEPS_PER_SECOND;
        // A user who limits the number of events knows the number.
        if seconds > VERY_LONG && by_time <= by_events {
            let cause = format!("a time of {duration} has about {:.0e} events", pace.events * duration);
            burdens.push(Burden { cause, seconds });
        }
        match thermostat {
            Some(Thermostat::Andersen { rate, .. }) => {
                let cause = format!("the heat bath assigns about {:.0e} new velocities", rate * pace.moving * duration);
                burdens.extend(pace.burden(cause, rate * pace.moving, duration));
            }
            Some(Thermostat::Rescaling { interval, .. }) => {
                let cause =
                    format!("the velocities of all particles are scaled about {:.0e} times", duration / interval);
                burdens.extend(pace.burden(cause, pace.moving / interval, duration));
            }
            None => {}
        }
        burdens.extend(of_moves(barostat, swap, &pace, duration));
        if let Some(rate) = scene.shear_rate {
            // Contacts with images are predicted again after each slide by a quarter of the box.
            let slides = 4.0 * rate.abs() * scene.space.size.y / scene.space.size.x;
            let cause = format!("the periodic images slide past the box about {:.0e} times", 0.25 * slides * duration);
            burdens.extend(pace.burden(cause, slides * pace.at_sides, duration));
        }
    }
    burdens.extend(frequencies(scene, pace.moving));
    if let Some(crowd) = crowd(scene) {
        let per_event = crowd / OTHERS_PER_STEP / STEPS_PER_SECOND;
        let events =
            plan.limit.events.map_or_else(|| plan.limit.time.unwrap_or(0.0) * pace.events, |events| events as f64);
        let cause = format!(
            "cells are as wide as the longest interaction range, so about {crowd:.0} particles are tested in each event, which \
             takes about {:.1e} seconds",
            per_event
        );
        burdens.push(Burden { cause, seconds: events * per_event });
    }
    burdens
}

/// The cost of Monte Carlo moves.
fn of_moves(
    barostat: Option<Barostat>,
    swap: Option<Swap>,
    pace: &Pace,
    duration: f64,
) -> impl Iterator<Item = Burden> {
    let of_volume = barostat.and_then(|barostat| {
        let times = duration / barostat.interval;
        let cause = format!("the volume is changed about {times:.0e} times, and all particles move with it");
        pace.burden(cause, pace.moving / barostat.interval, duration)
    });
    let of_swaps = swap.and_then(|swap| {
        // Before a set of moves, all moving particles are listed.
        let moves = swap.attempts(trunc_to_usize(pace.moving)) as f64;
        let cause = format!("there are about {:.0e} swap moves", moves * duration / swap.interval);
        pace.burden(cause, (moves + pace.moving) / swap.interval, duration)
    });
    of_volume.into_iter().chain(of_swaps)
}

/// Number of search steps per period of an oscillating or turning surface, for each particle near the surface.
const STEPS_OF_PERIOD: f64 = 16.0;
/// Wall time of a search step `[seconds]`.
const SEARCH_STEP: f64 = 1e-7;

/// After this number of periods, the rounding error of the time is a thousandth of a period.
const MOST_PERIODS: f64 = 1e-3 / f64::EPSILON;

/// Reports surfaces that oscillate or turn too fast. The run is then slow, or round-off exceeds the phase.
fn frequencies(scene: &Scene, moving: f64) -> Vec<Burden> {
    let plan = &scene.run;
    let duration: f64 = Stage::all(plan).filter_map(|stage| stage.settings(plan).limit.time).sum();
    let mut burdens = Vec::new();
    for surface in &scene.surfaces {
        let frequency = surface.motions.iter().filter_map(|motion| motion.kind.frequency()).fold(0.0, f64::max);
        let (periods, latest) = (frequency * duration, frequency * (scene.start_time.abs() + duration));
        if latest > MOST_PERIODS {
            let cause = format!(
                "surface `{}` has a frequency of {frequency}: after a time of {} its phase is lost in round-off, so its motion cannot be simulated",
                surface.name,
                scene.start_time.abs() + duration
            );
            burdens.push(Burden { cause, seconds: 0.0 });
            continue;
        }
        let seconds = periods * STEPS_OF_PERIOD * SEARCH_STEP * moving;
        if seconds > LONG {
            let cause = format!(
                "surface `{}` oscillates or turns about {periods:.0e} times, and each period takes several search \
                 steps for each nearby particle; if all particles are nearby",
                surface.name
            );
            burdens.push(Burden { cause, seconds });
        }
    }
    burdens
}

/// Event rate of a fluid from kinetic theory `[1 / time]`; `None` if particles fall, can leave the box, or are at rest.
pub(super) fn rate(scene: &Scene) -> Option<f64> {
    let is_falling = scene.accelerations().any(|acceleration| acceleration.norm() > 0.0);
    let rate = if is_falling || !scene.space.is_closed() { 0.0 } else { Pace::of(scene).events };
    (rate.is_finite() && rate > 0.0).then_some(rate)
}

/// Duration of a growth stage with a target packing fraction `[time]`; infinite for a target pressure.
fn duration_of(scene: &Scene, growth: &Growth) -> f64 {
    match growth.until {
        GrowthTarget::PackingFraction(target) => (scene.growth_to(target) - 1.0).max(0.0) / growth.rate,
        GrowthTarget::CompressibilityFactor(_) => f64::INFINITY,
    }
}

struct Pace {
    moving: f64,
    /// Event rate of the whole system `[1 / time]`.
    events: f64,
    /// Number of particles near the sides of a sheared box, where images slide past.
    at_sides: f64,
}

impl Pace {
    fn burden(&self, cause: String, rate: f64, duration: f64) -> Option<Burden> {
        let (steps, events) = (rate * duration, self.events * duration);
        let seconds = steps / STEPS_PER_SECOND;
        (seconds > LONG && steps > OUT_OF_PROPORTION * events).then_some(Burden { cause, seconds })
    }

    fn of(scene: &Scene) -> Self {
        let count = scene.moving().count().max(1) as f64;
        let dimensions = scene.space.dimensions();
        let squared = scene.moving().map(|particle| particle.velocity.norm_squared()).sum::<f64>() / count;
        let mass = scene.moving().map(|particle| scene.mass(particle)).sum::<f64>() / count;
        let diameter = scene.moving().map(|particle| scene.diameter(particle)).sum::<f64>() / count;
        let hottest = scene.run.thermostats().map(|thermostat| thermostat.temperature()).fold(0.0, f64::max);
        let thermal = dimensions as f64 * hottest / mass;
        let shear = scene.shear_rate.unwrap_or(0.0) * diameter;
        let speed = squared.max(thermal).max(shear * shear).sqrt();
        let range = scene.longest_range();
        Self {
            moving: count,
            events: 0.5 * std::f64::consts::SQRT_2 * count * count / scene.space.volume() * section(scene) * speed,
            at_sides: count * (2.0 * range / scene.space.size.y).min(1.0),
        }
    }
}

/// Mean collision cross section of all pairs of moving particles `[length^(D - 1)]`. The cross section of a hard core
/// is multiplied by Enskog's factor. Other steps of the potential are counted twice, because pairs cross them inwards
/// and outwards.
fn section(scene: &Scene) -> f64 {
    let dimensions = scene.space.dimensions();
    let factor = enskog_factor(scene.packing_fraction(), dimensions);
    let moving = |(count, species): (usize, &Species)| if species.is_static() { 0.0 } else { count as f64 };
    let counts: Vec<f64> = scene.population().into_iter().zip(&scene.species).map(moving).collect();
    let all = counts.iter().sum::<f64>().max(1.0);
    let of_pair = |potential: &Potential| -> f64 {
        let steps = potential.radii().iter().zip(potential.energies().windows(2));
        let events = |energies: &[f64]| if energies[1].is_infinite() { factor } else { 2.0 };
        steps.map(|(radius, energies)| events(energies) * cross_section(*radius, dimensions)).sum()
    };
    let of_pairs = scene.table.iter().map(|([a, b], id)| {
        let pairs = if a == b { 1.0 } else { 2.0 } * counts[a] * counts[b] / (all * all);
        pairs * of_pair(&scene.interactions[id.0 as usize].potential)
    });
    of_pairs.sum()
}

/// Enskog factor: the collision rate divided by the rate of a dilute gas. It equals the radial distribution function at
/// contact. Packing fractions that no fluid can have are reduced.
fn enskog_factor(packing_fraction: f64, dimensions: usize) -> f64 {
    const DENSEST: [f64; 3] = [0.95, 0.8, 0.6];
    match dimensions {
        3 => contact_value(packing_fraction.clamp(0.0, DENSEST[2])),
        2 => contact_value_of_disks(packing_fraction.clamp(0.0, DENSEST[1])),
        _ => 1.0 / (1.0 - packing_fraction.clamp(0.0, DENSEST[0])),
    }
}

/// Number of particles in the cells around a particle, which are as large as the longest range. `None` up to [`CROWD`],
/// and with neighbour lists, which have cells for each size of particles.
fn crowd(scene: &Scene) -> Option<f64> {
    if EngineChoice::new(scene).search != Search::Cells {
        return None;
    }
    let occurs = scene.occurring_species();
    let pairs = scene.table.iter().filter(|([a, b], _)| occurs[*a] && occurs[*b]);
    let range = pairs.map(|(_, id)| scene.interactions[id.0 as usize].potential.range()).fold(0.0, f64::max);
    let part = |k: usize| {
        if scene.space.boundary[k] == Boundary::Flat { 1.0 } else { (3.0 * range / scene.space.size[k]).min(1.0) }
    };
    let near = scene.particles.len() as f64 * (0..3).map(part).product::<f64>();
    (near > CROWD).then_some(near)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Scene;

    const FLUID: &str = "
        [[species]]
        name = \"A\"
        mass = 1.0
        diameter = 1.0
        [[interaction]]
        species = [\"A\", \"A\"]
        potential = \"hard-sphere\"
        [[fill]]
        species = \"A\"
        arrangement = \"fcc\"
        count = 500
        packing_fraction = 0.3
        temperature = 1.0
        [run]
        until_time = 100.0
    ";

    fn causes(overrides: &[(&str, &str)]) -> Vec<String> {
        let scene = Scene::from_toml_with(FLUID, "fluid", overrides).unwrap();
        burdens(&scene).into_iter().map(|burden| burden.cause).collect()
    }

    #[test]
    fn only_disproportionate_costs_are_reported() {
        let bath = |rate: &str| format!("{{ kind = \"andersen\", temperature = 1.0, rate = {rate} }}");
        let scaling = |interval: &str| format!("{{ kind = \"rescaling\", temperature = 1.0, interval = {interval} }}");
        assert_eq!(causes(&[]), [] as [&str; 0]);
        assert_eq!(causes(&[("run.thermostat", &bath("1.0"))]), [] as [&str; 0]);
        assert_eq!(causes(&[("run.thermostat", &bath("1e9"))]), ["the heat bath assigns about 5e13 new velocities"]);
        assert_eq!(causes(&[("run.thermostat", &scaling("0.1"))]), [] as [&str; 0]);
        let found = causes(&[("run.thermostat", &scaling("1e-9"))]);
        assert!(found[0].contains("scaled about 1e11 times"), "{found:?}");
        assert_eq!(causes(&[("space.shear_rate", "0.5")]), [] as [&str; 0]);
        let found = causes(&[("space.shear_rate", "1e6")]);
        assert!(found[0].starts_with("a time of 100 has about"), "{found:?}");
        let events = [("run.until_events", "1000000"), ("run.thermostat", &bath("1e9"))];
        assert_eq!(causes(&events).len(), 1);
    }

    #[test]
    fn costly_long_interaction_range_is_reported() {
        let overrides = [
            ("fill.0.count", "32000"),
            ("fill.0.packing_fraction", "0.01"),
            ("interaction.0.potential", "square-well"),
        ];
        let range = |lambda| {
            [
                overrides[0],
                overrides[1],
                overrides[2],
                ("interaction.0.lambda", lambda),
                ("interaction.0.well_depth", "1.0"),
            ]
        };
        assert_eq!(causes(&range("1.5")), [] as [&str; 0]);
        let found = causes(&range("50.0"));
        assert!(found[0].contains("particles are tested in each event"), "{found:?}");
    }
}

//! Estimates the event rate of a run in advance, even if the rate changes during the run.

use thiserror::Error;

use super::rate::{MOST, Try, expected_rate};
use super::stage::{Settings, Stage};
use crate::engine::Reason;
use crate::model::{Scene, Until};

/// Engine steps of a trial run, and engine steps between two records of the event count. A trial takes a few seconds.
const STEPS: u64 = 1_000_000;
const STEPS_OF_PART: u64 = 10_000;

/// A trial that advances too slowly is abandoned after this number of engine steps.
const PATIENCE: u64 = 120_000;

/// A trial of a cooling system may become faster by this factor, because events become rarer.
const MARGIN: f64 = 4.0;

/// Rates that differ by less than this factor are considered equal.
const STEADY: f64 = 1.5;

/// A trial that covers this fraction of the run is representative of the rest.
const FAR: f64 = 0.125;

/// Minimum number of events for the calculation of a rate.
const FEWEST: f64 = 30.0;

/// Why the event rate of a run cannot be estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum NoRate {
    /// Particles fall and lose energy in contacts. While they come to rest, contacts become more and more frequent.
    #[error("particles that fall and lose energy come to rest, in more and more contacts")]
    Collects,
    /// Particles can leave through open sides.
    #[error("particles can leave")]
    Leaves,
    /// Particles become faster and faster under gravity.
    #[error("falling particles keep getting faster")]
    Falls,
    /// Contacts dissipate energy and nothing supplies it.
    #[error("contacts lose energy and nothing supplies any, so they become rarer")]
    Cools,
    /// The trial had too few events, or there are too many particles for a trial.
    #[error("a trial run covers too little of it")]
    Untried,
}

/// Estimates the mean number of events of a run per simulated time `[1 / time]`.
///
/// A steady rate follows from a short trial run, or from kinetic theory if there are many particles. Otherwise, a
/// longer trial must reach the end of the run or a steady rate. The result does not depend on the speed of the machine.
///
/// # Errors
/// [`NoRate`] if the rate cannot be estimated within a factor of three.
pub fn foreseen_rate(scene: &Scene) -> Result<f64, NoRate> {
    match unsteady(scene) {
        None => expected_rate(scene).ok_or(NoRate::Untried),
        Some(why) => tried(scene, why).ok_or(why),
    }
}

/// Returns the reason why the event rate changes during a run; `None` if it is steady.
fn unsteady(scene: &Scene) -> Option<NoRate> {
    let is_falling = scene.accelerations().any(|acceleration| acceleration.norm() > 0.0);
    match () {
        () if is_falling && loses_energy(scene) => Some(NoRate::Collects),
        () if !scene.space.is_closed() => Some(NoRate::Leaves),
        () if is_falling => Some(NoRate::Falls),
        () if scene.cools_for_ever() => Some(NoRate::Cools),
        () => None,
    }
}

fn loses_energy(scene: &Scene) -> bool {
    let walls = scene.space.boundary.iter().flat_map(crate::model::space::Boundary::contact_laws).flatten();
    scene.interactions.iter().any(|interaction| interaction.law.dissipates())
        || walls.into_iter().any(|law| law.dissipates())
}

/// Duration of a run `[time]`. `None` if the duration is unknown, or if a stage has a thermostat or growth.
fn duration(scene: &Scene) -> Option<f64> {
    let plan = &scene.run;
    let of_stage = |Settings { limit, thermostat, growth, .. }: Settings| match limit {
        Until { time: Some(time), events: None } if growth.is_none() && thermostat.is_none() => Some(time),
        _ => None,
    };
    let stages = Stage::all(plan).map(|stage| stage.settings(plan));
    stages.filter(|settings| settings.has_end()).map(of_stage).sum()
}

fn tried(scene: &Scene, why: NoRate) -> Option<f64> {
    let duration = duration(scene)
        .filter(|time| *time > 0.0 && scene.moving().count() <= MOST && scene.particles.len() <= 100 * MOST)?;
    let mut attempt = Try::of(scene);
    let start = attempt.simulation.time();
    let until = Until::time(start + duration);
    let mut course = vec![(0.0, 0.0)];
    for part in 1..=STEPS / STEPS_OF_PART {
        let reason = attempt.advance(STEPS_OF_PART, until).ok()?;
        let simulation = &attempt.simulation;
        let events = simulation.event_counts().physical() as f64;
        if matches!(reason, Some(Reason::Time | Reason::Idle)) {
            return Some(events / duration);
        }
        let passed = simulation.time() - start;
        course.push((passed, events));
        let foreseen = MARGIN * passed * STEPS as f64 / (part * STEPS_OF_PART) as f64;
        if part * STEPS_OF_PART >= PATIENCE && foreseen < FAR * duration && why != NoRate::Falls {
            return None;
        }
    }
    let (passed, events) = *course.last()?;
    let by = |time: f64| course.iter().find(|(now, _)| *now >= time).map(|(_, events)| *events);
    let [quarter, half] = [by(0.25 * passed)?, by(0.5 * passed)?];
    let [earlier, later] = [(half - quarter) / (0.25 * passed), (events - half) / (0.5 * passed)];
    let is_steady = half - quarter >= FEWEST && later < STEADY * earlier && earlier < STEADY * later;
    // Particles that fall without dissipation soon have a steady rate, so a shorter trial is sufficient.
    let is_far = passed >= FAR * duration || why == NoRate::Falls;
    (is_steady && is_far).then(|| (events + later * (duration - passed)) / duration)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Simulation;

    fn scene(text: &str) -> Scene {
        Scene::from_toml(text, "scene.toml").unwrap()
    }

    fn events(scene: &Scene) -> f64 {
        let mut simulation = Simulation::without_plan(scene.clone());
        simulation.advance(Until::time(scene.run.limit.time.unwrap())).unwrap();
        simulation.event_counts().physical() as f64
    }

    const GRAINS: &str = "
        dynamics = { gravity = [0.0, 0.0, -1.0], contact_time = 1e-3 }
        species = [{ name = 'grain', mass = 1.0, diameter = 1.0 }]
        interaction = [{ species = ['grain', 'grain'], potential = 'hard-sphere', restitution = 0.7 }]
        ";

    fn rain(count: u32, time: f64) -> Scene {
        scene(&format!(
            "{GRAINS}
            space = {{ size = [8.0, 8.0, 60.0], z = {{ lower = 'wall', upper = 'open', restitution = 0.7 }} }}
            fill = [{{ species = 'grain', arrangement = 'random', count = {count}, region = {{ lower = [0.0, 0.0, 5.0], upper = [8.0, 8.0, 60.0] }}, temperature = 0.01 }}]
            run = {{ until_time = {time} }}"
        ))
    }

    #[test]
    fn estimated_event_counts_are_within_a_factor_of_three() {
        let ball = Scene::from_file("configs/bouncing_ball.toml").unwrap();
        let pendulum = Scene::from_file("configs/pendulum.toml").unwrap();
        for scene in [ball, pendulum, rain(5, 15.0)] {
            let (told, truth) = (foreseen_rate(&scene).unwrap() * scene.run.limit.time.unwrap(), events(&scene));
            assert!((told / truth - 1.0).abs() < 1e-9, "{told} {truth}");
        }
        assert_eq!(foreseen_rate(&rain(1000, 100.0)), Err(NoRate::Collects));
        let hopper = Scene::from_file("configs/hopper.toml").unwrap();
        // The run of the hopper has 1.45e6 events in 80 units of time.
        let told = 80.0 * foreseen_rate(&hopper).unwrap();
        assert!((0.5e6..4.3e6).contains(&told), "{told}");
    }

    /// Each of the two grains bounces once. They would come to rest only long after the run.
    #[test]
    fn an_estimate_does_not_go_beyond_the_end_of_the_run() {
        let two = scene(
            "
            space = { size = [8.0, 8.0, 60.0], z = { lower = 'wall', upper = 'open', restitution = 0.9 } }
            dynamics = { gravity = [0.0, 0.0, -1.0] }
            species = [{ name = 'grain', mass = 1.0, diameter = 1.0 }]
            interaction = [{ species = ['grain', 'grain'], potential = 'hard-sphere', restitution = 0.9 }]
            particle = [{ species = 'grain', position = [2.0, 2.0, 2.0] }, { species = 'grain', position = [6.0, 6.0, 3.0] }]
            run = { until_time = 3 }
            output = { contacts = true }",
        );
        let (rate, truth) = (foreseen_rate(&two).unwrap(), events(&two));
        assert_eq!((3.0 * rate).round(), truth);
        let estimate = crate::io::estimate::SizeEstimate::of(&two, Some(rate));
        assert!(estimate.bytes < 1e5, "{estimate:?}");
    }

    #[test]
    fn steady_scenes_keep_the_expected_rate_and_cooling_ones_have_none() {
        for name in ["hard_sphere_fluid", "sheared_granular_gas", "square_well_fluid"] {
            let scene = Scene::from_file(format!("configs/{name}.toml")).unwrap();
            assert_eq!(foreseen_rate(&scene).ok(), expected_rate(&scene), "{name}");
        }
        let cooling = Scene::from_file_with("configs/granular_cooling.toml", &[("fill.0.count", "10976")]).unwrap();
        assert_eq!(foreseen_rate(&cooling), Err(NoRate::Cools));
    }

    #[test]
    fn slow_cooling_is_not_mistaken_for_a_steady_rate() {
        // The trial covers only a small part of the cooling. The initial rate is twenty times the mean rate.
        let slow = scene(
            "
            species = [{ name = 'grain', mass = 1.0, diameter = 1.0 }]
            interaction = [{ species = ['grain', 'grain'], potential = 'hard-sphere', restitution = 0.9999 }]
            fill = [{ species = 'grain', arrangement = 'fcc', count = 500, packing_fraction = 0.1, temperature = 1.0 }]
            run = { until_time = 1e6 }",
        );
        assert_eq!(foreseen_rate(&slow), Err(NoRate::Cools));
    }
}

//! Validates the table `[exchange]`: temperatures, times, permitted features, and the existence of an
//! equilibrium.

mod umbrella;

use crate::Vector;
use crate::base::text::shortest;
use crate::model::exchange_plan::{MOST_ATTEMPTS, MOST_TEMPERATURES};
use crate::model::measurement_plan::InstrumentKind;
use crate::model::space::{AXES, Boundary, Face};
use crate::model::{ExchangeEnsemble, ExchangePlan, Format, Scene, SceneParts, SceneSurface, SurfaceLaw, Threads};
use crate::scene::builder::SceneBuilder;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, missing, refuse};
use crate::scene::limits::{affordable, positive};

impl SceneParts {
    pub(super) fn check_exchange(&self) -> Result<(), SceneError> {
        let Some(plan) = &self.exchange else { return Ok(()) };
        match plan.ensemble {
            ExchangeEnsemble::Umbrella => umbrella::check_windows(plan)?,
            _ => check_temperatures(plan)?,
        }
        let at = ConfigPath::root().key("exchange");
        positive(plan.interval, at.key("interval"))?;
        positive(plan.rate, at.key("rate"))?;
        self.check_times(plan)?;
        self.check_learning(plan)?;
        self.check_company()
    }

    /// Requires that times of the run and of its output are whole numbers of exchange intervals.
    fn check_times(&self, plan: &ExchangePlan) -> Result<(), SceneError> {
        let (run, output) = (ConfigPath::root().key("run"), ConfigPath::root().key("output"));
        if self.run.limit.time.is_none() {
            return Err(missing(
                &run,
                "until_time",
                "replicas are swapped at regular intervals, and an [exchange] must end with a swap",
            ));
        }
        let events = [(self.run.limit.events, "until_events"), (self.run.equilibration.events, "equilibration_events")];
        for (count, key) in events {
            if let Some(count) = count {
                let expected = "to be absent with [exchange], whose replicas are swapped at regular intervals: give until_time and equilibration_time";
                return refuse(run.key(key), count, expected);
            }
        }
        if self.run.until_stationary {
            let expected = "to be absent with [exchange]: give equilibration_time";
            return refuse(run.key("equilibration"), "\"auto\"", expected);
        }
        for (time, at) in [
            (self.run.limit.time, run.key("until_time")),
            (self.run.equilibration.time, run.key("equilibration_time")),
            (self.output.frame_interval, output.key("frame_interval")),
        ] {
            let Some(time) = time else { continue };
            if plan.attempts(time).is_none_or(|attempts| attempts == 0) {
                let expected = format!(
                    "a multiple of {} (exchange.interval), at most {MOST_ATTEMPTS:e} times as long",
                    shortest(plan.interval)
                );
                return refuse(at, shortest(time), expected);
            }
        }
        Ok(())
    }

    /// Requires an equilibration long enough to find multicanonical weights, or to bring replicas into their
    /// windows.
    fn check_learning(&self, plan: &ExchangePlan) -> Result<(), SceneError> {
        let why = match plan.ensemble {
            ExchangeEnsemble::Canonical => return Ok(()),
            ExchangeEnsemble::Multicanonical => {
                "\"multicanonical\", whose weights follow from the energies of its equilibration"
            }
            ExchangeEnsemble::Umbrella => {
                "\"umbrella\", because the replicas move into their windows during the equilibration"
            }
        };
        let at = ConfigPath::root().key("run");
        let expected = format!("at least {LEAST_LEARNING} times exchange.interval with the ensemble {why}");
        match self.run.equilibration.time {
            None => Err(missing(&at, "equilibration_time", &expected)),
            Some(time) if plan.attempts(time).is_none_or(|attempts| attempts < LEAST_LEARNING) => {
                refuse(at.key("equilibration_time"), shortest(time), expected)
            }
            Some(_) => Ok(()),
        }
    }

    /// Rejects tables and keys that a replica exchange does not support.
    fn check_company(&self) -> Result<(), SceneError> {
        let root = ConfigPath::root();
        if !self.run.stages.is_empty() {
            let expected = "to be absent with [exchange]: prepare the particles with `carom run`, and start from the end of that run with start.from";
            return refuse(ConfigPath::entry("stage", 0), "given", expected);
        }
        if self.run.thermostat.is_some() {
            let expected = "to be absent with [exchange], which has its own temperatures and rate";
            return refuse(root.key("run").key("thermostat"), "given", expected);
        }
        if self.run.barostat.is_some() {
            let expected = "to be absent with [exchange], whose replicas all have the volume of the scene";
            return refuse(root.key("run").key("barostat"), "given", expected);
        }
        if self.run.threads != Threads::default() {
            let expected = "1 with [exchange], because each replica has its own thread: `carom exchange --jobs` sets how many run at once";
            return refuse(root.key("run").key("threads"), self.run.threads, expected);
        }
        if let Some((key, expected)) = self.refused_instrument() {
            return refuse(root.key("measure").key(key), "given", expected);
        }
        let (at, output) = (root.key("output"), &self.output);
        for (is_given, key) in [
            (output.thermo_interval.is_some(), "thermo_interval"),
            (output.has_contacts, "contacts"),
            (output.has_event_log, "events"),
            (!output.regions.is_empty(), "count"),
        ] {
            if is_given {
                let expected =
                    "to be absent with [exchange], which writes only trajectories and a row for each attempt to swap";
                return refuse(at.key(key), "given", expected);
            }
        }
        if let Some(format) = output.formats.first().map(|format| Format::name(*format)) {
            let expected = format!(
                "to be absent with [exchange]: convert later with `carom convert DIR/trajectory-1.xyz --to {format}`"
            );
            return refuse(at.key("formats"), "given", expected);
        }
        if self.allow_invalid_start {
            let expected = "false with [exchange], which averages over valid states: let `carom run` separate the particles, and start from \
                            the end of that run with start.from";
            return refuse(root.key("allow_invalid_start"), "true", expected);
        }
        Ok(())
    }

    /// The first instrument that an exchange does not support, and what is expected instead.
    fn refused_instrument(&self) -> Option<(&'static str, String)> {
        let mut all = self.measure.requested().map(|it| it.kind);
        if self.exchange.as_ref().is_some_and(|plan| plan.ensemble != ExchangeEnsemble::Canonical) {
            let expected =
                "to be absent with an ensemble other than \"canonical\": measure it in the canonical ensemble";
            return all.next().map(|kind| (kind.key, expected.to_owned()));
        }
        let kind = all.find(|kind| !kind.at_one_time)?;
        let expected = format!(
            "to be absent with [exchange], whose replicas change their temperatures, so that it can measure only states at single times: {}; \
             measure others with `carom run` at one temperature, with an Andersen thermostat in [run]",
            InstrumentKind::listed(|kind| kind.at_one_time)
        );
        Some((kind.key, expected))
    }
}

impl SceneBuilder {
    pub(in crate::scene) fn check_equilibrium(&self, scene: &Scene) -> Result<(), SceneError> {
        let Some(plan) = &scene.exchange else { return Ok(()) };
        let root = ConfigPath::root();
        let lossy = |restitution: f64| restitution < 1.0;
        if let Some(index) = self.interactions.iter().position(|it| lossy(it.restitution)) {
            let at = ConfigPath::entry("interaction", index).key("restitution");
            return refuse(at, shortest(self.interactions[index].restitution), LOSSLESS);
        }
        if let Some((index, interaction)) =
            scene.interactions.iter().enumerate().find(|(_, it)| lossy(it.law.restitution))
        {
            let restitution = shortest(interaction.law.restitution);
            if scene.predecessor.is_some() {
                let value = format!("a run with an interaction of restitution {restitution}");
                return refuse(root.key("start").key("from"), value, LOSSLESS);
            }
            return refuse(ConfigPath::entry("interaction", index).key("restitution"), restitution, LOSSLESS);
        }
        if let Some(rate) = scene.shear_rate {
            let expected = "to be absent with [exchange]: a sheared fluid has no equilibrium";
            return refuse(root.key("space").key("shear_rate"), rate, expected);
        }
        for (axis, name) in AXES.into_iter().enumerate() {
            check_axis(scene, axis, &root.key("space").key(name))?;
        }
        for (index, surface) in scene.surfaces.iter().enumerate() {
            check_surface(surface, &ConfigPath::entry("surface", index))?;
        }
        let at = root.key("exchange").key("temperatures");
        if scene.particles.iter().all(|particle| scene.species[particle.species.0 as usize].is_static()) {
            return refuse(at, "given for a scene in which nothing moves", "particles that move");
        }
        check_energies(scene, plan)?;
        umbrella::check_groups(scene, plan)?;
        affordable((scene.particles.len() as u64).saturating_mul(plan.replicas() as u64), &at)
    }
}

/// Minimum number of attempts to swap replicas in an equilibration that finds weights or brings replicas into their
/// windows. In a multicanonical exchange, the first weights follow from a quarter of the equilibration, and so from at
/// least five attempts.
const LEAST_LEARNING: u64 = 20;

const LOSSLESS: &str = "1 with [exchange]: a system that loses energy in contacts has no equilibrium";

/// Checks that multicanonical weights are possible: the potential energy must change, and only in steps.
fn check_energies(scene: &Scene, plan: &ExchangePlan) -> Result<(), SceneError> {
    if plan.ensemble != ExchangeEnsemble::Multicanonical {
        return Ok(());
    }
    let at = ConfigPath::root().key("exchange").key("ensemble");
    let value = "\"multicanonical\"";
    if scene.species.iter().any(|species| !species.is_static() && species.acceleration != Vector::zeros()) {
        let expected = "\"canonical\" in a scene with gravity: weights need an energy that changes in steps only";
        return refuse(at, value, expected);
    }
    let energies = || scene.interactions.iter().flat_map(|it| it.potential.energies());
    if !energies().any(|energy| energy.is_finite() && *energy != 0.0) {
        let expected = "\"canonical\" in a scene of hard bodies: their potential energy is always zero";
        return refuse(at, value, expected);
    }
    Ok(())
}

fn check_temperatures(plan: &ExchangePlan) -> Result<(), SceneError> {
    let temperatures = &plan.temperatures;
    if plan.umbrella.is_some() {
        let at = ConfigPath::root().key("exchange").key("umbrella");
        return refuse(at, "given", "none, except with exchange.ensemble = \"umbrella\"");
    }
    let at = ConfigPath::root().key("exchange").key("temperatures");
    let count = temperatures.len();
    if !(2..=MOST_TEMPERATURES).contains(&count) {
        let expected = format!(
            "2 to {MOST_TEMPERATURES} temperatures, ascending or descending: replicas at neighbouring temperatures are swapped"
        );
        return refuse(at, format!("a list of {count}"), expected);
    }
    for (index, temperature) in temperatures.iter().enumerate() {
        positive(*temperature, at.index(index))?;
    }
    let is_ascending = temperatures[1] > temperatures[0];
    let is_wrong = |pair: &[f64]| pair[0] == pair[1] || (pair[1] > pair[0]) != is_ascending;
    if let Some(index) = temperatures.windows(2).position(is_wrong) {
        let (before, here) = (temperatures[index], temperatures[index + 1]);
        let order = if is_ascending { "above" } else { "below" };
        let expected = if before == here {
            "a temperature that differs from the one before".to_owned()
        } else {
            format!("a temperature {order} the one before, {}: temperatures must ascend or descend", shortest(before))
        };
        return refuse(at.index(index + 1), shortest(here), expected);
    }
    Ok(())
}

/// Checks that the sides of an axis confine particles and conserve their energy.
fn check_axis(scene: &Scene, axis: usize, at: &ConfigPath) -> Result<(), SceneError> {
    match scene.space.boundary[axis] {
        Boundary::Flat => Ok(()),
        Boundary::Bounded { lower, upper } => {
            let [below, above] = scene.wall_temperatures[axis];
            let sides = [("lower", lower, below), ("upper", upper, above)];
            // If both walls of an axis have the same law, the scene gives it once for the axis.
            let is_common = scene.space.walls(axis) < 2 || (lower, below) == (upper, above);
            sides.into_iter().try_for_each(|(side, face, temperature)| {
                let wall = if is_common { at.clone() } else { at.key(side) };
                check_side(face, temperature, at, &wall)
            })
        }
        Boundary::Periodic => {
            let falls = scene.species.iter().position(|species| species.acceleration[axis] != 0.0);
            let Some(index) = falls else { return Ok(()) };
            let expected = "\"wall\" with [exchange]: particles that fall for ever have no equilibrium";
            refuse(at.clone(), format!("periodic, and `{}` falls along it", scene.species[index].name), expected)
        }
    }
}

fn check_surface(surface: &SceneSurface, at: &ConfigPath) -> Result<(), SceneError> {
    if surface.moves() {
        let expected = "to be absent with [exchange]: a system that a surface drives has no equilibrium";
        return refuse(at.key("motion"), "given", expected);
    }
    match surface.law {
        SurfaceLaw::Thermal { temperature } => {
            let expected = "to be absent with [exchange], whose replicas have their own temperatures";
            refuse(at.key("temperature"), shortest(temperature), expected)
        }
        SurfaceLaw::Reflecting(law) if law.dissipates() => {
            refuse(at.key("restitution"), shortest(law.restitution), LOSSLESS)
        }
        SurfaceLaw::Reflecting(_) => Ok(()),
    }
}

/// Checks that one side of an axis confines particles and conserves their energy. `wall` is the config path of the
/// side's keys.
fn check_side(face: Face, temperature: Option<f64>, axis: &ConfigPath, wall: &ConfigPath) -> Result<(), SceneError> {
    if let Some(temperature) = temperature {
        let expected = "to be absent with [exchange], whose replicas have their own temperatures";
        return refuse(wall.key("temperature"), shortest(temperature), expected);
    }
    match face {
        Face::Open => {
            let expected = "\"wall\" or \"periodic\" with [exchange]: particles that can escape have no equilibrium";
            refuse(axis.clone(), "open", expected)
        }
        Face::Wall(law) if law.dissipates() => refuse(wall.key("restitution"), shortest(law.restitution), LOSSLESS),
        Face::Wall(_) => Ok(()),
    }
}

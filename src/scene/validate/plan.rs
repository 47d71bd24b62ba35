use crate::Vector;
use crate::base::text::digits;
use crate::model::run_plan::{EQUILIBRATION, MEASUREMENT};
use crate::model::space::{Boundary, Space};
use crate::model::{Growth, GrowthTarget, Scene, SceneParts, StagePlan, Thermostat, ThermostatError, Threads, Until};
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, missing, refuse};
use crate::scene::limits::{finite, on_flat_axes, positive, positive_if_given};
use crate::scene::validate::{barostat, swap};

pub(in crate::scene) const SO_MANY_THREADS: &str = "a whole number from 1 to 64, or \"auto\"";

fn check_gravity(gravity: Option<Vector>, space: &Space, at: &ConfigPath) -> Result<(), SceneError> {
    gravity.map_or(Ok(()), |gravity| on_flat_axes(&gravity, &Vector::zeros(), space, &at.key("gravity")))
}

const ROUNDED: f64 = 1e-3;

/// Checks that the round-off of the start time is at most a thousandth of any duration or interval. In a time equal to
/// the round-off, the fastest particle must move by less than the smallest diameter.
pub(super) fn check_start_time(scene: &Scene) -> Result<(), SceneError> {
    let Scene { run, output, particles, start_time, .. } = scene;
    let stages = run.stages.iter().filter_map(|stage| stage.limit.time);
    let given = [run.limit.time, run.equilibration.time, output.thermo_interval, output.frame_interval];
    let fastest = particles.iter().map(|particle| particle.velocity.norm()).fold(0.0, f64::max);
    let smallest = scene.diameters_of_species().iter().map(|range| range.smallest).fold(f64::INFINITY, f64::min);
    // The start time affects only the times in the output. The engine counts time from the start of the run.
    let crossing = if fastest > 0.0 { smallest / fastest / ROUNDED } else { f64::INFINITY };
    let times = stages.chain(given.into_iter().flatten());
    let shortest = times.fold(crossing, f64::min);
    let most = ROUNDED * shortest / f64::EPSILON;
    if start_time.abs() <= most {
        return Ok(());
    }
    let expected = format!("at most {most:.1e}: with larger values, a time of {} is below round-off", digits(shortest));
    refuse(ConfigPath::root().key("start_time"), digits(*start_time), expected)
}

pub(super) fn check_limit(limit: Until, time: ConfigPath, events: ConfigPath) -> Result<(), SceneError> {
    positive_if_given(limit.time, time)?;
    if limit.events == Some(0) {
        return refuse(events, 0, "at least 1");
    }
    Ok(())
}

/// Whether a name is a valid folder name on every operating system.
fn is_file_name(name: &str) -> bool {
    let is_good = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.');
    !name.starts_with('.') && !name.ends_with('.') && name.len() <= 50 && name.chars().all(is_good)
}

impl SceneParts {
    pub(super) fn check_run(&self) -> Result<(), SceneError> {
        let at = ConfigPath::root().key("run");
        check_limit(self.run.equilibration, at.key("equilibration_time"), at.key("equilibration_events"))?;
        check_limit(self.run.limit, at.key("until_time"), at.key("until_events"))?;
        check_thermostat(self.run.thermostat.as_ref(), &at.key("thermostat"))?;
        barostat::check_numbers(self.run.barostat.as_ref(), &at.key("barostat"))?;
        swap::check_numbers(self.run.swap.as_ref(), &at.key("swap"))?;
        check_gravity(self.run.gravity, &self.space, &at)?;
        if let Threads::Number(number) = self.run.threads
            && !(1..=Threads::MOST).contains(&number)
        {
            return refuse(at.key("threads"), number, SO_MANY_THREADS);
        }
        for (index, stage) in self.run.stages.iter().enumerate() {
            let at = ConfigPath::entry("stage", index);
            if [EQUILIBRATION, MEASUREMENT].contains(&stage.name.as_str()) {
                let expected = "another name: every run has a stage of this name";
                return refuse(at.key("name"), format!("{:?}", stage.name), expected);
            }
            check_limit(stage.limit, at.key("until_time"), at.key("until_events"))?;
            check_gravity(stage.gravity, &self.space, &at)?;
            check_thermostat(stage.thermostat.as_ref(), &at.key("thermostat"))?;
            barostat::check_numbers(stage.barostat.as_ref(), &at.key("barostat"))?;
            swap::check_numbers(stage.swap.as_ref(), &at.key("swap"))?;
            if let Some(growth) = &stage.growth {
                check_growth(growth, &at.key("grow"))?;
            }
            self.check_measured_stage(index)?;
        }
        Ok(())
    }

    fn check_measured_stage(&self, index: usize) -> Result<(), SceneError> {
        let stage = &self.run.stages[index];
        let at = ConfigPath::entry("stage", index);
        let Some(equilibration) = stage.measured else { return Ok(()) };
        check_limit(equilibration.limit, at.key("equilibration_time"), at.key("equilibration_events"))?;
        if stage.limit == Until::default() {
            return Err(missing(&at, "until_time", "give it or until_events, so that the stage ends"));
        }
        let name = &stage.name;
        if !is_file_name(name) {
            let expected = "letters, digits, `_`, `-` and `.` only, not beginning with a dot: the tables of the stage \
                            are in a folder of this name";
            return refuse(at.key("name"), format!("{name:?} in a measured stage"), expected);
        }
        let is_same = |other: &StagePlan| other.name == *name || other.name == format!("{name} {EQUILIBRATION}");
        let others = self.run.stages.iter().enumerate().filter(|(other, _)| *other != index);
        if let Some((other, _)) = others.into_iter().find(|(_, other)| is_same(other)) {
            let expected = format!(
                "a name that no other stage has, because the stage is measured: stage {other} has the same name"
            );
            return refuse(at.key("name"), format!("{name:?}"), expected);
        }
        Ok(())
    }

    /// The box must be long enough for the planned shear. `longest` is the longest range of an interaction.
    pub(in crate::scene) fn check_shear(&self, space: &Space, longest: f64) -> Result<(), SceneError> {
        let Some(rate) = self.shear_rate else { return Ok(()) };
        let at = ConfigPath::root().key("space").key("shear_rate");
        finite(rate, at.clone())?;
        let is_wide = |k: usize| space.boundary[k] == Boundary::Flat || space.size[k] >= 4.0 * longest * (1.0 + 1e-5);
        if rate == 0.0 || space.boundary[..2].contains(&Boundary::Flat) || !(0..3).all(is_wide) {
            let expected = format!(
                "a rate other than 0, in a periodic box with edges of at least {}, four times the interaction range",
                4.0 * longest
            );
            return refuse(at, rate, expected);
        }
        Ok(())
    }
}

fn check_thermostat(thermostat: Option<&Thermostat>, at: &ConfigPath) -> Result<(), SceneError> {
    thermostat.map_or(Ok(()), |thermostat| thermostat.check().or_else(|error| refuse_thermostat(error, at)))
}

fn refuse_thermostat(error: ThermostatError, at: &ConfigPath) -> Result<(), SceneError> {
    match error {
        ThermostatError::Number { name, value } => positive(value, at.key(name)).map(drop),
        ThermostatError::NoAxis => refuse(at.key("axes"), "[]", "at least one axis"),
        ThermostatError::FlatAxes => refuse(at.key("axes"), "only flat ones", "an axis along which particles move"),
        ThermostatError::NothingMoves => refuse(
            at.key("kind"),
            "\"andersen\" in a scene in which nothing moves",
            "no thermostat, or particles that move",
        ),
        ThermostatError::NoTemperature | ThermostatError::Rescaling => {
            let expected = "\"andersen\": scaling velocities needs two or more moving particles, without gravity";
            refuse(at.key("kind"), "\"rescaling\"", expected)
        }
    }
}

/// If any stage sets the gravity, all moving species must have the same acceleration. Stages without a gravity get this
/// acceleration, and the species get the gravity of the first stage.
pub(super) fn settle_gravity(scene: &mut Scene) -> Result<(), SceneError> {
    if scene.run.gravities().next().is_none() {
        return Ok(());
    }
    let mut moving = scene.species.iter().filter(|species| !species.is_static());
    let first = moving.next().map_or(Vector::zeros(), |species| species.acceleration);
    if let Some(other) = moving.find(|species| species.acceleration != first) {
        let (index, key) = match scene.run.stages.iter().position(|stage| stage.gravity.is_some()) {
            Some(index) => (ConfigPath::entry("stage", index), "gravity"),
            None => (ConfigPath::root().key("run"), "gravity"),
        };
        let expected = format!("no gravity in a stage: `{}` has an acceleration of its own", other.name);
        return refuse(index.key(key), "given", expected);
    }
    for gravity in scene.run.stages.iter_mut().map(|stage| &mut stage.gravity).chain([&mut scene.run.gravity]) {
        gravity.get_or_insert(first);
    }
    let at_start = scene.run.gravities().next().unwrap_or(first);
    let moving = scene.species.iter_mut().filter(|species| !species.is_static());
    moving.for_each(|species| species.acceleration = at_start);
    Ok(())
}

/// Adapts thermostats to the particles and the box. For example, removes flat axes from a heat bath.
pub(super) fn settle_thermostats(scene: &mut Scene) -> Result<(), SceneError> {
    // Particles that enter move.
    let moving = scene.moving().count() + scene.inlets.len();
    let is_accelerated = scene.accelerations().any(|acceleration| acceleration != Vector::zeros());
    let space = &scene.space;
    let in_stages = scene.run.stages.iter_mut().enumerate();
    let in_stages = in_stages.map(|(index, stage)| (ConfigPath::entry("stage", index), &mut stage.thermostat));
    let all = in_stages.chain([(ConfigPath::root().key("run"), &mut scene.run.thermostat)]);
    for (at, thermostat) in all {
        let Some(given) = thermostat else { continue };
        match given.settled(space, moving, is_accelerated) {
            Ok(settled) => *given = settled,
            Err(error) => refuse_thermostat(error, &at.key("thermostat"))?,
        }
    }
    Ok(())
}

fn check_growth(growth: &Growth, at: &ConfigPath) -> Result<(), SceneError> {
    positive(growth.rate, at.key("rate"))?;
    match growth.until {
        GrowthTarget::PackingFraction(fraction) if !(fraction > 0.0 && fraction < 1.0) => {
            refuse(at.key("packing_fraction"), fraction, "a number between 0 and 1")
        }
        GrowthTarget::CompressibilityFactor(factor) if !(factor > 1.0 && factor <= 1e12) => {
            refuse(at.key("compressibility_factor"), factor, "a number above 1, up to 1e12")
        }
        _ => Ok(()),
    }
}

/// Packing fraction of the densest packing of equal particles; 1 for particles of several sizes.
fn densest(scene: &Scene) -> f64 {
    let diameters = || scene.particles.iter().map(|particle| scene.diameter(particle));
    let (least, largest) = (diameters().fold(f64::INFINITY, f64::min), diameters().fold(0.0, f64::max));
    match scene.space.dimensions() {
        _ if least != largest => 1.0,
        3 => std::f64::consts::PI / 18.0_f64.sqrt(),
        2 => std::f64::consts::PI / 12.0_f64.sqrt(),
        _ => 1.0,
    }
}

/// Checks that packing fractions increase, and that the final particles fit into the box.
pub(in crate::scene) fn check_growth_fits(scene: &Scene) -> Result<(), SceneError> {
    let shortest = scene.space.periods().min();
    let mut filled = scene.packing_fraction();
    for (index, stage) in scene.run.stages.iter().enumerate() {
        let Some(growth) = &stage.growth else { continue };
        let at = ConfigPath::entry("stage", index).key("grow");
        let target = match growth.until {
            GrowthTarget::PackingFraction(target) if target <= filled => {
                return refuse(
                    at.key("packing_fraction"),
                    target,
                    format!("more than {filled:.4}, the packing fraction at the start"),
                );
            }
            GrowthTarget::PackingFraction(target) if target > densest(scene) => {
                let expected = format!("at most {:.4}, the packing fraction of the densest packing", densest(scene));
                return refuse(at.key("packing_fraction"), target, expected);
            }
            GrowthTarget::PackingFraction(target) => target,
            // The final packing fraction is unknown. Its upper limit is 1.
            GrowthTarget::CompressibilityFactor(_) => 1.0,
        };
        let range = scene.longest_range() * scene.growth_to(target);
        if 2.0 * range > shortest {
            let expected =
                format!("a box at least twice as long as the final diameter ({range:.4}), or more particles");
            return refuse(ConfigPath::root().key("space").key("size"), shortest, expected);
        }
        if matches!(growth.until, GrowthTarget::PackingFraction(_)) {
            filled = target;
        }
    }
    Ok(())
}

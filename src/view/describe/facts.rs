//! Facts of a scene, for `carom check` and the page of the run.

use super::{
    barostat, counts, equilibration, exchange, inlets, interactions, population, space, stage, start, surfaces, swap,
    thermostat,
};
use crate::base::text::{digits, plural};
use crate::engine::SingleThread;
use crate::model::diameters::Diameters;
use crate::model::{Scene, Sleep, Species, StaticSurface, TcRule, Threads, Units, Until};

/// A fact of a scene.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Fact {
    /// Label of the fact, such as `particles`.
    pub label: &'static str,
    /// Lines of text, at least one.
    pub values: Vec<String>,
}

/// Returns the facts of a scene: system, dynamics and drives. Unused features are left out.
#[must_use]
pub fn facts(scene: &Scene) -> Vec<Fact> {
    let run = &scene.run;
    let equilibrates = run.until_stationary || run.equilibration != Until::default();
    let all: [(&'static str, Vec<String>); 19] = [
        ("start", start(scene).into_iter().collect()),
        ("units", units(scene).into_iter().collect()),
        ("particles", vec![population(scene)]),
        ("species", scene.species.iter().zip(counts(scene)).zip(scene.diameters_of_species()).map(species).collect()),
        ("space", space(scene)),
        ("interactions", interactions(scene)),
        ("meshes", scene.static_surfaces.iter().map(surface).collect()),
        ("surfaces", scene.surfaces.iter().map(|surface| surfaces::surface(scene, surface)).collect()),
        ("inlets", scene.inlets.iter().map(|inlet| inlets::inlet(scene, inlet)).collect()),
        ("TC model", scene.contact_time.map(|time| contact_time(time, scene.tc_rule)).into_iter().collect()),
        ("sleep", scene.sleep.as_ref().map(sleep).into_iter().collect()),
        ("shear", scene.shear_rate.map(shear).into_iter().collect()),
        ("stages", run.stages.iter().map(stage).collect()),
        ("equilibration", equilibrates.then(|| equilibration(run)).into_iter().collect()),
        ("thermostat", run.thermostat.as_ref().map(thermostat).into_iter().collect()),
        ("barostat", run.barostat.as_ref().map(barostat).into_iter().collect()),
        ("swap moves", run.swap.as_ref().map(swap).into_iter().collect()),
        ("exchange", scene.exchange().map(exchange).into_iter().collect()),
        ("threads", threads(scene).into_iter().collect()),
    ];
    all.into_iter().filter(|(_, values)| !values.is_empty()).map(|(label, values)| Fact { label, values }).collect()
}

fn units(scene: &Scene) -> Option<String> {
    let Units { length, mass, time } = scene.units();
    let energy = scene.unit_of("energy");
    (!scene.units().are_unnamed())
        .then(|| format!("{length}, {mass} and {time}; energies and temperatures in {energy}"))
}

fn sleep(sleep: &Sleep) -> String {
    let [interval, distance, wake_speed] = [sleep.interval, sleep.distance, sleep.wake_speed].map(digits);
    format!(
        "grains that move by at most {distance} in a time of {interval} fall asleep, until they are hit faster than {wake_speed}"
    )
}

fn species(((species, count), range): ((&Species, usize), Diameters)) -> String {
    let mass = match species.is_static() {
        true => "static".to_owned(),
        false if species.has_different_masses() => {
            format!("mass {} at diameter {}", digits(species.mass), digits(species.diameter))
        }
        false => format!("mass {}", digits(species.mass)),
    };
    let acceleration = species.acceleration;
    let falling = if acceleration.norm() > 0.0 {
        let [x, y, z] = [0, 1, 2].map(|k| digits(acceleration[k]));
        format!(", acceleration ({x}, {y}, {z})")
    } else {
        String::new()
    };
    let diameter = match species.individual {
        Some(_) => format!("diameters {} to {}", digits(range.smallest), digits(range.largest)),
        None => format!("diameter {}", digits(species.diameter)),
    };
    format!("{}: {count} of {diameter}, {mass}{falling}", species.name)
}

fn surface(surface: &StaticSurface) -> String {
    let hole = surface.hole.map_or_else(String::new, |hole| format!(", holes up to {} in radius", digits(hole)));
    format!("{}: {}{hole}", surface.name, plural(surface.particles.len(), "sphere"))
}

fn contact_time(time: f64, rule: TcRule) -> String {
    let is = match rule {
        TcRule::Resting => "elastic",
        TcRule::LudingMcNamara => "elastic and smooth",
    };
    format!("a contact is {is} if one of its particles had another contact within a time of {} before it", digits(time))
}

fn shear(rate: f64) -> String {
    format!("velocity along x, gradient along y, rate {}", digits(rate))
}

pub(crate) const AUTO_THREADS: &str = "as many as there are cores, at most one per 50000 particles";

/// Describes the number of threads, or explains why the run can use only one thread.
fn threads(scene: &Scene) -> Option<String> {
    let asked = match scene.run.threads {
        Threads::Number(1) => return None,
        Threads::Number(number) => number.to_string(),
        Threads::Auto => AUTO_THREADS.to_owned(),
    };
    let grows = scene.run.has_growth();
    Some(match SingleThread::of(scene) {
        Some(why) => format!("always 1: {why}"),
        None if grows => format!("{asked}; 1 while the diameters grow"),
        None => asked,
    })
}

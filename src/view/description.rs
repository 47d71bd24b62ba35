//! A scene in words, with warnings about probable mistakes: the output of `carom check`.

use super::describe;
use crate::Vector;
use crate::analysis::instruments::{SystemDescription, shortened_cutoffs};
use crate::analysis::observables::ApplicableObservables;
use crate::base::text::digits;
use crate::engine::EngineChoice;
use crate::model::scene::own_volume;
use crate::model::{InputFile, Particle, Scene, Until};
use crate::prepare::resting::{Ground, resting};
use crate::run::{self, Burden, Unreached};

/// Describes a scene by its facts, one per line.
#[must_use]
pub fn text(scene: &Scene) -> String {
    let mut text = format!("{}, seed {}\n", scene.name(), scene.seed());
    for fact in describe::facts(scene) {
        let labels = [fact.label].into_iter().chain(std::iter::repeat(""));
        text.extend(labels.zip(&fact.values).map(|(label, value)| line(label, value)));
    }
    text.extend(density(scene).map(|density| line("density", &density)));
    let choice = EngineChoice::new(scene);
    text + &line("engine", &format!("{choice}, {}", describe::reasons(scene, choice)))
        + &line("measurement", &describe::limit(&scene.run().limit))
}

/// Formats a line of a description: a label and its value.
#[must_use]
pub fn line(label: &str, value: &str) -> String {
    format!("  {label:<14}{value}\n")
}

/// Warns of valid but probably unintended settings.
#[must_use]
pub fn warnings(scene: &Scene) -> Vec<String> {
    let mut warnings = Vec::new();
    for leak in scene.leaks() {
        warnings.push(format!(
            "mesh `{}` leaks {}: a hole of radius {} where contact is at {}; make its spacing smaller",
            leak.surface,
            leak.species,
            digits(leak.hole),
            digits(leak.contact)
        ));
    }
    for gap in scene.gaps() {
        warnings.push(format!(
            "meshes `{}` and `{}` leave a gap of {} at their joint, through which {} can pass",
            gap.surface,
            gap.other,
            digits(gap.width),
            gap.species
        ));
    }
    warnings.extend(unused_input(scene));
    warnings.extend(unmeasurable(scene));
    warnings.extend(shortened(scene));
    warnings.extend(few_digits(scene));
    let moving = scene.particles().iter().any(|particle| !scene.species()[particle.species.0 as usize].is_static());
    if !moving && scene.inlets().is_empty() {
        warnings.push("nothing in the scene moves".to_owned());
    }
    let is_endless = scene.run().until_stationary && scene.run().equilibration == Until::default();
    if is_endless && scene.cools_for_ever() {
        warnings.push(
            "contacts lose energy and nothing supplies any, so that the system cools for ever and equilibration = \"auto\" gives up: set run.equilibration_time or \
             run.equilibration_events"
                .to_owned(),
        );
    }
    if scene.run().limit == Until::default() {
        warnings.push("the measurement has no end: set until_time or until_events".to_owned());
    }
    warnings.extend(unreached(scene));
    warnings.extend(burdens(scene));
    warnings.extend(at_rest(scene));
    warnings.extend(describe::idle_surfaces(scene));
    let is_dissipative = scene.interactions().iter().any(|interaction| interaction.law.dissipates());
    let is_falling = scene.accelerations().any(|acceleration| acceleration.norm() > 0.0);
    if is_dissipative && is_falling && scene.contact_time().is_none() {
        warnings.push(
            "particles that fall and lose energy come to rest through ever more frequent contacts: consider dynamics.contact_time"
                .to_owned(),
        );
    }
    warnings
}

/// Lists unused parts of input files, such as columns.
#[must_use]
pub fn unused_input(scene: &Scene) -> Vec<String> {
    let mut lines = Vec::new();
    for InputFile { path, unused, extra_bytes, .. } in scene.inputs() {
        if !unused.is_empty() {
            let names = unused.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
            lines.push(format!("ignored in {path}: {names}"));
        }
        if *extra_bytes > 0 {
            lines.push(format!("ignored in {path}: {extra_bytes} bytes after the number of triangles in its header"));
        }
    }
    lines
}

/// Lists planned measurements that are not defined for the scene, with the reasons.
#[must_use]
pub fn unmeasurable(scene: &Scene) -> Vec<String> {
    let plan = scene.measure();
    if plan.pressure_tensor.is_none() && plan.transport.is_none() {
        return Vec::new();
    }
    let system = SystemDescription::of(scene);
    let pressure = plan.pressure_tensor.is_some() && !system.has_volume();
    let pressure = pressure.then(|| {
        "measure.pressure_tensor gives event rates but no pressure: the volume that is accessible to the moving particles between the static particles is unknown".to_owned()
    });
    let transport = plan.transport.as_ref().and_then(|_| system.obstacle_to_transport()).map(|obstacle| {
        format!(
            "measure.transport gives no results {obstacle}: Einstein-Helfand relations hold in equilibrium, where momentum and energy are conserved, in a periodic box"
        )
    });
    pressure.into_iter().chain(transport).collect()
}

/// Lists cutoffs that the box shortens, with the reasons.
#[must_use]
pub fn shortened(scene: &Scene) -> Vec<String> {
    let plan = scene.measure();
    if plan.radial_distribution.is_none() && plan.bond_order.is_none() {
        return Vec::new();
    }
    shortened_cutoffs(plan, &SystemDescription::of(scene))
}

/// Lists planned times that no stage reaches.
#[must_use]
pub fn unreached(scene: &Scene) -> Vec<String> {
    let told = |it| match it {
        Unreached::Time { key, time, stage, duration } => {
            let of = stage.map_or_else(|| "the longest measurement".to_owned(), |stage| format!("the stage `{stage}`"));
            format!("{key} of {} is longer than {of}, {}, so it is never reached", digits(time), digits(duration))
        }
        Unreached::Amplitude { moves, fewest } => format!(
            "{} volume moves before the measurement are too few to find an amplitude: plan at least {}, or set barostat.amplitude",
            digits(moves),
            digits(fewest)
        ),
        Unreached::Swaps { stage, is_forbidden: true, .. } => format!(
            "no swap moves in the stage `{stage}` will be accepted, because all ratios of diameters are above swap.largest_ratio"
        ),
        Unreached::Swaps { stage, acceptance, .. } => format!(
            "only about {acceptance:.0e} of the swap moves between unlike particles in the stage `{stage}` will be accepted: use more similar diameters, or add sizes in between"
        ),
    };
    run::unreached(scene).into_iter().map(told).collect()
}

/// Warns of particles that start at rest and in contact. The TC model lifts them.
#[must_use]
pub fn at_rest(scene: &Scene) -> Vec<String> {
    if scene.contact_time().is_some() {
        return Vec::new();
    }
    let all = resting(scene);
    let Some(first) = all.iter().min_by(|one, other| one.bounce.total_cmp(&other.bounce)) else { return Vec::new() };
    let ground = match &first.ground {
        Ground::Wall(axis, is_upper) => {
            let (axis, side) = (["x", "y", "z"][usize::from(*axis)], if *is_upper { "upper" } else { "lower" });
            format!("the {side} wall of {axis}")
        }
        Ground::Surface(name) => format!("surface `{name}`"),
        Ground::Particle(particle) => format!("particle {}", particle.0),
    };
    let others = match all.len() - 1 {
        0 => String::new(),
        others => format!(" (and {others} more)"),
    };
    let cause = match first.bounce {
        0.0 => "which needs infinitely many contacts: the run ends immediately with a dynamical arrest".to_owned(),
        bounce => {
            format!("and is in contact again every {} of time: the simulated time hardly advances", digits(bounce))
        }
    };
    let cure = "set dynamics.contact_time (the TC model), so that grains can rest, or move the particle slightly away";
    vec![format!("particle {} rests on {ground}{others}, {cause}; {cure}", first.particle.0)]
}

/// Lists what slows a run down besides its events, with wall times.
#[must_use]
pub fn burdens(scene: &Scene) -> Vec<String> {
    run::burdens(scene).into_iter().map(told).collect()
}

fn told(Burden { cause, seconds }: Burden) -> String {
    match seconds {
        // A wall time below one second is negligible or unknown.
        ..1.0 => cause,
        _ => format!("{cause}: about {} of wall time", wall_time(seconds)),
    }
}

fn wall_time(seconds: f64) -> String {
    match seconds {
        ..120.0 => format!("{seconds:.0} seconds"),
        ..7_200.0 => format!("{:.0} minutes", seconds / 60.0),
        ..172_800.0 => format!("{:.0} hours", seconds / 3_600.0),
        ..63_072_000.0 => format!("{:.0} days", seconds / 86_400.0),
        _ => format!("{} years", digits(seconds / 31_536_000.0)),
    }
}

/// Describes the number density and packing fraction, if all axes are periodic.
fn density(scene: &Scene) -> Option<String> {
    if !scene.space().is_fully_periodic() {
        return None;
    }
    let volume = scene.space().volume();
    let dimensions = scene.space().dimensions();
    let moving = || scene.particles.iter().filter(|particle| !scene.is_static(particle));
    let body = |particle: &Particle| own_volume(scene.diameter(particle), dimensions);
    let number_density = moving().count() as f64 / volume;
    let packing_fraction = moving().map(body).sum::<f64>() / volume;
    let temperature =
        temperature(scene).map_or_else(String::new, |now| format!(", temperature {} at the start", digits(now)));
    let (number_density, packing_fraction) = (digits(number_density), digits(packing_fraction));
    let when = if scene.run().has_barostat() { " at the start" } else { "" };
    Some(format!("number density {number_density}, packing fraction {packing_fraction}{when}{temperature}"))
}

fn temperature(scene: &Scene) -> Option<f64> {
    let mut kinetic = 0.0;
    let mut momentum = Vector::zeros();
    for particle in scene.particles() {
        if !scene.is_static(particle) {
            let (mass, velocity) =
                (scene.mass(particle), particle.velocity - scene.streaming_velocity(&particle.position));
            kinetic += 0.5 * mass * velocity.norm_squared();
            momentum += velocity * mass;
        }
    }
    ApplicableObservables::of(scene).temperature(kinetic, &momentum)
}

/// Warns if round-off of large coordinates or energies may cause overlaps. The audit accepts overlaps of up to a
/// millionth of a diameter.
fn few_digits(scene: &Scene) -> Vec<String> {
    const ROUNDINGS: f64 = 32.0;
    const MOST: f64 = 1e-8;
    let mut warnings = Vec::new();
    let smallest = scene.particles.iter().map(|particle| scene.diameter(particle)).fold(f64::INFINITY, f64::min);
    let farthest = scene.space().lower.amax().max(scene.space().upper().amax());
    let lost = ROUNDINGS * f64::EPSILON * farthest / smallest;
    if smallest.is_finite() && lost > MOST {
        warnings.push(format!(
            "coordinates of up to {} have a round-off of {} of the smallest diameter; the audit allows overlaps of at \
             most 1e-6",
            digits(farthest),
            digits(lost)
        ));
    }
    let steps =
        |energies: &[f64]| energies.iter().filter(|energy| energy.is_finite()).fold(0.0, |a: f64, e| a.max(e.abs()));
    let deepest = scene.interactions().iter().map(|it| steps(it.potential.energies())).fold(0.0, f64::max);
    let kinetic = scene
        .particles()
        .iter()
        .filter(|particle| !scene.is_static(particle))
        .map(|particle| 0.5 * scene.mass(particle) * particle.velocity.norm_squared())
        .fold(0.0, f64::max);
    let lost = f64::EPSILON * deepest / kinetic;
    if kinetic > 0.0 && lost > MOST {
        warnings.push(format!(
            "potential steps of up to {} cause relative round-off errors of up to {} in kinetic energies",
            digits(deepest),
            digits(lost)
        ));
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_wall_time_is_omitted() {
        let of = |seconds| told(Burden { cause: "large cells".to_owned(), seconds });
        assert_eq!([of(-0.0), of(0.0), of(0.25)], ["large cells"; 3]);
        assert_eq!(of(90.4), "large cells: about 90 seconds of wall time");
    }

    fn never(run: &str, measure: &str) -> Vec<String> {
        let text = format!(
            "species = [{{ name = \"A\", mass = 1.3, diameter = 1.0 }}]\n\
             interaction = [{{ species = [\"A\", \"A\"], potential = \"hard-sphere\" }}]\n\
             fill = [{{ species = \"A\", count = 32, arrangement = \"fcc\", packing_fraction = 0.2, temperature = 1.0 }}]\n{run}\n[measure]\n{measure}\n"
        );
        unreached(&Scene::from_toml(&text, "fluid.toml").unwrap())
    }

    #[test]
    fn intervals_longer_than_their_stage_give_a_warning() {
        let bath = "thermostat = { kind = \"andersen\", temperature = 1.0, rate = 1.0 }";
        let run = format!(
            "run = {{ {bath}, barostat = {{ pressure = 2.0, interval = 0.5 }}, equilibration_time = 19.9, until_time = 0.4 }}"
        );
        assert_eq!(
            never(&run, ""),
            [
                "barostat.interval of 0.5 is longer than the stage `measurement`, 0.4, so it is never reached",
                "39 volume moves before the measurement are too few to find an amplitude: plan at least 40, or set barostat.amplitude"
            ]
        );
        let enough = "equilibration_time = 20.0, until_time = 0.5";
        let run = run.replace("equilibration_time = 19.9, until_time = 0.4", enough);
        assert_eq!(never(&run, ""), [""; 0]);
        let given = run.replace("interval = 0.5", "interval = 0.5, amplitude = 0.1").replace("20.0", "1.0");
        assert_eq!(never(&given, ""), [""; 0]);
        let scaled = "run = { thermostat = { kind = \"rescaling\", temperature = 1.0, interval = 2.0 }, equilibration_time = 1.0, until_time = 8.0 }";
        let of_stage = ["thermostat.interval of 2 is longer than the stage `equilibration`, 1, so it is never reached"];
        assert_eq!(never(scaled, ""), of_stage);
        let measure = "diffusion = { interval = 0.5, span = 8.5 }\nspeeds = { window = 8.0 }\nflow = [{ name = \"gate\", axis = \"z\", at = 1.0, interval = 9.0 }]";
        let run = "run = { until_time = 8.0 }";
        let late = ["measure.diffusion.span of 8.5", "measure.flow[0].interval of 9"];
        assert_eq!(
            never(run, measure),
            late.map(|it| format!("{it} is longer than the longest measurement, 8, so it is never reached"))
        );
        // The simulated time of these events is unknown.
        assert_eq!(never("run = { until_events = 100 }", measure), [""; 0]);
    }
}

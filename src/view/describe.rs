//! Descriptions of a scene in words.

mod barostat;
mod estimate;
mod exchange;
mod facts;
mod inlets;
mod surfaces;
mod swap;

pub use barostat::{barostat, volume_moves};
pub use estimate::{estimate, observable};
pub use exchange::{distance_between, exchange};
pub(crate) use facts::AUTO_THREADS;
pub use facts::{Fact, facts};
pub use surfaces::{idle_surfaces, meshes};
pub use swap::{swap, swap_moves};

use std::collections::BTreeMap;
use std::path::Path;

use crate::Vector;
use crate::base::numbers::id;
use crate::base::text::{digits, listed, plural};
use crate::engine::EngineChoice;
use crate::model::potential::Potential;
use crate::model::space::{Boundary, Face};
use crate::model::{
    ContactLaw, Equilibration, GrowthTarget, Influence, Interaction, Restitution, Roughness, RunPlan, Scene, Species,
    SpeciesId, StagePlan, Thermostat, Until,
};

/// Returns the number of particles of each species.
#[must_use]
pub fn counts(scene: &Scene) -> Vec<usize> {
    let mut counts = vec![0; scene.species.len()];
    for particle in &scene.particles {
        counts[particle.species.0 as usize] += 1;
    }
    counts
}

/// Describes the particles of a scene: the number of particles of each species.
#[must_use]
pub fn population(scene: &Scene) -> String {
    population_of(scene, &counts(scene))
}

/// Describes the number of particles of each species, such as `500 A + 20 B`.
#[must_use]
pub fn population_of(scene: &Scene, counts: &[usize]) -> String {
    let of = |is_static: bool| {
        let species = scene.species.iter().zip(counts).filter(|(species, _)| species.is_static() == is_static);
        let words: Vec<String> = species.map(|(species, count)| format!("{count} {}", species.name)).collect();
        words.join(" + ")
    };
    let moving = if of(false).is_empty() { "nothing".to_owned() } else { of(false) };
    if of(true).is_empty() { moving } else { format!("{moving}; static: {}", of(true)) }
}

/// Returns the potential of the moving particles, such as `hard ` with a space; empty for several potentials.
#[must_use]
pub fn kind_of_potential(scene: &Scene) -> &'static str {
    let kind = |potential: &Potential| match potential.energies() {
        _ if potential.is_hard_sphere() => "hard ",
        [_, well, f64::INFINITY] if *well < 0.0 => "square-well ",
        [_, shoulder, f64::INFINITY] if *shoulder > 0.0 => "square-shoulder ",
        [.., core] if core.is_finite() => "penetrable ",
        _ => "stepped-potential ",
    };
    let is_moving = |at: usize| scene.species.get(at).is_some_and(|species| !species.is_static());
    let pairs = scene.table.iter().filter(|([a, b], _)| is_moving(*a) && is_moving(*b));
    let mut kinds = pairs.map(|(_, id)| kind(&scene.interactions[id.0 as usize].potential));
    let first = kinds.next().unwrap_or_default();
    if kinds.all(|other| other == first) { first } else { "" }
}

/// Describes the box, with one line per axis.
#[must_use]
pub fn space(scene: &Scene) -> Vec<String> {
    let axes = ["x", "y", "z"].iter().enumerate().map(|(k, name)| {
        let (lower, upper) = (scene.space.lower[k], scene.space.upper()[k]);
        let [below, above] = scene.wall_temperatures[k];
        let what = match &scene.space.boundary[k] {
            Boundary::Flat => return format!("{name} flat"),
            Boundary::Periodic => "periodic".to_owned(),
            Boundary::Bounded { lower, upper } => {
                let (lower, upper) = (face(lower, below), face(upper, above));
                if lower == upper { lower } else { format!("{lower} below, {upper} above") }
            }
        };
        format!("{name} from {} to {} {what}", digits(lower), digits(upper))
    });
    axes.collect()
}

fn face(face: &Face, temperature: Option<f64>) -> String {
    match (face, temperature) {
        (Face::Open, _) => "open".to_owned(),
        (Face::Wall(_), Some(temperature)) => format!("wall (temperature {temperature})"),
        (Face::Wall(law), None) => format!("wall ({})", contact_law(law)),
    }
}

/// Explains why an engine was chosen.
#[must_use]
pub fn reasons(scene: &Scene, choice: EngineChoice) -> String {
    let motion = if choice.is_falling {
        let falling: Vec<&str> = scene
            .species
            .iter()
            .filter(|species| species.acceleration.norm() > 0.0)
            .map(|species| species.name.as_str())
            .collect();
        format!("{} {}", listed(&falling), if falling.len() == 1 { "accelerates" } else { "accelerate" })
    } else {
        "nothing accelerates".to_owned()
    };
    let pairs = if !choice.has_table {
        "all particles are hard spheres of one species"
    } else if scene.species.iter().any(Species::is_static) {
        "some particles are static"
    } else if scene.has_individual_diameters() {
        "particles have individual diameters"
    } else if scene.species.len() > 1 {
        "there are several species"
    } else if !scene.bonds.is_empty() {
        "there are bonds"
    } else if scene.table.iter().next().is_none() {
        "particles do not interact with each other"
    } else {
        "pairs can be captured in potential steps"
    };
    format!("because {motion}, and {pairs}")
}

/// Describes an interaction in one line.
#[must_use]
pub fn interaction(interaction: &Interaction) -> String {
    let law = &interaction.law;
    let is_plain = law.roughness.is_none() && !law.dissipates();
    let law = if is_plain { String::new() } else { format!(", {}", contact_law(law)) };
    format!("{}{law}", potential(&interaction.potential))
}

/// Describes a coefficient of restitution.
pub(super) fn restitution(restitution: &Restitution) -> String {
    match restitution {
        Restitution::Constant(restitution) => format!("restitution {restitution}"),
        Restitution::Viscoelastic { viscous_time, stiffness } => {
            format!("restitution of viscoelastic spheres (A = {viscous_time}, rho = {stiffness})")
        }
        Restitution::Table(table) => {
            let (speeds, values) = (table.speeds(), table.values());
            let last = speeds.len() - 1;
            let first = format!("restitution {}", values[0]);
            match last {
                0 => first,
                _ => format!("{first} (at speed {}) to {} (at speed {})", speeds[0], values[last], speeds[last]),
            }
        }
    }
}

/// Describes a contact law by its numbers.
pub(super) fn contact_law(law: &ContactLaw) -> String {
    let restitution = restitution(&law.restitution);
    let Some(Roughness { tangential_restitution, friction }) = law.roughness else { return restitution };
    let sliding = if friction == f64::INFINITY { "no sliding".to_owned() } else { format!("friction {friction}") };
    format!("{restitution}, tangential restitution {tangential_restitution}, {sliding}")
}

fn potential(potential: &Potential) -> String {
    let (radii, energies) = (potential.radii(), potential.energies());
    let innermost = digits(radii[radii.len() - 1]);
    match (potential.is_bond(), potential.core().is_some(), radii.len()) {
        (true, true, 2) => format!("bond from {innermost} to {}", digits(radii[0])),
        (false, true, 1) => format!("hard spheres of contact distance {innermost}"),
        (false, true, 2) => {
            let what = if energies[1] < 0.0 { "well of depth" } else { "shoulder of height" };
            let size = digits(energies[1].abs());
            format!("hard core {innermost} with a square {what} {size}, range {}", digits(radii[0]))
        }
        (false, false, 1) => {
            format!("penetrable spheres of diameter {innermost}; an overlap costs the energy {}", digits(energies[1]))
        }
        _ => {
            let range = energies.iter().copied().filter(|energy| energy.is_finite());
            let lowest = digits(range.clone().fold(f64::INFINITY, f64::min));
            let highest = digits(range.fold(f64::NEG_INFINITY, f64::max));
            let core = if potential.core().is_some() { format!(", core {innermost}") } else { String::new() };
            let steps = plural(radii.len(), "step");
            format!("{steps} between energies {lowest} and {highest}, range {}{core}", digits(radii[0]))
        }
    }
}

/// Describes the interactions, with one line for each.
#[must_use]
pub fn interactions(scene: &Scene) -> Vec<String> {
    let mut lines = Vec::new();
    let species = |index: usize| &scene.species[index];
    let is_individual = |index: usize| species(index).individual.is_some();
    let scaled = |is_individual: bool| if is_individual { "; distances scale with the radii of the pair" } else { "" };
    for a in 0..scene.species.len() {
        for b in a..scene.species.len() {
            if species(a).is_static() && species(b).is_static() {
                continue;
            }
            let what = match scene.interaction_of(SpeciesId(id(a)), SpeciesId(id(b))) {
                Some(id) => {
                    interaction(&scene.interactions[id.0 as usize]) + scaled(is_individual(a) || is_individual(b))
                }
                None => "pass through each other".to_owned(),
            };
            lines.push(format!("{} and {}: {what}", species(a).name, species(b).name));
        }
    }
    let mut bonds: BTreeMap<u32, (usize, bool)> = BTreeMap::new();
    for bond in &scene.bonds {
        let (count, any) = bonds.entry(bond.interaction.0).or_default();
        *count += 1;
        *any |= bond.pair.iter().any(|id| is_individual(scene.particles[id.0 as usize].species.0 as usize));
    }
    for (id, (count, any)) in bonds {
        let law = interaction(&scene.interactions[id as usize]);
        lines.push(format!("{}: {law}{}", plural(count, "bonded pair"), scaled(any)));
    }
    lines
}

fn vector(v: &Vector) -> String {
    format!("({}, {}, {})", digits(v.x), digits(v.y), digits(v.z))
}

/// Describes a duration.
#[must_use]
pub fn limit(limit: &Until) -> String {
    match (limit.time, limit.events) {
        (Some(time), Some(events)) => format!("for a time of {time} or {events} events, whichever comes first"),
        (Some(time), None) => format!("for a time of {time}"),
        (None, Some(events)) => format!("for {events} events"),
        (None, None) => "not at all".to_owned(),
    }
}

/// Describes the length of an equilibration.
#[must_use]
pub fn equilibration(run: &RunPlan) -> String {
    equilibrates(&run.last_equilibration())
}

fn equilibrates(equilibration: &Equilibration) -> String {
    match (equilibration.until_stationary, equilibration.limit == Until::default()) {
        (true, true) => {
            let most = crate::run::MOST_EVENTS_PER_PARTICLE;
            format!("until nothing drifts; gives up after {most} events per particle")
        }
        (true, false) => format!("until nothing drifts, at most {}", limit(&equilibration.limit)),
        (false, _) => limit(&equilibration.limit),
    }
}

/// Describes a stage, such as
/// `growth: diameters grow by 0.05 of their initial values per unit of time, up to a packing fraction of 0.6`.
#[must_use]
pub fn stage(stage: &StagePlan) -> String {
    let mut parts = Vec::new();
    if let Some(growth) = &stage.growth {
        let until = match growth.until {
            GrowthTarget::PackingFraction(fraction) => format!("a packing fraction of {}", digits(fraction)),
            GrowthTarget::CompressibilityFactor(factor) => format!("a compressibility factor of {}", digits(factor)),
        };
        parts.push(format!(
            "diameters grow by {} of their initial values per unit of time, up to {until}",
            digits(growth.rate)
        ));
    }
    parts.extend(stage.gravity.map(|gravity| format!("gravity {}", vector(&gravity))));
    parts.extend(stage.thermostat.as_ref().map(thermostat));
    parts.extend(stage.barostat.as_ref().map(barostat));
    parts.extend(stage.swap.as_ref().map(swap));
    if let Some(before) = stage.measured.filter(|before| !before.is_empty()) {
        parts.push(format!("equilibrates {}", equilibrates(&before)));
    }
    if stage.limit != Until::default() {
        let measured = if stage.measured.is_some() { "measured " } else { "" };
        parts.push(format!("{measured}{}", limit(&stage.limit)));
    }
    format!("{}: {}", stage.name, parts.join("; "))
}

/// Describes a thermostat.
#[must_use]
pub fn thermostat(thermostat: &Thermostat) -> String {
    match thermostat {
        Thermostat::Andersen { temperature, rate, axes } => {
            let names: String =
                ["x", "y", "z"].iter().zip(axes).filter(|(_, is_on)| **is_on).map(|(name, _)| *name).collect();
            let (temperature, rate) = (digits(*temperature), digits(*rate));
            format!(
                "each particle gets a new velocity at temperature {temperature} along {names} {rate} times per unit of time (Andersen)"
            )
        }
        Thermostat::Rescaling { temperature, interval } => {
            format!("velocities are scaled to temperature {} every {}", digits(*temperature), digits(*interval))
        }
    }
}

/// Lists why a run does not conserve momentum, such as `walls along x and y, acceleration along z`.
#[must_use]
pub fn momentum_changes(scene: &Scene) -> String {
    let axes = |changed: &[bool; 3]| {
        let names = ["x", "y", "z"].into_iter().zip(changed).filter(|(_, is_changed)| **is_changed);
        listed(&names.map(|(name, _)| name).collect::<Vec<_>>())
    };
    let mut redrawn = [false; 3];
    for stage in scene.run.stages.iter().map(|stage| stage.thermostat).chain([scene.run.thermostat]).flatten() {
        if let Thermostat::Andersen { axes, .. } = stage {
            redrawn = std::array::from_fn(|axis| redrawn[axis] || axes[axis]);
        }
    }
    let mut words: Vec<String> = scene
        .influences()
        .iter()
        .filter_map(|(influence, changed)| match influence {
            Influence::Walls => Some(format!("walls along {}", axes(changed))),
            Influence::Surfaces => Some("surfaces".to_owned()),
            Influence::ThermalWalls => Some("thermal walls".to_owned()),
            Influence::SlidingContacts => Some(format!("sliding contacts along {}", axes(changed))),
            Influence::Gravity => Some(format!("acceleration along {}", axes(changed))),
            Influence::StaticParticles => Some("static particles".to_owned()),
            Influence::Flow => Some("particles that enter or leave".to_owned()),
            Influence::Sleep => Some("grains that fall asleep".to_owned()),
            // `redrawn` contains the axes of these collisions.
            Influence::AndersenCollisions => None,
        })
        .collect();
    if redrawn != [false; 3] {
        words.push(format!("a heat bath along {}", axes(&redrawn)));
    }
    if scene.shear_rate.is_some() {
        words.push("shear".to_owned());
    }
    words.join(", ")
}

/// Describes the earlier run from which a scene starts, if there is one.
#[must_use]
pub fn start(scene: &Scene) -> Option<String> {
    let run = scene.predecessor()?;
    let checkpoint = Path::new(&run.checkpoint.path);
    let folder = checkpoint.parent().unwrap_or(checkpoint).display();
    let engine = match run.differences() {
        [] => "its engine continues: the results are equal, bit for bit, to the results of one longer run".to_owned(),
        differences => format!("a new engine begins there, because these differ: {}", differences.join(", ")),
    };
    Some(format!("the end of {folder}, at t = {}; {engine}", digits(scene.start_time)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Growth;
    use crate::scene::{InteractionDraft, Model, SpeciesDraft};

    #[test]
    fn distances_that_scale_with_individual_radii_are_named() {
        let scene = |individual: &str, own: &str| {
            let text = format!(
                "space = {{ size = [9.0, 9.0, 9.0] }}
                species = [{{ name = 'bead', mass = 1.0, diameter = 1.0{individual} }}]
                interaction = [
                    {{ species = ['bead', 'bead'], potential = 'hard-sphere' }},
                    {{ name = 'link', potential = 'bond', shortest = 1.0, longest = 1.5 }},
                ]
                particle = [
                    {{ species = 'bead', position = [1, 1, 1]{own} }},
                    {{ species = 'bead', position = [2.2, 1, 1]{own} }},
                ]
                bond = [{{ particles = [0, 1], interaction = 'link' }}]
                run = {{ until_time = 1.0 }}"
            );
            interactions(&crate::model::Scene::from_toml(text, "dumbbell.toml").unwrap())
        };
        let lines = |scaled: &str| {
            let [core, bond] =
                ["bead and bead: hard spheres of contact distance 1", "1 bonded pair: bond from 1 to 1.5"];
            [core, bond].map(|line| format!("{line}{scaled}"))
        };
        assert_eq!(scene("", ""), lines(""));
        let individual = scene(", diameters = 'individual'", ", diameter = 1.0");
        assert_eq!(individual, lines("; distances scale with the radii of the pair"));
    }

    #[test]
    fn only_what_changes_the_momentum_is_named() {
        let scene = crate::scene::SceneBuilder::new("box")
            .space(crate::model::space::Space {
                boundary: [Boundary::walls(1.0), Boundary::Periodic, Boundary::walls(1.0)],
                ..crate::model::space::Space::periodic_cube(9.0)
            })
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .gravity(crate::Vector::new(0.0, -1.0, 0.0))
            .particle("A", crate::Vector::repeat(4.0), crate::Vector::zeros())
            .build()
            .unwrap();
        assert_eq!(momentum_changes(&scene), "walls along x and z, acceleration along y");
        let between_walls = crate::scene::SceneBuilder::new("box")
            .space(crate::model::space::Space {
                boundary: [Boundary::walls(1.0); 3],
                ..crate::model::space::Space::periodic_cube(9.0)
            })
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .particle("A", crate::Vector::repeat(4.0), crate::Vector::zeros())
            .build()
            .unwrap();
        assert_eq!(momentum_changes(&between_walls), "walls along x, y and z");
        let ball = crate::model::Scene::from_file("configs/bouncing_ball.toml").unwrap();
        let expected = "walls along z, sliding contacts along x and y, acceleration along z";
        assert_eq!(momentum_changes(&ball), expected, "x and y are open");
    }

    #[test]
    fn stage_description_names_growth_and_thermostat() {
        let growth = Growth { rate: 0.05, until: GrowthTarget::CompressibilityFactor(1000.0) };
        let bath = Thermostat::Andersen { temperature: 1.5, rate: 0.25, axes: [true, false, true] };
        let mut plan = StagePlan {
            name: "dense".to_owned(),
            limit: Until::time(20.0),
            thermostat: Some(bath),
            growth: Some(growth),
            ..StagePlan::default()
        };
        let text = stage(&plan);
        for part in [
            "dense: diameters grow by 0.05",
            "a compressibility factor of 1000",
            "temperature 1.5 along xz 0.25 times",
            "for a time of 20",
        ] {
            assert!(text.contains(part), "{text}");
        }
        plan.growth = Some(Growth { until: GrowthTarget::PackingFraction(0.6), ..growth });
        plan.thermostat = Some(Thermostat::Rescaling { temperature: 2.0, interval: 0.1 });
        plan.limit = Until::default();
        let text = stage(&plan);
        assert!(
            text.ends_with("up to a packing fraction of 0.6; velocities are scaled to temperature 2 every 0.1"),
            "{text}"
        );
    }
}

//! A table of features that exclude each other, for validation, the JSON Schema and the documents.

use std::fmt;

use crate::Vector;
use crate::base::text::shortest;
use crate::model::space::{AXES, Boundary, Face};
use crate::model::{
    Barostat, ContactLaw, ExchangeEnsemble, Growth, Interaction, Restitution, Roughness, RunPlan, SceneParts,
    SceneSurface, SurfaceLaw, Swap, Thermostat, Threads,
};
use crate::scene::builder::SceneBuilder;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, refuse};
use crate::scene::unvalidated::InteractionDraft;
use crate::scene::validate::start::Configuration;

/// A feature that a scene or one of its stages may have.
#[derive(Clone, Copy)]
pub struct Feature {
    /// Name in messages and documents.
    pub name: &'static str,
    /// Keys of a scene file that enable the feature, such as `space.shear_rate`. Indices are left out.
    pub keys: &'static [&'static str],
    found: Search,
}

impl fmt::Debug for Feature {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

/// Two features that exclude each other in a scene. Features of stages exclude each other only in the same stage.
#[derive(Debug, Clone, Copy)]
pub struct Exclusion {
    /// The feature whose value is marked in the error.
    pub feature: Feature,
    /// The feature that excludes `feature`.
    pub with: Feature,
    /// Words after the value in the error, such as "with gravity"; may be empty.
    pub circumstance: &'static str,
    /// What is expected instead; empty if the feature must be absent.
    cure: &'static str,
    /// Why the features exclude each other; empty if `cure` already explains it.
    reason: &'static str,
}

impl Exclusion {
    /// What is expected instead of the feature, and why.
    #[must_use]
    pub fn expected(&self) -> String {
        let absent = format!("to be absent with {}", self.with.name);
        let cure = if self.cure.is_empty() { absent.as_str() } else { self.cure };
        if self.reason.is_empty() { cure.to_owned() } else { format!("{cure}: {}", self.reason) }
    }
}

/// A scene during one of its stages.
struct Subject<'a> {
    builder: &'a SceneBuilder,
    parts: &'a SceneParts,
    start: &'a Configuration<'a>,
    phase: Phase<'a>,
}

/// Config path of a feature (`None` for its first key), and the value for the error message.
type Found = (Option<ConfigPath>, String);

type Search = fn(&Subject<'_>) -> Option<Found>;

pub(super) struct Phase<'a> {
    pub at: ConfigPath,
    pub thermostat: Option<&'a Thermostat>,
    pub barostat: Option<&'a Barostat>,
    pub swap: Option<&'a Swap>,
    pub growth: Option<&'a Growth>,
    /// Whether part of the stage is simulated but not measured.
    pub is_prepared: bool,
    pub is_measured: bool,
}

/// Iterates over the stages of a run. The measurement with its equilibration comes last.
pub(super) fn phases(plan: &RunPlan) -> impl Iterator<Item = Phase<'_>> {
    let listed = plan.stages.iter().enumerate().map(|(index, stage)| Phase {
        at: ConfigPath::entry("stage", index),
        thermostat: stage.thermostat.as_ref(),
        barostat: stage.barostat.as_ref(),
        swap: stage.swap.as_ref(),
        growth: stage.growth.as_ref(),
        is_prepared: stage.measured.is_none_or(|before| !before.is_empty()),
        is_measured: stage.measured.is_some(),
    });
    listed.chain([Phase {
        at: ConfigPath::root().key("run"),
        thermostat: plan.thermostat.as_ref(),
        barostat: plan.barostat.as_ref(),
        swap: plan.swap.as_ref(),
        growth: None,
        is_prepared: !plan.last_equilibration().is_empty(),
        is_measured: true,
    }])
}

pub(super) fn check(builder: &SceneBuilder, start: &Configuration<'_>) -> Result<(), SceneError> {
    let parts = &builder.parts;
    let subjects: Vec<_> = phases(&parts.run).map(|phase| Subject { builder, parts, start, phase }).collect();
    for row in EXCLUSIONS {
        for subject in &subjects {
            let Some((at, value)) = (row.feature.found)(subject) else { continue };
            if (row.with.found)(subject).is_some() {
                let at = at.unwrap_or_else(|| path(row.feature.keys[0]));
                return refuse(at, format!("{value} {}", row.circumstance).trim_end(), row.expected());
            }
        }
    }
    Ok(())
}

fn path(key: &'static str) -> ConfigPath {
    key.split('.').fold(ConfigPath::root(), |at, key| at.key(key))
}

fn given(is_given: bool) -> Option<Found> {
    is_given.then(|| (None, "given".to_owned()))
}

fn shown(value: Option<impl fmt::Display>) -> Option<Found> {
    Some((None, value?.to_string()))
}

fn given_at(is_given: bool, at: impl FnOnce() -> ConfigPath) -> Option<Found> {
    is_given.then(|| (Some(at()), "given".to_owned()))
}

const fn feature(name: &'static str, keys: &'static [&'static str], found: Search) -> Feature {
    Feature { name, keys, found }
}

const fn key(keys: &'static [&'static str; 1], found: Search) -> Feature {
    feature(keys[0], keys, found)
}

// Plans

const EXCHANGE: Feature = feature("[exchange]", &["exchange"], |it| given(it.parts.exchange.is_some()));
const MULTICANONICAL: Feature = feature("the ensemble \"multicanonical\"", &["exchange.ensemble"], |it| {
    let plan = it.parts.exchange.as_ref()?;
    shown((plan.ensemble == ExchangeEnsemble::Multicanonical).then_some("\"multicanonical\""))
});
const STAGE: Feature =
    feature("a [[stage]]", &["stage"], |it| given_at(it.phase.at.is_in("stage"), || it.phase.at.clone()));
const MEASURED_STAGE: Feature =
    feature("measure in the same stage", &["stage.measure"], |it| given(it.phase.is_measured));
const GROWTH: Feature =
    feature("grow", &["stage.grow"], |it| given_at(it.phase.growth.is_some(), || it.phase.at.key("grow")));
const BAROSTAT: Feature = feature("a barostat", &["run.barostat", "stage.barostat"], |it| {
    given_at(it.phase.barostat.is_some(), || it.phase.at.key("barostat"))
});
const SWAP: Feature = feature("swap moves", &["run.swap", "stage.swap"], |it| {
    given_at(it.phase.swap.is_some(), || it.phase.at.key("swap"))
});
const THERMOSTAT: Feature = key(&["run.thermostat"], |it| given(it.parts.run.thermostat.is_some()));
const HEAT: Feature = feature("a thermostat", &["run.thermostat", "stage.thermostat"], |it| {
    given_at(it.phase.thermostat.is_some(), || it.phase.at.key("thermostat"))
});
const RESCALING: Feature = feature("a rescaling thermostat in the same stage", &[], |it| {
    given(matches!(it.phase.thermostat, Some(Thermostat::Rescaling { .. })))
});
const NO_THERMOSTAT: Feature =
    feature("no thermostat in the same stage", &[], |it| given(it.phase.thermostat.is_none()));
const AUTOMATIC: Feature = feature("an automatic equilibration", &[], |it| {
    let mut stages = it.parts.run.stages.iter().filter_map(|stage| stage.measured.as_ref());
    given(it.parts.run.until_stationary || stages.any(|measured| measured.until_stationary))
});
const THREADS: Feature =
    key(&["run.threads"], |it| shown(Some(it.parts.run.threads).filter(|threads| *threads != Threads::default())));

// Dynamics

const GRAVITY: Feature = feature("gravity", &["dynamics.gravity"], |it| {
    let (run, zero) = (&it.parts.run, Vector::zeros());
    let is_accelerated = it.start.interactions.species.iter().any(|species| species.acceleration != zero);
    let mut gravities = run.stages.iter().map(|stage| stage.gravity).chain([run.gravity]);
    given(gravities.any(|gravity| gravity.map_or(is_accelerated, |gravity| gravity != zero)))
});
const ENDLESS_FALL: Feature = feature("gravity along a periodic axis", &[], |it| {
    let falls = |k: usize| {
        let mut moving = it.start.interactions.species.iter().filter(|species| !species.is_static());
        moving.find(|species| it.parts.run.gravity.unwrap_or(species.acceleration)[k] != 0.0)
    };
    let mut periodic = (0..3).filter(|axis| it.start.space.boundary[*axis] == Boundary::Periodic);
    let (axis, species) = periodic.find_map(|axis| Some((AXES[axis], falls(axis)?)))?;
    Some((Some(path("space").key(axis)), format!("periodic, and gravity pulls `{}` along it", species.name)))
});
const SHEAR: Feature = key(&["space.shear_rate"], |it| shown(it.parts.shear_rate));
const TC_MODEL: Feature = key(&["dynamics.contact_time"], |it| shown(it.parts.contact_time));
const NO_TC_MODEL: Feature = feature("no contact_time", &[], |it| given(it.parts.contact_time.is_none()));
const NO_GRAVITY: Feature = feature("no gravity", &[], |it| given((GRAVITY.found)(it).is_none()));
const SLEEP: Feature = key(&["dynamics.sleep"], |it| given(it.parts.sleep.is_some()));
const LOSSES: Feature = feature(
    "a restitution below 1",
    &[
        "interaction.restitution",
        "space.x.restitution",
        "space.y.restitution",
        "space.z.restitution",
        "surface.restitution",
    ],
    losses,
);
const ROUGH: Feature = feature(
    "rough contacts",
    &[
        "interaction.tangential_restitution",
        "interaction.friction",
        "space.x.tangential_restitution",
        "space.x.friction",
        "space.y.tangential_restitution",
        "space.y.friction",
        "space.z.tangential_restitution",
        "space.z.friction",
        "surface.tangential_restitution",
        "surface.friction",
    ],
    roughness,
);
const SIZES: Feature = feature("individual diameters", &["species.diameters"], |it| {
    let index = it.start.interactions.species.iter().position(|species| species.individual.is_some())?;
    given_at(true, || ConfigPath::entry("species", index).key("diameters"))
});
const SPINS: Feature = feature("particles with spins", &["particle.spin"], |it| {
    given(it.start.groups.particles.iter().any(|particle| particle.spin != Vector::zeros()))
});
const WELLS: Feature = feature("wells, shoulders or bonds", &[], |it| {
    given(it.start.interactions.list().iter().any(|it| !it.potential.is_hard_sphere() || it.potential.is_bond()))
});
const ALL_HARD: Feature = feature("only hard bodies", &[], |it| {
    let mut energies = it.start.interactions.list().iter().flat_map(|it| it.potential.energies());
    given(!energies.any(|energy| energy.is_finite() && *energy != 0.0))
});

// Box, particles, surfaces

const SIDES: Feature =
    feature("walls or open sides", &["space.x", "space.y", "space.z"], |it| given(!it.start.space.is_fully_periodic()));
const OPEN: Feature = feature("open sides", &[], |it| {
    let is_open = |k: &usize| matches!(it.start.space.boundary[*k], Boundary::Bounded { lower, upper } if [lower, upper].contains(&Face::Open));
    Some((Some(path("space").key(AXES[(0..3).find(is_open)?])), "open".to_owned()))
});
const NO_SIDES: Feature = feature("no walls or open sides", &[], |it| given(it.start.space.is_fully_periodic()));
const ONE_SIDED_AXIS: Feature =
    feature("fewer than two axes with walls or open sides", &[], |it| given(sided_axes(it).count() < 2));
const NO_WEIGHT: Feature = feature("no gravity along an axis with walls or open sides", &[], |it| {
    let species = &it.start.interactions.species;
    let pulls = |gravity: Option<Vector>| {
        let mut moving = species.iter().filter(|species| !species.is_static());
        moving.any(|species| sided_axes(it).any(|axis| gravity.unwrap_or(species.acceleration)[axis] != 0.0))
    };
    let run = &it.parts.run;
    let measured = run.stages.iter().filter(|stage| stage.measured.is_some()).map(|stage| stage.gravity);
    given(!measured.chain([run.gravity]).any(pulls))
});
const NO_PERIOD: Feature =
    feature("no periodic axis", &[], |it| given(!it.start.space.boundary.contains(&Boundary::Periodic)));
const THERMAL: Feature = feature(
    "thermal walls or surfaces",
    &["space.x.temperature", "space.y.temperature", "space.z.temperature", "surface.temperature"],
    |it| {
        laws(it).find_map(|(at, law)| match law {
            SurfaceLaw::Thermal { temperature } => Some((Some(at.key("temperature")), shortest(temperature))),
            SurfaceLaw::Reflecting(_) | SurfaceLaw::Outlet => None,
        })
    },
);
const SURFACE: Feature = feature("a [[surface]]", &["surface"], |it| given(!it.start.surfaces.of_scene().is_empty()));
const INLET: Feature =
    feature("an [[inlet]]", &["inlet"], |it| given_at(!it.start.inlets.is_empty(), || ConfigPath::entry("inlet", 0)));
const FLOW: Feature = feature("an [[inlet]] or an outlet", &["inlet", "surface.outlet"], |it| {
    let surfaces = it.start.surfaces.of_scene();
    match surfaces.iter().position(|surface| surface.law == SurfaceLaw::Outlet) {
        Some(outlet) => given_at(true, || ConfigPath::entry("surface", outlet).key("outlet")),
        None => (INLET.found)(it),
    }
});
const BONDS: Feature = feature("bonds", &["bond", "chain"], |it| given(!it.start.groups.bonds.is_empty()));
const MOTION: Feature = feature("a [[surface.motion]]", &["surface.motion"], |it| {
    let moving = it.start.surfaces.of_scene().iter().position(|surface| surface.moves())?;
    given_at(true, || ConfigPath::entry("surface", moving).key("motion"))
});
const STATIC: Feature = feature("static particles", &["species.static"], |it| {
    let particles = &it.start.groups.particles;
    let is_static: Vec<bool> = it.start.interactions.species.iter().map(|species| species.is_static()).collect();
    given(is_static.contains(&true) && particles.iter().any(|particle| is_static[particle.species.0 as usize]))
});
/// Growth and shear are incompatible with a static species, even if the species has no particles.
const STATIC_SPECIES: Feature = feature("static particles", &["species.static"], |it| {
    given(it.start.interactions.species.iter().any(|species| species.is_static()))
});
const NO_BONDS: Feature = feature("no bonds", &[], |it| given(it.start.groups.bonds.is_empty()));
const INVALID_START: Feature =
    key(&["allow_invalid_start"], |it| shown(it.parts.allow_invalid_start.then_some("true")));
const SEPARATION: Feature = key(&["separate_overlaps"], |it| shown(it.parts.separate_overlaps));

// Instruments and files

const PRESSURE_TENSOR: Feature =
    key(&["measure.pressure_tensor"], |it| given(it.parts.measure.pressure_tensor.is_some()));
const STRUCTURE_FACTOR: Feature =
    key(&["measure.structure_factor"], |it| given(it.parts.measure.structure_factor.is_some()));
const RADIAL: Feature =
    key(&["measure.radial_distribution"], |it| given(it.parts.measure.radial_distribution.is_some()));
const SIZES_BETWEEN_WALLS: Feature = feature("individual diameters between walls", &[], |it| {
    let is_walled = (0..3).any(|axis| it.start.space.walls(axis) > 0);
    given(is_walled && (SIZES.found)(it).is_some())
});
const SCALED: Feature = key(&["measure.radial_distribution.scaled"], |it| {
    given(it.parts.measure.radial_distribution.as_ref().is_some_and(|radial| radial.scaled))
});
const NO_CORES: Feature = feature("no hard cores", &[], |it| {
    let interactions = &it.start.interactions;
    given(!interactions.pairs().any(|(_, id)| interactions.get(id).potential.core().is_some()))
});
const MIXING: Feature = feature("a [[measure.mixing]]", &["measure.mixing"], |it| {
    given_at(!it.parts.measure.mixings.is_empty(), || ConfigPath::root().key("measure").key("mixing").index(0))
});
const ONE_MOVING_SPECIES: Feature = feature("fewer than two moving species", &[], |it| {
    let species = &it.start.interactions.species;
    given(species.iter().filter(|species| !species.is_static()).count() < 2)
});
const ALIKE: Feature = feature("particles that are all alike", &[], |it| {
    let species = &it.start.interactions.species;
    let moving = || species.iter().filter(|species| !species.is_static());
    given(moving().count() < 2 && moving().all(|species| species.individual.is_none()))
});
const STRESS: Feature = feature("a [[measure.stress]]", &["measure.stress"], |it| {
    given_at(!it.parts.measure.stresses.is_empty(), || ConfigPath::root().key("measure").key("stress").index(0))
});
const CHAINS: Feature = key(&["measure.chains"], |it| given(it.parts.measure.chains.is_some()));
const TRANSPORT: Feature = key(&["measure.transport"], |it| given(it.parts.measure.transport.is_some()));
const CENTRE_OF_MASS: Feature = key(&["measure.centre_of_mass"], |it| given(it.parts.measure.centre_of_mass.is_some()));
const AXIS_POINT: Feature = key(&["measure.centre_of_mass.axis_point"], |it| {
    given(it.parts.measure.centre_of_mass.as_ref().is_some_and(|plan| plan.axis_point.is_some()))
});
const RESIDENCE_TIMES: Feature =
    key(&["measure.residence_times"], |it| given(it.parts.measure.residence_times.is_some()));
const NO_PASSAGE: Feature = feature("no [[inlet]] or no outlet", &[], |it| {
    let is_outlet = |surface: &SceneSurface| surface.law == SurfaceLaw::Outlet;
    given(it.start.inlets.is_empty() || !it.start.surfaces.of_scene().iter().any(is_outlet))
});
const FLOW_ALONG_X: Feature = feature("a [[measure.flow]] along x", &["measure.flow.axis"], |it| {
    let index = it.parts.measure.flows.iter().position(|flow| flow.axis.as_deref() == Some("x"))?;
    Some((Some(path("measure.flow").index(index).key("axis")), "\"x\"".to_owned()))
});
const THERMO_INTERVAL: Feature =
    key(&["output.thermo_interval"], |it| given(it.parts.output.thermo_interval.is_some()));
const CONTACTS: Feature = key(&["output.contacts"], |it| given(it.parts.output.has_contacts));
const EVENT_LOG: Feature = key(&["output.events"], |it| given(it.parts.output.has_event_log));
const COUNTS: Feature = key(&["output.count"], |it| given(!it.parts.output.regions.is_empty()));
const FORMATS: Feature = key(&["output.formats"], |it| given(!it.parts.output.formats.is_empty()));

/// Axes that are neither periodic nor flat.
fn sided_axes(it: &Subject<'_>) -> impl Iterator<Item = usize> {
    let boundary = it.start.space.boundary;
    (0..3).filter(move |&axis| matches!(boundary[axis], Boundary::Bounded { .. }))
}

/// Iterates over the laws of walls and surfaces, with the config paths of their keys.
fn laws(it: &Subject<'_>) -> impl Iterator<Item = (ConfigPath, SurfaceLaw)> {
    let space = &it.start.space;
    let temperatures = space.of_walls(it.parts.wall_temperatures);
    let walls = (0..3).flat_map(move |k| {
        let Boundary::Bounded { lower, upper } = space.boundary[k] else { return Vec::new() };
        let axis = path("space").key(AXES[k]);
        let [below, above] = temperatures[k];
        // If both walls of an axis have the same law, the scene file contains a single law for the axis.
        let is_common = space.walls(k) < 2 || (lower, below) == (upper, above);
        let wall = |side: &'static str, face, temperature: Option<f64>| {
            let Face::Wall(law) = face else { return None };
            let at = if is_common { axis.clone() } else { axis.key(side) };
            let thermal = temperature.map(|temperature| SurfaceLaw::Thermal { temperature });
            Some((at, thermal.unwrap_or(SurfaceLaw::Reflecting(law))))
        };
        [wall("lower", lower, below), wall("upper", upper, above)].into_iter().flatten().collect()
    });
    let surfaces = it.start.surfaces.of_scene().iter().enumerate();
    walls.chain(surfaces.map(|(index, surface)| (ConfigPath::entry("surface", index), surface.law)))
}

fn losses(it: &Subject<'_>) -> Option<Found> {
    let value = |restitution: &Restitution| match *restitution {
        Restitution::Constant(restitution) => shortest(restitution),
        _ => "dependent on the speed".to_owned(),
    };
    let lossy = |at: &ConfigPath, law: &ContactLaw| {
        (!law.restitution.is_elastic()).then(|| (Some(at.key("restitution")), value(&law.restitution)))
    };
    first_law(it, lossy, |law| format!("a run with an interaction of restitution {}", value(&law.restitution)))
}

/// Whether any contacts of the scene are rough.
pub(super) fn is_rough(builder: &SceneBuilder, start: &Configuration<'_>) -> bool {
    let parts = &builder.parts;
    phases(&parts.run).any(|phase| roughness(&Subject { builder, parts, start, phase }).is_some())
}

fn roughness(it: &Subject<'_>) -> Option<Found> {
    let rough = |at: &ConfigPath, law: &ContactLaw| {
        let Roughness { tangential_restitution, friction } = law.roughness?;
        let never_slides = friction == f64::INFINITY;
        let (key, value) =
            if never_slides { ("tangential_restitution", tangential_restitution) } else { ("friction", friction) };
        Some((Some(at.key(key)), shortest(value)))
    };
    first_law(it, rough, |_| "a run with rough contacts".to_owned())
}

/// Returns what `found` finds in the first contact law: of an interaction, a wall or a surface. A scene without
/// interactions takes the interactions of the run from which it starts. `of_run` then describes the run.
fn first_law(
    it: &Subject<'_>,
    found: impl Fn(&ConfigPath, &ContactLaw) -> Option<Found>,
    of_run: impl Fn(&ContactLaw) -> String,
) -> Option<Found> {
    let of_draft =
        |(index, draft): (usize, &InteractionDraft)| found(&ConfigPath::entry("interaction", index), &draft.law);
    let of_interaction = |(index, interaction): (usize, &Interaction)| {
        let here = found(&ConfigPath::entry("interaction", index), &interaction.law)?;
        let run = || (Some(path("start.from")), of_run(&interaction.law));
        Some(if it.builder.start.is_some() { run() } else { here })
    };
    let (drafts, interactions) =
        (it.builder.interactions.iter().enumerate(), it.start.interactions.list().iter().enumerate());
    let pairs = drafts.filter_map(of_draft).chain(interactions.filter_map(of_interaction));
    pairs.chain(laws(it).filter_map(|(at, law)| found(&at, &law.contact()?))).next()
}

const fn row(
    feature: Feature,
    with: Feature,
    circumstance: &'static str,
    cure: &'static str,
    reason: &'static str,
) -> Exclusion {
    Exclusion { feature, with, circumstance, cure, reason }
}

const ABSENT: &str = "";
const ONLY_TRAJECTORIES: &str = "it writes only trajectories and a row for each attempt to swap";
const HARD_SPHERES: &str =
    "only hard spheres without bonds, in a periodic box without gravity, static particles or shear";
const PLAIN_SHEAR: &str = "no shear_rate, or a periodic box without gravity or static particles";
const CONSTANT_SIZE: &str = "surfaces need particles of constant size in a box without shear";
const ANDERSEN: &str = "a thermostat of the kind \"andersen\" in the same table";
const OF_MOVES: &str = "it gives the temperature of the volume moves";

/// Features that exclude each other. The first matching row determines the error.
#[rustfmt::skip]
pub const EXCLUSIONS: &[Exclusion] = &[
    row(STAGE, EXCHANGE, "", ABSENT, "prepare the particles with `carom run`, and start from the end of that run with start.from"),
    row(THERMOSTAT, EXCHANGE, "", ABSENT, "it has its own temperatures and rate"),
    row(BAROSTAT, EXCHANGE, "", ABSENT, "its replicas all have the volume of the scene"),
    row(THREADS, EXCHANGE, "", "1 with [exchange]", "each replica has its own thread; `carom exchange --jobs` sets how many run at once"),
    row(THERMO_INTERVAL, EXCHANGE, "", ABSENT, ONLY_TRAJECTORIES),
    row(CONTACTS, EXCHANGE, "", ABSENT, ONLY_TRAJECTORIES),
    row(EVENT_LOG, EXCHANGE, "", ABSENT, ONLY_TRAJECTORIES),
    row(COUNTS, EXCHANGE, "", ABSENT, ONLY_TRAJECTORIES),
    row(FORMATS, EXCHANGE, "", ABSENT, "convert later with `carom convert DIR/trajectory-1.xyz --to FORMAT`"),
    row(INVALID_START, EXCHANGE, "", "false with [exchange]", "it averages over valid states; let `carom run` separate the particles, and start from the end of that run with start.from"),
    row(LOSSES, EXCHANGE, "", "1 with [exchange]", "a system that loses energy in contacts has no equilibrium"),
    row(ROUGH, EXCHANGE, "", ABSENT, "replicas exchange velocities, but no spins"),
    row(SHEAR, EXCHANGE, "", ABSENT, "a sheared fluid has no equilibrium"),
    row(OPEN, EXCHANGE, "", "\"wall\" or \"periodic\" with [exchange]", "particles that can escape have no equilibrium"),
    row(ENDLESS_FALL, EXCHANGE, "", "\"wall\" with [exchange]", "particles that fall for ever have no equilibrium"),
    row(THERMAL, EXCHANGE, "", ABSENT, "its replicas have their own temperatures"),
    row(MOTION, EXCHANGE, "", ABSENT, "a system that a surface drives has no equilibrium"),
    row(FLOW, EXCHANGE, "", ABSENT, "replicas exchange the states of the same particles"),
    row(MULTICANONICAL, GRAVITY, "", "\"canonical\" in a scene with gravity", "weights need an energy that changes in steps only"),
    row(MULTICANONICAL, ALL_HARD, "", "\"canonical\" in a scene of hard bodies", "their potential energy is always zero"),
    row(GROWTH, MEASURED_STAGE, "in a measured stage", "no growth", "a stage that is measured has diameters that are constant; let them grow in a stage before it"),
    row(GROWTH, SURFACE, "", ABSENT, CONSTANT_SIZE),
    row(GROWTH, INLET, "", ABSENT, "the diameters of particles that enter are constant"),
    row(GROWTH, ROUGH, "", ABSENT, "growth would change the moments of inertia"),
    row(GROWTH, WELLS, "with other interactions", HARD_SPHERES, ""),
    row(GROWTH, SIDES, "in a box with open sides or walls", HARD_SPHERES, ""),
    row(GROWTH, GRAVITY, "with gravity", HARD_SPHERES, ""),
    row(GROWTH, STATIC_SPECIES, "with static particles", HARD_SPHERES, ""),
    row(GROWTH, SHEAR, "in a sheared box", HARD_SPHERES, ""),
    row(SHEAR, SURFACE, "", ABSENT, CONSTANT_SIZE),
    row(SHEAR, INLET, "", ABSENT, "particles that enter do not move with the streaming velocity"),
    row(SHEAR, SIDES, "in a box with open sides or walls", PLAIN_SHEAR, ""),
    row(SHEAR, GRAVITY, "with gravity", PLAIN_SHEAR, ""),
    row(SHEAR, STATIC_SPECIES, "with static particles", PLAIN_SHEAR, ""),
    row(TRANSPORT, SHEAR, "in a sheared box", "no transport", "Einstein-Helfand relations hold in equilibrium; pressure_tensor has the viscosity in shear"),
    row(FLOW_ALONG_X, SHEAR, "in a sheared box", "y or z", "along x, sliding images would count as particles that pass"),
    row(BAROSTAT, SIDES, "in a box with open sides or walls", "a box whose axes are all periodic or flat", ""),
    row(BAROSTAT, SURFACE, "with surfaces", ABSENT, "surfaces do not scale with the box"),
    row(BAROSTAT, STATIC, "with static particles", ABSENT, "they do not scale with the box"),
    row(BAROSTAT, GRAVITY, "with gravity", ABSENT, "particles that fall along a periodic axis have no equilibrium"),
    row(BAROSTAT, SHEAR, "in a sheared box", ABSENT, "a sheared system has no equilibrium"),
    row(BAROSTAT, TC_MODEL, "with the TC model", ABSENT, "contacts must be elastic"),
    row(BAROSTAT, ROUGH, "with rough contacts", "smooth contacts", "a barostat sets the temperature of the centres only"),
    row(BAROSTAT, LOSSES, "with a restitution below 1", "a restitution of 1", "a system that loses energy has no equilibrium"),
    row(BAROSTAT, INVALID_START, "with allow_invalid_start", "a start without overlaps", "volume moves are rejected as long as particles overlap"),
    row(SEPARATION, INVALID_START, "with allow_invalid_start", "only one of them", "particles that were moved apart do not overlap"),
    row(SEPARATION, SHEAR, "in a sheared box", ABSENT, "particles are moved apart in boxes at rest only"),
    row(SEPARATION, BONDS, "with bonds", ABSENT, "moves would change the lengths of bonds"),
    row(BAROSTAT, GROWTH, "together with grow", "only one of them", "volume moves need constant diameters"),
    row(BAROSTAT, RESCALING, "together with a thermostat that scales velocities", ANDERSEN, OF_MOVES),
    row(BAROSTAT, NO_THERMOSTAT, "without a thermostat", ANDERSEN, OF_MOVES),
    row(BAROSTAT, INLET, "", ABSENT, "its ensemble has a constant number of particles"),
    row(SWAP, EXCHANGE, "", ABSENT, "its replicas exchange their temperatures only"),
    row(SWAP, ALIKE, "with particles that are all alike", "two moving species, or individual diameters", "equal particles have nothing to exchange"),
    row(SWAP, WELLS, "with wells, shoulders or bonds", "only hard spheres without bonds", "an exchange would change their energy"),
    row(SWAP, GRAVITY, "with gravity", ABSENT, "an exchange of masses would change the potential energy"),
    row(SWAP, SHEAR, "in a sheared box", ABSENT, "a sheared system has no equilibrium"),
    row(SWAP, TC_MODEL, "with the TC model", ABSENT, "contacts must be elastic"),
    row(SWAP, ROUGH, "with rough contacts", "smooth contacts", "an exchange would change the energy of rotation"),
    row(SWAP, SPINS, "with particles that spin", ABSENT, "an exchange would change the energy of rotation"),
    row(SWAP, LOSSES, "with a restitution below 1", "a restitution of 1", "a system that loses energy has no equilibrium"),
    row(SWAP, INVALID_START, "with allow_invalid_start", "a start without overlaps", "swap moves are tested for overlaps of the exchanged particles only"),
    row(SWAP, GROWTH, "together with grow", "only one of them", "swap moves need constant diameters"),
    row(SWAP, FLOW, "", ABSENT, "its ensemble has a constant number of particles"),
    row(SCALED, SIDES, "in a box with walls or open sides", ABSENT, "the space that a particle can reach depends on its diameter"),
    row(SCALED, NO_CORES, "without hard cores", "hard cores", "particles without cores have no contact distance"),
    row(RADIAL, SIZES_BETWEEN_WALLS, "", ABSENT, "the space that a particle can reach depends on its diameter"),
    row(FLOW, BONDS, "with bonds", ABSENT, "a bonded particle cannot leave alone"),
    row(FLOW, RESCALING, "with a thermostat that scales velocities", ABSENT, "the temperature of a flow is not measured"),
    row(FLOW, AUTOMATIC, "with an automatic equilibration", "to be absent, or a given equilibration_time", "the rates of a flow do not show whether a silo is still filling"),
    row(FLOW, INVALID_START, "with allow_invalid_start", ABSENT, "particles enter only where they overlap nothing"),
    row(SLEEP, NO_TC_MODEL, "without a contact_time", "a contact_time in [dynamics]", "contacts in quick succession show which grains rest"),
    row(SLEEP, NO_GRAVITY, "without gravity", "gravity, or no sleep", "nothing holds grains at rest"),
    row(SLEEP, WELLS, "with wells, shoulders or bonds", ABSENT, "only hard grains sleep"),
    row(SLEEP, MOTION, "with a surface that moves", ABSENT, "surfaces would move into sleeping grains; surface_velocity moves the material of a surface at rest"),
    row(SLEEP, HEAT, "with a thermostat", ABSENT, "grains in a heat bath never rest"),
    row(SLEEP, EXCHANGE, "", ABSENT, "sleeping grains have no equilibrium"),
    row(SLEEP, INVALID_START, "with allow_invalid_start", ABSENT, "the overlaps of sleeping grains would remain; separate_overlaps removes them before the run"),
    row(COUNTS, BAROSTAT, "", ABSENT, "regions do not scale with the box"),
    row(PRESSURE_TENSOR, OPEN, "in an open box", "no pressure_tensor, or a box that is periodic or has walls", "an open one has no volume to divide by. thermo.csv has the number of events in each row"),
    row(STRESS, SHEAR, "", ABSENT, "the stress of a sheared box is the same everywhere; measure.pressure_tensor gives it"),
    row(MIXING, ONE_MOVING_SPECIES, "with fewer than two moving species", "no mixing, or two moving species", "particles of one species are always mixed"),
    row(STRUCTURE_FACTOR, NO_PERIOD, "in a box without a periodic axis", "no structure_factor, or a periodic axis", "its period determines the wave vectors"),
    row(CENTRE_OF_MASS, NO_SIDES, "in a box without walls or open sides", "no centre_of_mass, or an axis with walls or open sides", "particles that cross a periodic side have no unique centre of mass"),
    row(AXIS_POINT, NO_WEIGHT, "without gravity along an axis with walls or open sides", "no axis_point, or such a gravity in [dynamics]", "the inclination is the angle from gravity to the centre of mass"),
    row(AXIS_POINT, ONE_SIDED_AXIS, "with fewer than two axes with walls or open sides", "no axis_point, or two such axes", "an inclination is an angle in a plane"),
    row(RESIDENCE_TIMES, NO_PASSAGE, "without an [[inlet]] and an outlet", "no residence_times, or an [[inlet]] and a [[surface]] with `outlet = true`", "a residence time begins at an inlet and ends at an outlet"),
    row(CHAINS, NO_BONDS, "without bonds", "no chains, or bonds from [[chain]] or [[bond]]", ""),
];

//! Settings of a scene that have little or no effect.

use super::driver::FEWEST_MOVES;
use super::stage::{Settings, Stage};
use crate::analysis::published::HardMixture;
use crate::model::{Barostat, GrowthTarget, Scene, Swap, Thermostat};
use crate::scene::measurement_times;

/// A setting that has little or no effect.
#[derive(Debug, Clone, PartialEq)]
pub enum Unreached {
    /// An interval or a sampling time is longer than the stage or measurement.
    Time {
        /// Key of the time in the scene file.
        key: String,
        /// The time `[time]`.
        time: f64,
        /// Name of the stage that is too short; `None` if all measurements are too short.
        stage: Option<String>,
        /// Duration `[time]`.
        duration: f64,
    },
    /// There are too few volume moves to tune their amplitude.
    Amplitude {
        /// Number of volume moves in which the amplitude is tuned.
        moves: f64,
        /// Minimum number of volume moves needed to tune the amplitude.
        fewest: f64,
    },
    /// Swap moves are hardly ever accepted.
    Swaps {
        /// Name of the stage.
        stage: String,
        /// Expected number of accepted moves, divided by the number of moves of unlike particles.
        acceptance: f64,
        /// Whether all pairs of unlike particles exceed the largest ratio of diameters.
        is_forbidden: bool,
    },
}

/// Returns the times in a scene that are never reached, because stages with a time limit are too short, and moves that are
/// too few or hardly ever accepted.
#[must_use]
pub fn unreached(scene: &Scene) -> Vec<Unreached> {
    let plan = &scene.run;
    let stages: Vec<(Stage, Settings)> = Stage::simulated(plan).map(|stage| (stage, stage.settings(plan))).collect();
    let mut all = Vec::new();
    let mut longest = 0.0_f64;
    for (stage, settings) in &stages {
        // The duration is unknown for an automatic equilibration and for a stage that is limited by events.
        let duration = settings.limit.time.filter(|_| !settings.until_stationary).unwrap_or(f64::INFINITY);
        if stage.is_measured() {
            longest = longest.max(duration);
        }
        let acting = [
            ("barostat.interval", settings.barostat.map(|it| it.interval)),
            ("swap.interval", settings.swap.map(|it| it.interval)),
            ("thermostat.interval", settings.thermostat.and_then(scaling_interval)),
        ];
        for (key, time) in acting.into_iter().filter_map(|(key, time)| Some((key, time?))) {
            if time > duration {
                let stage = Some(stage.name(plan).into_owned());
                all.push(Unreached::Time { key: key.to_owned(), time, stage, duration });
            }
        }
    }
    all.extend(few_moves(&stages));
    all.extend(rare_swaps(scene, &stages));
    let late = measurement_times(&scene.measure).into_iter().filter(|(_, time)| *time > longest);
    all.extend(late.map(|(key, time)| Unreached::Time { key, time, stage: None, duration: longest }));
    all
}

fn scaling_interval(thermostat: Thermostat) -> Option<f64> {
    match thermostat {
        Thermostat::Rescaling { interval, .. } => Some(interval),
        Thermostat::Andersen { .. } => None,
    }
}

fn few_moves(stages: &[(Stage, Settings)]) -> Option<Unreached> {
    let is_open = |settings: &Settings| settings.barostat.is_some_and(|barostat| barostat.amplitude.is_none());
    let first = stages.iter().position(|(stage, settings)| stage.is_measured() && is_open(settings))?;
    let moves = |(stage, settings): &(Stage, Settings)| {
        let Settings { barostat: Some(Barostat { interval, .. }), limit, until_stationary, .. } = settings else {
            return 0.0;
        };
        match limit.time {
            _ if stage.is_measured() || !is_open(settings) => 0.0,
            Some(time) if !until_stationary => (time / interval).floor(),
            _ => f64::INFINITY,
        }
    };
    let moves = stages[..first].iter().map(moves).sum();
    let fewest = f64::from(FEWEST_MOVES);
    (moves < fewest).then_some(Unreached::Amplitude { moves, fewest })
}

/// Swap moves are reported if a smaller fraction of them is accepted.
const RARE: f64 = 1e-3;

fn rare_swaps(scene: &Scene, stages: &[(Stage, Settings)]) -> Vec<Unreached> {
    let mut grown = 1.0;
    let mut rare = Vec::new();
    for (stage, settings) in stages {
        match settings.growth.map(|growth| growth.until) {
            Some(GrowthTarget::PackingFraction(target)) => grown = scene.growth_to(target),
            // The packing fraction is unknown from here on.
            Some(GrowthTarget::CompressibilityFactor(_)) => break,
            None => {}
        }
        if settings.barostat.is_some() {
            break;
        }
        let acceptance = settings.swap.and_then(|swap| expected_acceptance(scene, &swap, grown));
        if let Some(acceptance) = acceptance.filter(|acceptance| *acceptance < RARE) {
            let stage = stage.name(&scene.run).into_owned();
            rare.push(Unreached::Swaps { stage, acceptance, is_forbidden: acceptance == 0.0 });
        }
    }
    rare
}

/// Number of particles with about the same diameter.
struct Size {
    diameter: f64,
    count: f64,
    is_static: bool,
}

/// Largest number of different diameters of a species in estimates. Similar individual diameters are combined.
const MOST_SIZES: usize = 64;

fn sizes_of(scene: &Scene, counts: &[usize]) -> Vec<Size> {
    let mut sizes = Vec::new();
    for (index, (species, &count)) in scene.species.iter().zip(counts).enumerate().filter(|(_, (_, n))| **n > 0) {
        let own = scene.particles.iter().filter(|particle| particle.species.0 as usize == index);
        let mut own: Vec<f64> = own.filter_map(|particle| particle.diameter).collect();
        if own.is_empty() {
            sizes.push(Size { diameter: species.diameter, count: count as f64, is_static: species.is_static() });
            continue;
        }
        own.sort_unstable_by(f64::total_cmp);
        for some in own.chunks(own.len().div_ceil(MOST_SIZES)) {
            let count = some.len() as f64;
            sizes.push(Size { diameter: some.iter().sum::<f64>() / count, count, is_static: species.is_static() });
        }
    }
    sizes
}

/// Returns the expected number of accepted swap moves, divided by the number of moves of unlike particles. The estimate
/// comes from scaled-particle theory. Diameters are multiplied by `grown`. `None` if contact distances are not the mean
/// diameters, because the theory does not cover this case.
fn expected_acceptance(scene: &Scene, swap: &Swap, grown: f64) -> Option<f64> {
    let counts = scene.population();
    let occurring: Vec<usize> = (0..counts.len()).filter(|&species| counts[species] > 0).collect();
    let mut pairs = occurring.iter().flat_map(|&a| occurring.iter().map(move |&b| (a, b)));
    if !pairs.all(|(a, b)| scene.is_additive(a, b)) {
        return None;
    }
    let volume = scene.space.volume();
    let sizes = sizes_of(scene, &counts);
    let mixture = HardMixture::new(
        scene.space.dimensions(),
        sizes.iter().map(|size| [grown * size.diameter, size.count / volume]),
    )?;
    let moving: Vec<[f64; 2]> =
        sizes.iter().filter(|size| !size.is_static).map(|size| [grown * size.diameter, size.count]).collect();
    let (mut accepted, mut all) = (0.0, 0.0);
    for (k, [first, of_first]) in moving.iter().enumerate() {
        for [second, of_second] in &moving[..k] {
            let pairs = of_first * of_second;
            all += pairs;
            if swap.allows([first.min(*second), first.max(*second)]) {
                accepted += pairs * mixture.acceptance_of_exchange([*first, *second]);
            }
        }
    }
    (all > 0.0).then_some(accepted / all)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A simulation of this scene with 512 particles accepted 4.1 % of the moves.
    #[test]
    fn expected_acceptance_is_that_of_a_simulation() {
        let scene = Scene::from_toml(include_str!("../../configs/glass_former.toml"), "glass_former.toml").unwrap();
        let grown = libm::cbrt(0.60 / scene.packing_fraction());
        let swap = scene.run.stages[1].swap.unwrap();
        let expected = expected_acceptance(&scene, &swap, grown).unwrap();
        assert!((expected / 0.041 - 1.0).abs() < 0.2, "{expected}");
        let limited = Swap { largest_ratio: Some(1.01), ..swap };
        assert!(expected_acceptance(&scene, &limited, grown).unwrap() < 0.5 * expected);
    }

    #[test]
    fn rare_swaps_are_reported_with_the_packing_fraction_of_their_stage() {
        let text = include_str!("../../configs/glass_former.toml")
            .replace("upper = 1.613 }\ndiameters = \"individual\"", "upper = 6.0, classes = 2 }");
        let of = |text: &str| {
            let scene = Scene::from_toml(text, "scene.toml").unwrap();
            unreached(&scene).into_iter().filter(|it| matches!(it, Unreached::Swaps { .. })).collect::<Vec<_>>()
        };
        let [Unreached::Swaps { stage, acceptance, is_forbidden: false }] = &of(&text)[..] else {
            panic!("{:?}", of(&text))
        };
        assert!(stage == "swap" && *acceptance < 1e-4, "{acceptance}");
        assert_eq!(of(&text.replace("packing_fraction = 0.60", "packing_fraction = 0.31")), []);
        assert_eq!(of(include_str!("../../configs/glass_former.toml")), []);
    }
}

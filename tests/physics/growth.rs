//! Diameters grow to target packing fractions and pressures without overlaps.

use carom::model::{Growth, GrowthTarget, RunPlan, StagePlan, Thermostat, Until};
use carom::scene::{Arrangement, Fill, InteractionDraft, SceneBuilder, SpeciesDraft};

use super::driven::assert_no_overlap;
use super::measure::{finish, hard};

#[test]
fn bidisperse_growth_reaches_its_packing_fraction_without_overlap() {
    let scaling = Thermostat::Rescaling { temperature: 1.0, interval: 0.5 };
    let growth = Growth { rate: 0.05, until: GrowthTarget::PackingFraction(0.6) };
    let stage =
        StagePlan { name: "compress".into(), thermostat: Some(scaling), growth: Some(growth), ..StagePlan::default() };
    let between = |a: f64, b: f64| hard(0.5 * (a + b));
    let mixture = Fill {
        composition: vec![("A".into(), 0.5), ("B".into(), 0.5)],
        temperature: Some(1.0),
        ..Fill::new(Arrangement::Random, "A").count(400).packing_fraction(0.2)
    };
    let scene = SceneBuilder::new("mixture")
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .species(SpeciesDraft::new("B").mass(2.0).diameter(1.4))
        .interaction(InteractionDraft::new(between(1.0, 1.0)).between("A", "A"))
        .interaction(InteractionDraft::new(between(1.0, 1.4)).between("A", "B"))
        .interaction(InteractionDraft::new(between(1.4, 1.4)).between("B", "B"))
        .fill(mixture)
        .run(RunPlan { stages: vec![stage], limit: Until::events(20_000), ..RunPlan::default() })
        .build()
        .unwrap();
    let finished = finish(scene);
    let scene = finished.simulation.scene();
    assert!((scene.packing_fraction() / 0.6 - 1.0).abs() < 1e-11, "{}", scene.packing_fraction());
    assert!((scene.species()[1].diameter / scene.species()[0].diameter - 1.4).abs() < 1e-14);
    let snapshot = finished.simulation.snapshot();
    let ratio = scene.species()[0].diameter;
    assert!((snapshot.scale - ratio).abs() < 1e-14);
    assert_no_overlap(scene, &snapshot, 0.0, &|id| scene.species()[scene.particles()[id].species.0 as usize].diameter);
    assert!(finished.measurement.event_counts.core >= 20_000);
    assert_eq!(finished.observables[0].0, "temperature");
    assert!((finished.observables[0].1.mean - 1.0).abs() < 1e-12);
}

const COUNT: u64 = 500;

/// Spheres that grow from a packing fraction until they have a compressibility factor.
fn growing_to(factor: f64, rate: f64, packing_fraction: f64, contacts: u64) -> SceneBuilder {
    let stage = StagePlan {
        name: "compress".into(),
        thermostat: Some(Thermostat::Rescaling { temperature: 1.0, interval: 0.1 }),
        growth: Some(Growth { rate, until: GrowthTarget::CompressibilityFactor(factor) }),
        ..StagePlan::default()
    };
    SceneBuilder::new("growing")
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(hard(1.0)).between("A", "A"))
        .fill(Fill::new(Arrangement::Random, "A").count(COUNT).packing_fraction(packing_fraction))
        .temperature(1.0)
        .run(RunPlan { stages: vec![stage], limit: Until::events(contacts), ..RunPlan::default() })
}

#[test]
fn growth_to_a_pressure_ends_near_the_jammed_state() {
    let scene = growing_to(200.0, 0.1, 0.2, 50_000);
    let finished = finish(scene.build().unwrap());
    let fraction = finished.simulation.scene().packing_fraction();
    // Fast compression jams at random close packing: 0.64 for large systems, slightly less at a finite pressure.
    assert!((0.60..0.66).contains(&fraction), "{fraction}");
}

/// The growth stage averages the pressure over the last `5 N` contacts of `N` spheres. The relative error of the
/// average is `sqrt(1.27 / (5 N))`, because impulses are Rayleigh distributed and the contact rate fluctuates.
///
/// Between two checks, each sphere has ten contacts in the time `10 sqrt(pi) sigma / (6 (Z - 1))` at temperature 1.
/// Near jamming, growth during this time raises `Z` by a fraction of `3 rate`. The final `Z` may be too high by 1.5
/// times this fraction, because the average lags behind and the last check may be late.
#[test]
fn growth_ends_at_the_pressure_that_was_asked_for() {
    let (target, rate, contacts) = (50.0, 0.005, 20_000);
    for seed in 1..=2 {
        let scene = growing_to(target, rate, 0.3, contacts).seed(seed);
        let measured = finish(scene.build().unwrap()).measurement;
        let factor = 1.0 + measured.event_counts.virial.total() / (3.0 * COUNT as f64 * measured.duration);
        let error = (1.27 / (5.0 * COUNT as f64) + 1.27 / contacts as f64).sqrt();
        let lag = 1.5 * 3.0 * rate;
        let allowed = target * (1.0 - 3.0 * error)..target * (1.0 + 3.0 * error + lag);
        assert!(allowed.contains(&factor), "{seed}: {factor}, not in {allowed:?}");
    }
}

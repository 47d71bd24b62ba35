//! Event rates per particle. A contact counts once for each of its particles that can move.

use carom::Vector;
use carom::io::Summary;
use carom::io::rates::Rate;
use carom::model::potential::Potential;
use carom::model::space::{Boundary, Space};
use carom::model::{RunPlan, Thermostat, Until};
use carom::run::Finished;
use carom::scene::{Arrangement, Fill, InteractionDraft, Model, SceneBuilder, SpeciesDraft};

use super::measure::finish;

fn collision_rate(finished: &Finished) -> f64 {
    finished.observable("collision_rate").unwrap().mean
}

#[test]
fn a_ball_among_fixed_spheres_counts_each_contact_once() {
    let mut builder = SceneBuilder::new("lorentz")
        .space(Space::periodic_cube(6.0))
        .species(SpeciesDraft::new("ball").mass(0.7).diameter(1.0))
        .species(SpeciesDraft::new("fixed").diameter(1.4).fixed())
        .interaction(InteractionDraft::new(Model::HardSphere).between("ball", "ball"))
        .interaction(InteractionDraft::new(Model::HardSphere).between("ball", "fixed"))
        .particle("ball", Vector::repeat(0.1), Vector::new(1.0, 0.3, 0.2))
        .run(RunPlan { limit: Until::events(5_000), ..RunPlan::default() });
    for (x, y, z) in [(3.01, 3.02, 3.03), (3.01, 0.02, 1.03), (1.01, 3.02, 5.03), (5.0, 2.1, 0.4)] {
        builder = builder.particle("fixed", Vector::new(x, y, z), Vector::zeros());
    }
    let finished = finish(builder.build().unwrap());
    let stretch = &finished.measurement;
    let rate = stretch.event_counts.core as f64 / stretch.duration;
    assert!((collision_rate(&finished) / rate - 1.0).abs() < 1e-9, "{} {rate}", collision_rate(&finished));
    let rates = Summary::of(&finished).rates;
    assert_eq!(rates.len(), 1);
    assert_eq!((rates[0].kind.as_str(), rates[0].events), ("core", 5_000));
    assert_eq!(rates[0].species, ["ball", "fixed"]);
    assert!((rates[0].per_particle[0].unwrap() / rate - 1.0).abs() < 1e-12 && rates[0].per_particle[1].is_none());
}

#[test]
fn rates_by_kind_and_species_add_up_to_all_events() {
    let bath = Thermostat::Andersen { temperature: 1.0, rate: 0.5, axes: [true; 3] };
    let well = |s: f64| Potential::square_well(s, 1.5, 1.0).unwrap();
    let scene = SceneBuilder::new("kinds")
        .seed(4)
        .space(Space {
            boundary: [Boundary::walls(1.0), Boundary::Periodic, Boundary::Periodic],
            ..Space::periodic_cube(7.0)
        })
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .species(SpeciesDraft::new("B").mass(3.0).diameter(0.8))
        .interaction(InteractionDraft::new(well(1.0)).between("A", "A"))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "B"))
        .interaction(InteractionDraft::new(well(0.8)).between("B", "B"))
        .interaction(InteractionDraft::new(Potential::bond(0.8, 1.2).unwrap()).named("link"))
        .fill(Fill::new(Arrangement::Random, "A").count(40))
        .particle("B", Vector::new(1.0, 1.0, 1.0), Vector::zeros())
        .particle("B", Vector::new(2.0, 1.0, 1.0), Vector::zeros())
        .bond([40, 41], "link")
        .temperature(1.0)
        .run(RunPlan {
            equilibration: Until::events(1_000),
            limit: Until::events(20_000),
            thermostat: Some(bath),
            ..RunPlan::default()
        })
        .build()
        .unwrap();
    let finished = finish(scene);
    let (event_counts, rates) = (&finished.measurement.event_counts, Summary::of(&finished).rates);
    let count = |kind: &str| rates.iter().filter(|rate| rate.kind == kind).map(|rate| rate.events).sum::<u64>();
    assert_eq!(
        (count("core"), count("capture"), count("release")),
        (event_counts.core, event_counts.capture, event_counts.release)
    );
    assert_eq!((count("bounce") + count("bond"), count("wall")), (event_counts.bounce, event_counts.wall));
    assert_eq!(count("thermostat"), event_counts.thermostat);
    assert!(count("bond") > 10 && count("bounce") > 10, "{rates:?}");
    let between = |rate: &&Rate| rate.kind == "core" && rate.species == ["A", "B"];
    let rate = rates.iter().find(between).unwrap();
    // Each contact is between one of 40 particles of species A and one of 2 particles of species B.
    let [a, b] = [0, 1].map(|k| rate.per_particle[k].unwrap());
    assert!((a * 20.0 / b - 1.0).abs() < 1e-12 && (b * 2.0 / rate.per_time.unwrap() - 1.0).abs() < 1e-12);
}

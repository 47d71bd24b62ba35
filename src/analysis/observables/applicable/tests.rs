use super::*;
use crate::analysis::observables::Observer;
use crate::engine::Until;
use crate::model::ContactLaw;
use crate::model::space::{Boundary, Face, Space};
use crate::scene::{Arrangement, Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};

fn pair() -> SceneBuilder {
    SceneBuilder::new("pair")
        .space(Space::periodic_cube(10.0))
        .species(SpeciesDraft::new("A").mass(2.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .particle("A", Vector::new(3.0, 5.0, 5.0), Vector::new(3.0, 0.0, 0.0))
        .particle("A", Vector::new(7.0, 5.0, 5.0), Vector::new(1.0, 0.0, 0.0))
}

fn fluid(count: u64) -> SceneBuilder {
    SceneBuilder::new("fluid")
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(count).packing_fraction(0.2))
}

fn slit() -> Space {
    Space { boundary: [Boundary::walls(1.0), Boundary::Periodic, Boundary::Periodic], ..Space::periodic_cube(10.0) }
}

fn observed(scene: &SceneBuilder) -> (Observer, Simulation) {
    let scene = scene.build().unwrap();
    (Observer::new(&scene), Simulation::without_plan(scene))
}

#[test]
fn a_periodic_fluid_has_everything_but_a_height() {
    let applicable = ApplicableObservables::of(&pair().build().unwrap());
    assert!(
        applicable.conserves_momentum && applicable.has_temperature && applicable.has_pressure && applicable.has_core
    );
    assert!(!applicable.has_wells && !applicable.has_height());
    assert_eq!(applicable.degrees_of_freedom, 3.0);
    assert_eq!(applicable.number_density, 0.002);
    // Both particles move at a speed of 1 relative to their common velocity of 2, so `K = 2` and `T = 2 * 2 / 3`.
    assert_eq!(applicable.temperature(10.0, &Vector::new(8.0, 0.0, 0.0)), Some(4.0 / 3.0));
}

#[test]
fn walls_gravity_and_static_particles_disable_observables() {
    let walls = Space { boundary: [Boundary::walls(1.0); 3], ..Space::periodic_cube(10.0) };
    let walled = ApplicableObservables::of(&pair().space(walls.clone()).build().unwrap());
    assert!(!walled.conserves_momentum && !walled.is_homogeneous && walled.has_temperature);
    assert!(walled.has_pressure && walled.pressed_walls == [[true; 2]; 3]);
    assert_eq!(walled.degrees_of_freedom, 6.0);
    assert_eq!(walled.temperature(10.0, &Vector::new(8.0, 0.0, 0.0)), Some(20.0 / 6.0));
    // The tangential forces of rough walls contribute to the virial, but only normal impulses are summed.
    let wall = Face::Wall(ContactLaw::smooth(1.0).with_friction(0.3));
    let rough = Space { boundary: [Boundary::Bounded { lower: wall, upper: wall }; 3], ..walls };
    let rough = ApplicableObservables::of(&pair().space(rough).build().unwrap());
    assert!(!rough.has_pressure && rough.pressed_walls == [[true; 2]; 3]);
    // The walls act only along x. The common motion along y has a kinetic energy of 2.
    let slit = ApplicableObservables::of(&pair().space(slit()).build().unwrap());
    assert!(!slit.conserves_momentum && slit.conserved_axes == [false, true, true]);
    assert_eq!(slit.degrees_of_freedom, 4.0);
    assert_eq!(slit.temperature(10.0, &Vector::new(8.0, 4.0, 0.0)), Some(2.0 * (10.0 - 2.0) / 4.0));
    assert_eq!(slit.drift(&Vector::new(8.0, 4.0, 0.0)), Vector::new(0.0, 1.0, 0.0));

    let falling = ApplicableObservables::of(&pair().gravity(Vector::new(0.0, 0.0, -1.0)).build().unwrap());
    assert!(!falling.conserves_momentum && !falling.has_pressure && !falling.has_temperature);
    assert!(falling.has_height());

    let with_static = pair()
        .species(SpeciesDraft::new("S").diameter(1.0).fixed())
        .interaction(InteractionDraft::new(Potential::square_well(1.0, 1.5, 1.0).unwrap()).between("A", "S"))
        .particle("S", Vector::zeros(), Vector::zeros());
    let with_static = ApplicableObservables::of(&with_static.build().unwrap());
    assert!(!with_static.conserves_momentum && !with_static.has_pressure && with_static.has_wells);
    assert_eq!(with_static.moving, 2);
}

#[test]
fn system_at_rest_has_unknown_equilibrium() {
    let (mut observer, mut simulation) = observed(&fluid(32));
    for row in 0..100 {
        simulation.advance(Until::time(f64::from(row))).unwrap();
        observer.row(&simulation);
    }
    let verdict = observer
        .equilibrium(&observer.stationarity(), simulation.event_counts(), simulation.scene().units())
        .to_string();
    assert_eq!(verdict, "unknown (no fluctuating quantity was measured)");
}

#[test]
fn fluid_virial_is_positive_and_rates_match_the_counts() {
    let (mut observer, mut simulation) = observed(&fluid(256).temperature(1.5));
    simulation.advance(Until::events(5_000)).unwrap();
    let first = observer.row(&simulation);
    assert_eq!((first.pressure, first.collision_rate), (None, None), "no interval yet");
    simulation.advance(Until::events(25_000)).unwrap();
    let row = observer.row(&simulation);
    assert_eq!(row.collision_rate, Some(2.0 * 20_000.0 / (256.0 * (row.time - first.time))));
    let (_, z) = observer.estimates()[2];
    // Carnahan and Starling give `Z = 2.4063`. 20,000 uncorrelated contacts would have a relative error of 0.7 %.
    assert!((z.mean / 2.4063 - 1.0).abs() < 0.03, "{}", z.mean);
    let temperature = row.temperature.unwrap();
    assert!((temperature - 1.5).abs() < 1e-12);
    let density = 0.2 * 6.0 / std::f64::consts::PI;
    assert!((row.pressure.unwrap() / (z.mean * density * temperature) - 1.0).abs() < 1e-12);
}

#[test]
fn only_motion_normal_to_the_walls_gives_pressure() {
    // One particle hits each wall of area 100 once in a time of 18 and transfers a momentum of 2. The pressure is
    // `2 / (18 * 100) = 1 / 900`. The other particle moves along the walls.
    let scene = SceneBuilder::new("slit")
        .space(slit())
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .particle("A", Vector::new(3.0, 5.0, 2.0), Vector::new(1.0, 0.0, 0.0))
        .particle("A", Vector::new(7.0, 5.0, 7.0), Vector::new(0.0, 2.0, 0.0));
    let (mut observer, mut simulation) = observed(&scene);
    for time in [0.0, 5.0, 18.0, 90.0] {
        simulation.advance(Until::time(time)).unwrap();
        let row = observer.row(&simulation);
        assert!(time == 0.0 || (row.pressure.unwrap() * 900.0 - 1.0).abs() < 1e-13, "{row:?}");
    }
}

#[test]
fn the_pressure_of_a_driven_granular_slit_is_that_on_its_walls() {
    // The walls normal to x are cold, a heat bath acts along y, and contacts dissipate energy. All temperatures differ.
    let mut scene = SceneBuilder::new("driven")
        .space(slit())
        .wall_temperature(0, 0.2)
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .species(SpeciesDraft::new("B").mass(5.0).diameter(2.0));
    for (pair, diameter) in [(["A", "A"], 1.0), (["A", "B"], 1.5), (["B", "B"], 2.0)] {
        scene = scene.interaction(
            InteractionDraft::new(Potential::hard_sphere(diameter).unwrap()).between(pair[0], pair[1]).restitution(0.7),
        );
    }
    let scene = scene
        .fill(Fill { temperature: Some(1.0), ..Fill::new(Arrangement::Random, "A").count(40) })
        .fill(Fill { temperature: Some(1.0), ..Fill::new(Arrangement::Random, "B").count(10) });
    let (mut observer, mut simulation) = observed(&scene);
    let bath = Thermostat::Andersen { temperature: 1.0, rate: 1.0, axes: [false, true, false] };
    simulation.set_thermostat(Some(&bath), 0).unwrap();
    // The virial pressure and the pressure on the walls differ only by the change of the moment `sum x m v / V`.
    let moment = |simulation: &Simulation| {
        let (scene, snapshot) = (simulation.scene(), simulation.snapshot());
        let of = |(k, particle): (usize, &crate::model::Particle)| {
            let species = &scene.species[particle.species.0 as usize];
            let room = scene.space.accessible_volume(species.diameter);
            (snapshot.positions[k].x - 5.0) * species.mass * snapshot.velocities[k].x / room
        };
        scene.particles.iter().enumerate().map(of).sum::<f64>()
    };
    let mut last: Option<(f64, EventCounts, f64)> = None;
    for stretch in 0..5_u64 {
        simulation.advance(Until::events(500 * stretch)).unwrap();
        let arrived = moment(&simulation);
        if stretch == 3 {
            simulation.scale_velocities(1.5, &Vector::zeros());
        }
        let (row, event_counts) = (observer.row(&simulation), *simulation.event_counts());
        if let Some((time, earlier, left)) = last {
            let on_walls: f64 = event_counts.since(&earlier).wall_push[0].iter().map(|sum| sum.total()).sum();
            let expected = (0.5 * on_walls + arrived - left) / (row.time - time);
            assert!((row.pressure.unwrap() / expected - 1.0).abs() < 1e-10, "{row:?} {expected}");
        }
        last = Some((row.time, event_counts, moment(&simulation)));
    }
}

//! Conservation of energy and momentum within round-off, and an exact solution in one dimension.

use carom::Vector;
use carom::engine::event::{Event, EventKind};
use carom::engine::{Reason, Simulation, Until};
use carom::model::Scene;
use carom::model::potential::Potential;
use carom::model::space::{Boundary, Space};
use carom::physics::response::Outcome;
use carom::scene::{Arrangement, Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};

/// Largest relative rounding error of an event, in units of epsilon. Vectors are rounded a few times.
const ROUNDINGS: f64 = 8.0;

/// Executes events. Checks that energy and momentum change by no more than the sum of all rounding errors.
fn assert_conserved(mut simulation: Simulation, events: u64) {
    let start = simulation.energy();
    assert_eq!(simulation.advance(Until::events(events)), Ok(Reason::Events));
    let end = simulation.energy();
    let particles = simulation.moving() as f64;
    let mass = simulation.scene().species().iter().map(|s| s.mass).filter(|m| m.is_finite()).fold(0.0, f64::max);
    // On average, a colliding particle has less than twice the mean kinetic energy.
    let typical = 2.0 * (start.kinetic.max(end.kinetic) / particles);
    let energy = 2.0 * ROUNDINGS * f64::EPSILON * events as f64 * typical;
    let error = end.kinetic + end.potential - start.kinetic - start.potential;
    println!("energy {error:e} of {}, bound {energy:e}", start.kinetic);
    assert!(error.abs() < energy, "energy changed by {error}, bound {energy}");
    let momentum = ROUNDINGS * f64::EPSILON * events as f64 * (2.0 * mass * typical).sqrt();
    let drift = (end.momentum - start.momentum).amax();
    println!("momentum {drift:e}, bound {momentum:e}");
    assert!(drift < momentum, "momentum changed by {drift}, bound {momentum}");
}

#[test]
fn hard_spheres_conserve_energy_and_momentum() {
    let scene = SceneBuilder::new("spheres")
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(500).packing_fraction(0.45))
        .temperature(1.0)
        .build()
        .unwrap();
    assert_conserved(Simulation::without_plan(scene), 500_000);
}

#[test]
fn stepped_lennard_jones_conserves_energy_and_momentum() {
    let overrides = [("fill.0.count", "500")];
    let scene = Scene::from_file_with("configs/stepped_lennard_jones.toml", &overrides).unwrap();
    assert_conserved(Simulation::without_plan(scene), 100_000);
}

#[test]
fn mixtures_of_masses_and_potentials_conserve_energy_and_momentum() {
    let mut fill = Fill::new(Arrangement::Random, "light").count(400).number_density(0.3);
    fill.composition = vec![("light".to_owned(), 3.0), ("heavy".to_owned(), 1.0)];
    let scene = SceneBuilder::new("mixture")
        .species(SpeciesDraft::new("light").mass(0.01).diameter(0.6))
        .species(SpeciesDraft::new("heavy").mass(7.0).diameter(1.2))
        .interaction(InteractionDraft::new(Potential::penetrable(0.6, 0.8).unwrap()).between("light", "light"))
        .interaction(InteractionDraft::new(Potential::square_well(0.9, 1.4, 0.7).unwrap()).between("light", "heavy"))
        .interaction(
            InteractionDraft::new(Potential::square_shoulder(1.2, 1.2, 0.5).unwrap()).between("heavy", "heavy"),
        )
        .fill(fill)
        .temperature(1.0)
        .build()
        .unwrap();
    assert_conserved(Simulation::without_plan(scene), 500_000);
}

#[test]
fn species_of_unequal_mass_share_the_energy_evenly() {
    let mut fill = Fill::new(Arrangement::Random, "light").count(400).packing_fraction(0.2);
    fill.composition = vec![("light".to_owned(), 1.0), ("heavy".to_owned(), 1.0)];
    let mut builder = SceneBuilder::new("mixture")
        .species(SpeciesDraft::new("light").mass(0.25).diameter(1.0))
        .species(SpeciesDraft::new("heavy").mass(4.0).diameter(1.0));
    for (a, b) in [("light", "light"), ("light", "heavy"), ("heavy", "heavy")] {
        builder = builder.interaction(InteractionDraft::new(Potential::hard_sphere(1.0).unwrap()).between(a, b));
    }
    let mut simulation = Simulation::without_plan(builder.fill(fill).temperature(1.0).build().unwrap());
    simulation.advance(Until::events(20_000)).unwrap();
    let shares = crate::measure::Mean::of((1..=100).map(|block| {
        simulation.advance(Until::events(20_000 + block * 4_000)).unwrap();
        let now = simulation.snapshot();
        let (mut light, mut all) = (0.0, 0.0);
        for (particle, velocity) in simulation.scene().particles().iter().zip(&now.velocities) {
            let energy = simulation.scene().species()[particle.species.0 as usize].mass * velocity.norm_squared();
            all += energy;
            light += if particle.species.0 == 0 { energy } else { 0.0 };
        }
        light / all
    }));
    // Conservation of momentum removes three degrees of freedom. The light species has 1/17 of the mass and loses 3/17.
    shares.assert_is((600.0 - 3.0 / 17.0) / 1197.0, 0.004, "energy of the light half");
}

#[test]
fn elastic_spheres_1d_scene_has_its_exact_solution() {
    let scene = Scene::from_file("configs/elastic_spheres_1d.toml").unwrap();
    let mut simulation = Simulation::without_plan(scene);
    let mut events: Vec<Event> = Vec::new();
    assert_eq!(simulation.advance_with(Until::time(10.0), |event| events.push(*event)), Ok(Reason::Time));
    let pairs: Vec<_> = events.iter().map(|e| (e.particle.0.min(e.partner().unwrap().0), e.kind)).collect();
    assert_eq!(pairs, [(0, EventKind::Pair(Outcome::Core)), (1, EventKind::Pair(Outcome::Core))]);
    assert_eq!(events[0].time, 0.0);
    assert!((events[1].time - 1.01).abs() <= 1e-14, "{}", events[1].time);
    let end = simulation.snapshot();
    for (k, (x, v)) in [(-10.0, -1.0), (11.5, 1.0), (20.99, 2.0)].into_iter().enumerate() {
        // Each position below 32 is rounded three times.
        assert!((end.positions[k].x - x).abs() <= 3.0 * 16.0 * f64::EPSILON, "{}", end.positions[k].x);
        assert_eq!(end.velocities[k], Vector::new(v, 0.0, 0.0));
    }
    assert_eq!(simulation.energy().kinetic, 3.0);
    assert_eq!(simulation.energy().momentum.x, 2.0);
}

#[test]
fn elastic_spheres_that_fall_between_elastic_walls_keep_their_energy() {
    let space = Space {
        lower: Vector::zeros(),
        size: Vector::new(6.0, 6.0, 12.0),
        boundary: [Boundary::Periodic, Boundary::walls(1.0), Boundary::walls(1.0)],
    };
    let scene = SceneBuilder::new("falling")
        .space(space)
        .gravity(Vector::new(0.0, 0.0, -1.0))
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .fill(Fill::new(Arrangement::Random, "A").count(100))
        .temperature(1.0)
        .build()
        .unwrap();
    let mut simulation = Simulation::without_plan(scene);
    let start = simulation.energy();
    simulation.advance(Until::events(200_000)).unwrap();
    let end = simulation.energy();
    let error = end.kinetic + end.potential - start.kinetic - start.potential;
    // The flight to an event rounds the energies of two particles. The energy of a particle is at most g h = 12.
    let bound = 200_000.0 * ROUNDINGS * 2.0 * 12.0 * f64::EPSILON;
    println!("energy {error:e}, bound {bound:e}");
    assert!(error.abs() < bound);
    assert!(simulation.event_counts().wall > 1000);
}

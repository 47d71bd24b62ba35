//! Hard spheres, disks and rods in equilibrium.

use crate::measure::{Fluid, Mean};
use carom::engine::{Simulation, Until};
use carom::model::space::Boundary;
use carom::scene::{Amount, Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};
use std::f64::consts::PI;

const BULK: [Boundary; 3] = [Boundary::Periodic; 3];
const PLANE: [Boundary; 3] = [Boundary::Periodic, Boundary::Periodic, Boundary::Flat];
const LINE: [Boundary; 3] = [Boundary::Periodic, Boundary::Flat, Boundary::Flat];

fn hard_spheres(boundary: [Boundary; 3], lattice: Lattice, count: u64, amount: Amount) -> Simulation {
    let scene = SceneBuilder::new("hard_spheres")
        .boundary(boundary)
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .fill(Fill { amount: Some(amount), ..Fill::new(lattice, "A").count(count) })
        .temperature(1.0)
        .build()
        .unwrap();
    Simulation::without_plan(scene)
}

/// The mKLM equation of state (Pieprzyk et al., Phys. Chem. Chem. Phys. 21, 6886, 2019).
fn mklm(packing_fraction: f64) -> f64 {
    let x = packing_fraction / (1.0 - packing_fraction);
    let terms = [
        (0, 1.0),
        (1, 4.0),
        (2, 6.0),
        (3, 2.3647684),
        (4, -0.8698551),
        (5, 1.1062803),
        (6, -1.1014221),
        (7, 0.66605866),
        (8, -0.03633431),
        (10, -0.20965164),
        (14, 0.10555569),
        (22, -0.0087238),
    ];
    terms.iter().map(|&(power, factor)| factor * x.powi(power)).sum()
}

/// Asserts that `Z - 1 = G sqrt(pi) / (2 D)` at temperature 1 in `D` dimensions. `Z` is the compressibility factor and
/// `G` is the collision rate. For `N` particles, the error of this relation is less than `1 / (4 D N)`.
fn assert_contacts_are_maxwellian(fluid: &Fluid) {
    let ratio = fluid.mean(|b| {
        let excess = b.virial / (fluid.dimensions * fluid.particles * b.temperature * b.time);
        let rate = 2.0 * b.core / (fluid.particles * b.time * b.temperature.sqrt());
        excess / (rate * PI.sqrt() / (2.0 * fluid.dimensions))
    });
    ratio.assert_is(1.0, 1e-3, "(Z - 1) 2 D / (G sqrt(pi))");
}

#[test]
fn spheres_have_the_pressure_and_collision_rate_of_their_packing_fraction() {
    assert!((mklm(0.40) - 6.94546).abs() < 1e-5);
    for packing_fraction in [0.10, 0.30, 0.45] {
        let amount = Amount::PackingFraction(packing_fraction);
        let mut simulation = hard_spheres(BULK, Lattice::FaceCentredCubic, 1372, amount);
        let fluid = Fluid::measure(&mut simulation, 200_000, 40, 25_000);
        let z = mklm(packing_fraction);
        fluid.compressibility().assert_is(z, 0.003 * z, "Z");
        let rate = 6.0 * (z - 1.0) / PI.sqrt();
        fluid.collision_rate().assert_is(rate, 0.003 * rate, "G");
        assert_contacts_are_maxwellian(&fluid);
        assert!((fluid.temperature().mean - 1.0).abs() < 1e-9);
    }
}

#[test]
fn a_crystal_at_melting_has_the_pressure_of_the_fluid_at_freezing() {
    // Speedy, J. Phys.: Condens. Matter 10, 4387 (1998). The pressure at coexistence is 11.566.
    let density: f64 = 1.0376;
    let z = density / 2.0_f64.sqrt();
    let speedy = 3.0 / (1.0 - z) - 0.5921 * (z - 0.7072) / (z - 0.601);
    assert!((density * speedy - 11.566).abs() < 1e-3);
    let mut simulation = hard_spheres(BULK, Lattice::FaceCentredCubic, 1372, Amount::NumberDensity(density));
    let fluid = Fluid::measure(&mut simulation, 200_000, 30, 25_000);
    fluid.compressibility().assert_is(speedy, 0.003 * speedy, "Z");
    let fluid_z = mklm(0.9392 * PI / 6.0);
    assert!((0.9392 * fluid_z - 11.566).abs() < 0.01, "{fluid_z}");
}

#[test]
fn disks_have_the_pressure_and_collision_rate_of_their_packing_fraction() {
    for (eta, z) in [(0.3_f64, 2.06369), (0.5, 4.10516)] {
        let series = 1.0 + eta * eta / 8.0 + eta.powi(3) / 18.0 - 4.0 * eta.powi(4) / 21.0;
        assert!((series / (1.0 - eta).powi(2) - z).abs() < 1e-5);
        // In a system of N particles, Z - 1 is lower by a fraction of about 1 / N.
        let mut simulation = hard_spheres(PLANE, Lattice::Hexagonal, 4096, Amount::PackingFraction(eta));
        let fluid = Fluid::measure(&mut simulation, 200_000, 40, 50_000);
        fluid.compressibility().assert_is(z, 0.003 * z, "Z");
        let rate = 4.0 * (z - 1.0) / PI.sqrt();
        fluid.collision_rate().assert_is(rate, 0.003 * rate, "G");
        assert_contacts_are_maxwellian(&fluid);
    }
}

#[test]
fn rods_on_a_ring_have_the_exact_number_of_contacts() {
    // Equal rods exchange their velocities, which move like points on a ring of length L - N sigma. Two velocities meet
    // floor or ceil(|v_i - v_j| t / (L - N sigma)) times, with the impulse |v_i - v_j|. At the density rho = 1/2,
    // Tonks's result is Z = 1 / (1 - rho sigma) = 2.
    let (count, time) = (50, 20_000.0);
    let mut simulation = hard_spheres(LINE, Lattice::Line, count, Amount::NumberDensity(0.5));
    let velocities: Vec<f64> = simulation.scene().particles().iter().map(|p| p.velocity.x).collect();
    let free = simulation.scene().space().size.x - count as f64;
    let pairs = velocities.iter().enumerate().flat_map(|(i, v)| velocities[..i].iter().map(move |w| (v - w).abs()));
    let (mut contacts, mut virial, mut most, mut fastest) = (0.0, 0.0, 0.0, 0.0_f64);
    for speed in pairs {
        contacts += speed * time / free;
        virial += speed * speed * time / free;
        most += 1.0;
        fastest = fastest.max(speed);
    }
    simulation.advance(Until::time(time)).unwrap();
    let event_counts = simulation.event_counts();
    println!(
        "{} contacts, expected {contacts:.0} +- {most}; virial {} of {virial}",
        event_counts.core,
        event_counts.virial.total()
    );
    assert!((event_counts.core as f64 - contacts).abs() <= most && most < 0.01 * contacts);
    assert!((event_counts.virial.total() - virial).abs() <= most * fastest && most * fastest < 0.01 * virial);
    let kinetic = simulation.energy().kinetic;
    let z = 1.0 + event_counts.virial.total() / (2.0 * kinetic * time);
    assert!((z - 2.0).abs() < 0.01, "{z}");
    // With Maxwell's velocity distribution, each rod would have 2 rho / ((1 - rho) sqrt(pi)) contacts per unit of time.
    let rate = 2.0 * event_counts.core as f64 / (count as f64 * time);
    assert!((rate - 2.0 / PI.sqrt()).abs() < 0.1, "{rate}");
}

#[test]
fn mean_has_the_exact_standard_error() {
    let mean = Mean::of([1.0, 2.0, 3.0, 4.0]);
    assert_eq!(mean.mean, 2.5);
    assert!((mean.error - (5.0_f64 / 12.0).sqrt()).abs() < 1e-15);
}

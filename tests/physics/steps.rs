//! The exact law for events at the steps of a potential in equilibrium.
//!
//! Relative normal velocities `vn` are Maxwellian on either side of a step. A pair of reduced mass `mu` that meets an
//! upward step `eps` bounces if `mu/2 vn^2 <= eps`. As many pairs go up as down, so `N_bounce / N_up = exp(eps / T) -
//! 1` (Bannerman and Lue, J. Chem. Phys. 133, 124506, 2010). For `N` particles of constant total energy in `D`
//! dimensions, the relative error is of order `1 / (D N)`.

use crate::measure::{Fluid, Mean};
use carom::engine::Simulation;
use carom::engine::event::EventKind;
use carom::model::potential::Potential;
use carom::physics::response::Outcome;
use carom::scene::{Fill, InteractionDraft, Lattice, SceneBuilder, SpeciesDraft};
use std::f64::consts::PI;

fn fluid(potential: &Potential, count: u64, density: f64, temperature: f64) -> Simulation {
    let scene = SceneBuilder::new("steps")
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(potential.clone()).between("A", "A"))
        .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(count).number_density(density))
        .temperature(temperature)
        .build()
        .unwrap();
    Simulation::without_plan(scene)
}

#[derive(Debug, Clone, Copy, Default)]
struct Counts {
    inwards: f64,
    outwards: f64,
    bounces: f64,
}

fn assert_the_law_holds(potential: &Potential, density: f64, temperature: f64, resolution: f64) {
    const BLOCKS: usize = 40;
    let mut counts = vec![vec![Counts::default(); BLOCKS]; potential.radii().len()];
    let mut simulation = fluid(potential, 864, density, temperature);
    let fluid = Fluid::measure_with(&mut simulation, 150_000, BLOCKS, 25_000, |block, event| {
        let step = potential.radii().iter().position(|radius| *radius == event.distance).unwrap();
        let counts = &mut counts[step][block];
        match event.kind {
            EventKind::Pair(Outcome::Capture) => counts.inwards += 1.0,
            EventKind::Pair(Outcome::Release) => counts.outwards += 1.0,
            EventKind::Pair(Outcome::Bounce) => counts.bounces += 1.0,
            _ => {}
        }
    });
    println!("temperature {:?}", fluid.temperature());
    for (step, counts) in counts.iter().enumerate() {
        let [outside, inside] = [potential.energies()[step], potential.energies()[step + 1]];
        if inside == f64::INFINITY {
            continue;
        }
        let height = (inside - outside).abs();
        let up = |c: &Counts| if inside > outside { c.inwards } else { c.outwards };
        let total: f64 = counts.iter().map(up).sum();
        // For B bounces and U passages upwards, B - (exp(eps / T) - 1) U has the mean 0. The mean of B / U is biased.
        let excess = Mean::of(
            counts.iter().zip(&fluid.blocks).map(|(c, b)| c.bounces - (height / b.temperature).exp_m1() * up(c)),
        );
        let scale = total / BLOCKS as f64;
        let ratio = height / fluid.temperature().mean;
        let law = Mean { mean: excess.mean / scale, error: excess.error / scale };
        law.assert_is(0.0, resolution * ratio.exp(), &format!("bounces at step {step}, {ratio:.3} T high"));
        let net: f64 = counts.iter().map(|c| c.inwards - c.outwards).sum();
        // The change of the number of pairs inside a step is far below the number of events.
        assert!(net.abs() < 4.0 * total.sqrt(), "{net} more went in than out at step {step}, of {total}");
    }
}

#[test]
fn square_wells_have_the_exact_ratio_of_bounces_to_releases() {
    assert_the_law_holds(&Potential::square_well(1.0, 1.5, 1.0).unwrap(), 0.5, 2.0, 0.01);
}

#[test]
fn square_shoulders_have_the_exact_ratio_of_bounces_to_entries() {
    assert_the_law_holds(&Potential::square_shoulder(1.0, 1.5, 1.0).unwrap(), 0.4, 3.0, 0.01);
}

#[test]
fn penetrable_spheres_have_the_exact_ratio_of_bounces_to_entries() {
    assert_the_law_holds(&Potential::penetrable(1.0, 1.0).unwrap(), 1.0, 2.0, 0.01);
}

#[test]
fn lennard_jones_steps_have_the_exact_ratios_of_bounces() {
    let potential = Potential::stepped_lennard_jones(1.0, 1.0, 1.8, 8, 10.0).unwrap();
    assert_the_law_holds(&potential, 0.5, 1.5, 0.05);
}

#[test]
fn well_under_a_shoulder_has_the_exact_ratios_of_bounces() {
    let inf = f64::INFINITY;
    let potential = Potential::new(vec![1.9, 1.6, 1.3, 1.0], vec![0.0, 0.7, -0.5, 0.4, inf]).unwrap();
    assert_the_law_holds(&potential, 0.3, 1.0, 0.02);
}

#[test]
fn dilute_square_wells_have_the_second_virial_coefficient() {
    // The virial expansion is Z - 1 = B2 rho + B3 rho^2 + ... Measurements at two densities eliminate B3.
    let sphere = 2.0 * PI / 3.0;
    let b2 = |temperature: f64| sphere * (1.0 - (1.5_f64.powi(3) - 1.0) * (1.0 / temperature).exp_m1());
    assert!((b2(2.0) / sphere + 0.54071).abs() < 1e-5 && (b2(1.0) / sphere + 3.08092).abs() < 1e-5);
    for temperature in [1.0, 3.0] {
        let [one, two] = [0.01, 0.02].map(|density| {
            let potential = Potential::square_well(1.0, 1.5, 1.0).unwrap();
            let mut simulation = fluid(&potential, 500, density, temperature);
            let fluid = Fluid::measure(&mut simulation, 50_000, 40, 12_000);
            // The temperature rises at first, because no pair is in a well at the start. Each block has its own
            // temperature.
            fluid.mean(|b| b.virial / (3.0 * fluid.particles * b.temperature * b.time * density) - b2(b.temperature))
        });
        let extrapolated = Mean { mean: 2.0 * one.mean - two.mean, error: (2.0 * one.error).hypot(two.error) };
        extrapolated.assert_is(0.0, 0.3, &format!("error of B2 = {:.4} at T = {temperature}", b2(temperature)));
    }
}

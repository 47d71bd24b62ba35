//! Hard rods on a ring, with an exactly known number of contacts.
//!
//! Equal rods exchange their velocities at a contact, like points that pass through each other on a ring of length
//! `L - N sigma`. In a time `t`, two points with velocities `v_i` and `v_j` pass each other
//! `|v_i - v_j| t / (L - N sigma)` times, rounded up or down. Each contact has the impulse `m |v_i - v_j|`.

use super::state_point::{Compared, Watch, advance, build, one_species};
use super::{Comparison, Effort, Source};
use crate::analysis::published;
use crate::engine::Simulation;
use crate::model::potential::Potential;
use crate::model::space::Boundary;
use crate::scene::{Fill, Lattice};

pub(super) const COUNT: u64 = 50;
/// On average, each pair of velocities has about four hundred contacts.
const EVENTS: u64 = 500_000;
const CHUNK: u64 = 50_000;

pub(super) const QUANTITIES: &[&str] = &["compressibility factor", "contacts"];

const TONKS: Source = Source {
    short: "exact, Tonks 1936",
    full: "Tonks, Phys. Rev. 50, 955 (1936): Z = 1 / (1 - rho sigma), of 50 rods 1 + (1 - 1 / N) rho sigma / (1 - rho sigma)",
};
const EXCHANGE: Source = Source {
    short: "exact, rods",
    full: "equal rods exchange velocities: each pair meets |v_i - v_j| t / (L - N sigma) times, rounded up or down",
};
const ROUNDED: &str = "one contact for each pair of rods";

pub(super) fn compare(number_density: f64, _: Effort, seed: u64, watch: Watch<'_>) -> Compared {
    let scene = one_species(seed, Potential::hard_sphere(1.0)?, 1.0)
        .boundary([Boundary::Periodic, Boundary::Flat, Boundary::Flat])
        .fill(Fill::new(Lattice::Line, "A").count(COUNT).number_density(number_density))
        .temperature(1.0);
    let mut simulation = Simulation::without_plan(build(&scene)?);
    let scene = simulation.scene();
    let free = scene.space.size.x - COUNT as f64;
    let velocities: Vec<f64> = scene.particles.iter().map(|particle| particle.velocity.x).collect();
    let pairs = velocities.iter().enumerate().flat_map(|(i, v)| velocities[..i].iter().map(move |w| (v - w).abs()));
    let (mut speeds, mut number) = (0.0, 0.0);
    for speed in pairs {
        speeds += speed;
        number += 1.0;
    }
    for _ in 0..EVENTS / CHUNK {
        advance(&mut simulation, CHUNK, watch, |_| {})?;
    }
    let (time, event_counts) = (simulation.time(), simulation.event_counts());
    // The compressibility factor is Z = 1 + W / (N T t), with the sum of the virial W. On a line without net momentum,
    // the kinetic energy is K = T (N - 1) / 2.
    let work = 2.0 * simulation.energy().kinetic * time * (COUNT as f64 / (COUNT as f64 - 1.0));
    // The configuration space of N rods on a ring has the volume `L (L - N sigma)^(N - 1)`. The derivative of its
    // logarithm with respect to L is the pressure divided by the temperature.
    let expected = 1.0 + (published::tonks(number_density) - 1.0) * (1.0 - 1.0 / COUNT as f64);
    Ok(vec![
        Comparison::exact(QUANTITIES[0], Some(1.0 + event_counts.virial.total() / work), expected, TONKS)
            .allow(speeds / work, ROUNDED),
        Comparison::exact(QUANTITIES[1], Some(event_counts.core as f64), speeds * time / free, EXCHANGE)
            .allow(number, ROUNDED),
    ])
}

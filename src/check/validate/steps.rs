//! Numbers of bounces, releases and captures at the edge of a square well, compared with their exact ratios.

use super::state_point::{Compared, Watch, advance, build, equilibration, mean, one_species};
use super::{Comparison, Effort, Source};
use crate::analysis::published;
use crate::analysis::statistics::Estimate;
use crate::engine::Simulation;
use crate::engine::event::EventKind;
use crate::model::potential::Potential;
use crate::physics::response::Outcome;
use crate::scene::{Fill, Lattice};

/// Number of blocks for the standard errors. A block is longer than the time that pairs stay in their wells.
const BLOCKS: u64 = 40;
const DEPTH: f64 = 1.0;

pub(super) const QUANTITIES: &[&str] = &["bounces per release", "captures per release"];

const BANNERMAN_LUE: Source = Source {
    short: "exact, steps",
    full: "Bannerman and Lue, J. Chem. Phys. 133, 124506 (2010): N_bounce / N_release = exp(eps / T) - 1, N_capture = N_release",
};
const FIXED_ENERGY: &str = "first order in 1 / (3 N - 3): the energy is fixed, not the temperature";

#[derive(Debug, Clone, Copy, Default)]
struct Block {
    captures: f64,
    releases: f64,
    bounces: f64,
    /// Mean temperature over the time of the block `[energy]`.
    temperature: f64,
}

pub(super) fn compare(temperature: f64, effort: Effort, seed: u64, watch: Watch<'_>) -> Compared {
    let scene = one_species(seed, Potential::square_well(1.0, 1.5, DEPTH)?, 1.0)
        .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(effort.particles()).number_density(0.5))
        .temperature(temperature);
    let mut simulation = Simulation::without_plan(build(&scene)?);
    let freedom = 3.0 * (simulation.moving() as f64 - 1.0);
    advance(&mut simulation, 2 * equilibration(effort), watch, |_| {})?;
    let mut blocks = Vec::new();
    for _ in 0..BLOCKS {
        blocks.push(block(&mut simulation, effort.events() / BLOCKS, freedom, watch)?);
    }
    Ok(law(&blocks, freedom))
}

fn block(
    simulation: &mut Simulation,
    events: u64,
    freedom: f64,
    watch: Watch<'_>,
) -> Result<Block, super::StatePointError> {
    let (start, mut now, mut kinetic) = (simulation.time(), simulation.time(), simulation.energy().kinetic);
    let (mut block, mut integral) = (Block::default(), 0.0);
    advance(simulation, events, watch, |event| {
        integral += kinetic * (event.time - now);
        kinetic -= event.energy_step;
        now = event.time;
        match event.kind {
            EventKind::Pair(Outcome::Capture) => block.captures += 1.0,
            EventKind::Pair(Outcome::Release) => block.releases += 1.0,
            EventKind::Pair(Outcome::Bounce) => block.bounces += 1.0,
            _ => {}
        }
    })?;
    Ok(Block { temperature: 2.0 * integral / (now - start) / freedom, ..block })
}

/// Compares ratios of event numbers with the law at the mean temperature of the blocks. Errors propagate linearly.
fn law(blocks: &[Block], freedom: f64) -> Vec<Comparison> {
    let count = blocks.len() as f64;
    let average = |of: fn(&Block) -> f64| blocks.iter().map(of).sum::<f64>() / count;
    let releases = average(|block| block.releases);
    let temperature = average(|block| block.temperature);
    let ratio = |of: fn(&Block) -> f64, slope: f64| {
        let ratio = average(of) / releases;
        let linear =
            |block: &Block| (of(block) - ratio * block.releases) / releases - slope * (block.temperature - temperature);
        let residues: Vec<f64> = blocks.iter().map(linear).collect();
        mean(&residues).map(|residue| Estimate { mean: ratio, ..residue })
    };
    let height = DEPTH / temperature;
    // Derivative of exp(eps / T) with respect to T.
    let slope = -height / temperature * libm::exp(height);
    let bounces = ratio(|block| block.bounces, slope);
    // At constant energy with `f` degrees of freedom, the radial energy of a pair exceeds the well depth `eps` with the
    // probability `(1 - 2 eps / (f T))^((f - 1) / 2)`. In addition, the temperature has a variance of at most
    // `2 T^2 / f`, which shifts the mean of `exp(eps / T)`.
    let allowance = libm::exp(height) * height * ((1.0 - height).abs() + height + 2.0) / freedom;
    vec![
        Comparison::statistical(
            QUANTITIES[0],
            bounces,
            published::bounces_per_release(DEPTH, temperature),
            BANNERMAN_LUE,
        )
        .allow(allowance, FIXED_ENERGY),
        Comparison::statistical(QUANTITIES[1], ratio(|block| block.captures, 0.0), 1.0, BANNERMAN_LUE),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lawful() -> Vec<Block> {
        let block = |k: u32| {
            let temperature = 2.0 + 1e-3 * f64::from(k % 5);
            let releases = 1000.0 + f64::from(k % 7);
            let bounces = releases * published::bounces_per_release(DEPTH, temperature);
            Block { captures: releases + f64::from(k % 3) - 1.0, releases, bounces, temperature }
        };
        (0..30).map(block).collect()
    }

    #[test]
    fn blocks_obeying_the_law_have_small_errors() {
        let compared = law(&lawful(), 3000.0);
        // The errors exclude the linear dependence of the law on temperature. The curvature, about (2e-3)^2, remains.
        assert!(compared[0].standard_error.unwrap() < 1e-5, "{compared:?}");
        assert!(compared[0].difference().unwrap().abs() < 1e-5, "{compared:?}");
        assert!(compared.iter().all(|comparison| comparison.verdict().is_pass()), "{compared:?}");
    }

    #[test]
    fn one_percent_too_many_bounces_or_captures_fails() {
        let mut blocks = lawful();
        blocks.iter_mut().for_each(|block| block.bounces *= 1.01);
        assert_eq!(law(&blocks, 3000.0)[0].verdict(), super::super::Verdict::Fail);
        let mut blocks = lawful();
        blocks.iter_mut().for_each(|block| block.captures *= 1.01);
        assert_eq!(law(&blocks, 3000.0)[1].verdict(), super::super::Verdict::Fail);
    }
}

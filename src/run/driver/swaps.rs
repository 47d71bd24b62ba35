//! Sets of swap moves at regular times.

use serde::{Deserialize, Serialize};

use super::Driver;
use crate::model::random::{Purpose, Random};
use crate::model::state_point::StatePoint;
use crate::model::{StageSwaps, Swap, SwapMoves};

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(in crate::run) struct Swaps {
    next: f64,
    random: Random,
    done: SwapMoves,
}

impl Driver<'_> {
    pub(super) fn begin_swaps(&mut self, swap: Option<Swap>, seed: u64, stream: usize) {
        self.state.swaps = swap.map(|swap| Swaps {
            next: self.simulation.time() + swap.interval,
            random: Random::new(StatePoint::new(seed).with(&[swap.interval]).number(), Purpose::Swap, stream),
            done: SwapMoves::default(),
        });
    }

    /// Simulated time of the next set of moves; infinite if there is none.
    pub(super) fn next_swap(&self) -> f64 {
        self.state.swaps.as_ref().map_or(f64::INFINITY, |swaps| swaps.next)
    }

    /// Makes a set of moves. The simulation has reached `time` within round-off.
    pub(super) fn swap(&mut self, time: f64) {
        let Some(swap) = self.settings().swap else { return };
        let Some(mut swaps) = self.state.swaps.take() else { return };
        let moves = self.simulation.swap(&swap, &mut swaps.random);
        if moves.accepted > 0 {
            // Volume moves and instruments know the species of each particle.
            self.scaling = None;
            if let Some(system) = &mut self.system {
                system.take_species(&self.simulation);
            }
        }
        swaps.done.add(&moves);
        swaps.next = self.next_multiple(swap.interval, time);
        self.state.swaps = Some(swaps);
    }

    /// Keeps the statistics of a stage that ends.
    pub(super) fn note_swaps(&mut self) {
        if let Some(swaps) = self.state.swaps.take().filter(|swaps| swaps.done.attempted > 0) {
            let stage = self.state.stage.stage.name(&self.simulation.scene().run).into_owned();
            self.state.stage_swaps.push(StageSwaps { stage, moves: swaps.done });
        }
    }
}

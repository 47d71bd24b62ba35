//! Histograms of the potential energy of several ensembles, in blocks of time.

use super::density_of_states::{DensityOfStates, MultiHistogram};
use super::ensemble::Ensemble;

const MOST_LEVELS: usize = 4096;

/// Energies with a smaller relative difference are equal, except for round-off in sums.
const SAME: f64 = 1e-9;

const MOST_BLOCKS: u64 = 512;

/// The energy levels of a run. A first pass finds the levels; a second pass fills [`EnergyHistograms`].
///
/// With stepped potentials, each energy is a level. More than 4096 different energies are counted in equal bins.
#[derive(Debug, Clone, Default)]
pub struct EnergyLevels {
    /// Energies in ascending order, or lower edges of the bins.
    levels: Vec<f64>,
    are_bins: bool,
    ends: Option<[f64; 2]>,
    rows: u64,
}

impl EnergyLevels {
    /// Creates bins with lower edges in ascending order. Energies below the first edge are in the first bin.
    #[must_use]
    pub fn of_bins(lower_edges: &[f64]) -> Self {
        Self { levels: lower_edges.to_vec(), are_bins: true, ..Self::default() }
    }

    /// Registers the energies of all ensembles at one time `[energy]`.
    pub fn see(&mut self, energies: &[f64]) {
        self.rows += 1;
        for energy in energies.iter().copied().filter(|energy| energy.is_finite()) {
            let [least, most] = self.ends.unwrap_or([energy, energy]);
            self.ends = Some([least.min(energy), most.max(energy)]);
            if !self.are_bins
                && self.levels.len() <= MOST_LEVELS
                && let Err(place) = self.find(energy)
            {
                self.levels.insert(place, energy);
            }
        }
    }

    /// Returns the level of an energy, or the position for a new level.
    fn find(&self, energy: f64) -> Result<usize, usize> {
        let tolerance = SAME * energy.abs();
        let place = self.levels.partition_point(|level| *level < energy - tolerance);
        let is_it = self.levels.get(place).is_some_and(|level| *level <= energy + tolerance);
        if is_it { Ok(place) } else { Err(place) }
    }

    fn closed(mut self) -> Self {
        if let Some([least, most]) = self.ends.filter(|_| !self.are_bins && self.levels.len() > MOST_LEVELS) {
            let width = (most - least) / MOST_LEVELS as f64;
            self.levels = (0..MOST_LEVELS).map(|bin| least + bin as f64 * width).collect();
            self.are_bins = true;
        }
        self
    }

    fn place(&self, energy: f64) -> usize {
        match self.are_bins {
            true => self.levels.partition_point(|edge| *edge <= energy).saturating_sub(1),
            false => self.find(energy).unwrap_or_else(|place| place.min(self.levels.len() - 1)),
        }
    }
}

#[derive(Debug, Clone)]
struct Block {
    rows: u64,
    counts: Vec<u32>,
    sums: Vec<f64>,
    /// For each additional quantity, the sum over the samples in each level.
    others: Vec<Vec<f64>>,
}

/// Sums over the samples in a level: number, deviation of the energy from a reference, and squared deviation.
#[derive(Debug, Clone, Copy, Default)]
struct Spread {
    count: f64,
    sum: f64,
    squares: f64,
}

/// Histograms of the potential energy of several ensembles, in blocks of time. All ensembles are sampled at the same
/// times. The levels are the [`EnergyLevels`] of a first pass.
#[derive(Debug, Clone)]
pub struct EnergyHistograms {
    ensembles: Vec<Ensemble>,
    levels: EnergyLevels,
    rows_per_block: u64,
    blocks: Vec<Block>,
    spreads: Vec<Spread>,
    others: usize,
}

#[derive(Debug, Clone)]
pub(super) struct Counts {
    pub rows: f64,
    pub levels: Vec<f64>,
    pub others: Vec<Vec<f64>>,
}

impl EnergyHistograms {
    /// Creates empty histograms with known levels. `others` is the number of quantities measured besides the energy.
    #[must_use]
    pub fn new(ensembles: Vec<Ensemble>, levels: EnergyLevels, others: usize) -> Self {
        let levels = levels.closed();
        Self {
            ensembles,
            rows_per_block: levels.rows.div_ceil(MOST_BLOCKS).max(1),
            blocks: Vec::new(),
            spreads: vec![Spread::default(); levels.levels.len()],
            levels,
            others,
        }
    }

    /// Adds the energies of all ensembles at one time. `others` contains the additional quantities, one ensemble after
    /// the other. If a value is not finite, no values are added.
    pub fn add(&mut self, energies: &[f64], others: &[f64]) {
        let count = self.ensembles.len();
        let is_whole = energies.len() == count
            && others.len() == self.others * count
            && energies.iter().chain(others).all(|number| number.is_finite());
        if self.levels.levels.is_empty() || !is_whole {
            return;
        }
        if self.blocks.last().is_none_or(|block| block.rows == self.rows_per_block) {
            let levels = self.spreads.len();
            let others = vec![vec![0.0; levels]; self.others];
            self.blocks.push(Block { rows: 0, counts: vec![0; levels], sums: vec![0.0; count], others });
        }
        let Some(block) = self.blocks.last_mut() else { return };
        block.rows += 1;
        for (at, (energy, sum)) in energies.iter().zip(&mut block.sums).enumerate() {
            let place = self.levels.place(*energy);
            for (own, value) in block.others.iter_mut().zip(&others[at * self.others..]) {
                own[place] += value;
            }
            block.counts[place] += 1;
            *sum += energy;
            let (spread, deviation) = (&mut self.spreads[place], energy - self.levels.levels[place]);
            spread.count += 1.0;
            spread.sum += deviation;
            spread.squares += deviation * deviation;
        }
    }

    /// The ensembles.
    #[must_use]
    pub fn ensembles(&self) -> &[Ensemble] {
        &self.ensembles
    }

    /// Number of levels or bins.
    #[must_use]
    pub fn levels(&self) -> usize {
        self.spreads.len()
    }

    /// Returns true if there are no samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    /// The density of states from all ensembles. `None` if there are no samples or the ensembles share no energies.
    #[must_use]
    pub fn density_of_states(&self) -> Option<DensityOfStates> {
        if self.is_empty() {
            return None;
        }
        let start = MultiHistogram::start(&self.ensembles, &self.means());
        self.counts(0..self.blocks()).solve(&self.ensembles, &self.energies().0, &start)
    }

    pub(super) fn blocks(&self) -> usize {
        self.blocks.len()
    }

    pub(super) fn series(&self, place: usize) -> Vec<f64> {
        self.blocks.iter().map(|block| block.sums[place] / block.rows as f64).collect()
    }

    pub(super) fn means(&self) -> Vec<f64> {
        let rows: u64 = self.blocks.iter().map(|block| block.rows).sum();
        let sum = |place| self.blocks.iter().map(|block| block.sums[place]).sum::<f64>();
        (0..self.ensembles.len()).map(|place| sum(place) / rows as f64).collect()
    }

    pub(super) fn counts(&self, blocks: std::ops::Range<usize>) -> Counts {
        let mut all = Counts {
            rows: 0.0,
            levels: vec![0.0; self.spreads.len()],
            others: vec![vec![0.0; self.spreads.len()]; self.others],
        };
        for block in &self.blocks[blocks] {
            all.rows += block.rows as f64;
            all.levels.iter_mut().zip(&block.counts).for_each(|(sum, count)| *sum += f64::from(*count));
            add_each(&mut all.others, &block.others);
        }
        all
    }

    /// Mean and variance of the energy in each level.
    pub(super) fn energies(&self) -> (Vec<f64>, Vec<f64>) {
        let of_level = |(level, spread): (&f64, &Spread)| {
            let count = spread.count.max(1.0);
            let mean = spread.sum / count;
            (level + mean, (spread.squares / count - mean * mean).max(0.0))
        };
        self.levels.levels.iter().zip(&self.spreads).map(of_level).unzip()
    }
}

impl Counts {
    pub fn add(&mut self, other: &Self) {
        self.rows += other.rows;
        self.levels.iter_mut().zip(&other.levels).for_each(|(sum, count)| *sum += count);
        add_each(&mut self.others, &other.others);
    }

    /// Means of the additional quantities in each level; 0 in levels without samples.
    pub fn means(&self) -> Vec<Vec<f64>> {
        let mean = |(sum, count): (&f64, &f64)| if *count > 0.0 { sum / count } else { 0.0 };
        self.others.iter().map(|sums| sums.iter().zip(&self.levels).map(mean).collect()).collect()
    }

    pub fn solve(&self, ensembles: &[Ensemble], energies: &[f64], start: &[f64]) -> Option<DensityOfStates> {
        let samples = vec![self.rows; ensembles.len()];
        MultiHistogram { ensembles, samples: &samples, energies, counts: &self.levels }.solve(start)
    }
}

fn add_each(sums: &mut [Vec<f64>], more: &[Vec<f64>]) {
    for (sums, more) in sums.iter_mut().zip(more) {
        sums.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
    }
}

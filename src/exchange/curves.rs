//! Energy, heat capacity and entropy as functions of the temperature.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::execute::ExchangeRecorder;
use super::levels::{LevelDensity, populations};
use super::replicas::{Exchange, ExchangeRow};
use super::results::Population;
use crate::analysis::reweighting::{DensityOfStates, EnergyHistograms, EnergyLevels, Moments, Reweighting};
use crate::analysis::statistics::Estimate;
use crate::model::ExchangeEnsemble;
use crate::model::exchange_plan::ends;
use std::convert::Infallible;

/// Approximate number of temperatures of a curve. Each interval between two simulated temperatures is divided into
/// equally many parts, with a constant ratio of successive temperatures.
const POINTS: usize = 120;

/// Names of the quantities that are relative to their values at the highest temperature.
const RELATIVE: [&str; 2] = ["entropy_per_particle", "reduced_free_energy_per_particle"];

const HALVINGS: u32 = 30;

/// Thermal quantities at one temperature, in the canonical ensemble. Averages are per moving particle.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct ThermalPoint {
    /// The temperature `T` `[energy]`.
    pub temperature: f64,
    /// Mean potential energy per particle, `<U> / N` `[energy]`.
    pub potential_energy_per_particle: Estimate,
    /// Heat capacity at constant volume in units of k_B, `D / 2 + <(U - <U>)^2> / (N T^2)`. The first term is kinetic.
    pub heat_capacity_per_particle: Estimate,
    /// Entropy in units of k_B, relative to its value at the highest temperature. It includes the kinetic part.
    pub entropy_per_particle: Estimate,
    /// Free energy divided by the temperature, `A / (N T)` with `A = E - T S`, relative to its value at the highest
    /// temperature. It includes the kinetic part.
    pub reduced_free_energy_per_particle: Estimate,
    /// Means of the quantities of [`Exchange::measured_names`], by name.
    pub others: BTreeMap<String, Estimate>,
}

/// A maximum of the heat capacity strictly between the lowest and the highest temperature.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct HeatCapacityPeak {
    /// Temperature of the maximum `[energy]`.
    pub temperature: Estimate,
    /// Heat capacity per particle at the maximum, in units of k_B.
    pub heat_capacity_per_particle: Estimate,
}

/// Thermal quantities as functions of the temperature. They are computed from the potential energies at all
/// temperatures with [`DensityOfStates`]. [`Reweighting`] determines the errors.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct ThermalCurves {
    /// Points at ascending temperatures, including all simulated temperatures. Empty if all energies are equal, or if
    /// the energies at different temperatures do not overlap sufficiently. Also empty for an exchange between windows.
    pub points: Vec<ThermalPoint>,
    /// The highest maximum of the heat capacity that is not at an end of the curve.
    pub peak: Option<HeatCapacityPeak>,
    /// True if some temperatures share too few energies with the other temperatures. Then there are no curves.
    pub is_torn: bool,
    /// The density of states of all visited levels, by ascending energy.
    pub density_of_states: Vec<LevelDensity>,
    /// Populations of the levels at each temperature of a multicanonical exchange, otherwise empty.
    pub populations: Vec<Vec<Population>>,
}

/// Potential energies of an exchange, kept in memory. Use this recorder for exchanges without a folder.
///
/// ```
/// # use carom::Vector;
/// # use carom::model::{ExchangeEnsemble, ExchangePlan, Potential, RunPlan, Space, Until};
/// # use carom::scene::{InteractionDraft, SceneBuilder, SpeciesDraft};
/// use carom::exchange::{Exchange, PotentialEnergies};
/// use std::ops::ControlFlow;
///
/// # let scene = SceneBuilder::new("pair")
/// #     .space(Space::periodic_cube(4.0))
/// #     .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
/// #     .interaction(InteractionDraft::new(Potential::square_well(1.0, 1.5, 1.0)?).between("A", "A"))
/// #     .particle("A", Vector::new(1.0, 1.0, 1.0), Vector::zeros())
/// #     .particle("A", Vector::new(3.0, 3.0, 3.0), Vector::zeros())
/// #     .exchange(ExchangePlan { temperatures: vec![0.4, 0.6, 1.0], interval: 2.0, rate: 1.0, ensemble: ExchangeEnsemble::Canonical, umbrella: None })
/// #     .run(RunPlan { equilibration: Until::time(20.0), limit: Until::time(4000.0), ..RunPlan::default() })
/// #     .build()?;
/// let mut energies = PotentialEnergies::default();
/// let exchange = Exchange::new(scene)?.execute(2, &mut energies, &mut |_| ControlFlow::Continue(()))?;
/// let curves = energies.curves(&exchange);
/// assert_eq!(curves.points[0].temperature, 0.4);
/// let bound = -2.0 * curves.points[0].potential_energy_per_particle.mean;
/// assert!((bound - 0.709).abs() < 0.1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct PotentialEnergies {
    rows: Vec<Vec<f64>>,
    others: Vec<Vec<f64>>,
}

impl ExchangeRecorder for PotentialEnergies {
    type Error = Infallible;

    fn row(&mut self, row: &ExchangeRow<'_>) -> Result<(), Infallible> {
        self.rows.push(row.potential.to_vec());
        self.others.push(row.measured.to_vec());
        Ok(())
    }
}

impl PotentialEnergies {
    /// Potential energies at all temperatures, for each recorded attempt `[energy]`.
    #[must_use]
    pub fn rows(&self) -> &[Vec<f64>] {
        &self.rows
    }

    /// Computes the thermal curves from the recorded energies.
    #[must_use]
    pub fn curves(&self, exchange: &Exchange) -> ThermalCurves {
        let visit = |see: &mut dyn FnMut(&[f64], &[f64])| {
            self.rows.iter().zip(&self.others).for_each(|(row, others)| see(row, others));
            Ok::<(), Infallible>(())
        };
        ThermalCurves::of(exchange, visit).unwrap_or_else(|none| match none {})
    }
}

struct System<'n> {
    particles: f64,
    dimensions: f64,
    highest: f64,
    names: &'n [&'static str],
}

impl System<'_> {
    fn heat_capacity(&self, temperature: f64, moments: &Moments) -> f64 {
        0.5 * self.dimensions + moments.variance / (self.particles * temperature * temperature)
    }

    fn quantities(&self, temperature: f64, density: &DensityOfStates, highest: &Moments) -> Vec<f64> {
        let here = &density.at(temperature);
        let of_velocities = 0.5 * self.dimensions * libm::log(temperature / self.highest);
        let log_ratio = (here.log_partition - highest.log_partition) / self.particles + of_velocities;
        let energies = (here.mean / temperature - highest.mean / self.highest) / self.particles;
        let energy = here.mean / self.particles;
        let mut all = vec![energy, self.heat_capacity(temperature, here), log_ratio + energies, -log_ratio];
        if !self.names.is_empty() {
            all.extend(density.means_at(temperature));
        }
        all
    }

    /// Finds the maximum of the heat capacity near `grid[place]` by golden-section search. The temperatures in `grid`
    /// ascend. Returns the temperature and the value of the maximum.
    fn peak_near(&self, density: &DensityOfStates, grid: &[f64], place: usize) -> [f64; 2] {
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        let height = |temperature: f64| self.heat_capacity(temperature, &density.at(temperature));
        let (mut from, mut to) = (grid[place.saturating_sub(1)], grid[(place + 1).min(grid.len() - 1)]);
        let inner = |from: f64, to: f64| [to - GOLDEN * (to - from), from + GOLDEN * (to - from)];
        let mut inside = inner(from, to);
        let mut heights = inside.map(height);
        for _ in 0..HALVINGS {
            if heights[0] >= heights[1] {
                to = inside[1];
                inside = [inner(from, to)[0], inside[0]];
                heights = [height(inside[0]), heights[0]];
            } else {
                from = inside[0];
                inside = [inside[1], inner(from, to)[1]];
                heights = [heights[1], height(inside[1])];
            }
        }
        [0.5 * (from + to), height(0.5 * (from + to))]
    }
}

impl ThermalCurves {
    /// Computes the curves. `visit` goes through the energies and other quantities of all attempts. It is called twice:
    /// to find the energy levels, and to fill the histograms.
    pub(super) fn of<E>(
        exchange: &Exchange,
        mut visit: impl FnMut(&mut dyn FnMut(&[f64], &[f64])) -> Result<(), E>,
    ) -> Result<Self, E> {
        if exchange.plan().umbrella.is_some() {
            return Ok(Self::default());
        }
        let mut levels = EnergyLevels::default();
        visit(&mut |row, _| levels.see(row))?;
        let names = exchange.measured_names();
        let mut histograms = EnergyHistograms::new(exchange.ensembles(), levels, names.len());
        visit(&mut |row, others| histograms.add(row, others))?;
        let [particles, dimensions] = exchange.size();
        let [_, highest] = ends(exchange.temperatures());
        let system = System { particles, dimensions, highest, names: &names };
        Ok(Self::made(&histograms, exchange, &system))
    }

    fn made(histograms: &EnergyHistograms, exchange: &Exchange, system: &System<'_>) -> Self {
        // With a single energy level, as for hard bodies, nothing depends on the temperature.
        if histograms.levels() < 2 {
            return Self::default();
        }
        let Some(reweighting) = Reweighting::new(histograms, exchange.scene().seed()) else {
            return Self { is_torn: true, ..Self::default() };
        };
        let temperatures = exchange.temperatures();
        let (points, peak) = curve(&reweighting, &grid(temperatures), system);
        let populations = match exchange.plan().ensemble {
            ExchangeEnsemble::Multicanonical => populations(&reweighting, temperatures),
            _ => Vec::new(),
        };
        let density_of_states = LevelDensity::all(&reweighting, system.highest);
        Self { points, peak, is_torn: false, density_of_states, populations }
    }
}

fn curve(
    reweighting: &Reweighting,
    grid: &[f64],
    system: &System<'_>,
) -> (Vec<ThermalPoint>, Option<HeatCapacityPeak>) {
    let heat_capacities = |density: &DensityOfStates| -> Vec<f64> {
        grid.iter().map(|temperature| system.heat_capacity(*temperature, &density.at(*temperature))).collect()
    };
    let each = 4 + system.names.len();
    let has_peak = (1..grid.len().max(1) - 1).contains(&highest(&heat_capacities(reweighting.density())));
    let all = reweighting.estimates(|density| {
        let top = density.at(system.highest);
        let mut all: Vec<f64> = grid.iter().flat_map(|t| system.quantities(*t, density, &top)).collect();
        if has_peak {
            let heights: Vec<f64> = all.iter().skip(1).step_by(each).copied().collect();
            all.extend(system.peak_near(density, grid, highest(&heights)));
        }
        all
    });
    let (of_points, of_peak) = all.split_at(each * grid.len());
    let peak = match of_peak {
        [temperature, height] => {
            Some(HeatCapacityPeak { temperature: *temperature, heat_capacity_per_particle: *height })
        }
        _ => None,
    };
    let points = grid
        .iter()
        .zip(of_points.chunks_exact(each))
        .map(|(temperature, it)| ThermalPoint::new(*temperature, it, system.names));
    (points.collect(), peak)
}

impl ThermalPoint {
    pub(super) fn new(temperature: f64, of: &[Estimate], names: &[&str]) -> Self {
        Self {
            temperature,
            potential_energy_per_particle: of[0],
            heat_capacity_per_particle: of[1],
            entropy_per_particle: of[2],
            reduced_free_energy_per_particle: of[3],
            others: names.iter().map(|name| (*name).to_owned()).zip(of[4..].iter().copied()).collect(),
        }
    }

    pub(super) fn means(&self) -> BTreeMap<String, Estimate> {
        let all = self.quantities().into_iter();
        let of = |(name, it): (&str, Estimate)| (name.to_owned(), it);
        all.filter(|(name, _)| !RELATIVE.contains(name)).map(of).collect()
    }

    /// Returns all quantities except the temperature, by name, in the order of the columns of `curves.csv`.
    #[must_use]
    pub fn quantities(&self) -> Vec<(&str, Estimate)> {
        let always = [
            ("potential_energy_per_particle", self.potential_energy_per_particle),
            ("heat_capacity_per_particle", self.heat_capacity_per_particle),
            ("entropy_per_particle", self.entropy_per_particle),
            ("reduced_free_energy_per_particle", self.reduced_free_energy_per_particle),
        ];
        always.into_iter().chain(self.others.iter().map(|(name, it)| (name.as_str(), *it))).collect()
    }
}

fn highest(numbers: &[f64]) -> usize {
    (1..numbers.len()).fold(0, |best, place| if numbers[place] > numbers[best] { place } else { best })
}

fn grid(temperatures: &[f64]) -> Vec<f64> {
    let mut ascending = temperatures.to_vec();
    ascending.sort_by(f64::total_cmp);
    let parts = POINTS.div_ceil(ascending.len().max(2) - 1);
    let between = |pair: &[f64]| {
        let (from, ratio) = (pair[0], pair[1] / pair[0]);
        (0..parts).map(move |part| if part == 0 { from } else { from * libm::pow(ratio, part as f64 / parts as f64) })
    };
    let inner: Vec<f64> = ascending.windows(2).flat_map(between).collect();
    inner.into_iter().chain(ascending.last().copied()).collect()
}

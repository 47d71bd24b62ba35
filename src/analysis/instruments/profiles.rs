//! Density, flow velocity and temperature on a grid.

use super::budgeted_times::budgeted_times;
use super::grid::Grid;
use super::instrument::{Instrument, Setup};
use super::quantity::{Curve, Measured, Normalisation};
use super::system::{Sample, SystemDescription};
use crate::Vector;
use crate::analysis::sampling_times::SamplingTimes;
use crate::analysis::statistics::{CurveAverage, Estimate};
use crate::base::numbers::id;
use crate::model::measurement_plan as plan;
use serde::{Deserialize, Serialize};

/// Quantities averaged in each cell: number, mass and momentum along three axes, then `m |v|^2` and the momentum along
/// x, both relative to the streaming velocity.
const ELEMENTS: usize = 7;

/// Time averages in the cells of a grid: number density, flow velocity and kinetic temperature.
///
/// With `N` particles in a cell of volume `V`, `M = <sum m>`, `P = <sum m v>` and `A = <sum m |v|^2>`, the density is
/// `<N> / V`, the velocity is `u = P / M`, and the temperature is `(A - P^2 / M) / f`. Errors follow from the errors of
/// the means and their correlations.
///
/// `f` is the number of free velocity components per sample, for `D` axes and `S` samples: `f = D (<N> - 1 / S) - c (M
/// / M_total) (1 - 1 / S)`. Along each axis, all samples have `S <N>` components, and the mean `u` removes one of them.
/// Each of the `c` conserved components of the total momentum removes the fraction `M / M_total` of a component from
/// each sample, because `<m v^2> = T (1 - m / M_total)`. The term `1 / S` avoids counting this fraction twice.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Profile {
    name: String,
    times: SamplingTimes,
    grid: Grid,
    /// The species that counts; `None` for all species.
    species: Option<u32>,
    samples: u64,
    curve: CurveAverage,
}

impl Profile {
    pub fn new(plan: &plan::Profile, setup: &Setup<'_>) -> Self {
        let system = setup.system;
        // An unknown species counts nothing. The reader of scenes rejects it.
        let named = |name: &String| system.species_names.iter().position(|other| other == name).map_or(u32::MAX, id);
        let species = plan.species.as_ref().map(named);
        let counts = |&&id: &&u32| species.is_none_or(|species| species == system.species[id as usize]);
        let count = system.moving.iter().filter(counts).count();
        let grid = Grid::new(plan.bins, plan.lower, plan.upper, &system.space);
        Self {
            name: plan.name.clone(),
            times: budgeted_times(setup, plan.interval, 10.0 * count as f64),
            curve: CurveAverage::new(grid.cells() * ELEMENTS),
            grid,
            species,
            samples: 0,
        }
    }
}

impl Instrument for Profile {
    fn next_sample(&self) -> f64 {
        self.times.next()
    }

    fn sample(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        if !self.times.is_due(sample.time) {
            return;
        }
        let mut values = vec![0.0; self.curve.len()];
        let states = sample.species.iter().zip(sample.positions).zip(sample.velocities).enumerate();
        for (index, ((species, position), velocity)) in states {
            let mass = system.mass_in(sample, index);
            if !(mass.is_finite() && self.species.is_none_or(|counted| counted == species.0)) {
                continue;
            }
            let Some(cell) = self.grid.cell_of(position, &system.space) else { continue };
            let momentum = mass * velocity;
            let streaming = system.streaming_velocity(position);
            let peculiar = velocity - streaming;
            let square = mass * peculiar.norm_squared();
            let parts = [1.0, mass, momentum.x, momentum.y, momentum.z, square, mass * streaming.x];
            let sums = &mut values[cell * ELEMENTS..(cell + 1) * ELEMENTS];
            sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part);
        }
        self.samples += 1;
        self.curve.add_all(values);
    }

    fn report(&self, system: &SystemDescription, measured: &mut Measured) {
        let dimensions = system.space.dimensions();
        let volume = self.grid.cell_volume(&system.space);
        let cells: Vec<Cell> = (0..self.grid.cells()).map(|cell| self.cell(cell, volume, system)).collect();
        let column = |value: &dyn Fn(&Cell) -> Option<Estimate>| cells.iter().map(value).collect::<Vec<_>>();
        let over = |sum: &str| Normalisation::of(sum).by("samples", "1", self.samples as f64);
        let particles = over("particles in the cell, over all samples");
        let density = particles.by("cell_volume", &format!("length^{dimensions}"), volume);
        let each = |number: fn(&Cell) -> f64| cells.iter().map(number).collect::<Vec<f64>>();
        let momentum = over("momentum of the particles in the cell, over all samples");
        let momentum = momentum.by_each("mean_mass", "mass", each(|cell| cell.mass));
        let square = over("m |v - u|^2 of the particles in the cell, over all samples");
        let square = square.by_each("degrees_of_freedom", "1", each(|cell| cell.degrees));
        let method = format!(
            "means over {} samples in each cell: number density <N> / V, velocity u = <sum m v> / <sum m>, temperature \
             <sum m |v - u|^2> over the number of free components of v - u in the cell{}",
            self.samples,
            if system.shear_rate == 0.0 {
                ""
            } else {
                ", with v and u in this sum relative to the mean flow at the position of the particle"
            }
        );
        let mut curve = Curve::new(&format!("profile_{}", self.name), &format!("Profile {}", self.name), &method);
        curve.variables = self.grid.variables();
        curve = curve
            .series("density", &format!("1 / length^{dimensions}"), &column(&|cell| cell.density))
            .normalised(density);
        for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
            curve = curve
                .series(&format!("velocity {axis}"), "length / time", &column(&|cell| cell.velocity[k]))
                .normalised(momentum.clone());
        }
        measured
            .curves
            .push(curve.series("temperature", "energy", &column(&|cell| cell.temperature)).normalised(square));
    }
}

#[derive(Debug, Clone, Copy, Default)]
struct Cell {
    /// Mean total mass of the particles in the cell, and the number of free velocity components per sample.
    mass: f64,
    degrees: f64,
    density: Option<Estimate>,
    velocity: [Option<Estimate>; 3],
    temperature: Option<Estimate>,
}

impl Profile {
    fn cell(&self, cell: usize, volume: f64, system: &SystemDescription) -> Cell {
        let dimensions = system.space.dimensions() as f64;
        let conserved = system.conserved_axes.iter().filter(|is_conserved| **is_conserved).count() as f64;
        let first = cell * ELEMENTS;
        let mean = |element: usize| self.curve.mean(first + element);
        let (Some(number), Some(mass)) = (mean(0), mean(1)) else { return Cell::default() };
        if number <= 0.0 {
            return Cell { density: Some(Estimate { mean: 0.0, standard_error: None }), ..Cell::default() };
        }
        let flow = Vector::from_fn(|k, _| mean(2 + k).unwrap_or(0.0) / mass);
        // The mean velocity relative to the streaming velocity is not thermal motion.
        let common = flow - Vector::new(mean(6).unwrap_or(0.0) / mass, 0.0, 0.0);
        let error = |terms: &[(usize, f64)]| self.curve.combination(terms).and_then(|sum| sum.standard_error);
        let velocity = |k: usize| Estimate {
            mean: flow[k],
            standard_error: error(&[(first + 2 + k, 1.0 / mass), (first + 1, -flow[k] / mass)]),
        };
        let samples = self.samples as f64;
        let shared = if conserved > 0.0 { conserved * mass / system.moving_mass() } else { 0.0 };
        let degrees = dimensions * (number - 1.0 / samples) - shared * (1.0 - 1.0 / samples);
        let temperature = mean(5).and_then(|square| {
            // Round-off may make this difference slightly negative if all velocities are equal.
            let fluctuation = (square - mass * common.norm_squared()).max(0.0);
            let temperature = fluctuation / degrees;
            // The derivatives of T = (A - P^2 / M) / f, where f is proportional to the particle number N.
            let part = 1.0 / degrees;
            let terms = [
                (first + 5, part),
                (first + 2, -2.0 * common.x * part),
                (first + 3, -2.0 * common.y * part),
                (first + 4, -2.0 * common.z * part),
                (first + 6, 2.0 * common.x * part),
                (first + 1, common.norm_squared() * part),
                (first, -temperature / number),
            ];
            // The temperature needs at least two velocities and a positive number of free components.
            (number * samples > 1.5 && degrees > 0.5 / samples)
                .then(|| Estimate { mean: temperature, standard_error: error(&terms) })
        });
        Cell {
            mass,
            degrees,
            density: self.curve.combination(&[(first, 1.0 / volume)]),
            velocity: std::array::from_fn(|k| Some(velocity(k))),
            temperature,
        }
    }
}

#[cfg(test)]
mod tests;

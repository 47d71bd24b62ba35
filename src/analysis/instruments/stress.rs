//! Stress and dissipated power on a grid.

use super::budgeted_times::budgeted_times;
use super::grid::Grid;
use super::instrument::{Instrument, Setup};
use super::momentum_flow::COMPONENTS;
use super::quantity::{Curve, Measured};
use super::system::{Sample, SystemDescription};
use crate::Vector;
use crate::analysis::sampling_times::SamplingTimes;
use crate::analysis::statistics::{CurveAverage, Estimate};
use crate::engine::event::{Event, EventKind};
use crate::model::measurement_plan as plan;
use crate::model::space::AXES;
use serde::{Deserialize, Serialize};

/// Sums over the particles in a cell: number, mass, momentum, and `m v_a v_b`. Velocities are relative to the streaming
/// velocity of a sheared box.
const NUMBER: usize = 0;
const MASS: usize = 1;
const MOMENTUM: usize = 2;
const FLUX: usize = 5;
/// Sums over the collisions in a cell, per time: `r_a J_b` by rows, and the dissipated energy.
const COLLISIONS: usize = 11;
const DISSIPATED: usize = 20;
const ELEMENTS: usize = 21;
const OF_COLLISIONS: usize = ELEMENTS - COLLISIONS;

/// Time averages of the stress and of the dissipated power in the cells of a grid.
///
/// In a cell of volume `V`, the stress is `(<sum m w_a w_b> + sum f r_a J_b / t) / V`, positive in compression. `w` is
/// the velocity of a particle relative to the mean velocity of the cell, and `J` is the impulse of a collision. `r` is the
/// line from the partner to the particle, or from the point of contact with a surface. `f` is the part of this line that
/// lies in the cell. With this rule of Irving and Kirkwood, the stress balances the forces on each layer of cells.
///
/// The component `ab` is the force along `b` on an area that is normal to `a`. Smooth contacts have a symmetric stress.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Stress {
    name: String,
    times: SamplingTimes,
    grid: Grid,
    samples: u64,
    /// Length of an interval with the weight 1 `[time]`.
    unit: f64,
    curve: CurveAverage,
    /// Sums over collisions since this time, [`OF_COLLISIONS`] for each cell.
    since: f64,
    collisions: Vec<f64>,
}

impl Stress {
    pub fn new(plan: &plan::Stress, setup: &Setup<'_>) -> Self {
        let grid = Grid::new(plan.bins, plan.lower, plan.upper, &setup.system.space);
        let times = budgeted_times(setup, plan.interval, 20.0 * setup.system.moving.len() as f64);
        Self {
            name: plan.name.clone(),
            unit: times.interval(),
            times,
            samples: 0,
            curve: CurveAverage::new(grid.cells() * ELEMENTS),
            since: setup.sample.time,
            collisions: vec![0.0; grid.cells() * OF_COLLISIONS],
            grid,
        }
    }

    fn close_interval(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        let duration = sample.time - self.since;
        if duration <= 0.0 {
            return;
        }
        let mut values = vec![0.0; self.curve.len()];
        self.add_particles(sample, system, &mut values);
        for (cell, sums) in self.collisions.chunks_exact_mut(OF_COLLISIONS).enumerate() {
            let rates = &mut values[cell * ELEMENTS + COLLISIONS..(cell + 1) * ELEMENTS];
            rates.iter_mut().zip(sums).for_each(|(rate, sum)| *rate = std::mem::take(sum) / duration);
        }
        self.since = sample.time;
        self.samples += 1;
        self.curve.add_weighted(values, duration / self.unit);
    }

    fn add_particles(&self, sample: &Sample<'_>, system: &SystemDescription, values: &mut [f64]) {
        for (index, (position, velocity)) in sample.positions.iter().zip(sample.velocities).enumerate() {
            let mass = system.mass_in(sample, index);
            if !mass.is_finite() {
                continue;
            }
            let Some(cell) = self.grid.cell_of(position, &system.space) else { continue };
            let velocity = velocity - system.streaming_velocity(position);
            let sums = &mut values[cell * ELEMENTS..(cell + 1) * ELEMENTS];
            sums[NUMBER] += 1.0;
            sums[MASS] += mass;
            for axis in 0..3 {
                sums[MOMENTUM + axis] += mass * velocity[axis];
            }
            for (sum, [a, b]) in sums[FLUX..COLLISIONS].iter_mut().zip(COMPONENTS) {
                *sum += mass * velocity[a] * velocity[b];
            }
        }
    }
}

impl Instrument for Stress {
    fn next_sample(&self) -> f64 {
        self.times.next()
    }

    fn sample(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        if self.times.is_due(sample.time) {
            self.close_interval(sample, system);
        }
    }

    /// Adds the collisions since the latest sample.
    fn end(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        self.close_interval(sample, system);
    }

    fn has_events(&self) -> bool {
        true
    }

    fn event(&mut self, event: &Event, system: &SystemDescription) {
        if !matches!(event.kind, EventKind::Pair(_) | EventKind::Surface) {
            return;
        }
        let line = event.normal * event.distance;
        let place = event.positions[0];
        let flux: [f64; 9] = std::array::from_fn(|k| line[k / 3] * event.impulse[k % 3]);
        let Self { grid, collisions, .. } = self;
        grid.for_each_piece(&place, &-line, &system.space, |cell, fraction| {
            let sums = &mut collisions[cell * OF_COLLISIONS..];
            sums.iter_mut().zip(flux).for_each(|(sum, flux)| *sum += fraction * flux);
        });
        // A contact counts in the middle of its line, because the point of contact with a wall is at the edge of the box.
        if event.dissipated != 0.0
            && let Some(cell) = grid.cell_of(&(place - line * 0.5), &system.space)
        {
            collisions[cell * OF_COLLISIONS + DISSIPATED - COLLISIONS] += event.dissipated;
        }
    }

    fn report(&self, system: &SystemDescription, measured: &mut Measured) {
        let volume = self.grid.cell_volume(&system.space);
        let axes: Vec<usize> = system.axes().collect();
        let cells: Vec<Cell> = (0..self.grid.cells()).map(|cell| self.cell(cell, system)).collect();
        let column = |terms: &dyn Fn(&Cell) -> Option<Terms>| {
            let of = |cell: &Cell| Some(self.curve.combination(&terms(cell)?)?.over(volume));
            cells.iter().map(of).collect::<Vec<Option<Estimate>>>()
        };
        let method = format!(
            "means over {} intervals: stress (<sum m w_a w_b> + sum f r_a J_b / t) / V, positive in compression, the force \
             along b on an area normal to a; w: velocity relative to the mean velocity of the cell; f: part of the line r \
             in the cell",
            self.samples
        );
        let mut curve = Curve::new(&format!("stress_{}", self.name), &format!("Stress {}", self.name), &method);
        curve.variables = self.grid.variables();
        for &a in &axes {
            for &b in &axes {
                let stress = column(&|cell| cell.stress([a, b]));
                curve = curve.series(&format!("stress {}{}", AXES[a], AXES[b]), "energy / length^D", &stress);
            }
        }
        let per_axis = 1.0 / axes.len() as f64;
        let kinetic = column(&|cell| {
            let mut terms = Vec::new();
            for &axis in &axes {
                terms.extend(cell.kinetic([axis; 2])?.into_iter().map(|(element, part)| (element, part * per_axis)));
            }
            Some(terms)
        });
        curve = curve.series("kinetic pressure", "energy / length^D", &kinetic);
        let dissipated = column(&|cell| Some(vec![(cell.first + DISSIPATED, 1.0)]));
        measured.curves.push(curve.series("dissipated power", "energy / length^D / time", &dissipated));
    }
}

/// Averaged elements and their coefficients.
type Terms = Vec<(usize, f64)>;

/// Means in a cell, from which the coefficients of the averaged elements follow.
struct Cell {
    first: usize,
    samples: f64,
    number: f64,
    /// Mean velocity of the cell.
    flow: Vector,
    /// Axes with conserved momentum, and the factor for them.
    is_conserved: [bool; 3],
    freed: f64,
}

impl Stress {
    fn cell(&self, cell: usize, system: &SystemDescription) -> Cell {
        let first = cell * ELEMENTS;
        let mean = |element: usize| self.curve.mean(first + element).unwrap_or(0.0);
        let (number, mass) = (mean(NUMBER), mean(MASS));
        let flow = Vector::from_fn(|k, _| if mass > 0.0 { mean(MOMENTUM + k) / mass } else { 0.0 });
        let moving = system.moving.len() as f64;
        let freed = if moving > 1.0 { moving / (moving - 1.0) } else { 1.0 };
        Cell { first, samples: self.samples as f64, number, flow, is_conserved: system.conserved_axes, freed }
    }
}

impl Cell {
    /// Terms of the kinetic part `<sum m v_a v_b> - P_a P_b / M`, times the volume. Returns `None` if there are
    /// too few velocities.
    ///
    /// Two factors correct for velocity components that are not free. The first factor is `1 / (1 - 1 / n)` for `n`
    /// velocities, because the mean velocity of the cell is computed from the same velocities. If the total momentum is
    /// conserved, the second factor is `N / (N - 1)` for all `N` moving particles, as in the pressure tensor.
    fn kinetic(&self, [a, b]: [usize; 2]) -> Option<Terms> {
        let component = COMPONENTS.iter().position(|of| *of == [a.min(b), a.max(b)])?;
        if self.number <= 0.0 {
            return Some(vec![(self.first + FLUX + component, 1.0)]);
        }
        let velocities = self.number * self.samples;
        if velocities < 1.5 {
            return None;
        }
        let conserved = if self.is_conserved[a] || self.is_conserved[b] { self.freed } else { 1.0 };
        let factor = conserved / (1.0 - 1.0 / velocities);
        let terms = [
            (FLUX + component, 1.0),
            (MOMENTUM + a, -self.flow[b]),
            (MOMENTUM + b, -self.flow[a]),
            (MASS, self.flow[a] * self.flow[b]),
        ];
        Some(terms.map(|(element, part)| (self.first + element, part * factor)).to_vec())
    }

    fn stress(&self, [a, b]: [usize; 2]) -> Option<Terms> {
        let mut terms = self.kinetic([a, b])?;
        terms.push((self.first + COLLISIONS + 3 * a + b, 1.0));
        Some(terms)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::instruments::test_system::{instrument, measure, report, unlike_spheres};

    #[test]
    fn the_kinetic_pressure_of_individual_diameters_follows_from_the_energy() {
        let (system, mut simulation) = unlike_spheres(40);
        let plan = plan::Stress { name: "s".into(), bins: [1; 3], lower: None, upper: None, interval: Some(0.5) };
        let mut stress = instrument(&simulation, &system, 5.0, |setup| Stress::new(&plan, setup));
        measure(&mut simulation, &system, &mut stress, 5.0);
        let measured = report(&stress, &system);
        let kinetic = measured.curves[0].series.iter().find(|series| series.name == "kinetic pressure").unwrap();
        let found = kinetic.values[0].unwrap();
        // The momentum is conserved, and the mean velocity is computed from ten samples of 40 velocities.
        let correction = 40.0 / 39.0 / (1.0 - 1.0 / 400.0);
        let expected = 2.0 / 3.0 * simulation.energy().kinetic / system.space.volume() * correction;
        assert!((found / expected - 1.0).abs() < 1e-10, "{found} {expected}");
    }
}

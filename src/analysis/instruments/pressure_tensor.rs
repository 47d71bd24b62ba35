use serde::{Deserialize, Serialize};

use super::block_times::{EARLY, block_times};
use super::instrument::{Instrument, Setup};
use super::momentum_flow::{COMPONENTS, MomentumFlow, Tensor};
use super::quantity::{Measured, Number};
use super::system::{Sample, SystemDescription};
use crate::analysis::sampling_times::SamplingTimes;
use crate::analysis::statistics::{BlockAverage, Estimate};
use crate::engine::event::{Event, EventKind};
use crate::model::ParticleId;
use crate::model::measurement_plan::PressureTensor as Plan;

const BLOCKS: u32 = 1000;

const RATES: [&str; 5] = ["core", "capture", "release", "bounce", "wall"];

/// Measures the pressure tensor and the rates of events.
///
/// `P_ab V = <sum m v_a v_b> N / (N - 1) + (1/t) sum r_a J_b`. If momentum along `a` or `b` is conserved, velocities
/// are relative to the centre of mass; otherwise the factor `N / (N - 1)` is absent. Walls keep centres a radius away,
/// so between walls each species has its own volume `V_i`. The kinetic part is then `<sum m v_a v_b / V_i>` times the
/// factor [`freed`]. Along an axis between walls, the collisional part is the sum of `r_a J_b / V_i` over the
/// particles, where `r_a` is measured from the middle of the box. The trace is `D (N T + W / (D t))`, derived at
/// [`Observer`](crate::analysis::observables::Observer). `Z` is the mean trace divided by the mean of the kinetic part,
/// `D rho T`. The kinetic part is exact unless particles accelerate. It is then interpolated linearly between samples.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct PressureTensor {
    blocks: SamplingTimes,
    flow: MomentumFlow,
    block_start: f64,
    /// Number of moving particles in the events of each kind in [`RATES`], for this block and for the whole run.
    counts: [u64; 5],
    totals: [u64; 5],
    tensor: Vec<BlockAverage>,
    pressure: BlockAverage,
    ideal: BlockAverage,
    rates: Vec<BlockAverage>,
}

impl PressureTensor {
    pub fn new(plan: &Plan, setup: &Setup<'_>) -> Self {
        let start = setup.sample.time;
        let blocks = block_times(setup, plan.interval, BLOCKS);
        let average = BlockAverage::new(blocks.interval());
        Self {
            blocks,
            flow: MomentumFlow::new(&setup.sample, setup.system),
            block_start: start,
            counts: [0; 5],
            totals: [0; 5],
            tensor: vec![average.clone(); 6],
            pressure: average.clone(),
            ideal: average.clone(),
            rates: vec![average; 5],
        }
    }

    fn close_block(&mut self, duration: f64, system: &SystemDescription) {
        let moving = system.moving.len() as f64;
        let axes = system.pressed_axes();
        let scale = 1.0 / (system.space.volume() * duration);
        let mut kinetic = self.flow.kinetic;
        let factor = freed(system);
        for (flow, [a, b]) in kinetic.iter_mut().zip(COMPONENTS) {
            if system.conserved_axes[a] || system.conserved_axes[b] {
                *flow *= factor;
            }
        }
        let collisional = &self.flow.collisional;
        for (average, (kinetic, collisional)) in self.tensor.iter_mut().zip(kinetic.iter().zip(collisional)) {
            average.add(scale * (kinetic + collisional), duration);
        }
        let mean = |tensor: &Tensor| axes.iter().map(|&axis| tensor[axis]).sum::<f64>() / axes.len() as f64;
        self.pressure.add(scale * (mean(&kinetic) + mean(collisional)), duration);
        self.ideal.add(scale * mean(&kinetic), duration);
        for (k, average) in self.rates.iter_mut().enumerate() {
            average.add(self.counts[k] as f64 / (moving * duration), duration);
            self.totals[k] += self.counts[k];
        }
        self.counts = [0; 5];
        self.flow.restart();
    }
}

/// Factor of the kinetic part along axes with conserved momentum, for the missing motion of the centre of mass.
///
/// In the frame of the centre of mass, a velocity component has the mean square `T / m_i (1 - m_i / M)`, where `M` is
/// the total mass. Without conservation, it has `T / m_i`. With the crowding `c_i = V / V_i`, the sum of `c_i m_i
/// v_i^2` has the mean `T sum c_i (1 - m_i / M)` instead of `T sum c_i`. The factor is the ratio of these means. If all
/// particles have the same crowding, it is `N / (N - 1)` for any masses.
fn freed(system: &SystemDescription) -> f64 {
    let mass = system.moving_mass();
    let parts = system.moving.iter().map(|&id| (system.crowding_of(id), system.masses[id as usize] / mass));
    let (mut all, mut free, mut first, mut is_even) = (0.0, 0.0, None, true);
    for (crowding, part) in parts {
        all += crowding;
        free += crowding * (1.0 - part);
        is_even &= *first.get_or_insert(crowding) == crowding;
    }
    let moving = system.moving.len() as f64;
    match system.moving.len() {
        0 | 1 => 1.0,
        _ if is_even => moving / (moving - 1.0),
        _ => all / free,
    }
}

/// Whether a component of the pressure tensor is the time derivative of a bounded moment. The mean over a time `t` is
/// then the change of the moment divided by `t`.
///
/// This requires walls across `a` and no transfer of momentum along `b`, not even by these walls. No thermostat may
/// scale the velocities, and no particles exchange their species. Then `d/dt sum m r_a v_b / V_i = sum m v_a v_b / V_i + sum r_a J_b / V_i`.
fn is_moment([a, b]: [usize; 2], system: &SystemDescription) -> bool {
    let keeps = |walled: usize, other: usize| system.space.walls(walled) == 2 && system.conserved_axes[other];
    (keeps(a, b) || keeps(b, a)) && system.scaling_interval.is_none() && !system.has_swaps
}

impl Instrument for PressureTensor {
    fn next_sample(&self) -> f64 {
        self.blocks.next()
    }

    fn sample(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        self.flow.synchronise(sample, system);
        let duration = sample.time - self.block_start;
        if duration > 0.0 {
            self.close_block(duration, system);
            self.block_start = sample.time;
        }
        self.blocks.pass_early(sample.time, EARLY);
    }

    /// Closes the last block, which includes the events since the last sample.
    fn end(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        self.sample(sample, system);
    }

    fn has_events(&self) -> bool {
        true
    }

    fn scaled(&mut self, before: &Sample<'_>, after: &Sample<'_>, system: &SystemDescription) {
        self.flow.synchronise(before, system);
        self.flow.synchronise(after, system);
    }

    fn event(&mut self, event: &Event, system: &SystemDescription) {
        self.flow.event(event, system);
        let kind = match event.kind {
            // The variants of `Outcome` are in the order of `RATES`.
            EventKind::Pair(outcome) => outcome as usize,
            EventKind::Surface => 4,
            EventKind::Thermostat | EventKind::Entry | EventKind::Exit | EventKind::Rest | EventKind::Wake => return,
        };
        let moves = |id: &&ParticleId| system.masses[id.0 as usize].is_finite();
        self.counts[kind] += [Some(event.particle), event.partner()].iter().flatten().filter(moves).count() as u64;
    }

    fn report(&self, system: &SystemDescription, measured: &mut Measured) {
        let has_volume = system.has_volume();
        let inside = |average: &BlockAverage| average.estimate().filter(|_| has_volume);
        let component = |axes: [usize; 2], average: &BlockAverage| {
            if is_moment(axes, system) { average.estimate_of_ends().filter(|_| has_volume) } else { inside(average) }
        };
        let axes: Vec<usize> = system.axes().collect();
        let numbers = &mut measured.numbers;
        let unit = "energy / length^D";
        for ([a, b], average) in COMPONENTS.into_iter().zip(&self.tensor) {
            if axes.contains(&a) && axes.contains(&b) {
                let estimate = component([a, b], average);
                let [a, b] = [a, b].map(|axis| ["x", "y", "z"][axis]);
                let (name, title) = (format!("pressure_{a}{b}"), format!("Pressure tensor, {a}{b}"));
                numbers.push(Number::estimated(&name, &title, unit, estimate, TENSOR));
            }
        }
        numbers.push(Number::estimated("pressure", "Pressure", unit, inside(&self.pressure), TRACE));
        let compressibility = self.pressure.ratio(&self.ideal).filter(|_| has_volume && system.is_homogeneous);
        if system.shear_rate != 0.0 {
            let viscosity = inside(&self.tensor[3]).map(|stress| stress.over(-system.shear_rate));
            let title = "Shear viscosity, from the stress of the sheared box";
            numbers.push(Number::estimated("viscosity_in_shear", title, "energy time / length^D", viscosity, IN_SHEAR));
        }
        let title = "Compressibility factor";
        numbers.push(Number::estimated("compressibility_factor", title, "1", compressibility, COMPRESSIBILITY));
        for (k, (kind, average)) in RATES.into_iter().zip(&self.rates).enumerate() {
            if self.totals[k] > 0 || kind == "core" {
                let (name, title) = (format!("{kind}_rate"), format!("Rate of {kind} events per particle"));
                numbers.push(rate(&name, &title, average.estimate()));
            }
        }
    }
}

const IN_SHEAR: &str = "eta = - P_xy / (dv_x / dy), with peculiar velocities in the pressure tensor.";

fn rate(name: &str, title: &str, estimate: Option<Estimate>) -> Number {
    let method = "Rate of events of this kind per moving particle: n / (N t), where an event of two moving particles counts twice.";
    Number::estimated(name, title, "1 / time", estimate, method)
}

const TENSOR: &str = "P_ab V = <sum m v_a v_b> + (1/t) sum r_a J_b over all pair events, with the volume that centres can reach; where momentum is conserved the first sum is in \
    the frame of the centre of mass, with N / (N - 1), or between walls sum c_i / sum c_i (1 - m_i / M), where c_i is one over the volume of i; it is exact between events.";
const TRACE: &str =
    "Mean of the diagonal of the pressure tensor over all axes; in a box with walls, over the axes that have walls.";
const COMPRESSIBILITY: &str = "Z = p / (rho T): the mean pressure divided by the mean of its kinetic part.";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector;
    use crate::analysis::instruments::test_system::{
        Recorded, equilibrate, estimate, hard_spheres, instrument, measure, number, report, start,
    };
    use crate::analysis::observables::Observer;
    use crate::engine::Simulation;
    use crate::model::space::{Boundary, Space};
    use crate::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};

    fn tensor(simulation: &Simulation, system: &SystemDescription, duration: f64) -> PressureTensor {
        instrument(simulation, system, duration, |setup| PressureTensor::new(&Plan::default(), setup))
    }

    #[test]
    fn trace_of_pressure_tensor_equals_observed_pressure() {
        let (system, mut simulation) = hard_spheres(108, 0.3);
        equilibrate(&mut simulation, 20);
        let mut observer = Observer::new(simulation.scene());
        observer.row(&simulation);
        let mut instrument = tensor(&simulation, &system, 5.0);
        measure(&mut simulation, &system, &mut instrument, 5.0);
        let row = observer.row(&simulation);
        let measured = report(&instrument, &system);
        let pressure = number(&measured, "pressure").mean.unwrap();
        // Each of the 2700 events adds a few rounding errors.
        assert!((pressure / row.pressure.unwrap() - 1.0).abs() < 1e-12, "{pressure} {row:?}");
        let diagonal: f64 =
            ["xx", "yy", "zz"].map(|ab| number(&measured, &format!("pressure_{ab}")).mean.unwrap()).iter().sum();
        assert!((diagonal / 3.0 / pressure - 1.0).abs() < 1e-12);
        let (rate, z) = (number(&measured, "core_rate"), number(&measured, "compressibility_factor"));
        assert!((rate.mean.unwrap() / row.collision_rate.unwrap() - 1.0).abs() < 1e-12);
        let observed = observer.estimates().iter().find(|(name, _)| *name == "compressibility_factor").unwrap().1.mean;
        assert!((z.mean.unwrap() / observed - 1.0).abs() < 1e-12);
        assert!(measured.numbers.iter().all(|number| number.name != "wall_rate" && number.name != "capture_rate"));
    }

    #[test]
    fn a_fluid_has_its_published_pressure_in_all_directions_and_no_shear() {
        let (system, mut simulation) = hard_spheres(256, 0.3);
        equilibrate(&mut simulation, 50);
        let mut instrument = tensor(&simulation, &system, 20.0);
        measure(&mut simulation, &system, &mut instrument, 20.0);
        let measured = report(&instrument, &system);
        // The pressure of 256 spheres is 0.2 % lower than in an infinite system.
        let expected = crate::analysis::published::hard_spheres(0.3) * 0.572_957_8;
        for ab in ["xx", "yy", "zz"] {
            let (mean, error) = estimate(&measured, &format!("pressure_{ab}"));
            assert!((mean - expected).abs() < 4.0 * error + 0.004 * expected, "{ab}: {mean} {error} {expected}");
            assert!(error < 0.05 * expected);
        }
        for ab in ["xy", "xz", "yz"] {
            let (mean, error) = estimate(&measured, &format!("pressure_{ab}"));
            assert!(mean.abs() < 4.0 * error, "{ab}: {mean} {error}");
        }
    }

    #[test]
    fn restored_pressure_tensor_continues_bitwise() {
        let (system, mut simulation) = hard_spheres(32, 0.2);
        let mut both = Recorded::new(tensor(&simulation, &system, 1.0));
        measure(&mut simulation, &system, &mut both, 0.1);
        assert_eq!(both.again, both.instrument);
    }

    #[test]
    fn one_particle_between_walls_has_the_kinetic_pressure_of_its_velocity() {
        let walls = Space { boundary: [Boundary::walls(1.0), Boundary::Periodic, Boundary::Flat], ..flat_box() };
        let (system, mut simulation) = start(
            SceneBuilder::new("box")
                .space(walls)
                .species(SpeciesDraft::new("A").mass(2.0).diameter(1.0))
                .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
                .particle("A", Vector::new(3.0, 5.0, 0.0), Vector::new(3.0, 1.0, 0.0))
                .build()
                .unwrap(),
        );
        let mut instrument = tensor(&simulation, &system, 4.0);
        measure(&mut simulation, &system, &mut instrument, 4.0);
        let measured = report(&instrument, &system);
        let mean = |name: &str| number(&measured, name).mean.unwrap();
        // The kinetic pressure is m v_a v_b / A, where A = 90 is the area that the centre can reach. The wall reverses
        // v_x once, at t = 6.5 / 3.
        assert!((mean("pressure_xx") - 0.2).abs() < 1e-12);
        assert!((mean("pressure_yy") - 0.02 / 0.9).abs() < 1e-12);
        assert!((mean("pressure") - 0.2).abs() < 1e-12, "that on the walls");
        let forth = 6.5 / 3.0;
        assert!((mean("pressure_xy") - 0.06 / 0.9 * (2.0 * forth - 4.0) / 4.0).abs() < 1e-12);
        assert!((mean("wall_rate") - 1.0 / 4.0).abs() < 1e-12);
        assert_eq!(number(&measured, "compressibility_factor").mean, None);
        assert!(measured.numbers.iter().all(|number| !number.name.contains("z")));
    }

    #[test]
    fn open_box_has_no_pressure_and_falling_particle_a_sampled_mean() {
        let open = Space { boundary: [Boundary::OPEN; 3], ..Space::periodic_cube(10.0) };
        let scene = |space| {
            SceneBuilder::new("fall")
                .space(space)
                .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
                .gravity(Vector::new(0.0, 0.0, -1.0))
                .particle("A", Vector::repeat(5.0), Vector::zeros())
        };
        for (space, pressure) in [(open, None), (Space::periodic_cube(10.0), Some(0.001 / 3.0))] {
            let (system, mut simulation) = start(scene(space).build().unwrap());
            let mut instrument = tensor(&simulation, &system, 1.0);
            measure(&mut simulation, &system, &mut instrument, 1.0);
            // The mean of (g t)^2 from 0 to 1 is 1/3. The trapezoidal rule with 1000 intervals adds (1/1000)^2 / 6.
            let zz = number(&report(&instrument, &system), "pressure_zz").mean;
            assert_eq!(zz.is_some(), pressure.is_some());
            assert!((zz.unwrap_or(0.0) - pressure.unwrap_or(0.0)).abs() < 0.2e-9, "{zz:?}");
        }
    }

    #[test]
    fn two_unlike_particles_in_a_slit_have_exact_kinetic_pressure() {
        // Along the slit, A moves at 5 and B at -1/2 relative to the centre of mass. There is one free velocity
        // component, with the reduced mass 10/11 and the relative speed 11/2, so T = 10/11 (11/2)^2.
        let slit = Space { boundary: [Boundary::walls(1.0), Boundary::Periodic, Boundary::Flat], ..flat_box() };
        let slit = Space { size: Vector::new(8.0, 8.0, 0.0), ..slit };
        let scene = SceneBuilder::new("slit")
            .space(slit)
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .species(SpeciesDraft::new("B").mass(10.0).diameter(5.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .interaction(InteractionDraft::new(Model::None).between("A", "B"))
            .interaction(InteractionDraft::new(Model::HardSphere).between("B", "B"))
            .particle("A", Vector::new(2.0, 2.0, 0.0), Vector::new(1.0, 8.0, 0.0))
            .particle("B", Vector::new(4.0, 6.0, 0.0), Vector::new(0.0, 2.5, 0.0))
            .build()
            .unwrap();
        let system = SystemDescription::of(&scene);
        let mut simulation = Simulation::without_plan(scene);
        let mut instrument = tensor(&simulation, &system, 1.0);
        measure(&mut simulation, &system, &mut instrument, 1.0);
        let pressure = number(&report(&instrument, &system), "pressure_yy").mean.unwrap();
        // The area that a centre can reach is 7 x 8 for A and 3 x 8 for B.
        let expected = 10.0 / 11.0 * 5.5 * 5.5 * (1.0 / 56.0 + 1.0 / 24.0);
        assert!((pressure / expected - 1.0).abs() < 1e-12, "{pressure} {expected}");
    }

    fn flat_box() -> Space {
        Space { size: Vector::new(10.0, 10.0, 0.0), ..Space::periodic_cube(10.0) }
    }
}

//! Flow of momentum and energy through a system, which determines the pressure and transport coefficients.

use serde::{Deserialize, Serialize};

use super::system::{Sample, SystemDescription};
use crate::Vector;
use crate::engine::event::{Event, EventKind};

/// Row and column of each stored component of a symmetric tensor.
pub(super) const COMPONENTS: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]];

pub(super) type Tensor = [f64; 6];

pub(super) fn trace(tensor: &Tensor) -> f64 {
    tensor[0] + tensor[1] + tensor[2]
}

/// Transfer of momentum and energy in an event. Velocities are relative to the centre of mass.
struct Transfer {
    /// `r_ij` to the nearest image of the partner; zero for an event with a wall or a thermostat `[length]`.
    apart: Vector,
    /// For each particle, the volume of the box divided by the volume accessible to the centre.
    crowding: [f64; 2],
    /// `r_ij` times the mean `crowding` `[length]`. If `c_i` and `c_j` in `crowding` differ, the component between two
    /// walls is `c_i x_i - c_j x_j`, where `x` is measured from the middle of the box.
    arm: Vector,
    /// Momentum that the particle gained, or that the partner lost if the particle is static `[mass length / time]`.
    momentum: Vector,
    /// Kinetic energy that the particle gained `[energy]`.
    energy: f64,
    /// Mass, velocity before and velocity after the event; `None` for a static particle or a surface.
    movers: [Option<(f64, Vector, Vector)>; 2],
}

impl Transfer {
    fn of(event: &Event, system: &SystemDescription, drift: &Vector) -> Self {
        let ids = [Some(event.particle), event.partner()];
        let movers = std::array::from_fn(|k| {
            let mass = *system.masses.get(ids[k]?.0 as usize)?;
            mass.is_finite().then_some((mass, event.before[k] - drift, event.after[k] - drift))
        });
        let gained = |mover: &Option<(f64, Vector, Vector)>| mover.map(|(m, before, after)| (after - before) * m);
        let momentum = gained(&movers[0]).or_else(|| Some(-gained(&movers[1])?)).unwrap_or_default();
        let energy =
            movers[0].map_or(0.0, |(m, before, after)| 0.5 * m * (after.norm_squared() - before.norm_squared()));
        let apart = match event.kind {
            // The separation of the images that collided, even in a sheared box.
            EventKind::Pair(_) => event.normal * event.distance,
            EventKind::Surface
            | EventKind::Thermostat
            | EventKind::Entry
            | EventKind::Exit
            | EventKind::Rest
            | EventKind::Wake => Vector::zeros(),
        };
        let crowding = ids.map(|id| id.map_or(1.0, |id| system.crowding_of(id.0)));
        let arm = arm(event, system, &apart, crowding);
        Self { apart, crowding, arm, momentum, energy, movers }
    }
}

fn arm(event: &Event, system: &SystemDescription, apart: &Vector, crowding: [f64; 2]) -> Vector {
    let [ci, cj] = crowding;
    if event.partner().is_none() || ci == cj {
        return apart * ci;
    }
    let middle = system.space.lower + 0.5 * system.space.size;
    Vector::from_fn(|axis, _| {
        let [xi, xj] = event.positions.map(|position| position[axis] - middle[axis]);
        if system.space.walls(axis) == 2 { ci * xi - cj * xj } else { 0.5 * (ci + cj) * apart[axis] }
    })
}

/// Time integrals of the kinetic and of the collisional flow of momentum, `sum m v_a v_b dt` and `sum r_a J_b`.
///
/// Walls keep centres a radius away. The integrals are later divided by the volume of the box. Each term is therefore
/// divided by the fraction of the box that the centres of the species can reach.
///
/// The kinetic flow changes only at events, unless particles accelerate or the box is sheared. In these cases, it is
/// interpolated linearly between samples. Each sample removes the accumulated round-off.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct MomentumFlow {
    /// Time up to which the integrals are complete `[time]`.
    pub time: f64,
    /// Velocity of the centre of mass at the start, along the axes on which momentum is conserved.
    drift: Vector,
    /// Whether the flow changes between events, because particles accelerate or the box is sheared.
    is_changing: bool,
    /// The current `sum m v_a v_b` `[energy]`.
    flow: Tensor,
    /// Time integral of `flow` `[energy time]`.
    pub kinetic: Tensor,
    /// `sum r_a J_b`, symmetrised `[energy time]`. The symmetrisation matters only for sliding contacts.
    pub collisional: Tensor,
    pub heat: Option<HeatFlow>,
}

/// Flow of kinetic energy, for particles without potential energy and without acceleration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct HeatFlow {
    /// The current `sum (m/2 v^2) v` `[energy length / time]`.
    flow: Vector,
    /// Time integral of `flow`, plus the sum of `r_ij dE_i` over all collisions `[energy length]`.
    pub integral: Vector,
}

impl MomentumFlow {
    pub fn new(sample: &Sample<'_>, system: &SystemDescription) -> Self {
        let drift = system.drift(sample.velocities);
        Self {
            time: sample.time,
            drift,
            is_changing: system.is_accelerated || system.shear_rate != 0.0,
            flow: kinetic_flow(sample, system, &drift),
            kinetic: [0.0; 6],
            collisional: [0.0; 6],
            heat: None,
        }
    }

    pub fn with_heat(self, sample: &Sample<'_>, system: &SystemDescription) -> Self {
        let heat = HeatFlow { flow: energy_flow(sample, system, &self.drift), integral: Vector::zeros() };
        Self { heat: Some(heat), ..self }
    }

    /// Advances to a later time. There must be no event in between.
    pub fn pass(&mut self, time: f64) {
        if !self.is_changing {
            let passed = (time - self.time).max(0.0);
            self.kinetic.iter_mut().zip(&self.flow).for_each(|(sum, flow)| *sum += flow * passed);
            if let Some(heat) = &mut self.heat {
                heat.integral += heat.flow * passed;
            }
            self.time = self.time.max(time);
        }
    }

    pub fn event(&mut self, event: &Event, system: &SystemDescription) {
        self.pass(event.time);
        let transfer = Transfer::of(event, system, &self.drift);
        for (k, [a, b]) in COMPONENTS.into_iter().enumerate() {
            let Transfer { arm, momentum, .. } = &transfer;
            self.collisional[k] += 0.5 * (arm[a] * momentum[b] + arm[b] * momentum[a]);
            if !self.is_changing {
                for (mover, crowding) in transfer.movers.iter().zip(transfer.crowding) {
                    let Some((mass, before, after)) = mover else { continue };
                    self.flow[k] += crowding * mass * (after[a] * after[b] - before[a] * before[b]);
                }
            }
        }
        if let Some(heat) = &mut self.heat {
            heat.integral += transfer.apart * transfer.energy;
            for (mass, before, after) in transfer.movers.iter().flatten() {
                heat.flow += (after * after.norm_squared() - before * before.norm_squared()) * (0.5 * mass);
            }
        }
    }

    pub fn synchronise(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        self.pass(sample.time);
        let flow = kinetic_flow(sample, system, &self.drift);
        if self.is_changing {
            let passed = (sample.time - self.time).max(0.0);
            for (sum, (before, after)) in self.kinetic.iter_mut().zip(self.flow.iter().zip(&flow)) {
                *sum += 0.5 * (before + after) * passed;
            }
            self.time = self.time.max(sample.time);
        }
        self.flow = flow;
        if let Some(heat) = &mut self.heat {
            heat.flow = energy_flow(sample, system, &self.drift);
        }
    }

    pub fn restart(&mut self) {
        (self.kinetic, self.collisional) = ([0.0; 6], [0.0; 6]);
    }
}

fn kinetic_flow(sample: &Sample<'_>, system: &SystemDescription, drift: &Vector) -> Tensor {
    let mut flow = [0.0; 6];
    // In a sheared box, the common peculiar velocity along x may change with time. The current value is subtracted.
    let drift = drift + system.common_peculiar_velocity(sample);
    for &id in &system.moving {
        let streaming = system.streaming_velocity(&sample.positions[id as usize]);
        let mass = system.masses[id as usize] * system.crowding_of(id);
        let v = sample.velocities[id as usize] - drift - streaming;
        for (sum, [a, b]) in flow.iter_mut().zip(COMPONENTS) {
            *sum += mass * v[a] * v[b];
        }
    }
    flow
}

fn energy_flow(sample: &Sample<'_>, system: &SystemDescription, drift: &Vector) -> Vector {
    let flow_of = |&id: &u32| {
        let v = sample.velocities[id as usize] - drift;
        v * (0.5 * system.masses[id as usize] * v.norm_squared())
    };
    system.moving.iter().map(flow_of).sum()
}

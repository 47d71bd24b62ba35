//! Stages in which spheres grow to a target size or pressure. Jams end the run.

use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};

use super::Driver;
use crate::model::{Growth, GrowthTarget, Until};
use crate::run::{Ending, Jam};

/// Spheres grow beyond the target by this factor, because rounding could stop the growth below the target.
const BEYOND: f64 = 1.0 + 1e-12;

/// Above this compressibility factor, spheres are jammed if they cannot reach the target size.
const JAMMED: f64 = 1000.0;

/// Number of contacts per particle between two checks of the pressure.
const CONTACTS: u64 = 10;

/// Compressibility factor of growing spheres, as an average between two checks.
///
/// `Z = 1 + sum r.p / (D N T) / t`, as in [`Observer`](crate::analysis::observables::Observer). The sum is over all
/// contacts in the time `t`, and `p` is the exchanged momentum. Growth heats the spheres and a thermostat cools them.
/// Between two scalings of the velocities, `T` is therefore the mean of the first and the last temperature.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(in crate::run) struct PressureCheck {
    since: f64,
    /// Number of physical events at the next check.
    next: u64,
    /// Sum of `r.p / (D N T)` since the last check `[time]`.
    exchanged: f64,
    /// Virial at the start of the averaging interval.
    virial: f64,
    /// Temperature at the start of the averaging interval.
    temperature: f64,
}

impl Driver<'_> {
    pub(super) fn growth(&self) -> Option<Growth> {
        self.settings().growth
    }

    pub(super) fn begin_growth(&mut self, growth: &Growth, limit: &mut Until) {
        let scene = self.simulation.scene();
        let target = match growth.until {
            GrowthTarget::PackingFraction(target) => target,
            // The final packing fraction is unknown, but below 1.
            GrowthTarget::CompressibilityFactor(_) => 1.0,
        };
        // A target below the current size has been rejected, so a ratio below 1 is a rounding error.
        let largest = scene.growth_to(target).max(1.0) * BEYOND;
        self.simulation.grow(growth, largest);
        if let GrowthTarget::PackingFraction(_) = growth.until {
            let duration = (largest - 1.0) / growth.rate;
            limit.time = Some(limit.time.map_or(duration, |time| time.min(duration)));
        }
        self.begin_pressure_check();
    }

    fn begin_pressure_check(&mut self) {
        let contacts = (CONTACTS * self.state.observer.applicable().moving as u64).div_ceil(2).max(1);
        let event_counts = self.simulation.event_counts();
        self.state.pressure_check = Some(PressureCheck {
            since: self.simulation.time(),
            next: event_counts.physical().saturating_add(contacts),
            exchanged: 0.0,
            virial: event_counts.virial.total(),
            temperature: self.temperature(),
        });
    }

    fn temperature(&self) -> f64 {
        let energy = self.simulation.energy();
        self.state.observer.applicable().temperature(energy.thermal, &energy.peculiar_momentum).unwrap_or(0.0)
    }

    /// Returns the number of physical events, since the start of the simulation, at the next check.
    pub(super) fn next_check(&self) -> u64 {
        let pressure = self.state.pressure_check.map_or(u64::MAX, |check| check.next).min(self.next_storm_check());
        self.state.monitor.as_ref().map_or(pressure, |monitor| pressure.min(monitor.next))
    }

    /// Ends an averaging interval of the pressure, before velocities are scaled.
    pub(super) fn end_piece(&mut self) {
        if self.state.pressure_check.is_none() {
            return;
        }
        let (virial, temperature) = (self.simulation.event_counts().virial.total(), self.temperature());
        let applicable = self.state.observer.applicable();
        let components = applicable.dimensions * applicable.moving as f64;
        let Some(check) = &mut self.state.pressure_check else { return };
        let mean = 0.5 * (check.temperature + temperature);
        if virial > check.virial {
            check.exchanged += (virial - check.virial) / (components * mean);
        }
        (check.virial, check.temperature) = (virial, temperature);
    }

    /// Starts an averaging interval of the pressure, after velocities are scaled.
    pub(super) fn begin_piece(&mut self) {
        if let Some(mut check) = self.state.pressure_check {
            check.temperature = self.temperature();
            self.state.pressure_check = Some(check);
        }
    }

    /// Ends the stage at the target pressure. Ends the run if the spheres jam below the target packing fraction.
    pub(super) fn check_growth(&mut self) -> ControlFlow<Option<Ending>> {
        let Some(growth) = self.growth() else { return ControlFlow::Continue(()) };
        if self.state.pressure_check.is_none_or(|check| self.simulation.event_counts().physical() < check.next) {
            return ControlFlow::Continue(());
        }
        self.end_piece();
        let Some(check) = self.state.pressure_check else { return ControlFlow::Continue(()) };
        let factor = 1.0 + check.exchanged / (self.simulation.time() - check.since);
        self.begin_pressure_check();
        match growth.until {
            GrowthTarget::CompressibilityFactor(target) if factor >= target => ControlFlow::Break(None),
            GrowthTarget::CompressibilityFactor(_) => ControlFlow::Continue(()),
            GrowthTarget::PackingFraction(target) => match self.jam(&growth, target, factor) {
                Some(jam) => ControlFlow::Break(Some(Ending::Jammed(jam))),
                None => ControlFlow::Continue(()),
            },
        }
    }

    /// Returns a jam if the packing fraction `phi_J` of the jammed state is below the target. In `D` dimensions near
    /// jamming, `Z = D / (1 - phi / phi_J)` at the packing fraction `phi`.
    fn jam(&self, growth: &Growth, target: f64, factor: f64) -> Option<Jam> {
        let scene = self.simulation.scene();
        let dimensions = scene.space.dimensions() as f64;
        let grown = self.simulation.scale() / self.simulation.grown();
        let packing_fraction = scene.packing_fraction() * libm::pow(grown, dimensions);
        // Fast growth makes contacts harder and more frequent. `Z - 1` may be too large by up to the factor `excess`.
        let largest = scene.particles.iter().map(|particle| scene.diameter(particle)).fold(0.0, f64::max);
        let heaviest = scene.particles.iter().map(|particle| scene.mass(particle)).fold(0.0, f64::max);
        let speed = (self.temperature() / heaviest).sqrt();
        let excess = libm::pow(1.0 + growth.rate * largest / speed, 2.0);
        let least = 1.0 + (factor - 1.0) / excess;
        // `D / Z` is the relative distance to jamming. The factor 2 allows for the error of `Z`.
        let limit = packing_fraction * (1.0 + 2.0 * dimensions / least);
        let time = self.simulation.time();
        (least > JAMMED && limit < target).then_some(Jam {
            packing_fraction,
            target,
            compressibility_factor: factor,
            time,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;
    use crate::analysis::instruments::Registry;
    use crate::engine::Simulation;
    use crate::model::{RunPlan, StagePlan, Thermostat};
    use crate::run::driver::KeepsError;
    use crate::run::{Ending, Progress, RunState};
    use crate::scene::{Arrangement, Fill, InteractionDraft, Model, SceneBuilder, SpeciesDraft};

    /// Returns the factor by which diameters grow to the target pressure, in calls with at most `step` events.
    fn grown(step: u64) -> f64 {
        let stage = StagePlan {
            name: "compress".into(),
            thermostat: Some(Thermostat::Rescaling { temperature: 1.0, interval: 0.1 }),
            growth: Some(Growth { rate: 0.05, until: GrowthTarget::CompressibilityFactor(15.0) }),
            ..StagePlan::default()
        };
        let scene = SceneBuilder::new("growing")
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .fill(Fill::new(Arrangement::Random, "A").count(32).packing_fraction(0.1))
            .temperature(1.0)
            .run(RunPlan { stages: vec![stage], limit: Until::events(1), ..RunPlan::default() })
            .build()
            .unwrap();
        let simulation = Simulation::without_plan(scene);
        let state = RunState::new(&simulation);
        let watch = &mut |_: &Progress| ControlFlow::Continue(());
        let mut recorder = KeepsError { recorder: &mut (), error: None };
        let mut driver =
            Driver { steps: 1, ..Driver::new(simulation, state, Registry::default(), &mut recorder, watch) };
        driver.enter();
        loop {
            let events = driver.simulation.event_counts().physical().saturating_add(step);
            if driver.advance(f64::INFINITY, events).unwrap() != Some(Ending::Events) {
                return driver.simulation.scale();
            }
        }
    }

    fn disks(packing_fraction: f64, rate: f64, thermostat: Option<Thermostat>) -> Ending {
        let stage = StagePlan {
            name: "compress".into(),
            thermostat,
            growth: Some(Growth { rate, until: GrowthTarget::PackingFraction(packing_fraction) }),
            ..StagePlan::default()
        };
        let mut space = crate::model::space::Space::periodic_cube(8.0);
        (space.size.z, space.boundary[2]) = (0.0, crate::model::space::Boundary::Flat);
        let scene = SceneBuilder::new("disks")
            .space(space)
            .species(SpeciesDraft::new("A").mass(1.0).diameter(0.5))
            .species(SpeciesDraft::new("B").mass(1.0).diameter(0.7))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "B"))
            .interaction(InteractionDraft::new(Model::HardSphere).between("B", "B"))
            .fill(crate::scene::Fill::new(Arrangement::Random, "A").count(16))
            .fill(crate::scene::Fill::new(Arrangement::Random, "B").count(16))
            .temperature(1.0)
            .run(RunPlan { stages: vec![stage], limit: Until::events(1), ..RunPlan::default() })
            .build()
            .unwrap();
        crate::run::run(scene, &mut (), &mut |_| ControlFlow::Continue(())).unwrap().ending
    }

    #[test]
    fn growth_that_jams_ends_and_says_where() {
        let cooled = Some(Thermostat::Rescaling { temperature: 1.0, interval: 0.05 });
        for thermostat in [None, cooled] {
            let Ending::Jammed(jam) = disks(0.95, 0.05, thermostat) else {
                panic!("the disks did not jam before a packing fraction of 0.95")
            };
            assert!((0.75..0.92).contains(&jam.packing_fraction), "{jam}");
            assert_eq!(disks(0.7, 0.05, thermostat), Ending::Events);
        }
    }

    #[test]
    fn growth_that_is_faster_than_the_particles_is_not_taken_for_a_jam() {
        let cooled = Some(Thermostat::Rescaling { temperature: 1e-4, interval: 1e-3 });
        assert_eq!(disks(0.6, 1.0, cooled), Ending::Events);
    }

    #[test]
    fn where_growth_ends_does_not_depend_on_how_it_is_cut_up() {
        let whole = grown(u64::MAX);
        // Up to this size, the engine rebuilds its cells several times.
        assert!(whole > 1.5, "{whole}");
        for step in [1, 7, 160, 1003] {
            assert_eq!(grown(step).to_bits(), whole.to_bits(), "{step}");
        }
    }
}

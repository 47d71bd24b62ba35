//! Observables during a run: rows at equidistant times, and means with standard errors.
//!
//! An observer does not change a single bit of the trajectory.

mod applicable;
mod equilibrium;
mod regions;
mod row;
mod volume;

pub use applicable::ApplicableObservables;
use equilibrium::Conditions;
pub(crate) use equilibrium::is_settled;
pub use equilibrium::{Answer, Equilibrium};
pub use row::Row;
use volume::VolumePiece;

use crate::Vector;
use crate::analysis::statistics::{BlockAverage, Estimate, Stationarity};
use crate::base::numbers::trunc_to_usize;
use crate::engine::event::EventCounts;
use crate::engine::{Energy, Simulation};
use crate::model::{Barostat, Scene, Thermostat, Units};
use serde::{Deserialize, Serialize};

const TEMPERATURE: &str = "temperature";
const COMPRESSIBILITY: &str = "compressibility_factor";
const ISOTHERMAL_COMPRESSIBILITY: &str = "isothermal_compressibility";
const HEAT_FLUX: &str = "energy / (length^(D - 1) time)";

/// Names and units of the quantities that are averaged over a run, in the order of `summary.json`.
pub const OBSERVABLES: [(&str, &str); 23] = [
    (TEMPERATURE, "energy"),
    ("pressure", "energy / length^D"),
    (COMPRESSIBILITY, "1"),
    ("collision_rate", "1 / time"),
    ("potential_energy_per_particle", "energy"),
    ("pressure_on_lower_x_wall", "energy / length^D"),
    ("pressure_on_upper_x_wall", "energy / length^D"),
    ("pressure_on_lower_y_wall", "energy / length^D"),
    ("pressure_on_upper_y_wall", "energy / length^D"),
    ("pressure_on_lower_z_wall", "energy / length^D"),
    ("pressure_on_upper_z_wall", "energy / length^D"),
    ("heat_flux_through_lower_x_wall", HEAT_FLUX),
    ("heat_flux_through_upper_x_wall", HEAT_FLUX),
    ("heat_flux_through_lower_y_wall", HEAT_FLUX),
    ("heat_flux_through_upper_y_wall", HEAT_FLUX),
    ("heat_flux_through_lower_z_wall", HEAT_FLUX),
    ("heat_flux_through_upper_z_wall", HEAT_FLUX),
    ("volume", "length^D"),
    ("number_density", "1 / length^D"),
    ("packing_fraction", "1"),
    (ISOTHERMAL_COMPRESSIBILITY, "length^D / energy"),
    ("entry_rate", "1 / time"),
    ("exit_rate", "1 / time"),
];

/// Indices into [`OBSERVABLES`]. `FIRST_WALL` and `FIRST_HEAT` are for the lower wall along x.
const PRESSURE: usize = 1;
const COLLISION_RATE: usize = 3;
const FIRST_WALL: usize = 5;
const FIRST_HEAT: usize = 11;
const VOLUME: usize = 17;
const SQUARED_VOLUME: usize = 20;

/// Averages thermodynamic observables between rows: temperature, pressure, collision rate, energies.
///
/// | quantity | measured as |
/// |---|---|
/// | temperature `T` | `2 (K - P^2 / 2M) / (D N - c)`, where the momentum `P` has `c` conserved components |
/// | pressure | `(N T + W / (D t)) / V`, where `W` is the sum of `r_ij . J` over the events of a time `t` |
/// | compressibility factor `Z` | mean pressure divided by `rho` and the mean of `T` |
/// | pressure between walls | mean over the axes `k` between walls of `<sum m v_k^2 / V_s> + W_k / t`, where `W_k` is the sum of `x_k J_k / V_s` over the particles of all pair events |
/// | pressure on a wall | momentum that the wall gave to each species in a time `t`, divided by `t` and by the area `A_s` that the centres of the species can reach |
/// | heat flux through a wall | energy that the wall supplied in a time `t`, divided by `t` and by the area of the wall; negative if the wall removed energy |
/// | collision rate | `n / (N t)`, where each Core event adds the number of its moving particles to `n` |
/// | potential energy per particle | energy of the pairs divided by `N` |
/// | volume, number density, packing fraction | if a barostat changes the volume `V`: time averages of `V`, of `N / V`, and of the volume of the particles divided by `V` |
/// | entry rate, exit rate | numbers of particles that enter and leave per time, in scenes with inlets or outlets |
/// | isothermal compressibility | `(<V^2> - <V>^2) / (<V> T)` at the temperature of the heat bath |
///
/// With a barostat, the pressure is the mean of `(N T + W / (D t)) / V` over the intervals of constant volume. The
/// compressibility factor is `P <V> / (N T)` with the pressure `P` of the barostat and the temperature of the heat
/// bath.
///
/// A wall keeps centres a radius away, so each species `s` has its own volume `V_s` and area `A_s`. Along an axis
/// between walls, with `x` measured from the middle, the mean of `d/dt sum x m v` is zero for each species. Therefore
/// `<sum m v_x^2> + <sum x J> / t` is `V_s / A_s` times the mean force of the species on the two walls, and the virial
/// pressure across a slit has the same mean as the pressure on its walls. The pressure along the slit is different. In
/// equilibrium `<sum m v_x^2>` is `N_s T`. A driven or dissipative system can have a different temperature for each
/// axis and species. The sum `sum m v_x^2` is constant between events, so its mean is exact.
///
/// `N` counts the moving particles, and `D` the axes that are not flat. Time averages of `T` and of the potential
/// energy are exact, because the integrals include the exact time of each change at an event. In a sheared box the
/// temperature also changes between events. There the mean of `T` uses straight lines between samples and the exact
/// times of the dissipating contacts.
///
/// The pressure is exact for any number of particles. Let `f = D N - c` be the number of free velocity components. The
/// phase-space volume below an energy `E` at a given momentum is proportional to the integral of `(E - U)^(f / 2)` over
/// all positions. The integral runs over all `N` particles even if the momentum is conserved, because the centre of
/// mass may be anywhere. The logarithm of the phase-space volume is Gibbs' entropy `S`, for which equipartition is
/// exact: `T = 2 <K'> / f` with the kinetic energy `K'` of the free components. In coordinates scaled by the box the
/// integral gets a factor `V^N`, and `P = T dS/dV` becomes `P V = N T + <sum r_ij . F_ij> / D`. Only `T` contains the
/// number of free components. For example, two hard spheres in a cube have positions that fill `V (V - 4 pi sigma^3 /
/// 3)`, so `Z = (1 + V / (V - 4 pi sigma^3 / 3)) / 2`. E. M. Pearson, T. Halicioglu and W. A. Tiller, Phys. Rev. A 32,
/// 3030 (1985), [doi:10.1103/PhysRevA.32.3030](https://doi.org/10.1103/PhysRevA.32.3030).
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Observer {
    applicable: ApplicableObservables,
    before: Option<Reading>,
    piece: Option<Piece>,
    averages: Vec<BlockAverage>,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Reading {
    piece: Piece,
    event_counts: EventCounts,
}

/// State and integrals at the last sample.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Piece {
    time: f64,
    elapsed: f64,
    /// Sum of the energies `dE` gained at events, and sum of `t dE` with the event times `t` `[energy, energy time]`.
    heated: [f64; 2],
    /// Sum of `t dU` over the changes `dU` of the pair energy `[energy time]`.
    pair_energy_moment: f64,
    temperature: Option<f64>,
    pair_energy: f64,
    volume: Option<VolumePiece>,
    /// Integrals of the temperature and of the pair energy `[energy time]`.
    integrals: [f64; 2],
    /// Time integral of `sum m v_k^2 / V` from the start, for each axis `k` between walls `[energy time / length^D]`.
    confined: [f64; 3],
}

impl Observer {
    /// Creates an observer for a scene, without any rows.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        Self { applicable: ApplicableObservables::of(scene), before: None, piece: None, averages: Vec::new() }
    }

    /// The observables that are defined for the scene.
    #[must_use]
    pub fn applicable(&self) -> &ApplicableObservables {
        &self.applicable
    }

    pub(crate) fn set_thermostat(&mut self, scene: &Scene, thermostat: Option<&Thermostat>) {
        self.applicable.set_thermostat(scene, thermostat);
    }

    pub(crate) fn set_swaps(&mut self, has_swaps: bool) {
        self.applicable.set_swaps(has_swaps);
    }

    /// `grown` is the factor by which diameters have grown since the start of the simulation.
    pub(crate) fn set_barostat(&mut self, scene: &Scene, acting: Option<(&Barostat, &Thermostat)>, grown: f64) {
        self.applicable.set_barostat(scene, acting, grown);
    }

    /// Measures the current values, and the means since the last row.
    pub fn row(&mut self, simulation: &Simulation) -> Row {
        let energy = simulation.energy();
        let temperature = self.integrate(simulation, &energy);
        let event_counts = *simulation.event_counts();
        let reading = self.piece.map(|piece| Reading { piece, event_counts });
        let interval = self.before.zip(reading).and_then(|(before, reading)| self.interval(&before, &reading));
        if let Some((duration, values)) = &interval {
            self.averages.resize(OBSERVABLES.len(), BlockAverage::new(*duration));
            for (average, value) in self.averages.iter_mut().zip(values) {
                average.add(value.unwrap_or(f64::NAN), *duration);
            }
        }
        self.before = reading;
        let mean = |observable: usize| interval.as_ref().and_then(|(_, values)| values[observable]);
        let (height, counts) = self.applicable.positions(simulation);
        Row {
            time: simulation.time(),
            events: event_counts.physical(),
            temperature,
            kinetic: energy.kinetic,
            rotational: energy.rotational,
            potential: energy.potential,
            supplied: event_counts.supplied.total(),
            ledger: energy.total() + event_counts.dissipated.total() - event_counts.supplied.total(),
            pressure: mean(PRESSURE),
            collision_rate: mean(COLLISION_RATE),
            volume: simulation.scene().run.has_barostat().then(|| simulation.volume()),
            height,
            counts,
            flow: self.applicable.has_flow.then(|| {
                let present: usize = simulation.population().iter().sum();
                [present as u64, event_counts.entry, event_counts.exit]
            }),
            asleep: simulation.scene().sleep().is_some().then(|| simulation.sleeping().len()),
        }
    }

    /// Returns the name and the mean of each quantity that is defined for the scene. A constant has the error 0. Errors
    /// are unknown for equal hard particles on a line. Such particles only exchange their velocities, so the means
    /// depend on the initial state.
    #[must_use]
    pub fn estimates(&self) -> Vec<(&'static str, Estimate)> {
        let is_too_short = self.is_short_of_volumes();
        let estimate = |at: usize, name: &str, average: &BlockAverage| {
            let estimate = match name {
                COMPRESSIBILITY if self.applicable.isobaric.is_none() => average.ratio(self.averages.first()?),
                ISOTHERMAL_COMPRESSIBILITY => {
                    self.applicable.isobaric?.compressibility(self.averages.get(VOLUME)?, average)
                }
                _ => self.of_wall(at, average).or_else(|| average.estimate()),
            }?;
            Some(match self.stationarity_of(name, average) {
                Stationarity::Constant => Estimate { standard_error: Some(0.0), ..estimate },
                _ if at > 0 && is_too_short || self.applicable.only_exchanges_velocities => {
                    Estimate { standard_error: None, ..estimate }
                }
                _ => estimate,
            })
        };
        let estimates = OBSERVABLES.iter().zip(&self.averages).enumerate();
        estimates.filter_map(|(at, ((name, _), average))| Some((*name, estimate(at, name, average)?))).collect()
    }

    /// Whether a run at constant pressure has sampled too few independent volumes. Errors may then be underestimated.
    fn is_short_of_volumes(&self) -> bool {
        let averages = self.averages.get(VOLUME).zip(self.averages.get(SQUARED_VOLUME));
        let averages = averages.filter(|_| self.applicable.isobaric.is_some());
        let variance = averages.and_then(|(volume, squares)| volume.variance(squares));
        variance.is_some_and(|variance| variance.standard_error.is_none())
    }

    /// Estimates a quantity of one wall. If a conservation law relates the two walls of an axis, the error follows from
    /// the virial pressure or from the mean heat flux of the two walls.
    fn of_wall(&self, at: usize, average: &BlockAverage) -> Option<Estimate> {
        let is_of = |axis: usize, first: usize| (first + 2 * axis..first + 2 * axis + 2).contains(&at);
        if self.applicable.balanced_axis.is_some_and(|axis| is_of(axis, FIRST_WALL)) {
            return average.estimate_beside(self.averages.get(PRESSURE)?);
        }
        self.applicable.heated_axis.filter(|axis| is_of(*axis, FIRST_HEAT))?;
        let other = self.averages.get(FIRST_HEAT + ((at - FIRST_HEAT) ^ 1))?;
        average.estimate_beside(&average.with(other, |own, other| 0.5 * (own - other))?)
    }

    /// Stationarity of each defined observable. Omits the compressibility factor if all particles are at rest.
    #[must_use]
    pub fn stationarity(&self) -> Vec<(&'static str, Stationarity)> {
        let is_at_rest = self.averages.first().and_then(BlockAverage::mean) == Some(0.0);
        let means =
            |name: &str, average: &BlockAverage| average.mean().is_some() && !(is_at_rest && name == COMPRESSIBILITY);
        let all = OBSERVABLES.iter().zip(&self.averages).filter(|((name, _), average)| means(name, average));
        all.map(|((name, _), average)| (*name, self.stationarity_of(name, average))).collect()
    }

    /// Whether the run was in equilibrium or in a steady state, from stationarity and the number of events. The reasons
    /// contain the names of `units`.
    #[must_use]
    pub fn equilibrium(
        &self,
        stationarity: &[(&'static str, Stationarity)],
        counted: &EventCounts,
        units: &Units,
    ) -> Equilibrium {
        let alone = counted.wall + counted.exit;
        let taken = 2 * (counted.physical() - alone) - counted.core_static + alone + counted.thermostat;
        let conditions = Conditions {
            dimensions: trunc_to_usize(self.applicable.dimensions),
            has_steady_state: self.applicable.has_steady_state,
            only_exchanges_velocities: self.applicable.only_exchanges_velocities,
            // All particles that have entered count.
            events_per_particle: taken as f64 / (self.applicable.moving as u64 + counted.entry).max(1) as f64,
        };
        Equilibrium::of(stationarity, &conditions, units)
    }

    fn stationarity_of(&self, name: &str, average: &BlockAverage) -> Stationarity {
        match (name, self.averages.first()) {
            (COMPRESSIBILITY, Some(temperature)) if self.applicable.isobaric.is_none() => {
                average.stationarity_of_ratio(temperature)
            }
            (ISOTHERMAL_COMPRESSIBILITY, _) => {
                let ensemble = self.applicable.isobaric.zip(self.averages.get(VOLUME));
                let series = ensemble.and_then(|(it, volume)| it.fluctuation(volume, average));
                series.as_ref().unwrap_or(average).stationarity()
            }
            (TEMPERATURE, _) if self.applicable.conserves_temperature && average.is_constant() => {
                Stationarity::Constant
            }
            _ => average.stationarity(),
        }
    }

    pub(crate) fn stationarity_of_second_half(&self) -> Vec<(&'static str, Stationarity)> {
        let halves = Self { averages: self.averages.iter().map(BlockAverage::second_half).collect(), ..self.clone() };
        halves.stationarity()
    }

    /// Ends the current interval before the state jumps or another simulation follows. All means are kept.
    pub(crate) fn interrupt(&mut self) {
        (self.before, self.piece) = (None, None);
    }

    pub(crate) fn begin(&mut self) {
        (self.before, self.piece) = (None, None);
        self.averages.clear();
    }

    /// Samples temperature and potential energy, and adds to their integrals. Returns the temperature. Call this
    /// function before and after velocities are scaled, so that no straight line spans a jump.
    pub(crate) fn integrate(&mut self, simulation: &Simulation, energy: &Energy) -> Option<f64> {
        let (time, elapsed) = (simulation.time(), simulation.elapsed());
        let temperature = self.applicable.temperature(energy.thermal, &energy.peculiar_momentum);
        let counts = simulation.event_counts();
        let pair_energy_moment = counts.pair_energy_moment.total();
        let heated = self.applicable.heated(counts, energy.pair);
        let mut integrals = [0.0; 2];
        let mut volume = self.applicable.isobaric.map(|_| VolumePiece::of(simulation));
        if let Some(last) = &self.piece {
            let (half, middle) = (0.5 * (time - last.time), 0.5 * (last.elapsed + elapsed));
            let mean = last.temperature.zip(temperature).map_or(0.0, |(a, b)| a + b);
            // A straight line would be exact for changes in the middle of the interval.
            let missed = |change: f64, moment: f64| change * middle - moment;
            let later = missed(heated[0] - last.heated[0], heated[1] - last.heated[1]);
            let heat = half * mean + 2.0 * later / self.applicable.degrees_of_freedom.max(1.0);
            let pair = half * (last.pair_energy + energy.pair)
                + missed(energy.pair - last.pair_energy, pair_energy_moment - last.pair_energy_moment);
            integrals = [last.integrals[0] + heat, last.integrals[1] + pair];
            volume = last.volume.map(|last| last.next(simulation, 2.0 * half, heat, &self.applicable));
        }
        let heating = &counts.confined_heating;
        let confined = std::array::from_fn(|axis| energy.confined[axis] * time - heating[axis].total());
        self.piece = Some(Piece {
            time,
            elapsed,
            heated,
            pair_energy_moment,
            temperature,
            pair_energy: energy.pair,
            volume,
            integrals,
            confined,
        });
        temperature
    }

    /// The time between two rows and the means over this time, in the order of [`OBSERVABLES`]; `None` if undefined.
    fn interval(&self, from: &Reading, to: &Reading) -> Option<(f64, Vec<Option<f64>>)> {
        let duration = to.piece.time - from.piece.time;
        if duration <= 0.0 {
            return None;
        }
        let counted = to.event_counts.since(&from.event_counts);
        let (applicable, from, to) = (&self.applicable, &from.piece, &to.piece);
        let moving = applicable.moving as f64;
        let [heat, pair] = [0, 1].map(|k| to.integrals[k] - from.integrals[k]);
        let temperature = from.temperature.and(to.temperature).map(|_| heat / duration);
        let confined = std::array::from_fn(|axis| to.confined[axis] - from.confined[axis]);
        let isobaric = applicable.isobaric.zip(from.volume.zip(to.volume));
        let isobaric = isobaric.map(|(ensemble, (from, to))| (ensemble, to.since(&from, duration)));
        let pressure = temperature.and_then(|temperature| match isobaric {
            Some((_, means)) => applicable.has_pressure.then_some(means.pressure),
            None => applicable.pressure(&counted, duration, temperature, &confined),
        });
        // The mean of `factor` is later divided by the mean temperature, except at constant pressure.
        let factor = match isobaric {
            Some((ensemble, means)) => Some(ensemble.factor(means.volume, moving)),
            None => pressure.map(|pressure| pressure / applicable.number_density),
        };
        let of_all = [
            temperature,
            pressure,
            factor.filter(|_| applicable.is_homogeneous && temperature.is_some()),
            applicable.has_core.then(|| counted.core_contacts() as f64 / (moving * duration)),
            applicable.has_wells.then(|| pair / (duration * moving)),
        ];
        let walls = || (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]);
        let pressures = walls().map(|(axis, side)| {
            applicable.pressed_walls[axis][side].then(|| counted.wall_push[axis][side].total() / duration)
        });
        let fluxes = walls().map(|(axis, side)| {
            applicable.heat_areas[axis][side].map(|area| counted.wall_heat[axis][side].total() / (area * duration))
        });
        let of_volume = match isobaric {
            Some((ensemble, means)) => means.values(&ensemble, moving).map(Some),
            None => [None; 4],
        };
        let rates = [counted.entry, counted.exit].map(|count| applicable.has_flow.then(|| count as f64 / duration));
        Some((duration, of_all.into_iter().chain(pressures).chain(fluxes).chain(of_volume).chain(rates).collect()))
    }
}

fn upwards(scene: &Scene) -> Option<Vector> {
    let present = scene.particles.iter().map(|particle| particle.species);
    let sum: Vector = present
        .chain(scene.entering_species())
        .map(|species| &scene.species[species.0 as usize])
        .filter(|species| !species.is_static())
        .map(|species| species.acceleration)
        .sum();
    (-sum).try_normalize(0.0)
}

#[cfg(test)]
mod tests;

//! The replicas of an exchange.

use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

use super::averages::Averages;
use super::error::StartError;
use super::instruments::InstrumentsAtTemperatures;
use super::multicanonical::Multicanonical;
use super::replica::{Replica, bath};
use super::results::ExchangeResults;
use super::walk::Walk;
use crate::analysis::instruments::chains::ChainSizes;
use crate::analysis::reweighting::Ensemble;
use crate::engine::Simulation;
use crate::model::random::{Purpose, Random};
use crate::model::state_point::StatePoint;
use crate::model::{EnergyWeights, ExchangeEnsemble, ExchangePlan, Scene};
use crate::run::FrameLimit;

/// Replica exchange of a scene (parallel tempering): one replica for each temperature. At regular times, neighbouring
/// temperatures swap their replicas.
///
/// Each replica samples a canonical ensemble with an Andersen thermostat. Neighbouring temperatures `T_i` and `T_j`
/// swap with a probability of `min(1, exp((1/T_i - 1/T_j) (U_i - U_j)))`. Here `U` is the exact potential energy of
/// pairs and gravity. Attempts alternate between the pairs 1-2, 3-4, ... and the pairs 2-3, 4-5, ... After a swap,
/// velocities are multiplied by `sqrt(T_new / T_old)`, which keeps the ensembles canonical.
///
/// All random numbers follow from the seed of the scene. The start of each replica, the swaps and each heat bath have
/// separate random streams. Results are bitwise identical for any number of threads and any pauses.
///
/// With [`ExchangeEnsemble::Multicanonical`], swaps happen only in the first half of the equilibration. The energies of
/// the second quarter determine weights `exp(-w(U))`. With these weights, all replicas visit the energies between the
/// means at the lowest and the highest temperature equally often. Each replica moves as if its potential energy were `T
/// w(U)`, in a heat bath of the highest temperature `T`. After three quarters of the equilibration, the weights are
/// improved once. Reweighting yields the means at the temperatures, see [`ThermalCurves`](super::ThermalCurves): Y.
/// Sugita and Y. Okamoto, Chem. Phys. Lett. 329, 261 (2000),
/// [doi:10.1016/S0009-2614(00)00999-4](https://doi.org/10.1016/S0009-2614(00)00999-4).
///
/// R. H. Swendsen and J.-S. Wang, Phys. Rev. Lett. 57, 2607 (1986),
/// [doi:10.1103/PhysRevLett.57.2607](https://doi.org/10.1103/PhysRevLett.57.2607); K. Hukushima and K. Nemoto, J. Phys.
/// Soc. Jpn. 65, 1604 (1996), [doi:10.1143/JPSJ.65.1604](https://doi.org/10.1143/JPSJ.65.1604); in molecular dynamics
/// Y. Sugita and Y. Okamoto, Chem. Phys. Lett. 314, 141 (1999),
/// [doi:10.1016/S0009-2614(99)01123-9](https://doi.org/10.1016/S0009-2614(99)01123-9).
#[doc(alias = "parallel tempering")]
#[derive(Debug, Clone, Serialize, Deserialize)]
#[must_use = "an exchange does nothing until `execute` or `finish`"]
pub struct Exchange {
    pub(super) plan: ExchangePlan,
    pub(super) temperatures: Vec<f64>,
    pub(super) seed: u64,
    /// Index of the first random stream of the heat baths.
    pub(super) first_stream: usize,
    start: f64,
    pub(super) equilibration: u64,
    total: u64,
    frame_every: u64,
    pub(super) attempts: u64,
    pub(super) replicas: Vec<Replica>,
    /// Index of the replica at each temperature or in each window.
    pub(super) places: Vec<usize>,
    /// Potential energy at each temperature or in each window after the last attempt `[energy]`.
    pub(super) energies: Vec<f64>,
    /// Distance in each window at the last attempt `[length]`. Empty without windows.
    pub(super) distances: Vec<f64>,
    /// Whether the replica of each window is outside its window. Empty without windows.
    pub(super) is_outside: Vec<bool>,
    /// Values of other quantities at the last attempt, one temperature after the other.
    pub(super) measured: Vec<f64>,
    /// Not saved, because it follows from the scene.
    #[serde(skip)]
    chains: OnceLock<ChainSizes>,
    pub(super) random: Random,
    pub(super) averages: Averages,
    pub(super) instruments: InstrumentsAtTemperatures,
    pub(super) walk: Walk,
    pub(super) multicanonical: Option<Multicanonical>,
}

/// State of an exchange after an attempt to swap.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ExchangeRow<'e> {
    /// Simulated time `[time]`.
    pub time: f64,
    /// Index of the replica at each temperature after the swaps.
    pub replicas: &'e [usize],
    /// Potential energy at each temperature after the swaps `[energy]`.
    pub potential: &'e [f64],
    /// Values of the quantities of [`Exchange::measured_names`], one temperature after the other.
    pub measured: &'e [f64],
}

/// Name and unit of the distance that windows restrain. It is the first quantity of each window.
pub const DISTANCE: (&str, &str) = ("distance", "length");

impl ExchangeRow<'_> {
    pub(super) fn distances(&self) -> impl Iterator<Item = f64> {
        let each = self.measured.len() / self.potential.len().max(1);
        self.measured.iter().copied().step_by(each.max(1))
    }
}

pub(super) fn in_order<'e>(places: &'e [usize], replicas: &'e [Replica]) -> impl Iterator<Item = &'e Simulation> {
    places.iter().map(|number| &replicas[*number].simulation)
}

/// Number of attempts between two frames. By default, the frames of all temperatures stay within the size limit.
pub(super) fn frame_every(scene: &Scene, plan: &ExchangePlan, measured: u64) -> u64 {
    let given = scene.output().frame_interval.and_then(|interval| plan.attempts(interval)).filter(|every| *every > 0);
    given.unwrap_or_else(|| {
        let most = FrameLimit::of_replicas(scene, plan.replicas()).of_exchange();
        measured.div_ceil(u64::from(most))
    })
}

impl Exchange {
    /// Creates the replicas of a scene with the table `[exchange]`. They start at the positions of the scene, with
    /// velocities from the Maxwell distributions of their temperatures.
    ///
    /// # Errors
    /// [`StartError::NoPlan`] if the scene has no plan. [`StartError::Velocities`] if a velocity is too large.
    pub fn new(scene: Scene) -> Result<Self, StartError> {
        let plan = scene.exchange().cloned().ok_or(StartError::NoPlan)?;
        let attempts = |time: Option<f64>| time.map_or(Some(0), |time| plan.attempts(time));
        let equilibration = attempts(scene.run().equilibration.time).ok_or(StartError::NoPlan)?;
        let measured = attempts(scene.run().limit.time).filter(|attempts| *attempts > 0).ok_or(StartError::NoPlan)?;
        let (temperatures, count) = (plan.temperatures_of_places(), plan.replicas());
        let mut example = scene.clone();
        example.run.thermostat = Some(bath(&plan, temperatures[0]));
        let first_stream = scene.first_stream();
        let seed = StatePoint::at_start(&scene).with(&temperatures).seed(scene.seed());
        let mut exchange = Self {
            seed,
            first_stream,
            start: scene.start_time(),
            equilibration,
            total: equilibration + measured,
            frame_every: frame_every(&scene, &plan, measured),
            attempts: 0,
            replicas: (0..count).map(|number| Replica::new(&scene, &plan, seed, number)).collect::<Result<_, _>>()?,
            places: (0..count).collect(),
            energies: vec![0.0; count],
            distances: Vec::new(),
            is_outside: Vec::new(),
            measured: Vec::new(),
            chains: OnceLock::new(),
            random: Random::new(seed, Purpose::Exchange, 0),
            averages: Averages::new(&example, &plan),
            instruments: InstrumentsAtTemperatures::default(),
            walk: Walk::new(&temperatures),
            multicanonical: (plan.ensemble == ExchangeEnsemble::Multicanonical)
                .then(|| Multicanonical::new(equilibration)),
            plan,
            temperatures,
        };
        exchange.begin_windows();
        for number in 0..count {
            exchange.heat(number, number);
        }
        exchange.begin_intervals(None);
        Ok(exchange)
    }

    /// Exchange plan of the scene.
    #[must_use]
    pub fn plan(&self) -> &ExchangePlan {
        &self.plan
    }

    pub(super) fn enlarge(&self) {
        self.replicas.iter().for_each(|replica| replica.simulation.enlarge());
    }

    /// Temperatures in the order of the scene `[energy]`. All windows have the same temperature.
    #[must_use]
    pub fn temperatures(&self) -> &[f64] {
        &self.temperatures
    }

    /// The ensemble at each temperature or in each window.
    #[must_use]
    pub fn ensembles(&self) -> Vec<Ensemble> {
        match (&self.plan.umbrella, self.weights()) {
            (Some(umbrella), _) => umbrella.windows.iter().map(|ends| Ensemble::Window { ends: *ends }).collect(),
            (None, None) => Ensemble::canonical(self.temperatures()),
            (None, Some(weights)) => vec![Ensemble::Multicanonical(weights.clone()); self.places.len()],
        }
    }

    pub(super) fn weights(&self) -> Option<&EnergyWeights> {
        self.multicanonical.as_ref().and_then(Multicanonical::weights)
    }

    /// The simulation at the temperature with the index `place` in [`Self::temperatures`].
    #[must_use]
    pub fn simulation_at(&self, place: usize) -> Option<&Simulation> {
        self.places.get(place).map(|number| &self.replicas[*number].simulation)
    }

    pub(super) fn simulations(&self) -> impl Iterator<Item = &Simulation> {
        in_order(&self.places, &self.replicas)
    }

    /// Any of the simulations, for properties that all replicas share.
    pub(super) fn example(&self) -> &Simulation {
        &self.replicas[0].simulation
    }

    /// The scene of the replicas.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        self.replicas[0].simulation.scene()
    }

    /// Number of attempts to swap so far, and total number of attempts. The attempts of the equilibration are included.
    #[must_use]
    pub fn attempts(&self) -> [u64; 2] {
        [self.attempts, self.total]
    }

    /// Changes the simulated time of the averages `[time]`. Returns false if the duration is not a whole number of
    /// intervals or is already over. An extended exchange has the same results as an exchange that was planned with the
    /// longer duration.
    #[must_use]
    pub fn end_after(&mut self, duration: f64) -> bool {
        let total = self.plan.attempts(duration).map(|measured| self.equilibration + measured);
        let total = total.filter(|total| *total >= self.attempts && *total > self.equilibration);
        self.total = total.unwrap_or(self.total);
        total.is_some()
    }

    /// Number of moving particles, and number of axes along which they move.
    pub(super) fn size(&self) -> [f64; 2] {
        let applicable = self.averages.applicable();
        [applicable.moving as f64, applicable.dimensions]
    }

    /// Number of attempts before averaging begins.
    #[must_use]
    pub fn equilibration(&self) -> u64 {
        self.equilibration
    }

    /// Whether the exchange has reached its end.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.attempts == self.total
    }

    /// State of the exchange after the last attempt.
    #[must_use]
    pub fn row(&self) -> ExchangeRow<'_> {
        ExchangeRow {
            time: self.time_of(self.attempts),
            replicas: &self.places,
            potential: &self.energies,
            measured: &self.measured,
        }
    }

    pub(super) fn is_measured(&self) -> bool {
        self.attempts > self.equilibration
    }

    pub(super) fn has_frame(&self) -> bool {
        self.is_measured() && (self.attempts - self.equilibration).is_multiple_of(self.frame_every)
    }

    fn time_of(&self, attempt: u64) -> f64 {
        self.start + attempt as f64 * self.plan.interval
    }

    pub(super) fn next_time(&self) -> f64 {
        self.time_of(self.attempts + 1)
    }

    /// Names of the quantities sampled at each attempt besides the energies. For windows, the first quantity is the
    /// restrained `distance` `[length]`. Scenes with bonded particles have `mean_square_radius_of_gyration`, an average
    /// over all bonded molecules. Scenes with linear chains also have `mean_square_end_to_end_distance`, an average
    /// over these chains `[length^2]`.
    #[must_use]
    pub fn measured_names(&self) -> Vec<&'static str> {
        let distance = self.plan.umbrella.as_ref().map(|_| DISTANCE.0);
        distance.into_iter().chain(self.chains().names().iter().copied()).collect()
    }

    fn chains(&self) -> &ChainSizes {
        self.chains.get_or_init(|| ChainSizes::of_simulation(self.example(), self.averages.applicable()))
    }

    pub(super) fn now_measured(&self) -> Vec<f64> {
        let chains = self.chains();
        let of_place = |(place, simulation): (usize, &Simulation)| {
            let sizes = if chains.names().is_empty() { Vec::new() } else { chains.at(&simulation.snapshot()) };
            self.distances.get(place).copied().into_iter().chain(sizes)
        };
        self.simulations().enumerate().flat_map(of_place).collect()
    }

    /// Results so far.
    #[must_use]
    pub fn results(&self) -> ExchangeResults {
        let measured = self.attempts.saturating_sub(self.equilibration);
        let faults = self.replicas.iter().enumerate().flat_map(|(number, replica)| {
            replica.faults().into_iter().map(move |fault| format!("replica {}: {fault}", number + 1))
        });
        let mut at_places = self.averages.results(&self.temperatures, &self.measured_names());
        for (at, window) in at_places.iter_mut().zip(self.plan.umbrella.iter().flat_map(|it| &it.windows)) {
            at.window = Some(*window);
        }
        let of_instruments = self.instruments.report(self.example(), self.averages.applicable());
        at_places.iter_mut().zip(of_instruments).for_each(|(at, measured)| at.measured = measured);
        ExchangeResults {
            ensemble: self.plan.ensemble,
            start: self.time_of(self.equilibration),
            duration: measured as f64 * self.plan.interval,
            attempts: measured,
            temperatures: at_places,
            neighbours: match self.plan.ensemble {
                ExchangeEnsemble::Multicanonical => Vec::new(),
                _ => self.averages.neighbours(&self.temperatures),
            },
            round_trips: self.walk.trips().to_vec(),
            faults: faults.collect(),
        }
    }
}

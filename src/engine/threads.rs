//! Simulations on several threads of one process, in slabs, and in several processes, in domains.

use super::domains::{DomainWork, Domains};
use super::observe::Observe;
use super::parts::Engine;
use super::single_thread::SingleThread;
use super::slabs::{Slabs, ThreadWork};
use super::{Arrest, Chosen, Communicator, EngineError, Reason, Simulation, Until};
use crate::model::Threads;
use std::num::NonZero;
use std::sync::Arc;

/// Minimum number of moving particles for several threads. With fewer particles, the threads would mostly wait for each other.
const FEW: usize = 4_000;

/// False in WebAssembly, which runs on one thread.
const HAS_THREADS: bool = cfg!(not(target_family = "wasm"));

impl Simulation {
    /// Copies the states of all particles from the domains or threads to the engine. Their predictions are not copied.
    pub(crate) fn settle(&mut self) {
        with_engine!(&mut self.engine, engine => engine.settle());
    }

    /// Copies everything from the domains or threads to the engine, so that the simulation can be saved.
    pub(crate) fn complete(&mut self) {
        with_engine!(&mut self.engine, engine => engine.complete());
    }

    /// Reports an event storm as an [`Arrest`] that names the particles of the next predicted contact. `None` if no
    /// contact is predicted.
    pub(crate) fn storm(&self, events: u64, advance: f64) -> Option<Arrest> {
        with_engine!(&self.engine, engine => engine.storm(events, advance))
    }

    /// Number of threads in each process.
    #[must_use]
    pub fn threads(&self) -> usize {
        let cores = std::thread::available_parallelism().map_or(1, NonZero::get);
        let threads = self.threads.of(self.population().iter().sum::<usize>() / self.processes(), cores);
        threads.min(Threads::MOST / self.processes()).max(1)
    }

    /// Number of processes that simulate the system together.
    #[must_use]
    pub fn processes(&self) -> usize {
        self.communicator.as_ref().map_or(1, |communicator| communicator.size())
    }

    /// Returns the value of the first process, so that all processes agree.
    pub(crate) fn agreed(&self, found: u64) -> u64 {
        let Some(communicator) = &self.communicator else { return found };
        let all = communicator.share(found.to_le_bytes().to_vec());
        match all.first().and_then(|first| first.as_slice().try_into().ok()) {
            Some(first) => u64::from_le_bytes(first),
            None => communicator.abort("the processes are out of step"),
        }
    }

    pub(crate) fn chooses_threads(&self) -> bool {
        self.threads == Threads::Auto
    }

    /// Statistics of the work on several threads, or `None` if one thread has done all work.
    #[must_use]
    pub fn thread_work(&self) -> Option<ThreadWork> {
        let work = with_engine!(&self.engine, engine => engine.slabs.as_ref().map(|slabs| slabs.work));
        work.filter(|work| work.windows > 0)
    }

    /// Statistics of the work in domains, or `None` without domains.
    #[must_use]
    pub fn domain_work(&self) -> Option<DomainWork> {
        with_engine!(&self.engine, engine => engine.domains.as_ref().map(|domains| domains.work))
    }

    /// Returns the reason why the system cannot run on several threads. Returns `None` if it can. Too few particles are
    /// a reason only if several threads are set.
    #[must_use]
    pub fn single_thread(&self) -> Option<SingleThread> {
        let why = with_engine!(&self.engine, engine => engine.single_thread());
        why.filter(|why| *why != SingleThread::FewParticles || self.threads() > 1)
    }

    /// Whether several threads or processes share the system.
    pub(crate) fn is_spread(&self) -> bool {
        with_engine!(&self.engine, engine => engine.slabs.is_some() || engine.domains.is_some())
    }

    /// Runs the system on this number of threads, at most 64, instead of
    /// [`RunPlan::threads`](crate::model::RunPlan::threads). The results have the same bits as on one thread.
    ///
    /// The setting is not saved in checkpoints. Some systems always run on one thread: [`SingleThread`] lists the
    /// reasons, and [`Self::single_thread`] returns the reason for this system. `docs/speed.md`
    /// has the speed of two threads. Carom measures whether the threads are faster than one thread, and otherwise uses
    /// one: this happens in small systems, and if other programs use the cores.
    ///
    /// ```
    /// use carom::{SceneBuilder, Simulation, Until};
    /// use carom::scene::{Fill, InteractionDraft, Lattice, Model, SpeciesDraft};
    ///
    /// let scene = SceneBuilder::new("fluid")
    ///     .species(SpeciesDraft::new("sphere").mass(1.0).diameter(1.0))
    ///     .interaction(InteractionDraft::new(Model::HardSphere).between("sphere", "sphere"))
    ///     .fill(Fill::new(Lattice::FaceCentredCubic, "sphere").count(4_000).packing_fraction(0.4))
    ///     .temperature(1.0)
    ///     .build()?;
    /// let (mut one, mut two) = (Simulation::new(scene.clone())?, Simulation::new(scene)?);
    /// two.set_threads(2);
    /// one.advance(Until::time(0.5))?;
    /// two.advance(Until::time(0.5))?;
    /// assert_eq!(one.snapshot(), two.snapshot());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[doc(alias = "parallel")]
    #[doc(alias = "cores")]
    pub fn set_threads(&mut self, threads: impl Into<Threads>) {
        self.threads = threads.into();
        self.spread();
    }

    /// Spreads the system over processes. Each process must have the same simulation and number of threads, and
    /// simulates one domain per thread. If the system cannot be cut, or if there are more than 64 processes, every
    /// process simulates the whole system.
    ///
    /// From now on, all processes must make the same calls. Calls that change or advance the simulation wait for all
    /// processes.
    #[doc(alias = "mpi")]
    #[doc(alias = "machines")]
    pub fn set_communicator(&mut self, communicator: Arc<dyn Communicator>) {
        self.communicator = Some(communicator);
        self.spread();
    }

    /// Cuts the system into `domains` domains in each process, as several processes do, and simulates them on `threads`
    /// threads. With more domains than threads, the run is slower, but [`DomainWork::slowest`] shows what more processes
    /// would gain.
    pub fn set_domains(&mut self, domains: usize, threads: usize) {
        let communicator = self.communicator.clone();
        with_engine!(&mut self.engine, engine => engine.set_domains(domains, threads, communicator));
    }

    /// Uses several threads even if the system is small, and even if one thread is faster. A thread gets a slab that is
    /// at least `narrowest` times as wide as the layers at its faces in which threads wait for each other. For tests.
    #[doc(hidden)]
    pub fn set_slabs(&mut self, threads: usize, narrowest: f64) {
        with_engine!(&mut self.engine, engine => engine.set_slabs(Slabs::always(threads, narrowest)));
    }

    fn spread(&mut self) {
        let threads = usize::try_from(self.agreed(self.threads() as u64)).unwrap_or(1);
        if self.communicator.is_some() {
            self.set_domains(threads, threads);
        } else {
            with_engine!(&mut self.engine, engine => engine.set_threads(threads));
        }
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    fn set_threads(&mut self, threads: usize) {
        self.join();
        let has_slabs = HAS_THREADS && threads > 1 && self.state.moving >= FEW;
        (self.slabs, self.domains) = (has_slabs.then(|| Box::new(Slabs::new(threads))), None);
    }

    fn set_slabs(&mut self, slabs: Slabs) {
        self.join();
        (self.slabs, self.domains) = (HAS_THREADS.then(|| Box::new(slabs)), None);
    }

    pub(super) fn set_domains(&mut self, domains: usize, threads: usize, communicator: Option<Arc<dyn Communicator>>) {
        self.join();
        let threads = if self.state.bodies.len() < FEW { 1 } else { threads };
        let processes = communicator.as_ref().map_or(1, |communicator| communicator.size());
        let has_domains = HAS_THREADS && (domains > 1 || communicator.is_some()) && processes <= Threads::MOST;
        self.domains = has_domains.then(|| Box::new(Domains::new(domains, threads, communicator)));
        self.slabs = None;
    }

    fn single_thread(&self) -> Option<SingleThread> {
        let is_refused = self.slabs.as_ref().is_some_and(|slabs| slabs.is_refused());
        let is_spread = self.slabs.is_some() || self.domains.is_some();
        let has_few = self.state.moving < FEW && !is_spread;
        let too_small = is_refused.then_some(SingleThread::NoSlabs).or(has_few.then_some(SingleThread::FewParticles));
        self.obstacle().or(too_small)
    }

    /// Like [`Self::advance_for`], but on all threads and processes. The states in the engine may be outdated until
    /// [`Self::settle`] is called.
    pub(super) fn advance_on_cores(
        &mut self,
        steps: u64,
        until: Until,
        observe: &mut Observe<'_>,
    ) -> Result<Option<Reason>, EngineError> {
        let in_slabs = self.with_slabs(|slabs, whole| slabs.advance_for(whole, steps, until, observe));
        if let Some(result) = in_slabs.flatten() {
            return result;
        }
        let in_domains = self.with_domains(|domains, whole| domains.advance_for(whole, steps, until, observe));
        in_domains.unwrap_or_else(|| self.advance_for(steps, until, observe))
    }

    pub(super) fn settle(&mut self) {
        self.with_slabs(|slabs, whole| slabs.settle(whole));
        self.with_domains(Domains::settle);
    }

    pub(super) fn complete(&mut self) {
        self.with_slabs(Slabs::complete);
        self.with_domains(Domains::complete);
    }

    pub(super) fn join(&mut self) {
        self.with_slabs(Slabs::join);
        self.with_domains(Domains::join);
    }

    fn with_slabs<R>(&mut self, work: impl FnOnce(&mut Slabs, &mut Self) -> R) -> Option<R> {
        let mut slabs = self.slabs.take()?;
        let result = work(&mut slabs, self);
        self.slabs = Some(slabs);
        Some(result)
    }

    fn with_domains<R>(&mut self, work: impl FnOnce(&mut Domains<FALLING, TABLE>, &mut Self) -> R) -> Option<R> {
        if !HAS_THREADS {
            return None;
        }
        let mut domains = self.domains.take()?;
        let result = work(&mut domains, self);
        self.domains = Some(domains);
        Some(result)
    }
}

//! A simulation on several threads: the state is that of its domains until it is taken over.

use super::domains::{DomainWork, Domains, SingleThread};
use super::observe::Observe;
use super::parts::Engine;
use super::{Arrest, Chosen, EngineError, Reason, Simulation, Transport, Until};
use crate::model::Threads;
use std::num::NonZero;
use std::sync::Arc;

/// Domains of so few particles run one after the other.
const FEW: usize = 4_000;

/// Whether this machine has threads: a module of WebAssembly leaves the code for several cores out.
const HAS_DOMAINS: bool = cfg!(not(target_family = "wasm"));

impl Simulation {
    /// Takes over the state that the domains have, to look at it.
    pub(crate) fn settle(&mut self) {
        with_engine!(&mut self.engine, engine => engine.settle());
    }

    /// Takes over all that the domains have, to be kept.
    pub(crate) fn complete(&mut self) {
        with_engine!(&mut self.engine, engine => engine.complete());
    }

    /// The arrest by a storm of events, at the contact that comes next; none where no contact is foreseen.
    pub(crate) fn storm(&self, events: u64, advance: f64) -> Option<Arrest> {
        with_engine!(&self.engine, engine => engine.storm(events, advance))
    }

    /// The number of threads that it has, in each process.
    #[must_use]
    pub fn threads(&self) -> usize {
        let cores = std::thread::available_parallelism().map_or(1, NonZero::get);
        let threads = self.threads.of(self.population().iter().sum::<usize>() / self.processes(), cores);
        threads.min(Threads::MOST / self.processes()).max(1)
    }

    /// Number of processes that simulate it together.
    #[must_use]
    pub fn processes(&self) -> usize {
        self.transport.as_ref().map_or(1, |transport| transport.size())
    }

    /// Finding of the first of all processes, where that may differ.
    pub(crate) fn agreed(&self, found: u64) -> u64 {
        let Some(transport) = &self.transport else { return found };
        let all = transport.share(found.to_le_bytes().to_vec());
        match all.first().and_then(|first| first.as_slice().try_into().ok()) {
            Some(first) => u64::from_le_bytes(first),
            None => transport.abort("another process is not at the same place"),
        }
    }

    /// Whether it was left to it how many threads it has.
    pub(crate) fn chooses_threads(&self) -> bool {
        self.threads == Threads::Auto
    }

    /// How the work of domains went, on several cores.
    #[must_use]
    pub fn domain_work(&self) -> Option<DomainWork> {
        with_engine!(&self.engine, engine => engine.domains.as_ref().map(|domains| domains.work))
    }

    /// Why it runs in one thread now, whatever [`Self::set_threads`] was given.
    #[must_use]
    pub fn single_thread(&self) -> Option<SingleThread> {
        with_engine!(&self.engine, engine => Domains::obstacle(engine))
    }

    /// Runs the system on this number of threads from now on, at most 64, in place of [`RunPlan::threads`](crate::model::RunPlan::threads): the box is
    /// cut into as many domains. Events, states and sums have the same bits as with one.
    ///
    /// Nothing of this is written to a checkpoint. What is not covered runs in one thread: diameters that grow, sheared boxes, starts with overlaps that are allowed, and
    /// pairs with interactions of their own that do not hold them together ([`Self::single_thread`] tells). It pays from
    /// some 250,000 particles for each thread on, and takes two and a half times the memory (`docs/speed.md`).
    ///
    /// ```
    /// use carom::{Potential, SceneBuilder, Simulation, Until};
    /// use carom::scene::{Amount, Lattice};
    ///
    /// let scene = SceneBuilder::new("fluid")
    ///     .species("sphere", 1.0, 1.0)
    ///     .interaction("sphere", "sphere", Potential::hard_sphere(1.0)?, 1.0)
    ///     .fill(Lattice::FaceCentredCubic, "sphere", 4_000, Amount::PackingFraction(0.4))
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

    /// Spreads the system over processes from now on, of which each has the same simulation, and as many threads: of as many domains as all have threads,
    /// 64 at most, each has its part. What is not covered, all do, and so do more than 64 processes.
    ///
    /// From now on all have to do the same with it: what changes or advances it waits for the others, and what only looks at it does not.
    #[doc(alias = "mpi")]
    #[doc(alias = "machines")]
    pub fn set_transport(&mut self, transport: Arc<dyn Transport>) {
        self.transport = Some(transport);
        self.spread();
    }

    /// Cuts the system into a number of domains for each process, on a number of threads. [`Self::set_threads`] uses the same number for both. More domains than threads cost
    /// more than they bring, but tell what more threads would: [`DomainWork::slowest`].
    pub fn set_domains(&mut self, domains: usize, threads: usize) {
        let transport = self.transport.clone();
        with_engine!(&mut self.engine, engine => engine.set_domains(domains, threads, transport));
    }

    fn spread(&mut self) {
        let threads = usize::try_from(self.agreed(self.threads() as u64)).unwrap_or(1);
        self.set_domains(threads, threads);
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Sets the number of domains of each process and of threads. One domain runs serially.
    pub(super) fn set_domains(&mut self, domains: usize, threads: usize, transport: Option<Arc<dyn Transport>>) {
        self.join();
        // To begin a thread takes longer than a window of few particles.
        let threads = if self.state.bodies.len() < FEW { 1 } else { threads };
        let processes = transport.as_ref().map_or(1, |transport| transport.size());
        let has_domains = HAS_DOMAINS && (domains > 1 || transport.is_some()) && processes <= Threads::MOST;
        self.domains = has_domains.then(|| Box::new(Domains::new(domains, threads, transport)));
    }

    /// Goes on as [`Self::advance_for`] does, in domains if there are some. Then it is behind them until [`Self::settle`].
    pub(super) fn advance_on_cores(
        &mut self,
        steps: u64,
        until: Until,
        observe: &mut Observe<'_>,
    ) -> Result<Option<Reason>, EngineError> {
        let in_domains = self.with_domains(|domains, whole| domains.advance_for(whole, steps, until, observe));
        in_domains.unwrap_or_else(|| self.advance_for(steps, until, observe))
    }

    /// Takes over the state that the domains have, to look at it.
    pub(super) fn settle(&mut self) {
        self.with_domains(Domains::settle);
    }

    /// Takes over all that the domains have, to be kept or to go on from.
    pub(super) fn complete(&mut self) {
        self.with_domains(Domains::complete);
    }

    /// Takes over what the domains have before it is changed from outside.
    pub(super) fn join(&mut self) {
        self.with_domains(Domains::join);
    }

    /// Has the domains do something to the one engine, if there are some.
    fn with_domains<R>(&mut self, work: impl FnOnce(&mut Domains<FALLING, TABLE>, &mut Self) -> R) -> Option<R> {
        if !HAS_DOMAINS {
            return None;
        }
        let mut domains = self.domains.take()?;
        let result = work(&mut domains, self);
        self.domains = Some(domains);
        Some(result)
    }
}

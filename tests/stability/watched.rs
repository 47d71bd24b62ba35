use carom::engine::{Reason, Simulation, Until};
use carom::model::Scene;

/// Number of roundings per event that affect the energy.
const ROUNDINGS: f64 = 32.0;

pub struct Watched {
    pub simulation: Simulation,
    start: f64,
    scale: f64,
}

impl Watched {
    pub fn new(scene: Scene) -> Self {
        let simulation = Simulation::without_plan(scene);
        let energy = simulation.energy();
        let start = energy.kinetic + energy.potential;
        let mut watched = Self { simulation, start, scale: 0.0 };
        watched.see();
        watched
    }

    fn see(&mut self) {
        let energy = self.simulation.energy();
        for size in [energy.kinetic, energy.potential.abs(), self.simulation.event_counts().dissipated.total()] {
            self.scale = self.scale.max(size);
        }
    }

    /// Runs the simulation in 100 parts to a number of events. Asserts that time advances in each part.
    #[track_caller]
    pub fn run(&mut self, events: u64) {
        let (start, before) = (self.simulation.event_counts().physical(), self.simulation.time());
        let mut last = before;
        for part in 1..=100 {
            let until = start + (events - start) * part / 100;
            assert_eq!(self.simulation.advance(Until::events(until)), Ok(Reason::Events));
            self.see();
            let now = self.simulation.time();
            assert!(now > last, "time stands still at {now}");
            last = now;
        }
    }

    pub fn ledger_error(&self) -> f64 {
        let energy = self.simulation.energy();
        energy.kinetic + energy.potential + self.simulation.event_counts().dissipated.total() - self.start
    }

    /// Asserts that energy is conserved, and that no invalid state occurred at an event or at the end.
    #[track_caller]
    pub fn assert_sound(&self, share: f64) {
        self.assert_conserved(share);
        assert_eq!(self.simulation.event_counts().in_invalid_state, 0);
        assert_eq!(self.simulation.real_overlaps(), []);
    }

    /// Asserts that energy is conserved within round-off. An event may change the fraction `share` of the largest
    /// energy. A rounding error is at most `eps / 2` of the number, with a random sign. For `n` events, the standard
    /// deviation is below `ROUNDINGS eps / 2 sqrt(n)`. The limit is four standard deviations.
    #[track_caller]
    pub fn assert_conserved(&self, share: f64) {
        let event_counts = self.simulation.event_counts();
        let roundings = ((event_counts.physical() + event_counts.transition) as f64).sqrt() * share + 1.0;
        let limit = 4.0 * ROUNDINGS * 0.5 * f64::EPSILON * roundings * self.scale;
        let error = self.ledger_error();
        println!(
            "{} events, time {}: ledger {error:.2e} (limit {limit:.1e}) of {:.3e}, deepest {:.2e}, {} turning points",
            event_counts.physical(),
            self.simulation.time(),
            self.scale,
            event_counts.deepest_overlap,
            event_counts.turning_point,
        );
        assert!(error.abs() <= limit, "energy is off by {error:e}, more than {limit:e}");
    }
}

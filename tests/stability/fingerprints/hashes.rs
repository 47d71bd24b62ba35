use std::convert::Infallible;

use carom::analysis::instruments::Scalar;
use carom::analysis::observables::Row;
use carom::engine::event::{Event, EventCounts};
use carom::engine::{Search, Simulation, Snapshot};
use carom::run::{Finished, Recorder, Stage};

/// FNV-1a hash of the bits of numbers.
#[derive(Clone, Copy, PartialEq)]
pub struct Hash(pub u64);

impl Hash {
    pub const EMPTY: Self = Self(0xcbf2_9ce4_8422_2325);

    pub fn bits(&mut self, bits: u64) {
        self.0 = bits
            .to_le_bytes()
            .iter()
            .fold(self.0, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3));
    }

    pub fn add(&mut self, numbers: impl IntoIterator<Item = f64>) {
        numbers.into_iter().for_each(|x| self.bits(x.to_bits()));
    }

    fn state(&mut self, now: &Snapshot) {
        let vectors = now.positions.iter().chain(&now.velocities).chain(&now.spins);
        self.add(vectors.flat_map(|v| v.iter().copied()).chain([now.time]));
    }
}

pub fn fingerprint(now: &Snapshot) -> u64 {
    let mut hash = Hash::EMPTY;
    hash.state(now);
    hash.0
}

#[derive(Clone, Copy, PartialEq)]
pub struct Bits {
    /// Final positions, velocities, spins and time.
    pub state: Hash,
    /// Time, kind, particles, impulse, energies, positions and velocities of all events.
    pub events: Hash,
    /// Event counts, energies, rows and means.
    pub ledger: Hash,
    /// Whether the engine has acceleration, a table of interactions, and neighbour lists.
    pub engine: [bool; 3],
}

impl Bits {
    pub const EMPTY: Self = Self { state: Hash::EMPTY, events: Hash::EMPTY, ledger: Hash::EMPTY, engine: [false; 3] };

    pub fn see(&mut self, event: &Event) {
        self.events.bits(u64::from(event.code()));
        self.events.bits(u64::from(event.particle.0));
        self.events.bits(event.partner().map_or(u64::MAX, |partner| u64::from(partner.0)));
        self.events.add([event.time, event.distance, event.energy_step, event.dissipated]);
        let [positions, before, after] = [event.positions, event.before, event.after];
        let vectors =
            [event.normal, event.impulse, event.torques[0]].into_iter().chain(positions).chain(before).chain(after);
        self.events.add(vectors.flat_map(|v| [v.x, v.y, v.z]));
    }

    pub fn close(&mut self, simulation: &Simulation) {
        let engine = simulation.engine();
        self.engine = [engine.is_falling, engine.has_table, matches!(engine.search, Search::Lists { .. })];
        self.state.state(&simulation.snapshot());
        self.count(simulation.event_counts());
        let energy = simulation.energy();
        self.ledger.add([energy.kinetic, energy.thermal, energy.potential, energy.pair]);
        self.ledger
            .add([energy.confined, energy.momentum, energy.peculiar_momentum].iter().flat_map(|v| [v.x, v.y, v.z]));
    }

    pub fn end(&mut self, finished: &Finished) {
        self.close(&finished.simulation);
        self.ledger.add(finished.observables.iter().map(|(_, estimate)| estimate.mean));
    }

    fn count(&mut self, counts: &EventCounts) {
        for count in [
            counts.core,
            counts.core_static,
            counts.capture,
            counts.release,
            counts.bounce,
            counts.wall,
            counts.transition,
            counts.turning_point,
            counts.in_invalid_state,
            counts.tc_contacts,
            counts.tc_altered,
            counts.thermostat,
        ] {
            self.ledger.bits(count);
        }
        self.ledger.add([counts.deepest_overlap, counts.virial.total()]);
        self.ledger.add(counts.confined_virial.map(|sum| sum.total()));
        self.ledger.add(counts.confined_heating.map(|sum| sum.total()));
        self.ledger.add(counts.wall_push.into_iter().flatten().map(|sum| sum.total()));
        self.ledger.add(counts.wall_heat.into_iter().flatten().map(|sum| sum.total()));
        let sums = [
            counts.dissipated,
            counts.dissipated_moment,
            counts.supplied,
            counts.supplied_moment,
            counts.pair_energy_moment,
        ];
        self.ledger.add(sums.map(|sum| sum.total()));
    }
}

impl Recorder for Bits {
    type Error = Infallible;

    fn row(&mut self, _stage: Stage, row: &Row) -> Result<(), Infallible> {
        self.ledger.add([row.time, row.kinetic, row.potential, row.supplied, row.ledger]);
        self.ledger.add([row.temperature, row.pressure, row.collision_rate, row.height].into_iter().flatten());
        Ok(())
    }

    fn frame(&mut self, _: &Snapshot, _: Vec<Scalar>) -> Result<(), Infallible> {
        Ok(())
    }

    fn has_events(&self) -> bool {
        true
    }

    fn event(&mut self, event: &Event) -> Result<(), Infallible> {
        self.see(event);
        Ok(())
    }
}

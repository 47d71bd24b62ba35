//! Time: epochs that keep its digits, and the watch for dynamics that stand still.

use super::parts::Engine;
use super::prediction::{Contact, Prediction};
use super::surfaces::FIRST_SURFACE;
use super::{Arrest, Standstill};
use serde::{Deserialize, Serialize};

/// Time that advances by less than this part of the queue's span stands still: some thousand times the spacing of the
/// floats that count it. An epoch sees of the order of ten events per particle, so a working system is far away from it.
pub(super) const SHORTEST_ADVANCE: f64 = 1.0 / (1_u64 << 40) as f64;

/// Simulated time, counted from an epoch that moves along with it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Clock {
    /// Simulated time at the start, at the epoch since then, and now since the epoch: negative while the epoch is that of the next event, after
    /// the end of a stretch in which nothing happens.
    pub start: f64,
    pub epoch: f64,
    pub now: f64,
    /// Number of epochs that have ended.
    pub epochs: u64,
    /// Length of the previous epoch, or half the length of the one before it, if that is more: predictions are up to three epochs old.
    pub last_reached: f64,
    pub standstill: StandstillWatch,
}

/// An epoch that has moved.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moved {
    /// By how much.
    pub shift: f64,
}

impl Moved {
    /// States from before this time, since the new epoch, have been brought forward.
    pub fn oldest(&self) -> f64 {
        -2.0 * self.shift
    }
}

/// Counts events without time.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct StandstillWatch {
    /// Time at which the count began.
    pub since: f64,
    /// Physical events since then.
    pub events: u64,
    /// More than this many in no time is an arrest.
    pub most: u64,
    /// Approach speed of an inelastic contact that lost it in rounding.
    pub lost_speed: Option<f64>,
}

impl Clock {
    /// At a simulated time, for a number of particles.
    pub fn new(start: f64, particles: usize) -> Self {
        let n = particles as u64;
        let standstill = StandstillWatch {
            since: 0.0,
            events: 0,
            // Simultaneous events of a lattice, and N^2/2 of touching spheres on a line, are no arrest.
            most: 1_000 + 64 * n + (n * n / 2).min(10_000_000),
            lost_speed: None,
        };
        Self { start, epoch: 0.0, now: 0.0, epochs: 0, last_reached: 0.0, standstill }
    }

    /// Whether the neighbour search is reconsidered at this epoch. After the start, densities change slowly.
    pub fn is_looked_at(epochs: u64) -> bool {
        epochs.is_power_of_two() || epochs.is_multiple_of(16)
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Ends the run where events go on without time, or without speed: theory, section 6.
    pub(super) fn check_standstill(&self, particle: u32, prediction: &Prediction) -> Result<(), Arrest> {
        let standstill = match self.clock.standstill.lost_speed {
            Some(approach) => Standstill::Speed { approach },
            None => match self.time_standstill() {
                Some(standstill) => standstill,
                None => return Ok(()),
            },
        };
        let partner = matches!(prediction.contact, Contact::Pair(_)).then_some(prediction.partner);
        Err(Arrest { surface: self.surface_of(prediction), ..self.arrest(particle, partner, standstill) })
    }

    /// Index of the surface that a predicted contact is with; `None` for a pair or a wall of the box.
    fn surface_of(&self, prediction: &Prediction) -> Option<u32> {
        let index = (prediction.contact == Contact::Surface).then_some(prediction.partner_events)?;
        self.sources.surfaces.get(index)?.number.checked_sub(FIRST_SURFACE)
    }

    #[inline]
    fn time_standstill(&self) -> Option<Standstill> {
        let StandstillWatch { events, most, .. } = self.clock.standstill;
        (events > most).then_some(Standstill::Time { events })
    }

    /// Ends the run where events go on without time.
    #[inline]
    pub(super) fn check_time_stands_still(&self, particle: u32, partner: Option<u32>) -> Result<(), Arrest> {
        self.time_standstill().map_or(Ok(()), |standstill| Err(self.arrest(particle, partner, standstill)))
    }

    /// The arrest by a storm of events, at the contact that comes next; none where no contact is foreseen.
    pub fn storm(&self, events: u64, advance: f64) -> Option<Arrest> {
        let all = (0..).zip(&self.schedule.predictions);
        let next = all.min_by(|(_, one), (_, other)| one.contact_time.total_cmp(&other.contact_time));
        let (particle, prediction) = next.filter(|(_, prediction)| prediction.contact_time < f64::INFINITY)?;
        let partner = matches!(prediction.contact, Contact::Pair(_)).then_some(prediction.partner);
        let arrest = self.arrest(particle, partner, Standstill::Storm { events, advance });
        Some(Arrest { surface: self.surface_of(prediction), ..arrest })
    }

    #[cold]
    fn arrest(&self, particle: u32, partner: Option<u32>, standstill: Standstill) -> Arrest {
        Arrest {
            particle: self.name(particle),
            partner: partner.map(|partner| self.name(partner)),
            surface: None,
            moving: self.sources.surfaces.moving_at(self.time()),
            has_losses: self.pairs.rules.steps.iter().any(|steps| steps.restitution < 1.0)
                || self.sources.surfaces.dissipate(),
            time: self.time(),
            standstill,
            has_contact_time: self.pairs.contact_times.is_some(),
        }
    }

    /// Time since the start `[time]`.
    #[inline]
    pub fn elapsed(&self) -> f64 {
        self.clock.epoch + self.clock.now
    }

    /// Counts an event, unless time has moved since the last one.
    #[inline]
    pub(super) fn count_standstill(&mut self) {
        if self.clock.now - self.clock.standstill.since > self.schedule.queue.span() * SHORTEST_ADVANCE {
            (self.clock.standstill.since, self.clock.standstill.events) = (self.clock.now, 0);
        } else {
            self.clock.standstill.events += 1;
        }
    }

    /// Moves the epoch to where the queue has come, or further if nothing happens before; none if nothing ever happens.
    ///
    /// Times stay small this way, so that the last event of a long run is as accurate as the first. The shift is a
    /// multiple of a power of two, which most times lose without rounding.
    pub(super) fn move_epoch(&mut self) -> Option<Moved> {
        let next = self.schedule.predictions.iter().map(Prediction::due_time).fold(self.sources.next_global, f64::min);
        if next == f64::INFINITY {
            return None;
        }
        let moved = self.begin_epoch(next);
        self.shift_columns(moved.shift);
        let is_looked_at = Clock::is_looked_at(self.clock.epochs);
        if is_looked_at {
            self.reorder_if_due();
        }
        if !(is_looked_at && self.change_search_if_due()) {
            for particle in self.particles() {
                self.bring_forward(particle, moved.oldest());
            }
        }
        for particle in self.particles() {
            self.enqueue(particle);
        }
        Some(moved)
    }

    /// Moves the epoch of all global state, and empties the queue. The next entry is due at `next`.
    pub(super) fn begin_epoch(&mut self, next: f64) -> Moved {
        let reached = self.schedule.queue.reached();
        self.clock.last_reached = reached.max(0.5 * self.clock.last_reached);
        let shift = reached * (next / reached).floor().max(1.0);
        self.clock.epoch += shift;
        self.clock.now -= shift;
        self.clock.standstill.since -= shift;
        self.shift_sources(shift);
        self.clock.epochs += 1;
        self.schedule.queue.restart();
        Moved { shift }
    }

    /// Brings a particle forward to the epoch if nothing has happened to it since `oldest`; whether it does.
    ///
    /// A state from long ago has its position rounded at the whole distance flown since, with every wrap, and its contact is
    /// predicted from as far away.
    ///
    /// Who comes first decides nothing: others see a particle at the epoch with the same bits before and after.
    pub(super) fn bring_forward(&mut self, particle: u32, oldest: f64) -> bool {
        let is_old = self.state.bodies[particle as usize].time < oldest;
        if is_old {
            self.stream(particle, 0.0);
            if !self.is_static(particle) {
                self.predict_anew(particle, 0.0);
            }
        }
        is_old
    }
}

//! Simulated time. Epochs keep times small and accurate, and a watch detects that time stands still.

use super::parts::Engine;
use super::prediction::{Contact, Prediction, id_of};
use super::surfaces::FIRST_SURFACE;
use super::{Arrest, Standstill};
use crate::model::ParticleId;
use serde::{Deserialize, Serialize};

/// Time stands still if it advances by less than this fraction of the queue's span. The fraction is a few thousand
/// times the round-off of times.
pub(super) const SHORTEST_ADVANCE: f64 = 1.0 / (1_u64 << 40) as f64;

/// Simulated time, counted from an epoch that moves forward.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Clock {
    /// The simulated time is `start + epoch + now`: the start of the run, the epoch since the start, and the time since
    /// the epoch. `now` is negative if the epoch has moved to the next event, but the advance ends before this event.
    pub start: f64,
    pub epoch: f64,
    pub now: f64,
    pub epochs: u64,
    /// Length `l` of recent epochs. An epoch of length `e` changes `l` to `max(e, l / 2)`. Predictions can be up to
    /// three epochs old.
    pub last_reached: f64,
    pub standstill: StandstillWatch,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Moved {
    /// Difference between the new and the old epoch.
    pub shift: f64,
}

impl Moved {
    /// Returns the oldest permitted time of a state, counted from the new epoch. Older states are streamed to the
    /// epoch.
    pub fn oldest(&self) -> f64 {
        -2.0 * self.shift
    }
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct StandstillWatch {
    /// Time since the epoch at which the count of events began.
    pub since: f64,
    pub events: u64,
    /// Largest number of events without an advance of time. A larger number is a dynamical arrest.
    pub most: u64,
    /// Approach speed of a contact whose speed was lost to rounding, if any.
    pub lost_speed: Option<f64>,
}

impl Clock {
    pub fn new(start: f64, particles: usize) -> Self {
        let standstill = StandstillWatch { since: 0.0, events: 0, most: 0, lost_speed: None };
        let mut clock = Self { start, epoch: 0.0, now: 0.0, epochs: 0, last_reached: 0.0, standstill };
        clock.watch_for(particles);
        clock
    }

    /// Sets the largest permitted number of events without an advance of time.
    ///
    /// A lattice has simultaneous events, and `N` touching spheres on a line have `N^2 / 2` events.
    pub fn watch_for(&mut self, particles: usize) {
        let n = particles as u64;
        self.standstill.most = 1_000 + 64 * n + (n * n / 2).min(10_000_000);
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Returns an arrest if events continue while time stands still, or if the speed of a contact was lost to rounding.
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

    /// Index of the surface of a predicted contact; `None` for a pair or a wall of the box.
    fn surface_of(&self, prediction: &Prediction) -> Option<u32> {
        let index = (prediction.contact == Contact::Surface).then_some(prediction.partner_version)?;
        self.sources.surfaces.get(index)?.number.checked_sub(FIRST_SURFACE)
    }

    #[inline]
    fn time_standstill(&self) -> Option<Standstill> {
        let StandstillWatch { events, most, .. } = self.clock.standstill;
        (events > most).then_some(Standstill::Time { events })
    }

    #[inline]
    pub(super) fn check_time_stands_still(&self, particle: u32, partner: Option<u32>) -> Result<(), Arrest> {
        self.time_standstill().map_or(Ok(()), |standstill| Err(self.arrest(particle, partner, standstill)))
    }

    /// Returns an arrest that reports an event storm at the next predicted contact; `None` if no contact is predicted.
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
            particle: self.id(particle),
            partner: partner.map(|partner| ParticleId(id_of(partner, &self.state.bodies))),
            surface: None,
            moving: self.sources.surfaces.moving_at(self.time()),
            has_losses: self.pairs.rules.steps.iter().any(|steps| steps.law.dissipates())
                || self.sources.surfaces.dissipate(),
            time: self.time(),
            standstill,
            has_contact_time: self.pairs.contact_times.is_some(),
        }
    }

    /// Time since the start of the run `[time]`.
    #[inline]
    pub fn elapsed(&self) -> f64 {
        self.clock.epoch + self.clock.now
    }

    #[inline]
    pub(super) fn count_standstill(&mut self) {
        if self.clock.now - self.clock.standstill.since > self.schedule.queue.span() * SHORTEST_ADVANCE {
            (self.clock.standstill.since, self.clock.standstill.events) = (self.clock.now, 0);
        } else {
            self.clock.standstill.events += 1;
        }
    }

    /// Starts the next epoch, and skips epochs without predicted events. Returns `None` if no event is predicted.
    ///
    /// Times since the epoch stay small, so the last event of a long run is as accurate as the first. The shift is a
    /// multiple of a power of two, so most times are shifted without rounding.
    pub(super) fn move_epoch(&mut self) -> Option<Moved> {
        let moved = self.start_epoch()?;
        for particle in self.particles() {
            self.enqueue(particle);
        }
        Some(moved)
    }

    /// Like [`Self::move_epoch`], but the queue stays empty.
    pub(super) fn start_epoch(&mut self) -> Option<Moved> {
        let next = self.schedule.predictions.iter().map(Prediction::due_time).fold(self.sources.next_global, f64::min);
        if next == f64::INFINITY {
            return None;
        }
        let moved = self.begin_epoch(next);
        self.shift_columns(moved.shift);
        let is_looked_at = self.is_layout_looked_at(self.clock.epochs);
        if is_looked_at {
            self.reorder_if_due();
        }
        if !(is_looked_at && self.change_search_if_due()) {
            for particle in self.particles() {
                self.bring_forward(particle, moved.oldest());
            }
        }
        Some(moved)
    }

    /// Whether the memory layout and the neighbour search are reconsidered at an epoch: often at the start, rarely
    /// later, and if the number of particles has changed much.
    pub(super) fn is_layout_looked_at(&self, epochs: u64) -> bool {
        epochs.is_power_of_two() || epochs.is_multiple_of(16) || self.is_search_outgrown()
    }

    /// Begins the epoch of the event at the time `next`, and empties the queue.
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
        self.schedule.queue.fit_to(self.state.moving);
        Moved { shift }
    }

    /// Streams a particle to the epoch if its state is older than `oldest`. Returns true in this case.
    ///
    /// Rounding errors grow with the distance that a particle has flown since its state was written. The order in which
    /// particles are streamed does not matter: their states at the epoch are the same before and after, bit for bit.
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

//! The share of a thread: the steps in its slab and in its strip.

use super::geometry::{Geometry, Slab};
use super::places::Places;
use super::rooms::Rooms;
use crate::Vector;
use crate::engine::domains::log::Log;
use crate::engine::domains::outcome::Times;
use crate::engine::event_loop::Next;
use crate::engine::marks::Marks;
use crate::engine::parts::{Counts, Engine};
use crate::engine::predict::Scratch;
use crate::engine::prediction::{FIRST_ABSENT, Prediction};
use crate::engine::schedule::{EventQueue, QueueEntry};

/// Depth up to which the steps of slabs are recorded to find conflicts, in units of the distance at which steps are
/// held back around a step that is held back.
const RECORDED: f64 = 4.0;

/// Largest number of steps of a thread in a phase. It limits the memory for undoing the window.
const MOST_STEPS: u64 = 100_000;

/// What a thread keeps from window to window.
#[derive(Debug, Clone)]
pub struct Part {
    /// Entries of the particles in the slab.
    pub queue: EventQueue,
    /// The particles in the slab.
    pub held: Marks,
    /// Empty between phases.
    pub of_strip: EventQueue,
    pub rooms: Rooms,
    /// Event counts of the window, and of earlier windows since the last transfer to the engine.
    pub counts: Box<Counts>,
    pub total: Box<Counts>,
    /// Counts of no events.
    pub none: Box<Counts>,
    pub scratch: Option<Box<Scratch>>,
    /// False until the queue has been filled.
    pub is_filled: bool,
}

impl Part {
    pub fn new(queue: EventQueue, of_strip: EventQueue, none: Counts) -> Self {
        let none = Box::new(none);
        Self {
            queue,
            of_strip,
            held: Marks::default(),
            rooms: Rooms::default(),
            counts: none.clone(),
            total: none.clone(),
            none,
            scratch: None,
            is_filled: false,
        }
    }
}

/// What a thread does in a phase of a window.
#[derive(Debug, Default)]
pub struct Phase {
    pub log: Log,
    pub times: Times,
    pub steps: u64,
    /// Time of the last step.
    pub latest: f64,
    /// Entries of steps that another thread or a later phase has to execute, with the coordinates of their particles.
    pub held_back: Vec<(QueueEntry, f64)>,
    /// Particles with a step, and their coordinates. Only for strips and for the last phase.
    pub touched: Vec<(u32, f64)>,
    /// Places and times of steps that may conflict with the steps of a later phase.
    pub places: Vec<(Vector, f64, f64)>,
    /// Whether a step came too late, after another thread had executed a later step nearby.
    pub has_conflict: bool,
    /// Whether the thread could not continue, for example because memory must be enlarged.
    pub is_stuck: bool,
    /// Whether the window has too many steps.
    pub is_too_long: bool,
}

impl Phase {
    pub fn new() -> Self {
        Self { latest: f64::NEG_INFINITY, ..Self::default() }
    }

    pub fn clear(&mut self) {
        self.log.clear();
        self.times.clear();
        (self.steps, self.latest) = (0, f64::NEG_INFINITY);
        self.held_back.clear();
        self.touched.clear();
        self.places.clear();
        (self.has_conflict, self.is_stuck, self.is_too_long) = (false, false, false);
    }
}

/// Where and until when a thread executes steps.
#[derive(Clone, Copy)]
pub struct Task<'a> {
    pub geometry: &'a Geometry,
    pub region: &'a Slab,
    pub stop: f64,
    /// Number of the phase: 0 for slabs, 1 for strips, 2 for the rest.
    pub phase: usize,
    /// True if the last phase executes all steps.
    pub is_alone: bool,
}

/// Steps that limit the steps of a thread.
pub struct Around<'a> {
    /// Steps that are held back in this phase.
    pub held_back: &'a mut Places,
    /// Steps of earlier phases.
    pub earlier: &'a Places,
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Runs a phase up to and including the time `stop`. The steps near the faces of the region, and near steps that
    /// are held back, are held back.
    pub(super) fn run_phase(&mut self, task: &Task<'_>, around: Around<'_>, phase: &mut Phase) {
        let is_plain = self.changes_motions_and_pairs_only();
        let Around { held_back, earlier } = around;
        while !phase.has_conflict && !phase.is_stuck {
            let entry = match self.next_due(task.stop) {
                Next::Particle(entry) => entry,
                Next::Void => {
                    self.schedule.queue.discard();
                    continue;
                }
                // A window never extends beyond its epoch, and has no global events.
                Next::Limit | Next::Epoch | Next::GlobalEvent => break,
            };
            let particle = entry.particle;
            let prediction = self.schedule.predictions[particle as usize];
            let along = task.geometry.along(self, particle);
            let depth = task.region.depth(along);
            if self.is_held_back(particle, &prediction, depth, task, held_back) {
                self.schedule.queue.discard();
                phase.held_back.push((entry, along));
                continue;
            }
            if phase.steps >= MOST_STEPS {
                phase.is_too_long = true;
                break;
            }
            if self.must_grow(particle, &prediction) {
                phase.is_stuck = true;
                break;
            }
            self.schedule.queue.pop();
            self.clock.now = entry.time;
            phase.steps += 1;
            phase.latest = entry.time;
            let before = task.records(depth).then(|| task.geometry.place(self, particle));
            let partner = self.partner_of(&prediction);
            let is_done = if prediction.is_transition() {
                phase.times.quiet.push(entry.time);
                phase.log.transition(self, particle, entry.time)
            } else {
                self.meet_logged(particle, partner, &prediction, is_plain, phase)
            };
            phase.is_stuck = !is_done;
            if let Some(before) = before {
                let after = prediction.is_transition().then_some(particle).or(partner);
                let places = [Some(before), after.map(|other| task.geometry.place(self, other))];
                for place in places.into_iter().flatten() {
                    phase.has_conflict |= task.phase > 0 && !task.is_alone && !task.knows(&place);
                    phase.has_conflict |= earlier.has_near(&place, entry.time);
                    phase.places.push((place, entry.time, depth));
                }
            }
            if task.phase > 0 {
                phase.touched.push((particle, task.geometry.along(self, particle)));
                phase.touched.extend(partner.map(|partner| (partner, task.geometry.along(self, partner))));
            }
        }
    }

    /// Executes a contact, and saves what it changes. Returns false if the thread cannot continue.
    #[inline(always)]
    fn meet_logged(
        &mut self,
        particle: u32,
        partner: Option<u32>,
        prediction: &Prediction,
        is_plain: bool,
        phase: &mut Phase,
    ) -> bool {
        let time = self.clock.now;
        let is_void = self.is_void(prediction);
        if !is_void && let Some(partner) = partner {
            phase.log.contact(self, partner, is_plain);
        }
        phase.log.contact(self, particle, is_plain);
        if is_void {
            self.repredict(particle, time);
            return true;
        }
        let executed = self.execute_contact(particle, prediction, &mut None);
        phase.times.event(time);
        matches!(executed, Ok(Some(_))) && self.clock.standstill.lost_speed.take().is_none()
    }

    /// Whether a step may have to enlarge an array, which threads cannot do.
    #[inline]
    fn must_grow(&self, particle: u32, prediction: &Prediction) -> bool {
        if prediction.is_transition() {
            return self.neighbours.is_short(particle) || self.state.images.is_full(particle);
        }
        TABLE && {
            let partner = self.partner_of(prediction);
            let is_full = |particle: u32| self.pairs.states.is_full(particle);
            is_full(particle) || partner.is_some_and(is_full) || self.neighbours.is_short(particle)
        }
    }

    #[inline]
    fn partner_of(&self, prediction: &Prediction) -> Option<u32> {
        if prediction.is_transition() {
            return None;
        }
        prediction.partner_in_contact().filter(|partner| *partner < FIRST_ABSENT && !self.is_static(*partner))
    }

    /// Whether a step is held back. If it is, its place is added to `held_back`.
    #[inline]
    fn is_held_back(
        &self,
        particle: u32,
        prediction: &Prediction,
        depth: f64,
        task: &Task<'_>,
        held_back: &mut Places,
    ) -> bool {
        let geometry = task.geometry;
        let near = geometry.around_held.along(geometry.axis);
        if task.is_alone {
            return task.phase < 2;
        }
        let met = self.partner_of(prediction);
        // Another thread may change a partner that is not in the slab.
        let is_bound = met.is_some_and(|met| !self.schedule.has(met) || held_back.holds(met));
        if !is_bound && depth > geometry.of_transition.max(held_back.deepest) + 3.0 * near {
            return false;
        }
        let is_transition = prediction.is_transition();
        let least = if is_transition { geometry.of_transition } else { geometry.of_contact };
        let mut is_held_back = is_bound || depth < least;
        // The place of a partner may be read only if no other thread can change it.
        let can_read = |partner: &u32| match &self.schedule.part {
            Some(part) => part.has(*partner),
            None => depth >= geometry.reach.along(geometry.axis),
        };
        let partner = met.filter(can_read);
        let partner = partner.map(|partner| (partner, task.region.depth(geometry.along(self, partner))));
        is_held_back |= partner.is_some_and(|(_, depth)| depth < least);
        let others = [Some((particle, depth)), partner].into_iter().flatten();
        if !is_held_back && !held_back.is_empty() {
            is_held_back = others.clone().any(|(particle, depth)| {
                depth < held_back.deepest + near
                    && held_back.has_near(&geometry.place(self, particle), f64::NEG_INFINITY)
            });
        }
        if is_held_back {
            for (particle, depth) in others {
                held_back.hold(particle);
                held_back.add(&geometry.place(self, particle), 0.0, depth);
            }
        }
        is_held_back
    }
}

impl Task<'_> {
    /// Whether the places of a step at this depth are recorded.
    #[inline]
    fn records(&self, depth: f64) -> bool {
        let geometry = self.geometry;
        self.phase > 0 || depth < geometry.of_transition + RECORDED * geometry.around_held.along(geometry.axis)
    }

    /// Whether all steps of slabs near a place are recorded.
    fn knows(&self, place: &Vector) -> bool {
        let geometry = self.geometry;
        let along = place[geometry.axis];
        let slab = &geometry.slabs[geometry.slab_of(along)];
        let recorded = geometry.of_transition + RECORDED * geometry.around_held.along(geometry.axis);
        // The place of a step may be recorded for the other particle of the step.
        let needed = 2.0 * geometry.reach.along(geometry.axis);
        slab.is_within(recorded - needed) || slab.depth(along) < recorded - needed
    }
}

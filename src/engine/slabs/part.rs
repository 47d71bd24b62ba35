//! The share of a thread: the steps in its slab and in its strip.

use super::covered::Covered;
use super::geometry::{Geometry, Slab};
use super::places::Places;
use super::rooms::Rooms;
use crate::Vector;
use crate::engine::event::Event;
use crate::engine::event_loop::Next;
use crate::engine::marks::Marks;
use crate::engine::observe::Observe;
use crate::engine::parts::{Counts, Engine};
use crate::engine::predict::Scratch;
use crate::engine::prediction::{FIRST_ABSENT, Prediction};
use crate::engine::progress::{Seen, Times};
use crate::engine::schedule::{EventQueue, QueueEntry};
use crate::engine::sources::andersen::Collision;
use crate::engine::undo_log::UndoLog;
use std::ops::ControlFlow;

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
    pub own: Marks,
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
            own: Marks::default(),
            rooms: Rooms::default(),
            counts: none.clone(),
            total: none.clone(),
            none,
            scratch: None,
            is_filled: false,
        }
    }
}

/// A predicted step that is held back.
#[derive(Debug, Clone, Copy)]
pub struct HeldBack {
    pub entry: QueueEntry,
    /// Coordinate of the particle along the axis that is cut.
    pub along: f64,
    /// Whether the step is a contact of two particles whose places are known.
    pub is_covered: bool,
}

/// What a thread does in a phase of a window.
#[derive(Debug, Default)]
pub struct Phase {
    pub log: UndoLog,
    pub times: Times,
    pub steps: u64,
    /// Number of collisions with the heat bath, which are not counted as steps.
    pub baths: u64,
    /// Time of the last step.
    pub latest: f64,
    /// Steps that another thread or a later phase has to execute.
    pub held_back: Vec<HeldBack>,
    /// Collisions with the heat bath that are held back, and the coordinates of their particles.
    pub collisions: Vec<(Collision, f64)>,
    /// Events for the observer.
    pub seen: Vec<Seen>,
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
        (self.steps, self.baths, self.latest) = (0, 0, f64::NEG_INFINITY);
        self.held_back.clear();
        self.collisions.clear();
        self.seen.clear();
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
    /// Whether events are recorded for an observer.
    pub is_observed: bool,
    /// Whether contacts change only motions, predictions and captured pairs.
    pub is_plain: bool,
}

/// Steps that limit the steps of a thread.
pub struct Around<'a> {
    /// Steps that are held back in this phase.
    pub held_back: &'a mut Places,
    /// Steps of earlier phases.
    pub earlier: &'a Places,
    /// Contacts that do not conflict with them.
    pub covered: &'a mut Covered,
}

/// The next step of a phase.
struct Due {
    particle: u32,
    time: f64,
    /// A particle that the step changes, too.
    partner: Option<u32>,
    /// Coordinate of the particle along the axis that is cut, and its depth in the region.
    along: f64,
    depth: f64,
    step: Step,
}

enum Step {
    Predicted(QueueEntry, Prediction),
    Bath(Collision),
}

impl Due {
    #[inline]
    fn is_transition(&self) -> bool {
        matches!(&self.step, Step::Predicted(_, prediction) if prediction.is_transition())
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Runs a phase up to and including the time `stop`. Holds back steps near the faces of the region, and steps near
    /// other steps that it has held back. `collisions` with the heat bath are in the order of their times.
    pub(super) fn run_phase(
        &mut self,
        task: &Task<'_>,
        around: Around<'_>,
        collisions: impl IntoIterator<Item = Collision>,
        phase: &mut Phase,
    ) {
        let Around { held_back, earlier, covered } = around;
        let mut collisions = collisions.into_iter().peekable();
        while !phase.has_conflict && !phase.is_stuck {
            let entry = match self.next_due(task.stop) {
                Next::Particle(entry) => Some(entry),
                Next::Void => {
                    self.schedule.queue.discard();
                    continue;
                }
                // A window never extends beyond its epoch. Collisions with the heat bath are drawn before each window,
                // and there are no other global events.
                Next::Stop | Next::Epoch | Next::GlobalEvent => None,
            };
            let next = entry.map_or(f64::INFINITY, |entry| entry.time);
            let collision = collisions.next_if(|collision| collision.time < next);
            let Some(due) = self.due_step(entry, collision, task) else { break };
            if self.is_held_back(&due, task, held_back) {
                match due.step {
                    Step::Predicted(entry, prediction) => {
                        self.schedule.queue.discard();
                        let is_known = due.partner.is_none_or(|partner| self.schedule.has(partner));
                        let is_covered = task.phase == 0 && is_known && !prediction.is_transition();
                        phase.held_back.push(HeldBack { entry, along: due.along, is_covered });
                    }
                    Step::Bath(collision) => phase.collisions.push((collision, due.along)),
                }
                continue;
            }
            if phase.steps + phase.baths >= MOST_STEPS {
                phase.is_too_long = true;
                break;
            }
            if self.must_grow(&due) {
                phase.is_stuck = true;
                break;
            }
            self.run_step(&due, task, (earlier, covered), phase);
        }
    }

    /// Returns the collision with the heat bath, or else the step of an entry.
    #[inline(always)]
    fn due_step(&self, entry: Option<QueueEntry>, collision: Option<Collision>, task: &Task<'_>) -> Option<Due> {
        let (particle, time, partner, step) = match (collision, entry) {
            (Some(collision), _) => (self.state.numbers[collision.id], collision.time, None, Step::Bath(collision)),
            (None, Some(entry)) => {
                let prediction = self.schedule.predictions[entry.particle as usize];
                (entry.particle, entry.time, self.partner_of(&prediction), Step::Predicted(entry, prediction))
            }
            (None, None) => return None,
        };
        let along = task.geometry.along(self, particle);
        Some(Due { particle, time, partner, along, depth: task.region.depth(along), step })
    }

    /// Executes a step, and records what other phases and the observer need.
    #[inline(always)]
    fn run_step(&mut self, due: &Due, task: &Task<'_>, (earlier, covered): (&Places, &mut Covered), phase: &mut Phase) {
        let &Due { particle, time, partner, along: _, depth, ref step } = due;
        let before = task.records(depth).then(|| task.geometry.place(self, particle));
        self.clock.now = time;
        phase.latest = time;
        let is_done = match step {
            Step::Predicted(_, prediction) => {
                self.schedule.queue.pop();
                phase.steps += 1;
                if prediction.is_transition() {
                    phase.times.quiet.push(time);
                    phase.log.execute_transition(self, particle, time)
                } else {
                    self.meet_logged(due, prediction, task, phase)
                }
            }
            Step::Bath(collision) => self.meet_bath_logged(particle, collision, task, phase),
        };
        phase.is_stuck = !is_done;
        if let Some(before) = before {
            let after = if due.is_transition() { Some(particle) } else { partner };
            let places = [Some(before), after.map(|other| task.geometry.place(self, other))];
            let is_covered = task.phase == 1 && covered.has(particle, partner);
            for place in places.into_iter().flatten() {
                if task.phase > 0 && !is_covered {
                    phase.has_conflict |= !task.is_alone && !task.knows(&place);
                    phase.has_conflict |= earlier.has_near(&place, time);
                }
                phase.places.push((place, time, depth));
            }
        }
        if task.phase > 0 {
            [Some(particle), partner].into_iter().flatten().for_each(|particle| covered.change(particle));
            phase.touched.push((particle, task.geometry.along(self, particle)));
            phase.touched.extend(partner.map(|partner| (partner, task.geometry.along(self, partner))));
        }
    }

    /// Executes a contact, and saves what it changes. Returns false if the thread cannot continue.
    #[inline(always)]
    fn meet_logged(&mut self, due: &Due, prediction: &Prediction, task: &Task<'_>, phase: &mut Phase) -> bool {
        let &Due { particle, time, partner, .. } = due;
        let is_void = self.is_void(prediction);
        if !is_void && let Some(partner) = partner {
            phase.log.contact(self, partner, task.is_plain);
        }
        phase.log.contact(self, particle, task.is_plain);
        if is_void {
            self.repredict(particle, time);
            return true;
        }
        let mut see = record(time, &mut phase.seen);
        let mut observe: Observe<'_> = if task.is_observed { Some(&mut see) } else { None };
        let executed = self.execute_contact(particle, prediction, &mut observe);
        phase.times.event(time);
        matches!(executed, Ok(Some(_))) && self.clock.standstill.lost_speed.take().is_none()
    }

    /// Executes a collision with the heat bath, and saves what it changes.
    #[cold]
    #[inline(never)]
    fn meet_bath_logged(&mut self, particle: u32, collision: &Collision, task: &Task<'_>, phase: &mut Phase) -> bool {
        phase.baths += 1;
        phase.log.contact(self, particle, task.is_plain);
        let mut see = record(collision.time, &mut phase.seen);
        let mut observe: Observe<'_> = if task.is_observed { Some(&mut see) } else { None };
        let _ = self.collide(particle, collision, &mut observe);
        self.repredict(particle, collision.time);
        true
    }

    /// Whether a step may have to enlarge an array, which threads cannot do.
    #[inline]
    fn must_grow(&self, due: &Due) -> bool {
        let particle = due.particle;
        if due.is_transition() {
            return self.neighbours.is_short(particle) || self.state.images.is_full(particle);
        }
        TABLE && {
            let is_full = |particle: u32| self.pairs.states.is_full(particle);
            is_full(particle) || due.partner.is_some_and(is_full) || self.neighbours.is_short(particle)
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
    fn is_held_back(&self, due: &Due, task: &Task<'_>, held_back: &mut Places) -> bool {
        let geometry = task.geometry;
        let near = geometry.around_held.along(geometry.axis);
        if task.is_alone {
            return task.phase < 2;
        }
        let &Due { particle, partner: met, depth, .. } = due;
        // Another thread may change a partner that is not in the slab.
        let is_bound = met.is_some_and(|met| !self.schedule.has(met) || held_back.holds(met));
        if !is_bound && depth > geometry.of_transition.max(held_back.deepest) + 3.0 * near {
            return false;
        }
        let least = if due.is_transition() { geometry.of_transition } else { geometry.of_contact };
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

/// Returns an observer that records the events at a time.
fn record(time: f64, seen: &mut Vec<Seen>) -> impl FnMut(&Event) -> ControlFlow<()> {
    move |event| {
        seen.push(Seen { time, event: *event });
        ControlFlow::Continue(())
    }
}

impl Task<'_> {
    /// Whether the places of a step at this depth are recorded.
    #[inline]
    fn records(&self, depth: f64) -> bool {
        self.phase > 0 || depth < self.recorded()
    }

    /// Depth up to which the steps of slabs are recorded.
    fn recorded(&self) -> f64 {
        let geometry = self.geometry;
        geometry.of_transition + RECORDED * geometry.around_held.along(geometry.axis)
    }

    /// Whether all steps of slabs near a place are recorded.
    fn knows(&self, place: &Vector) -> bool {
        let geometry = self.geometry;
        let along = place[geometry.axis];
        let slab = &geometry.slabs[geometry.slab_of(along)];
        // A step is recorded if the first of its two particles is near enough to a face.
        let least = self.recorded() - 2.0 * geometry.reach.along(geometry.axis);
        slab.is_within(least) || slab.depth(along) < least
    }
}

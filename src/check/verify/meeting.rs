//! Checks that the current event was due and has the right outcome.

use super::approach::{Approach, Boundary};
use super::bounds::{Bounds, Flight, is_without_digits};
use super::certificate::note;
use super::contact::Contact;
use super::moving::{Beside, Carried};
use super::outcome::Encounter;
use super::rules::{Side, Step};
use super::verifier::Verifier;
use super::violation::Fault;
use super::window::wall_approach;
use crate::check::reference::{Motion, Touch};
use crate::engine::States;
use crate::engine::event::{Event, Outcome};
use crate::model::ContactLaw;

/// A particle at a feature of a surface, with the data needed to check the event.
struct Meeting {
    approach: Approach,
    bounds: Bounds,
    touch: Touch,
    carried: Carried,
}

impl Meeting {
    fn has_foot(&self) -> bool {
        self.approach.foot.is_none_or(|foot| foot.within(0.0) >= -self.bounds.distance)
    }

    fn gap(&self) -> f64 {
        self.approach.gap_now()
    }

    fn is_in_contact(&self) -> bool {
        self.gap() <= self.bounds.distance
    }
}

impl Verifier {
    pub(super) fn flight(&self, i: u32) -> Flight {
        Flight::new(&self.world, &self.before, i, &self.last_event[i as usize], &self.window.origin)
    }

    pub(super) fn flights(&self, contact: &Contact) -> [Flight; 2] {
        match contact {
            Contact::Pair(pair) => pair.map(|id| self.flight(id.0)),
            Contact::Wall { particle, .. } => [self.flight(particle.0), Flight::NONE],
            Contact::Surface { particle, surface } => {
                let motion = self.world.motion(&self.before, particle.0);
                let sway = self.world.motions.sway_beside(*surface, motion, &self.before.elapsed);
                [self.flight(particle.0), Flight::of_surface(self.world.farthest_facet, &sway)]
            }
        }
    }

    pub(super) fn bounds(&self, contact: &Contact, approach: &Approach, flights: &[Flight; 2]) -> Bounds {
        match (contact, approach.boundary) {
            (Contact::Pair(_) | Contact::Surface { .. }, Boundary::Sphere { distance, .. }) => {
                Bounds::pair(&self.world, &flights[0], &flights[1], distance)
            }
            (contact, _) => {
                let radius = contact.particles().next().map_or(0.0, |i| self.world.radius(i));
                match contact {
                    Contact::Surface { .. } => {
                        let slenderness = approach.foot.map_or(1.0, |foot| foot.slenderness);
                        Bounds::plane(&flights[0], &flights[1], radius, slenderness)
                    }
                    _ => Bounds::wall(&flights[0], self.world.farthest_wall, radius),
                }
            }
        }
    }

    pub(super) fn check_pair(
        &mut self,
        event: &Event,
        contact: Contact,
        outcome: Outcome,
        after: &States,
    ) -> Result<(), Fault> {
        let (i, j) = (event.particle.0, event.partner().unwrap_or(event.particle).0);
        let state = self.pairs.get(i, j).unwrap_or(0);
        let Some((side, seen, law)) = self.seen(event, outcome, i, j, state) else {
            return Err(Fault::Unknown { contact, distance: event.distance, state });
        };
        let (now, boundary) =
            (self.window.time(&self.before.elapsed), Boundary::Sphere { distance: seen.distance, side });
        let approach = Approach::of_pair(&self.world, &self.before, [i, j], now, boundary);
        let flights = [i, j].map(|particle| self.flight(particle));
        let bounds = self.bounds(&contact, &approach, &flights);
        self.check_contact(contact, &approach, &bounds, seen.distance)?;
        self.encounter(event, after, bounds, flights).check_pair(j, side, &seen, &law, outcome)?;
        if seen.is_barrier() {
            self.note_contact(&[i, j], after, false);
        }
        match outcome {
            Outcome::Core => self.proof.counts.core += 1,
            Outcome::Bounce => self.proof.counts.bounce += 1,
            Outcome::Capture => {
                self.proof.counts.capture += 1;
                self.pairs.set(i, j, state + 1);
            }
            Outcome::Release if state == 1 && !self.world.is_bonded(i, j) => {
                self.proof.counts.release += 1;
                self.pairs.forget(i, j);
            }
            Outcome::Release => {
                self.proof.counts.release += 1;
                self.pairs.set(i, j, state - 1);
            }
        }
        Ok(())
    }

    /// Returns the discontinuity at the distance of an event, with the side of the pair and the contact law. If both
    /// sides fit, the outcome decides.
    fn seen(&self, event: &Event, outcome: Outcome, i: u32, j: u32, state: usize) -> Option<(Side, Step, ContactLaw)> {
        let interaction = self.world.interaction(i, j).filter(|_| i != j)?;
        let sides = match outcome {
            Outcome::Release => [Side::Negative, Side::Positive],
            Outcome::Core | Outcome::Capture | Outcome::Bounce => [Side::Positive, Side::Negative],
        };
        let seen = sides.into_iter().filter_map(|side| Some((side, Step::seen(&interaction.potential, state, side)?)));
        let (side, seen) = seen.into_iter().find(|(_, seen)| seen.distance == event.distance)?;
        Some((side, seen, interaction.law))
    }

    pub(super) fn check_wall(&mut self, event: &Event, contact: Contact, after: &States) -> Result<(), Fault> {
        let i = event.particle.0;
        let radius = self.world.radius(i);
        let unknown = Fault::Unknown { contact, distance: event.distance, state: 0 };
        let wall = self.world.wall(&contact).filter(|_| event.distance == radius && !self.world.is_static(i));
        let wall = wall.ok_or(unknown)?;
        let now = self.window.time(&self.before.elapsed);
        let approach = wall_approach(&self.world, &self.before, i, &wall, now);
        let flights = self.flights(&contact);
        let bounds = self.bounds(&contact, &approach, &flights);
        // A point particle has no radius, so its gap is compared with 1.
        self.check_contact(contact, &approach, &bounds, if radius > 0.0 { radius } else { 1.0 })?;
        self.encounter(event, after, bounds, flights).check_wall(&wall)?;
        self.note_contact(&[i], after, false);
        self.proof.counts.wall += 1;
        Ok(())
    }

    pub(super) fn check_surface(&mut self, event: &Event, contact: Contact, after: &States) -> Result<(), Fault> {
        let i = event.particle.0;
        let unknown = Fault::Unknown { contact, distance: event.distance, state: 0 };
        let Contact::Surface { surface, .. } = contact else { return Err(unknown) };
        let is_its = event.distance == self.world.radius(i);
        let law = self.world.law_of_surface(i, surface).filter(|_| is_its).ok_or(unknown)?;
        let meetings = self.meetings(contact, surface);
        let (proof, mut fault) = (self.proof, None);
        for meeting in meetings {
            if fault.is_some() && !meeting.is_in_contact() {
                break;
            }
            match self.check_meeting(event, after, &meeting, &law) {
                Ok(()) => {
                    self.note_contact(&[i], after, self.world.velocity_of_surface(surface).is_some());
                    self.proof.counts.surface += 1;
                    return Ok(());
                }
                Err(found) => fault = fault.or(Some(found)),
            }
            self.proof = proof;
        }
        Err(fault.unwrap_or(unknown))
    }

    /// Returns the features of a surface that a particle may touch, nearest first. Rounding decides which feature the
    /// engine uses. If none is near, returns all features onto which the particle projects, for the error message.
    fn meetings(&self, contact: Contact, surface: u32) -> Vec<Meeting> {
        let Some(i) = contact.particles().next() else { return Vec::new() };
        let motion = self.world.motion(&self.before, i);
        let beside = self.world.motions.beside(surface, motion, &self.before.elapsed);
        let beside: Vec<(Beside<'_>, Motion)> = beside.into_iter().map(|beside| (beside, beside.seen())).collect();
        let near = self.meetings_beside(contact, surface, &beside, false);
        if near.is_empty() { self.meetings_beside(contact, surface, &beside, true) } else { near }
    }

    fn meetings_beside(
        &self,
        contact: Contact,
        surface: u32,
        beside: &[(Beside<'_>, Motion)],
        are_all: bool,
    ) -> Vec<Meeting> {
        let (now, flights) = (self.window.time(&self.before.elapsed), self.flights(&contact));
        let mut on = Vec::new();
        for facet in self.world.facets.iter().filter(|facet| facet.surface == surface) {
            for (beside, _) in beside.iter().filter(|(beside, seen)| are_all || facet.is_near(seen, beside)) {
                let approach = facet.approach_in(beside.piece, &beside.motion, beside.now, now);
                let bounds = self.bounds(&contact, &approach, &flights);
                let carried = beside.carried(facet, self.world.velocity_of_surface(surface), &bounds);
                on.push(Meeting { approach, bounds, touch: beside.contact(facet), carried });
            }
        }
        on.retain(Meeting::has_foot);
        on.sort_by(|a, b| a.gap().abs().total_cmp(&b.gap().abs()));
        on
    }

    fn check_meeting(
        &mut self,
        event: &Event,
        after: &States,
        meeting: &Meeting,
        law: &ContactLaw,
    ) -> Result<(), Fault> {
        let (i, contact) = (event.particle.0, Contact::of(event));
        let radius = self.world.radius(i);
        let unit = if radius > 0.0 { radius } else { 1.0 };
        self.check_contact(contact, &meeting.approach, &meeting.bounds, unit)?;
        let flights = self.flights(&contact);
        self.encounter(event, after, meeting.bounds, flights).check_surface(&meeting.touch, law, &meeting.carried)
    }

    fn note_contact(&mut self, particles: &[u32], now: &States, is_driven: bool) {
        if let Some(contacts) = &mut self.contacts {
            // Only moving particles have a last contact time in the TC model.
            let moving: Vec<u32> =
                particles.iter().copied().filter(|&particle| !self.world.is_static(particle)).collect();
            contacts.note(&moving, &now.elapsed);
            if let Some(sleep) = &mut self.sleep {
                sleep.note(&moving, is_driven);
            }
        }
    }

    fn encounter<'a>(
        &'a mut self,
        event: &'a Event,
        after: &'a States,
        bounds: Bounds,
        flights: [Flight; 2],
    ) -> Encounter<'a> {
        let Self { world, before, proof, contacts, .. } = self;
        Encounter { world, event, before, after, bounds, flights, contacts, margins: &mut proof.margins }
    }

    /// Checks that the event was due: the particles were at the discontinuity and approached it, within round-off.
    fn check_contact(
        &mut self,
        contact: Contact,
        approach: &Approach,
        bounds: &Bounds,
        unit: f64,
    ) -> Result<(), Fault> {
        let (gap, closing, bound) = (approach.gap_now(), approach.closing_now(), bounds.distance);
        if gap.is_nan() || gap > bound {
            return Err(Fault::Early { contact, gap, bound });
        }
        // Because of round-off, an event may be after the minimum of the gap. The gap has then grown by `missed`.
        let missed = closing * closing / (2.0 * approach.curvature());
        if closing < -bounds.normal_velocity && (missed.is_nan() || missed > bound) {
            return Err(Fault::NotClosing { contact, speed: -closing });
        }
        self.proof.counts.turning_points += u64::from(closing <= bounds.normal_velocity);
        self.proof.counts.in_invalid_state += u64::from(gap < -bound);
        // An overlap beyond the bound is permitted: `settle` has checked that it has not grown since the event was due.
        if gap.abs() <= bound {
            if is_without_digits(gap, unit) {
                return Err(Fault::WithoutDigits { contact, by: gap.abs(), distance: unit });
            }
            note(&mut self.proof.margins.distance, gap.abs(), bound);
        }
        self.proof.largest_gap = self.proof.largest_gap.max(gap / unit);
        self.proof.deepest_overlap = self.proof.deepest_overlap.max(-gap / unit);
        Ok(())
    }
}

//! Motion after a contact with an infinite barrier, by restitution and the TC model.

use super::bounds::rounded;
use crate::engine::Elapsed;
use crate::model::TcRule;

/// Relative motion on arrival at a barrier. Each pair of numbers is a value and its uncertainty.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arrival {
    /// Speed after the contact by the coefficient of restitution alone `[length / time]`.
    pub rebound: (f64, f64),
    /// Normal speed towards the barrier; 0 if the particle moves away from it `[length / time]`.
    pub approach: (f64, f64),
    /// Speed along the barrier `[length / time]`.
    pub tangential: (f64, f64),
    /// Acceleration towards the barrier, from forces and from the curvature of the barrier `[length / time^2]`.
    pub closing: (f64, f64),
    /// Acceleration towards the barrier, from forces alone `[length / time^2]`.
    pub closing_at_rest: (f64, f64),
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Leaving {
    /// Speed away from the barrier, with its uncertainty `[length / time]`.
    pub speed: (f64, f64),
    /// Speed along the barrier, with its uncertainty `[length / time]`; `None` if it does not change.
    pub sliding: Option<(f64, f64)>,
    /// Whether a rough barrier exerts a tangential impulse in this contact.
    pub is_rough: bool,
    /// Whether a rough barrier reverses the slip. It does if the contact is elastic or if the particle is at rest.
    pub reverses_slip: bool,
    /// Normal speed up to which the energy lost to friction goes into the normal motion, with its uncertainty
    /// `[length / time]`; 0 if this energy is lost.
    pub fastest: (f64, f64),
    /// Normal speed at which contacts with the same mean force would be one contact time apart: lower bound, computed
    /// value and upper bound `[length / time]`.
    pub rattling: [f64; 3],
}

impl Leaving {
    /// Leaves at this speed, without a gain from friction.
    pub fn at(speed: (f64, f64), sliding: Option<(f64, f64)>, is_rough: bool) -> Self {
        Self { speed, sliding, is_rough, reverses_slip: false, fastest: (0.0, 0.0), rattling: [0.0; 3] }
    }

    /// Returns the motion after a contact with a moving surface, which the particle approached at this speed. A moving
    /// surface supplies energy, so the energy of friction is lost at a smaller slip than at a surface at rest.
    pub fn at_moving_surface(self, (approach, uncertain): (f64, f64)) -> Self {
        let rattling = [-1.0, 0.0, 1.0].map(|sign| {
            let fastest = (self.fastest.0 + sign * self.fastest.1).max(0.0);
            libm::sqrt(fastest * (approach + sign * uncertain).max(0.0))
        });
        Self { rattling, ..self }
    }

    /// Returns the normal speed and its uncertainty. `lost` is the energy lost to friction, divided by the reduced
    /// mass, and `slip` is the speed at which the surfaces slip, each with its uncertainty.
    pub fn speed_with(&self, lost: (f64, f64), slip: (f64, f64)) -> (f64, f64) {
        let ((speed, bound), (fastest, uncertain)) = (self.speed, self.fastest);
        if fastest == 0.0 {
            return self.speed;
        }
        // Grains that slip at up to 4 times the speed `rattling` keep the energy. From 8 times on, it is lost.
        let [slowest, rattling, quickest] = self.rattling;
        let faster = |speed: f64, lost: f64, fastest: f64, (slip, rattling): (f64, f64)| {
            let (speed, slip) = (speed.max(0.0), slip.max(0.0));
            let share = if rattling > 0.0 { (2.0 - slip / (4.0 * rattling)).clamp(0.0, 1.0) } else { 0.0 };
            (speed * speed + 2.0 * share * lost.max(0.0)).sqrt().min(fastest).max(speed)
        };
        let lower = faster(speed - bound, lost.0 - lost.1, fastest - uncertain, (slip.0 + slip.1, slowest));
        let upper = faster(speed + bound, lost.0 + lost.1, fastest + uncertain, (slip.0 - slip.1, quickest));
        let value = faster(speed, lost.0, fastest, (slip.0, rattling));
        (value, (upper - value).max(value - lower) + rounded(value))
    }
}

#[derive(Debug)]
pub(super) struct ContactMemory {
    contact_time: f64,
    /// Whether only the published rule applies: a contact within the contact time is elastic and smooth.
    is_published: bool,
    last: Vec<Last>,
}

#[derive(Debug, Clone, Copy)]
enum Last {
    Never,
    At(Elapsed),
    /// The particle has had no contact since this time. Earlier contacts are unknown.
    Before(Elapsed),
}

/// A contact is sliding if this many contacts would follow each other within one contact time.
const SLIDING: f64 = 64.0;

impl ContactMemory {
    /// If `unknown_before` is given, contacts before that time are unknown. Otherwise, there were no earlier contacts.
    pub fn new(contact_time: f64, particles: usize, unknown_before: Option<Elapsed>) -> Self {
        Self {
            contact_time,
            is_published: false,
            last: vec![unknown_before.map_or(Last::Never, Last::Before); particles],
        }
    }

    pub fn with(self, rule: TcRule) -> Self {
        Self { is_published: rule == TcRule::LudingMcNamara, ..self }
    }

    pub fn note(&mut self, particles: &[u32], now: &Elapsed) {
        for &particle in particles {
            self.last[particle as usize] = Last::At(*now);
        }
    }

    /// Time since the latest contact of one of the particles, with its uncertainty; infinity if there was none. A contact
    /// that is not known may have been at any time since the start of the records.
    fn since(&self, particles: &[u32], now: &Elapsed) -> (f64, f64) {
        let of_this = |&particle: &u32| match self.last[particle as usize] {
            Last::Never => (f64::INFINITY, 0.0),
            Last::At(last) => {
                let since = now.after(&last);
                (since, rounded(since + now.since_epoch.abs().max(last.since_epoch.abs())))
            }
            Last::Before(start) => (now.after(&start), self.contact_time),
        };
        let earliest = |a: (f64, f64), b: (f64, f64)| (a.0.min(b.0), a.1.max(b.1));
        particles.iter().map(of_this).fold((f64::INFINITY, 0.0), earliest)
    }

    /// Whether a particle had a contact less than `t_c` ago; `None` if round-off leaves the answer open.
    fn is_recent(&self, particles: &[u32], now: &Elapsed) -> Option<bool> {
        let is_of_this = |&particle: &u32| match self.last[particle as usize] {
            Last::Never => Some(false),
            Last::At(last) => {
                let since = now.after(&last);
                // The round-off of a time depends on the time since its epoch.
                let bound = rounded(since + now.since_epoch.abs().max(last.since_epoch.abs()));
                let is_close = (since - self.contact_time).abs() <= bound;
                (!is_close).then_some(since < self.contact_time)
            }
            Last::Before(start) => (now.after(&start) > self.contact_time * (1.0 + 1e-9)).then_some(false),
        };
        let each: Vec<Option<bool>> = particles.iter().map(is_of_this).collect();
        [Some(true), None].into_iter().find(|answer| each.contains(answer)).unwrap_or(Some(false))
    }

    /// Returns the possible motions after a contact. There are several if round-off leaves the case open.
    ///
    /// A particle that leaves at the speed `v = closing t_c / 2` returns after the time `t_c`. A particle slower than
    /// `v / SLIDING` slides: at constant energy, it leaves at `2 v / SLIDING`, or at its total speed if that is lower. A
    /// faster contact is elastic if a particle had a contact less than `t_c` ago. Otherwise, the particle loses speed, but
    /// keeps its approach speed up to `v`.
    ///
    /// Let `v0 = closing_at_rest t_c / 2`. A particle with a total speed below `v0 / SLIDING` is at rest, and leaves at
    /// `v0`.
    pub fn leavings(&self, arrival: &Arrival, particles: &[u32], now: &Elapsed) -> Vec<Leaving> {
        let Arrival { rebound, approach, tangential, closing, closing_at_rest } = *arrival;
        let away = |closing: (f64, f64)| {
            let away = (0.5 * closing.0 * self.contact_time).max(0.0);
            (away, 0.5 * closing.1 * self.contact_time + rounded(away))
        };
        let (away, at_rest) = (away(closing), away(closing_at_rest));
        let slowest = (away.0 / SLIDING, away.1 / SLIDING);
        let is_recent = self.is_recent(particles, now);
        let mut leavings = Vec::new();
        if self.is_published {
            leavings.extend((is_recent != Some(false)).then_some(Leaving::at(approach, None, false)));
            leavings.extend((is_recent != Some(true)).then_some(Leaving::at(rebound, None, true)));
            return leavings;
        }
        let uncertain = slowest.1 + approach.1;
        if approach.0 >= slowest.0 - uncertain {
            if is_recent != Some(false) {
                let (since, uncertain) = self.since(particles, now);
                let factor = |since: f64| (self.contact_time / since.max(0.0)).clamp(1.0, 16.0);
                let bound = (factor(since - uncertain) - factor(since + uncertain)) * approach.0 + 2.0 * approach.1;
                let fastest = factor(since) * approach.0;
                let fastest = (fastest, bound + rounded(fastest));
                let rattling = [(-1.0, uncertain), (0.0, 0.0), (1.0, -uncertain)].map(|(sign, later)| {
                    let speed = (approach.0 + sign * approach.1).max(0.0);
                    speed * self.contact_time / (since + later).max(0.0)
                });
                leavings.push(Leaving { fastest, rattling, reverses_slip: true, ..Leaving::at(approach, None, true) });
            }
            if is_recent != Some(true) {
                let speed = rebound.0.max(away.0.min(approach.0));
                let bound = rebound.1.max(approach.1) + away.1;
                let (excess, uncertain) = (approach.0 - 2.0 * away.0, approach.1 + 2.0 * away.1);
                let leaving = Leaving::at((speed, bound), None, true);
                leavings.extend((excess <= uncertain).then_some(Leaving { reverses_slip: true, ..leaving }));
                leavings.extend((excess >= -uncertain).then_some(leaving));
            }
        }
        if approach.0 <= slowest.0 + uncertain {
            let total = libm::hypot(approach.0, tangential.0);
            let slowest_at_rest = at_rest.0 / SLIDING;
            let uncertain = at_rest.1 / SLIDING + approach.1 + tangential.1 + rounded(total);
            if total < slowest_at_rest + uncertain {
                leavings.push(Leaving::at(at_rest, None, false));
            }
            if total > slowest_at_rest - uncertain {
                leavings.push(slide(approach, tangential, slowest));
            }
        }
        leavings
    }
}

/// Motion after a sliding contact, with the normal speed `2 slowest` and constant kinetic energy.
fn slide(approach: (f64, f64), tangential: (f64, f64), slowest: (f64, f64)) -> Leaving {
    let energy = approach.0 * approach.0 + tangential.0 * tangential.0;
    let speed = ((2.0 * slowest.0).min(energy.sqrt()), 2.0 * slowest.1 + approach.1 + tangential.1);
    let left = (energy - speed.0 * speed.0).max(0.0);
    // Uncertainty of the squared speed along the barrier. Its root is an upper bound for the uncertainty of the speed.
    let uncertain = 2.0 * (approach.0 * approach.1 + tangential.0 * tangential.1 + speed.0 * speed.1) + rounded(energy);
    let left_bound = (uncertain / left.sqrt()).min(uncertain.sqrt()) + tangential.1;
    Leaving::at(speed, Some((left.sqrt(), left_bound)), false)
}

#[cfg(test)]
mod tests {
    use super::*;

    const AT_ONE: Elapsed = Elapsed { epoch: 0.0, since_epoch: 1.0, epochs: 0 };

    fn arrival(restitution: f64, approach: f64, tangential: f64, closing: f64) -> Arrival {
        Arrival {
            rebound: (restitution * approach, 0.0),
            approach: (approach, 0.0),
            tangential: (tangential, 0.0),
            closing: (closing, 0.0),
            closing_at_rest: (closing, 0.0),
        }
    }

    fn speeds(memory: &ContactMemory, arrival: &Arrival, at: f64) -> Vec<f64> {
        let now = Elapsed { since_epoch: at, ..AT_ONE };
        memory.leavings(arrival, &[0, 1], &now).iter().map(|leaving| leaving.speed.0).collect()
    }

    #[test]
    fn contact_within_contact_time_is_elastic_and_borderline_allows_both() {
        let mut memory = ContactMemory::new(0.5, 2, None);
        let fast = arrival(0.25, 2.0, 0.0, 0.0);
        assert_eq!(speeds(&memory, &fast, 1.0), [0.5]);
        memory.note(&[1], &AT_ONE);
        assert_eq!(speeds(&memory, &fast, 1.25), [2.0]);
        assert_eq!(speeds(&memory, &fast, 1.5), [2.0, 0.5]);
        assert_eq!(speeds(&memory, &fast, 1.75), [0.5]);
        let unseen = ContactMemory::new(0.5, 2, Some(AT_ONE));
        assert_eq!(speeds(&unseen, &fast, 1.25), [2.0, 0.5]);
        assert_eq!(speeds(&unseen, &fast, 1.75), [0.5]);
    }

    #[test]
    fn slow_contact_keeps_a_least_speed_and_slides_if_it_has_none() {
        let memory = ContactMemory::new(0.5, 2, None);
        assert_eq!(speeds(&memory, &arrival(0.0, 2.0, 0.0, 1.0), 1.0), [0.25]);
        assert_eq!(speeds(&memory, &arrival(0.0, 0.125, 0.0, 1.0), 1.0), [0.125]);
        // At rest, the least speed is 0.25. At 1 / 64 of it, round-off decides.
        assert_eq!(speeds(&memory, &arrival(0.5, 0.003, 0.0, 1.0), 1.0), [0.25]);
        assert_eq!(speeds(&memory, &arrival(0.5, 0.25 / 64.0, 0.0, 1.0), 1.0), [0.25 / 64.0, 0.25, 0.25 / 64.0]);
        let curved = Arrival { closing_at_rest: (0.0, 0.0), ..arrival(0.5, 0.003, 0.0, 1.0) };
        assert_eq!(speeds(&memory, &curved, 1.0), [0.003]);
        let slides = memory.leavings(&arrival(0.0, 0.0, 2.0, 1.0), &[0], &AT_ONE);
        let [Leaving { speed, sliding: Some((along, _)), .. }] = slides[..] else { panic!("{slides:?}") };
        assert_eq!(speed.0, 0.25 / 32.0);
        assert!((along * along + speed.0 * speed.0 - 4.0).abs() < 1e-14);
    }
}

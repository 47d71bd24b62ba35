//! Response at a discontinuity: Core, Capture, Release or Bounce.
//!
//! A prediction only states that a pair reaches a discontinuity. The energy step and the radial kinetic energy decide
//! the outcome of the event (Bannerman and Strobl, section 1).

use crate::physics::overlap::Side;
use crate::physics::restitution::Restitution;
use crate::physics::rough::Roughness;
use serde::{Deserialize, Serialize};

/// Contact law of an infinite barrier: the core of a pair, the end of a bond, a wall or a surface.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ContactLaw {
    /// Coefficient of restitution, which may depend on the speed of impact.
    pub restitution: Restitution,
    /// Friction and tangential restitution; `None` for a smooth barrier, which exerts no tangential forces.
    pub roughness: Option<Roughness>,
}

impl ContactLaw {
    /// Law of a smooth barrier, which leaves the tangential velocity unchanged.
    #[must_use]
    pub const fn smooth(restitution: f64) -> Self {
        Self { restitution: Restitution::Constant(restitution), roughness: None }
    }

    /// Law of a rough barrier, which also acts on spins.
    #[must_use]
    pub const fn rough(restitution: f64, roughness: Roughness) -> Self {
        Self { restitution: Restitution::Constant(restitution), roughness: Some(roughness) }
    }

    /// Makes the barrier rough, with a tangential restitution. Contacts never slide unless friction is also set.
    #[must_use]
    pub fn with_tangential_restitution(self, tangential_restitution: f64) -> Self {
        let friction = self.roughness.map_or(f64::INFINITY, |roughness| roughness.friction);
        Self { roughness: Some(Roughness { tangential_restitution, friction }), ..self }
    }

    /// Makes the barrier rough, with a friction coefficient. The tangential restitution is 0 unless it is set, too.
    #[must_use]
    pub fn with_friction(self, friction: f64) -> Self {
        let tangential_restitution = self.roughness.map_or(0.0, |roughness| roughness.tangential_restitution);
        Self { roughness: Some(Roughness { tangential_restitution, friction }), ..self }
    }

    /// Whether contacts dissipate kinetic energy.
    #[must_use]
    pub fn dissipates(&self) -> bool {
        !self.restitution.is_elastic() || self.roughness.is_some_and(|roughness| roughness.dissipates())
    }
}

/// Outcome of an event at a discontinuity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Outcome {
    /// Reflection off an infinite inner barrier, with restitution.
    Core,
    /// The pair crosses a finite step inwards.
    Capture,
    /// The pair crosses a finite step outwards.
    Release,
    /// Reflection by a finite step that is too high, or by the infinite outer barrier of a bond (with restitution).
    Bounce,
}

/// Radial state of a pair at a discontinuity.
///
/// The radial motion is described by `B = v . r`, not by `vn = B / |r|`. The square root of a number near 1 rounds down
/// more often than up, so a unit normal computed from `|r|` is too long on average. Reflections along this normal would
/// add energy, about 3e-16 kT per event in a hard-sphere fluid. `B` and `|r|^2` need no square root. They may be
/// computed from any vector parallel to `r_ij`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Approach {
    /// `B = v_ij . r_ij` `[length^2 / time]`, negative if the pair approaches.
    pub radial: f64,
    /// `|r_ij|^2` `[length^2]`.
    pub squared: f64,
    /// `mu = 1 / (w_i + w_j)` `[mass]`.
    pub reduced_mass: f64,
}

/// Outcome of an event, and the radial motion of the pair after the event.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// Outcome of the event.
    pub outcome: Outcome,
    /// Radial motion after the event, `B' = v_ij' . r_ij` `[length^2 / time]`.
    pub radial: f64,
    /// Factor that multiplies the relative tangential velocity; 1 except in sliding contacts of the TC model.
    pub tangential_scale: f64,
    /// Roughness in this contact; `None` if it is smooth.
    pub roughness: Option<Roughness>,
    /// Whether the pair was at rest and gained energy, see [`tc_contact`].
    pub is_lifted: bool,
    /// Rule by which energy lost to friction returns to the normal motion.
    pub rattle: Rattle,
}

/// Decides the response of a pair at a discontinuity.
///
/// The change of the potential energy in a crossing is `dU = energy_step` `[energy]`. With `vn = B / |r|`:
///
/// | at | condition | outcome | `vn'` |
/// |---|---|---|---|
/// | an infinite step | | Core (inner), Bounce (outer) | `-e vn`, where `e` may depend on `vn` and `mu` |
/// | a finite step | `mu/2 vn^2 > dU` | Capture (inner), Release (outer) | `vn'^2 = vn^2 - 2 dU / mu`, sign kept |
/// | a finite step | `mu/2 vn^2 <= dU` | Bounce | `-vn` |
#[inline]
#[must_use]
pub fn respond(side: Side, energy_step: f64, approach: &Approach, law: &ContactLaw) -> Response {
    let &Approach { radial, squared, reduced_mass } = approach;
    let smooth = |outcome, radial| Response {
        outcome,
        radial,
        tangential_scale: 1.0,
        roughness: None,
        is_lifted: false,
        rattle: Rattle::NONE,
    };
    if energy_step == f64::INFINITY {
        // The particles do not touch at the end of a bond, so this barrier is smooth.
        let (outcome, roughness) = match side {
            Side::Positive => (Outcome::Core, law.roughness),
            Side::Negative => (Outcome::Bounce, None),
        };
        let restitution = match law.restitution {
            Restitution::Constant(restitution) => restitution,
            ref varying => varying.at(radial.abs() / squared.sqrt(), reduced_mass),
        };
        return Response { roughness, ..smooth(outcome, reflect(side, radial, restitution)) };
    }
    let beyond = radial * radial - 2.0 * energy_step / reduced_mass * squared;
    if beyond <= 0.0 {
        return smooth(Outcome::Bounce, reflect(side, radial, 1.0));
    }
    let outcome = match side {
        Side::Positive => Outcome::Capture,
        Side::Negative => Outcome::Release,
    };
    // A pair at a turning point crosses the discontinuity, although its radial speed is zero.
    smooth(outcome, -side.sign() * beyond.sqrt())
}

/// Returns the radial motion after a reflection. A pair that recedes because of round-off keeps its motion.
#[inline]
fn reflect(side: Side, radial: f64, restitution: f64) -> f64 {
    if radial * side.sign() < 0.0 { -restitution * radial } else { radial }
}

/// Relative motion before a contact with an infinite barrier, which the TC model needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrival {
    /// Normal speed of approach, at least 0 `[length / time]`.
    pub approach: f64,
    /// Coefficient of restitution at this speed.
    pub restitution: f64,
    /// Relative speed along the barrier `[length / time]`.
    pub tangential: f64,
    /// Relative acceleration towards the barrier, from gravity or the centrifugal force; negative if it drives the pair
    /// away `[length / time^2]`.
    pub closing: f64,
    /// The same without the centrifugal force: from gravity, or from the acceleration of a surface
    /// `[length / time^2]`.
    pub closing_at_rest: f64,
}

/// Velocity of a pair after a contact with an infinite barrier under the TC model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leaving {
    /// Normal speed away from the barrier `[length / time]`.
    pub speed: f64,
    /// Factor that multiplies the relative tangential velocity; 1 unless the contact is sliding.
    pub tangential_scale: f64,
    /// Roughness in this contact; `None` if it is smooth.
    pub roughness: Option<Roughness>,
    /// Whether the pair was at rest and gained energy.
    pub is_lifted: bool,
    /// Whether the pair slides along the barrier, without friction.
    pub is_sliding: bool,
    /// Rule by which energy lost to friction returns to the normal motion.
    pub rattle: Rattle,
}

impl Leaving {
    /// Creates the result of a smooth contact with this normal speed afterwards.
    pub fn smoothly(speed: f64) -> Self {
        Self {
            speed,
            tangential_scale: 1.0,
            roughness: None,
            is_lifted: false,
            is_sliding: false,
            rattle: Rattle::NONE,
        }
    }
}

/// Rule of the TC model for contacts that follow a previous contact within the contact time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum TcRule {
    /// Contacts are elastic but remain rough, and grains at rest stay apart for a contact time.
    #[default]
    Resting,
    /// The published model alone: contacts are elastic and smooth.
    LudingMcNamara,
}

/// Maximum number of contacts within one contact time. A pair that would have more contacts slides, and then gets twice
/// the limiting normal speed. With the limiting speed itself, round-off would decide whether its next contacts slide.
const SLIDING: f64 = 64.0;

/// A contact reverses the slip if its normal speed is below this multiple of the normal speed of a grain at rest.
/// Contacts of a grain at rest are exactly one contact time apart. Without this rule, round-off would decide whether
/// they reverse the slip.
const RESTING: f64 = 2.0;

/// Largest factor by which the energy lost to friction may increase the normal speed in one contact.
const FASTER: f64 = 16.0;

/// Grains only rattle if the slip speed is at most this multiple of the speed of [`Rattle`]. Faster grains slide.
const SLIP: f64 = 4.0;

/// Rule by which energy lost to friction returns to the normal motion, in elastic contacts under the TC model. Grains
/// that rattle get the energy back. Bodies that slide lose it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rattle {
    /// Normal speed at which contacts with the same mean force would be one contact time apart `[length / time]`.
    speed: f64,
    /// Normal speed up to which the normal motion gains energy `[length / time]`.
    fastest: f64,
}

impl Rattle {
    /// All energy lost to friction is dissipated.
    pub const NONE: Self = Self { speed: 0.0, fastest: 0.0 };

    /// A contact with the normal speed `approach`, and the time `since` after the previous contact.
    fn new(approach: f64, since: f64, contact_time: f64) -> Self {
        let [speed, fastest] = [f64::INFINITY, FASTER].map(|most| approach * (contact_time / since).min(most));
        Self { speed, fastest }
    }

    /// Adapts the rule to a contact with a moving surface, or with a surface whose material moves. `approach` is the
    /// normal speed of the contact.
    ///
    /// A moving surface can supply unlimited energy, so grains that slide on it could rattle ever faster. The slip is
    /// therefore compared with a lower speed: the geometric mean of `approach` and the largest normal speed that the
    /// contact can reach.
    #[must_use]
    pub fn at_moving_surface(self, approach: f64) -> Self {
        Self { speed: (self.fastest * approach).sqrt(), ..self }
    }

    /// Returns the increase of the normal speed `speed`. `slip` is the slip speed of the surfaces, and `lost` is the
    /// energy lost to friction, divided by the reduced mass. All of this energy returns to the normal motion if the
    /// slip speed is at most 4 times the speed of [`Rattle`]. The share decreases to zero at 8 times this speed.
    #[inline]
    #[must_use]
    pub fn gain(&self, speed: f64, slip: f64, lost: f64) -> f64 {
        if self.fastest <= speed || lost <= 0.0 {
            return 0.0;
        }
        let kept = lost * (2.0 - slip / (SLIP * self.speed)).clamp(0.0, 1.0);
        (speed * speed + 2.0 * kept).sqrt().min(self.fastest) - speed
    }
}

/// A contact with an infinite barrier under the TC model of Luding and McNamara (Granular Matter 1, 113, 1998).
///
/// A contact is elastic if the time `since` the previous contact of either particle is less than `contact_time`. For a
/// restitution near 0, this rule is not sufficient, and the events would never end. After any other contact, the speed
/// is therefore at least `closing * contact_time / 2`, unless the pair arrives more slowly. At this speed, the pair
/// stays apart for one contact time. If a pair slides along the barrier with hardly any normal speed, a small part of
/// the tangential velocity is turned into the normal direction. None of these rules adds energy.
///
/// Elastic contacts remain rough, and reverse the slip unless they slide ([`Roughness::elastic`]). Contacts of grains
/// at rest, which are one contact time apart, also reverse the slip. If a contact only stopped the slip, a grain held
/// by friction would creep, because its load accelerates it between two contacts. With the reversal, the normal
/// impulses of a pair that stays in contact add up to the normal force, and the tangential impulses add up to the
/// friction force of Coulomb's law. In the published model, elastic contacts are smooth, and a grain that has come to
/// rest on a slope would slide without friction.
///
/// Grains in a packing rattle, and friction would consume the energy of this motion. Slower grains in a packing meet
/// more often, so the number of contacts would grow. The energy that friction takes from an elastic contact therefore
/// returns to the normal motion. The normal speed increases at most to 16 times its value, and at most to the speed at
/// which contacts would be one contact time apart. Bodies that slide lose the energy ([`Rattle`]).
///
/// A pair at rest has no energy to separate. It gets the speed `closing_at_rest * contact_time / 2`, at which its
/// contacts are one contact time apart. This adds energy, which counts as supplied energy.
#[inline]
#[must_use]
pub fn tc_contact(rule: TcRule, law: &ContactLaw, since: f64, arrival: &Arrival, contact_time: f64) -> Leaving {
    let &Arrival { approach, restitution, tangential, closing, closing_at_rest } = arrival;
    if rule == TcRule::LudingMcNamara {
        return if since < contact_time {
            Leaving::smoothly(approach)
        } else {
            Leaving { roughness: law.roughness, ..Leaving::smoothly(restitution * approach) }
        };
    }
    let away_for_contact_time = (0.5 * closing * contact_time).max(0.0);
    let slowest = away_for_contact_time / SLIDING;
    if approach < slowest {
        let energy = approach * approach + tangential * tangential;
        let speed_at_rest = 0.5 * closing_at_rest * contact_time;
        if SLIDING * energy.sqrt() < speed_at_rest {
            return Leaving { is_lifted: true, ..Leaving::smoothly(speed_at_rest) };
        }
        let speed = (2.0 * slowest).min(energy.sqrt());
        let left = (energy - speed * speed).max(0.0).sqrt();
        let tangential_scale = if tangential > 0.0 { left / tangential } else { 1.0 };
        return Leaving { tangential_scale, is_sliding: true, ..Leaving::smoothly(speed) };
    }
    let elastic = law.roughness.map(Roughness::elastic);
    if since < contact_time {
        let rattle = Rattle::new(approach, since, contact_time);
        return Leaving { roughness: elastic, rattle, ..Leaving::smoothly(approach) };
    }
    let speed = (restitution * approach).max(away_for_contact_time.min(approach));
    let roughness = if approach < RESTING * away_for_contact_time { elastic } else { law.roughness };
    Leaving { roughness, ..Leaving::smoothly(speed) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pair at distance 2 with reduced mass 1/2 and normal velocity `vn`.
    fn at(vn: f64) -> Approach {
        Approach { radial: 2.0 * vn, squared: 4.0, reduced_mass: 0.5 }
    }

    /// Motion after a contact with the speeds `[approach, tangential]`.
    fn left(restitution: f64, is_recent: bool, speeds: [f64; 2], closing: f64, contact_time: f64) -> Leaving {
        let [approach, tangential] = speeds;
        let arrival = Arrival { approach, restitution, tangential, closing, closing_at_rest: closing };
        tc_contact(
            TcRule::Resting,
            &ContactLaw::smooth(restitution),
            if is_recent { 0.0 } else { contact_time },
            &arrival,
            contact_time,
        )
    }

    fn outcome_and_normal_velocity(side: Side, energy_step: f64, vn: f64, restitution: f64) -> (Outcome, f64) {
        let response = respond(side, energy_step, &at(vn), &ContactLaw::smooth(restitution));
        (response.outcome, response.radial / 2.0)
    }

    #[test]
    fn an_infinite_step_reflects_with_restitution() {
        let core = outcome_and_normal_velocity(Side::Positive, f64::INFINITY, -2.0, 0.25);
        assert_eq!(core, (Outcome::Core, 0.5));
        let bond = outcome_and_normal_velocity(Side::Negative, f64::INFINITY, 2.0, 0.25);
        assert_eq!(bond, (Outcome::Bounce, -0.5));
    }

    #[test]
    fn pair_receding_within_rounding_keeps_its_velocity() {
        for least in [0.0, f64::MIN_POSITIVE] {
            assert_eq!(outcome_and_normal_velocity(Side::Positive, f64::INFINITY, least, 1.0), (Outcome::Core, least));
            assert_eq!(
                outcome_and_normal_velocity(Side::Negative, f64::INFINITY, -least, 1.0),
                (Outcome::Bounce, -least)
            );
            assert_eq!(outcome_and_normal_velocity(Side::Positive, 9.0, least, 1.0), (Outcome::Bounce, least));
        }
        assert_eq!(
            outcome_and_normal_velocity(Side::Positive, f64::INFINITY, -f64::MIN_POSITIVE, 1.0).1,
            f64::MIN_POSITIVE
        );
    }

    #[test]
    fn a_pair_that_falls_into_a_well_gains_its_depth() {
        // The kinetic energy of the normal motion grows by the depth of the well: 1/4 (9 - 1) = 2.
        assert_eq!(outcome_and_normal_velocity(Side::Positive, -2.0, -1.0, 0.0), (Outcome::Capture, -3.0));
        assert_eq!(outcome_and_normal_velocity(Side::Negative, 2.0, 3.0, 0.0), (Outcome::Release, 1.0));
    }

    #[test]
    fn pair_reflects_elastically_if_the_step_exceeds_its_energy() {
        // The kinetic energy of the normal motion, mu/2 vn^2 = 1/4 * 4 = 1, equals the height of the step.
        assert_eq!(outcome_and_normal_velocity(Side::Negative, 1.0, 2.0, 0.1), (Outcome::Bounce, -2.0));
        assert_eq!(outcome_and_normal_velocity(Side::Positive, 1.0, -2.0, 0.1), (Outcome::Bounce, 2.0));
        let lower = 1.0_f64.next_down();
        assert_eq!(outcome_and_normal_velocity(Side::Negative, lower, 2.0, 0.1).0, Outcome::Release);
        assert_eq!(outcome_and_normal_velocity(Side::Positive, lower, -2.0, 0.1).0, Outcome::Capture);
    }

    #[test]
    fn a_pair_that_already_separates_is_not_driven_back() {
        for vn in [0.0, 1e-17] {
            assert_eq!(outcome_and_normal_velocity(Side::Positive, f64::INFINITY, vn, 0.5).1, vn);
            assert_eq!(outcome_and_normal_velocity(Side::Negative, f64::INFINITY, -vn, 0.5).1, -vn);
            assert_eq!(outcome_and_normal_velocity(Side::Positive, 1.0, vn, 0.5).1, vn);
        }
        // A pair crosses a step to lower energy even at normal velocity 0. Otherwise the events would never end.
        assert_eq!(outcome_and_normal_velocity(Side::Positive, -1.0, 0.0, 0.5).1, -2.0);
    }

    #[test]
    fn the_tc_model_makes_frequent_contacts_elastic() {
        let contact = |e, is_recent, closing| left(e, is_recent, [3.0, 1.0], closing, 0.1);
        assert_eq!(contact(0.5, true, 1.0), Leaving { rattle: Rattle::new(3.0, 0.0, 0.1), ..Leaving::smoothly(3.0) });
        assert_eq!(contact(0.5, false, 1.0), Leaving::smoothly(1.5));
        assert_eq!(contact(0.0, false, -1.0), Leaving::smoothly(0.0), "the pair separates by itself");
    }

    #[test]
    fn friction_acts_in_elastic_contacts() {
        let law = ContactLaw::smooth(0.5).with_friction(0.3);
        let arrival = Arrival { approach: 3.0, restitution: 0.5, tangential: 1.0, closing: 1.0, closing_at_rest: 1.0 };
        for (since, fastest) in [(0.0, 48.0), (0.004, 48.0), (0.08, 3.75), (0.1, 0.0)] {
            let leaving = tc_contact(TcRule::Resting, &law, since, &arrival, 0.1);
            assert_eq!(leaving.rattle.fastest, fastest);
            assert_eq!(leaving.speed, if since < 0.1 { 3.0 } else { 1.5 });
        }
        // A pair at the limit of sliding does not slide in its next contact.
        let elastic = law.roughness.map(Roughness::elastic);
        let slow = tc_contact(TcRule::Resting, &law, 0.05, &Arrival { approach: 0.0, ..arrival }, 0.1);
        let next = tc_contact(TcRule::Resting, &law, 0.05, &Arrival { approach: slow.speed, ..arrival }, 0.1);
        assert_eq!((next.speed, next.roughness, next.tangential_scale), (slow.speed, elastic, 1.0));
    }

    #[test]
    fn elastic_contacts_and_contacts_at_rest_reverse_the_slip() {
        let law = ContactLaw::smooth(0.5).with_friction(0.3);
        let elastic = ContactLaw::smooth(0.5).with_friction(0.3).with_tangential_restitution(1.0);
        let smooth = ContactLaw::smooth(0.5).with_tangential_restitution(-1.0);
        // A grain at rest has the speed 1 * 0.1 / 2 at its contacts.
        for (approach, since, is_reversed) in
            [(0.05, 0.1, true), (0.099, 0.1, true), (0.101, 0.1, false), (0.101, 0.099, true), (9.0, 0.0, true)]
        {
            let arrival = Arrival { approach, restitution: 0.5, tangential: 1.0, closing: 1.0, closing_at_rest: 1.0 };
            let roughness = |law: &ContactLaw| tc_contact(TcRule::Resting, law, since, &arrival, 0.1).roughness;
            assert_eq!(roughness(&law), if is_reversed { elastic.roughness } else { law.roughness });
            assert_eq!(roughness(&smooth), smooth.roughness, "it stays smooth");
        }
    }

    #[test]
    fn published_model_makes_recent_contacts_elastic_and_smooth() {
        let law = ContactLaw::smooth(0.5).with_friction(0.3);
        let arrival = Arrival { approach: 3.0, restitution: 0.5, tangential: 1.0, closing: 1e9, closing_at_rest: 1e9 };
        let left = |since: f64| tc_contact(TcRule::LudingMcNamara, &law, since, &arrival, 0.1);
        assert_eq!(left(0.05), Leaving::smoothly(3.0));
        assert_eq!(left(0.1), Leaving { roughness: law.roughness, ..Leaving::smoothly(1.5) });
    }

    #[test]
    fn energy_of_friction_goes_into_the_normal_motion_of_grains_that_rattle() {
        // Contacts with the same mean force and the speed 3 * 0.1 / 0.02 = 15 would be one contact time apart.
        let rattle = Rattle::new(3.0, 0.02, 0.1);
        let gain = |slip: f64, lost: f64| rattle.gain(3.0, slip, lost);
        assert!((gain(1.0, 8.0) - 2.0).abs() < 1e-15, "3^2 + 2 * 8 = 5^2");
        assert!((gain(90.0, 16.0) - 2.0).abs() < 1e-15, "half of the energy, at 6 times the speed 15");
        assert_eq!([gain(120.0, 8.0), gain(500.0, 8.0), gain(1.0, -1.0), gain(1.0, 0.0)], [0.0; 4]);
        assert_eq!(gain(1.0, 1e9), 12.0, "up to 15");
        assert_eq!(Rattle::new(3.0, 0.0, 0.1).gain(3.0, 1e9, 1e9), 45.0, "up to 16 times");
        assert_eq!(Rattle::NONE.gain(3.0, 1.0, 8.0), 0.0);
        let moving = Rattle::new(3.0, 0.025, 0.1).at_moving_surface(3.0);
        assert_eq!([moving.gain(3.0, 24.0, 8.0), moving.gain(3.0, 48.0, 8.0)], [2.0, 0.0], "sqrt(3 * 12) = 6");
    }

    #[test]
    fn tc_model_gives_enough_speed_to_separate_for_a_contact_time() {
        // A pair with speed 0.05 and acceleration 1 returns after one contact time, 0.1.
        assert_eq!(left(0.0, false, [0.5, 0.0], 1.0, 0.1).speed, 0.05);
        assert_eq!(left(0.0, false, [0.01, 0.0], 1.0, 0.1).speed, 0.01, "the speed does not increase");
    }

    #[test]
    fn the_tc_model_turns_a_sliding_contact_at_constant_energy() {
        let leaving = left(0.0, true, [0.0, 2.0], 1.0, 0.128);
        assert_eq!(leaving.speed, 0.002);
        let energy = leaving.speed.powi(2) + (2.0 * leaving.tangential_scale).powi(2);
        assert!((energy - 4.0).abs() < 4.0 * f64::EPSILON);
    }

    #[test]
    fn pair_at_rest_gets_the_speed_of_grains_at_rest() {
        // A particle that leaves at 0.064 returns after one contact time. A pair slower than 0.001 counts as at rest.
        let lifted = Leaving { is_lifted: true, ..Leaving::smoothly(0.064) };
        for [approach, tangential] in [[0.0, 0.0], [1e-8, 0.0], [0.0, 0.0009], [0.0007, 0.0007]] {
            for is_recent in [false, true] {
                let leaving = left(0.3, is_recent, [approach, tangential], 1.0, 0.128);
                assert_eq!(leaving, lifted);
            }
        }
        let slides = left(0.3, true, [0.0008, 0.003], 1.0, 0.128);
        assert!(slides.speed == 0.002 && slides.tangential_scale < 1.0, "{slides:?}");
        // The centrifugal force lifts no pair. Otherwise, each lift would increase the force, and the energy would grow
        // without limit.
        let arrival =
            Arrival { approach: 0.0, restitution: 0.3, tangential: 2.0, closing: 400.0, closing_at_rest: 0.0 };
        let along = tc_contact(TcRule::Resting, &ContactLaw::smooth(0.3), 0.0, &arrival, 1.0);
        assert_eq!(along, Leaving { tangential_scale: 0.0, is_sliding: true, ..Leaving::smoothly(2.0) });
        let apart = left(0.3, false, [0.0, 0.0], -1.0, 0.128);
        assert_eq!(apart.speed, 0.0, "a pair that gravity separates is not lifted");
    }
}

//! What happens at a discontinuity: Core, Capture, Release or Bounce.
//!
//! The event queue only knows that a pair reaches a discontinuity from one side. Here, when that time has come, the energy
//! step and the radial kinetic energy decide the outcome (theory: Bannerman and Strobl, section 1).

use crate::overlap::Side;

/// What a pair does at a discontinuity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Outcome {
    /// Reflection off an infinite inner barrier, with restitution.
    Core,
    /// The pair goes one step inwards.
    Capture,
    /// The pair goes one step outwards.
    Release,
    /// Reflection off a finite step that is too high, or off the infinite end of a bond (with restitution).
    Bounce,
}

/// An outcome with the relative normal velocity after it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// What happened.
    pub outcome: Outcome,
    /// `vn'`, the relative velocity along `rhat` afterwards `[length / time]`.
    pub normal_velocity: f64,
}

/// Decides what a pair does at a discontinuity.
///
/// `energy_step` is `dU`, the potential energy beyond the discontinuity less the one before it `[energy]`; `reduced_mass` is
/// `mu = 1 / (w_i + w_j)` `[mass]`; `normal_velocity` is `vn = v_ij . rhat` `[length / time]`, negative where the pair
/// approaches.
///
/// | at | condition | outcome | `vn'` |
/// |---|---|---|---|
/// | an infinite step | | Core (inner), Bounce (outer) | `-e vn` |
/// | a finite step | `mu/2 vn^2 > dU` | Capture (inner), Release (outer) | `vn'^2 = vn^2 - 2 dU / mu`, sign kept |
/// | a finite step | `mu/2 vn^2 <= dU` | Bounce | `-vn` |
#[inline]
#[must_use]
pub fn respond(side: Side, energy_step: f64, reduced_mass: f64, normal_velocity: f64, restitution: f64) -> Response {
    if energy_step == f64::INFINITY {
        let outcome = match side {
            Side::Positive => Outcome::Core,
            Side::Negative => Outcome::Bounce,
        };
        return Response { outcome, normal_velocity: reflect(side, normal_velocity, restitution) };
    }
    let squared = normal_velocity * normal_velocity - 2.0 * energy_step / reduced_mass;
    if squared <= 0.0 {
        return Response { outcome: Outcome::Bounce, normal_velocity: reflect(side, normal_velocity, 1.0) };
    }
    let outcome = match side {
        Side::Positive => Outcome::Capture,
        Side::Negative => Outcome::Release,
    };
    // The pair goes on across the discontinuity, also from a turning point, where it has no speed of its own yet.
    Response { outcome, normal_velocity: -side.sign() * squared.sqrt() }
}

/// A pair that does not go towards the invalid side, at a turning point within round-off, keeps its velocity: to reverse it
/// would drive the pair in.
#[inline]
fn reflect(side: Side, normal_velocity: f64, restitution: f64) -> f64 {
    if normal_velocity * side.sign() < 0.0 { -restitution * normal_velocity } else { normal_velocity }
}

/// The restitution of a contact under the TC model of Luding and McNamara (Granular Matter 1, 113, 1998).
///
/// A contact is elastic when either particle had its previous one less than `contact_time` ago (`is_recent`). Other contacts
/// keep `restitution`, but never leave the pair so slow that it would be back within the contact time: under the
/// relative acceleration `closing` with which it returns to the discontinuity `[length / time^2]`, a pair that leaves with speed
/// `closing * contact_time / 2` is back after `contact_time`. Without this a restitution of 0 would leave a resting contact
/// with no speed at all, which no elastic contact could give back. The contact never gains energy.
#[inline]
#[must_use]
pub fn tc_restitution(restitution: f64, is_recent: bool, normal_velocity: f64, closing: f64, contact_time: f64) -> f64 {
    if is_recent {
        return 1.0;
    }
    let slowest = 0.5 * closing * contact_time;
    let speed = normal_velocity.abs();
    if restitution * speed >= slowest {
        restitution
    } else if slowest >= speed {
        1.0
    } else {
        slowest / speed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_infinite_step_reflects_with_restitution() {
        let core = respond(Side::Positive, f64::INFINITY, 0.5, -2.0, 0.25);
        assert_eq!(core, Response { outcome: Outcome::Core, normal_velocity: 0.5 });
        let bond = respond(Side::Negative, f64::INFINITY, 0.5, 2.0, 0.25);
        assert_eq!(bond, Response { outcome: Outcome::Bounce, normal_velocity: -0.5 });
    }

    #[test]
    fn a_pair_that_falls_into_a_well_gains_its_depth() {
        // mu/2 (vn'^2 - vn^2) = 1/4 (9 - 1) = 2.
        let capture = respond(Side::Positive, -2.0, 0.5, -1.0, 0.0);
        assert_eq!(capture, Response { outcome: Outcome::Capture, normal_velocity: -3.0 });
        let release = respond(Side::Negative, 2.0, 0.5, 3.0, 0.0);
        assert_eq!(release, Response { outcome: Outcome::Release, normal_velocity: 1.0 });
    }

    #[test]
    fn a_step_that_is_too_high_reflects_elastically_one_float_either_side_of_the_limit() {
        // mu/2 vn^2 = 1/4 * 4 = 1.
        assert_eq!(respond(Side::Negative, 1.0, 0.5, 2.0, 0.1).outcome, Outcome::Bounce);
        assert_eq!(respond(Side::Negative, 1.0, 0.5, 2.0, 0.1).normal_velocity, -2.0);
        assert_eq!(respond(Side::Negative, 1.0_f64.next_down(), 0.5, 2.0, 0.1).outcome, Outcome::Release);
        assert_eq!(respond(Side::Positive, 1.0, 0.5, -2.0, 0.1).outcome, Outcome::Bounce);
        assert_eq!(respond(Side::Positive, 1.0_f64.next_down(), 0.5, -2.0, 0.1).outcome, Outcome::Capture);
    }

    #[test]
    fn a_pair_that_already_separates_is_not_driven_back() {
        for vn in [0.0, 1e-17] {
            assert_eq!(respond(Side::Positive, f64::INFINITY, 0.5, vn, 0.5).normal_velocity, vn);
            assert_eq!(respond(Side::Negative, f64::INFINITY, 0.5, -vn, 0.5).normal_velocity, -vn);
            assert_eq!(respond(Side::Positive, 1.0, 0.5, vn, 0.5).normal_velocity, vn);
        }
        // A step down is taken all the same, or the pair would stay at it for ever.
        assert_eq!(respond(Side::Positive, -1.0, 0.5, 0.0, 0.5).normal_velocity, -2.0);
    }

    #[test]
    fn the_tc_model_makes_frequent_and_slow_contacts_elastic() {
        assert_eq!(tc_restitution(0.4, true, -3.0, 1.0, 0.1), 1.0);
        assert_eq!(tc_restitution(0.4, false, -3.0, 1.0, 0.1), 0.4);
        assert_eq!(tc_restitution(0.4, false, -3.0, -1.0, 0.1), 0.4, "a pair that separates by itself needs nothing");
        // Back after 0.1 under acceleration 1 with speed 0.05.
        assert_eq!(tc_restitution(0.0, false, -0.5, 1.0, 0.1), 0.1);
        assert_eq!(tc_restitution(0.0, false, -0.01, 1.0, 0.1), 1.0, "never faster than it came");
        assert_eq!(tc_restitution(0.0, false, 0.0, 1.0, 0.1), 1.0);
    }
}

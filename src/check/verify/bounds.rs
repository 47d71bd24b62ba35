//! Round-off bounds. They are not chosen: each follows from the number and the size of the roundings.

use super::moving::Sway;
use super::world::World;
use crate::Vector;
use crate::engine::{Elapsed, States};

/// Number of roundings in a bound. Each is at most one unit in the last place of the magnitudes in [`Flight`].
/// Between a prediction and its event, each of the six coordinates of a pair collects rounding errors from the
/// free flight (three operations), from the event time, and from a wrap. They occur in the engine and again in the
/// verifier. The sum in the overlap function has eight terms.
const ROUNDINGS: f64 = 32.0;

/// Square root of the smallest normal floating-point number. The squares of lower speeds underflow, so norms and
/// energies lose their accuracy.
const SMALLEST: f64 = 1.5e-154;

/// Returns the error of [`ROUNDINGS`] roundings of a number as large as `scale`.
pub(super) fn rounded(scale: f64) -> f64 {
    ROUNDINGS * f64::EPSILON * scale + SMALLEST
}

/// Largest acceptable overlap or gap relative to the distance of a discontinuity. A larger one is an error even if the
/// rounded numbers are so large that round-off could explain it.
const MOST_OF_DISTANCE: f64 = 1e-6;

pub(super) fn is_without_digits(length: f64, distance: f64) -> bool {
    length.abs() > MOST_OF_DISTANCE * distance
}

/// Magnitudes that determine the round-off of a particle's flight.
#[derive(Debug, Clone, Copy)]
pub(super) struct Flight {
    /// Largest coordinate rounded since the last event `[length]`.
    length: f64,
    /// Largest speed since the last event `[length / time]`.
    pub speed: f64,
    /// Error of the velocity because event times are rounded while the particle accelerates `[length / time]`.
    falling: f64,
    /// Time since the last event `[time]`.
    duration: f64,
    /// Angle by which a rotating surface turns within the round-off error of a time `[1]`.
    turning: f64,
}

impl Flight {
    /// The flight of a wall, which never moves.
    pub const NONE: Self = Self { length: 0.0, speed: 0.0, falling: 0.0, duration: 0.0, turning: 0.0 };

    pub fn of_surface(farthest: f64, sway: &Sway) -> Self {
        let Sway { length, speed, falling, turning, .. } = *sway;
        Self { length: farthest + length, speed, falling, duration: f64::INFINITY, turning }
    }

    pub fn new(world: &World, states: &States, i: u32, last_event: &Elapsed, window: &Elapsed) -> Self {
        let duration = states.elapsed.after(last_event).max(0.0);
        let (position, velocity): (&Vector, &Vector) = (&states.positions[i as usize], &states.velocities[i as usize]);
        let acceleration = world.accelerations[i as usize].norm();
        let speed = velocity.norm() + acceleration * duration;
        // The rounding error of a time is proportional to the time since its epoch. A prediction may be in an earlier
        // epoch than its event, so the longer time counts. The verifier rounds the time again, in proportion to the
        // time since the start of the window.
        let since_epoch = states.elapsed.since_epoch.abs().max(last_event.since_epoch.abs());
        let times = duration + since_epoch.max(states.elapsed.after(window));
        // Each wrap at a periodic boundary rounds a coordinate once more.
        let wraps = if world.shortest_period.is_finite() { speed * duration / world.shortest_period } else { 0.0 };
        // The engine rounds the state of a particle once when it moves the state to the next epoch.
        let epochs = states.elapsed.epochs.saturating_sub(last_event.epochs) as f64;
        // Before it is wrapped, a coordinate may be as large as the period, whatever its present value is.
        let largest = position.amax() + speed * times + world.periods.amax();
        let length = largest * (1.0 + (wraps + epochs) / ROUNDINGS);
        let falling = if acceleration > 0.0 {
            acceleration * times + (speed + acceleration * times) * (epochs / ROUNDINGS)
        } else {
            0.0
        };
        Self { length, speed, falling, duration, turning: 0.0 }
    }

    /// Round-off bound of the particle's position `[length]`.
    pub fn position(&self) -> f64 {
        rounded(self.length)
    }

    /// Flight after an event that increased the speed by at most `gained` `[length / time]`.
    pub fn leaving(&self, gained: f64) -> Self {
        Self { speed: self.speed + gained, ..*self }
    }

    /// Round-off bound of the particle's velocity `[length / time]`.
    pub fn velocity(&self) -> f64 {
        rounded(self.speed + self.falling)
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    /// Round-off bound of a distance `[length]`.
    pub distance: f64,
    /// Round-off bound of a change of velocity `[length / time]`.
    pub velocity: f64,
    /// Round-off bound of the normal velocity `[length / time]`. It includes the direction of the normal, which depends
    /// on rounded positions.
    pub normal_velocity: f64,
    /// Round-off bound of the direction of the normal `[1]`.
    pub direction: f64,
}

impl Bounds {
    /// Bounds for a pair at a discontinuity at `distance`.
    ///
    /// The overlap function is a difference of squares. Its round-off is that of the squared separation at the
    /// prediction. The separation is at most `distance` plus the distance that the two particles have flown since the
    /// later of their last events. Dividing the round-off of the square by `distance` gives the round-off of the
    /// distance.
    pub fn pair(world: &World, a: &Flight, b: &Flight, distance: f64) -> Self {
        let flown = (a.speed + b.speed) * a.duration.min(b.duration);
        let separation = (distance + flown).min(world.diagonal.max(distance));
        let bound = rounded(a.length + b.length + distance + separation * separation / distance);
        let speed = a.speed + b.speed;
        let velocity = a.velocity() + b.velocity();
        let direction = rounded(1.0 + b.turning) + bound / distance;
        Self { distance: bound, velocity, normal_velocity: velocity + speed * direction, direction }
    }

    /// Bounds after an event that increased the speeds by at most `gained`. They include the rounding of the new
    /// velocities.
    pub fn leaving(&self, gained: f64) -> Self {
        let velocity = self.velocity + rounded(gained);
        Self { velocity, normal_velocity: self.normal_velocity + rounded(gained) + gained * self.direction, ..*self }
    }

    pub fn wall(a: &Flight, at: f64, radius: f64) -> Self {
        let velocity = a.velocity();
        let distance = rounded(a.length + at.abs() + radius);
        Self { distance, velocity, normal_velocity: velocity, direction: 0.0 }
    }

    /// Bounds at a plane of any orientation. For a triangular face, `slenderness` is the error of its normal in units
    /// of round-off; otherwise it is 1.
    pub fn plane(a: &Flight, plane: &Flight, radius: f64, slenderness: f64) -> Self {
        let (velocity, direction) = (a.velocity() + plane.velocity(), rounded(slenderness + plane.turning));
        let distance = rounded((a.length + plane.length) * slenderness + radius);
        Self { distance, velocity, normal_velocity: velocity + (a.speed + plane.speed) * direction, direction }
    }
}

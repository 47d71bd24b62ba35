//! Round-off bounds, derived from the number and the size of the roundings.

use super::moving::Sway;
use super::world::World;
use crate::Vector;
use crate::engine::{Elapsed, States};

/// Number of roundings in a bound, each of at most one unit in the last place of the magnitudes in [`Flight`]. The
/// engine and the verifier round the free flight, the event time, wraps and the overlap function.
const ROUNDINGS: f64 = 32.0;

/// Square root of the smallest normal floating-point number. Squares of lower speeds underflow.
const SMALLEST: f64 = 1.5e-154;

/// Returns the error of [`ROUNDINGS`] roundings of a number as large as `scale`.
pub(super) fn rounded(scale: f64) -> f64 {
    ROUNDINGS * f64::EPSILON * scale + SMALLEST
}

/// Largest acceptable overlap or gap relative to the distance of a discontinuity, even if round-off could be larger.
const MOST_OF_DISTANCE: f64 = 1e-6;

pub(super) fn is_without_digits(length: f64, distance: f64) -> bool {
    length.abs() > MOST_OF_DISTANCE * distance
}

/// Magnitudes that determine the round-off of a particle's flight.
#[derive(Debug, Clone, Copy)]
pub(super) struct Flight {
    /// Largest magnitude of the coordinates that were rounded since the last event `[length]`.
    length: f64,
    /// Largest speed since the last event `[length / time]`.
    pub speed: f64,
    /// Velocity error of an accelerated particle, caused by rounded event times `[length / time]`.
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
        // Rounding errors of a time are proportional to the time since its epoch, or to the time in the window.
        let since_epoch = states.elapsed.since_epoch.abs().max(last_event.since_epoch.abs());
        let times = duration + since_epoch.max(states.elapsed.after(window));
        // Each wrap at a periodic boundary rounds a coordinate once more.
        let wraps = if world.shortest_period.is_finite() { speed * duration / world.shortest_period } else { 0.0 };
        // The engine rounds the state of a particle once when it moves the state to the next epoch.
        let epochs = states.elapsed.epochs.saturating_sub(last_event.epochs) as f64;
        // Before it is wrapped, a coordinate may be as large as the period.
        let largest = position.amax() + speed * times + world.periods.amax();
        let length = largest * (1.0 + (wraps + epochs) / ROUNDINGS);
        let falling = if acceleration > 0.0 {
            acceleration * times + (speed + acceleration * times) * (epochs / ROUNDINGS)
        } else {
            0.0
        };
        Self { length, speed, falling, duration, turning: 0.0 }
    }

    pub fn position(&self) -> f64 {
        rounded(self.length)
    }

    /// Flight after an event that increased the speed by at most `gained` `[length / time]`.
    pub fn leaving(&self, gained: f64) -> Self {
        Self { speed: self.speed + gained, ..*self }
    }

    pub fn velocity(&self) -> f64 {
        rounded(self.speed + self.falling)
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    pub distance: f64,
    pub velocity: f64,
    /// Round-off bound of the normal velocity, including the round-off of the normal's direction `[length / time]`.
    pub normal_velocity: f64,
    pub direction: f64,
}

impl Bounds {
    /// Bounds for a pair at a discontinuity at `distance`.
    ///
    /// The overlap function is a difference of squares, with the round-off of the squared separation at the prediction.
    /// The separation was at most `distance` plus the path of the two particles since the later of their last events.
    /// The round-off of the distance is the round-off of the square divided by `distance`.
    pub fn pair(world: &World, a: &Flight, b: &Flight, distance: f64) -> Self {
        let flown = (a.speed + b.speed) * a.duration.min(b.duration);
        let separation = (distance + flown).min(world.diagonal.max(distance));
        let bound = rounded(a.length + b.length + distance + separation * separation / distance);
        let speed = a.speed + b.speed;
        let velocity = a.velocity() + b.velocity();
        let direction = rounded(1.0 + b.turning) + bound / distance;
        Self { distance: bound, velocity, normal_velocity: velocity + speed * direction, direction }
    }

    /// Bounds after an event that increased the speeds by at most `gained`, with the rounding of new velocities.
    pub fn leaving(&self, gained: f64) -> Self {
        let velocity = self.velocity + rounded(gained);
        Self { velocity, normal_velocity: self.normal_velocity + rounded(gained) + gained * self.direction, ..*self }
    }

    pub fn wall(a: &Flight, at: f64, radius: f64) -> Self {
        let velocity = a.velocity();
        let distance = rounded(a.length + at.abs() + radius);
        Self { distance, velocity, normal_velocity: velocity, direction: 0.0 }
    }

    /// Bounds at a plane. `slenderness` is the error of the normal in units of round-off, 1 unless the plane is a face.
    pub fn plane(a: &Flight, plane: &Flight, radius: f64, slenderness: f64) -> Self {
        let (velocity, direction) = (a.velocity() + plane.velocity(), rounded(slenderness + plane.turning));
        let distance = rounded((a.length + plane.length) * slenderness + radius);
        Self { distance, velocity, normal_velocity: velocity + (a.speed + plane.speed) * direction, direction }
    }
}

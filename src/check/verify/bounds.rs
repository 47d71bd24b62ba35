//! Round-off bounds. None is a chosen tolerance: each bound is counted from the numbers that were rounded.

use super::moving::Sway;
use super::world::World;
use crate::Vector;
use crate::engine::{Elapsed, States};

/// Number of roundings between the state at a prediction and the state at its event. For a pair, six
/// coordinates are rounded by one free flight (three operations), by the time of the event and by a wrap.
/// This happens once in the engine and once here. The sum in the overlap function has eight terms. Each
/// rounding is below one unit in the last place of the scales defined below.
const ROUNDINGS: f64 = 32.0;

/// Speeds below the square root of the smallest floating-point number have squares of 0, so their norm or
/// energy has no digits.
const SMALLEST: f64 = 1.5e-154;

/// Returns the error of [`ROUNDINGS`] roundings of a number of the order of `scale`.
pub(super) fn rounded(scale: f64) -> f64 {
    ROUNDINGS * f64::EPSILON * scale + SMALLEST
}

/// Largest acceptable overlap or gap relative to the distance of a discontinuity. Beyond this, round-off
/// proves nothing, however large the rounded numbers are.
const MOST_OF_DISTANCE: f64 = 1e-6;

/// Whether a length within its round-off bound is still far too large for a discontinuity at `distance`.
pub(super) fn is_without_digits(length: f64, distance: f64) -> bool {
    length.abs() > MOST_OF_DISTANCE * distance
}

/// The scales of a particle in flight.
#[derive(Debug, Clone, Copy)]
pub(super) struct Flight {
    /// Largest coordinate rounded since the last event `[length]`.
    length: f64,
    /// Largest speed since the last event `[length / time]`.
    pub speed: f64,
    /// Error of the velocity from the rounding of event times under acceleration `[length / time]`.
    falling: f64,
    /// Time since the last event `[time]`.
    duration: f64,
    /// Angle by which a rotating surface turns within the round-off of a time `[1]`.
    turning: f64,
}

impl Flight {
    /// The flight of a wall, which never moves.
    pub const NONE: Self = Self { length: 0.0, speed: 0.0, falling: 0.0, duration: 0.0, turning: 0.0 };

    /// The flight of a feature, from its largest coordinate and the motion of its surface.
    pub fn of_surface(farthest: f64, sway: &Sway) -> Self {
        let Sway { length, speed, falling, turning, .. } = *sway;
        Self { length: farthest + length, speed, falling, duration: f64::INFINITY, turning }
    }

    /// The flight of a particle, from its state, the time of its last event and the start of the window.
    pub fn new(world: &World, states: &States, i: u32, last_event: &Elapsed, window: &Elapsed) -> Self {
        let duration = states.elapsed.after(last_event).max(0.0);
        let (position, velocity): (&Vector, &Vector) = (&states.positions[i as usize], &states.velocities[i as usize]);
        let acceleration = world.accelerations[i as usize].norm();
        let speed = velocity.norm() + acceleration * duration;
        // Times are rounded as times since the epoch. A prediction may be in an earlier epoch than its
        // event. In the verifier, times are rounded once more, as times in the window.
        let since_epoch = states.elapsed.since_epoch.abs().max(last_event.since_epoch.abs());
        let times = duration + since_epoch.max(states.elapsed.after(window));
        // A coordinate is rounded once more at every wrap, however far it was extrapolated.
        let wraps = if world.shortest_period.is_finite() { speed * duration / world.shortest_period } else { 0.0 };
        // The engine rounds states once when it moves them to the next epoch.
        let epochs = states.elapsed.epochs.saturating_sub(last_event.epochs) as f64;
        // A coordinate outside the box may be as large as the period, whatever its previous value was.
        let largest = position.amax() + speed * times + world.periods.amax();
        let length = largest * (1.0 + (wraps + epochs) / ROUNDINGS);
        let falling = if acceleration > 0.0 {
            acceleration * times + (speed + acceleration * times) * (epochs / ROUNDINGS)
        } else {
            0.0
        };
        Self { length, speed, falling, duration, turning: 0.0 }
    }

    /// Scale of the particle's position `[length]`.
    pub fn position(&self) -> f64 {
        rounded(self.length)
    }

    /// Scales after an event that increased the speed by at most `gained` `[length / time]`.
    pub fn leaving(&self, gained: f64) -> Self {
        Self { speed: self.speed + gained, ..*self }
    }

    /// Scale of the particle's velocity `[length / time]`.
    pub fn velocity(&self) -> f64 {
        rounded(self.speed + self.falling)
    }
}

/// Round-off bounds at a contact.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    /// Bound for a distance `[length]`.
    pub distance: f64,
    /// Bound for a change of velocity `[length / time]`.
    pub velocity: f64,
    /// Bound for the normal velocity `[length / time]`. The direction of the normal depends on rounded
    /// positions.
    pub normal_velocity: f64,
    /// Bound for the direction of the normal `[1]`.
    pub direction: f64,
}

impl Bounds {
    /// Bounds at a discontinuity at `distance`.
    ///
    /// The overlap function is a difference of squares. Its round-off is the round-off of the squared
    /// separation at the prediction. Since the later of their latest events, the two particles have
    /// flown a limited distance; the separation is at most `distance` plus this distance. As a distance, the
    /// round-off is `|r|^2 / s`.
    pub fn pair(world: &World, a: &Flight, b: &Flight, distance: f64) -> Self {
        let flown = (a.speed + b.speed) * a.duration.min(b.duration);
        let separation = (distance + flown).min(world.diagonal.max(distance));
        let bound = rounded(a.length + b.length + distance + separation * separation / distance);
        let speed = a.speed + b.speed;
        let velocity = a.velocity() + b.velocity();
        let direction = rounded(1.0 + b.turning) + bound / distance;
        Self { distance: bound, velocity, normal_velocity: velocity + speed * direction, direction }
    }

    /// Bounds after an event that increased the speeds by at most `gained`. The new velocities are
    /// rounded, too.
    pub fn leaving(&self, gained: f64) -> Self {
        let velocity = self.velocity + rounded(gained);
        Self { velocity, normal_velocity: self.normal_velocity + rounded(gained) + gained * self.direction, ..*self }
    }

    /// At a wall.
    pub fn wall(a: &Flight, at: f64, radius: f64) -> Self {
        let velocity = a.velocity();
        let distance = rounded(a.length + at.abs() + radius);
        Self { distance, velocity, normal_velocity: velocity, direction: 0.0 }
    }

    /// At a plane in any direction, or at a face of the given slenderness.
    pub fn plane(a: &Flight, plane: &Flight, radius: f64, slenderness: f64) -> Self {
        let (velocity, direction) = (a.velocity() + plane.velocity(), rounded(slenderness + plane.turning));
        let distance = rounded((a.length + plane.length) * slenderness + radius);
        Self { distance, velocity, normal_velocity: velocity + (a.speed + plane.speed) * direction, direction }
    }
}

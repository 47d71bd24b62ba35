//! The length of time windows.

use super::window::{Window, reach};
use super::world::World;
use crate::engine::States;

/// In the first window, a particle at the mean speed travels this fraction of the longest range.
const FIRST: f64 = 0.1;
/// Smallest number of events for which a window is planned, because opening windows also takes time.
const FEWEST: u64 = 64;

/// Chooses the length of time windows. A window has about as many events as there are particles. Then the search of all
/// pairs at its start takes about as long as the searches after its events.
#[derive(Debug)]
pub(super) struct Pace {
    target: f64,
}

impl Pace {
    pub fn new(world: &World, states: &States) -> Self {
        let count = world.moving.len().max(1) as f64;
        let mean = |of: &dyn Fn(usize) -> f64| world.moving.iter().map(|&i| of(i as usize)).sum::<f64>() / count;
        let speed = mean(&|i| states.velocities[i].norm());
        let acceleration = mean(&|i| world.accelerations[i].norm());
        Self { target: duration(speed, acceleration, FIRST * world.longest_length) }
    }

    pub fn learn(&mut self, window: &Window, world: &World) {
        let wanted = (world.moving.len() as u64).max(FEWEST) as f64;
        self.target = window.length * (wanted / window.events.max(1) as f64).clamp(0.25, 4.0);
    }

    /// Returns the length of a window that begins now `[time]`. The next event happens after a time `next`. The window
    /// ends before the fastest particle can travel around a periodic box, to limit the number of images.
    pub fn length(&self, world: &World, states: &States, next: f64) -> f64 {
        let wanted = if self.target.is_finite() { self.target.max(1.01 * next) } else { 1.01 * next };
        round_the_box(world, states, &world.moving, wanted).min(wanted)
    }
}

/// Returns the shortest time in which a particle could travel around the box; infinity if longer than `within`.
pub(super) fn round_the_box(world: &World, states: &States, particles: &[u32], within: f64) -> f64 {
    let shortest = world.shortest_period;
    let time = |&i: &u32| {
        let (velocity, acceleration) = (&states.velocities[i as usize], &world.accelerations[i as usize]);
        let is_slow = reach(velocity, acceleration, within) <= shortest;
        if is_slow { f64::INFINITY } else { duration(velocity.norm(), acceleration.norm(), shortest) }
    };
    particles.iter().map(time).fold(f64::INFINITY, f64::min)
}

fn duration(speed: f64, acceleration: f64, distance: f64) -> f64 {
    // Positive solution `t` of `speed t + acceleration t^2 / 2 = distance`.
    2.0 * distance / (speed + (speed * speed + 2.0 * acceleration * distance).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flight_duration_is_exact() {
        assert_eq!(duration(2.0, 0.0, 3.0), 1.5);
        assert_eq!(duration(0.0, 2.0, 4.0), 2.0);
        assert_eq!(duration(1.0, 2.0, 6.0), 2.0);
        assert_eq!(duration(0.0, 0.0, 1.0), f64::INFINITY);
    }
}

//! A particle and a plane: a flat wall, a face of a cell, or a face of a mesh.

use super::stretch::Stretch;

/// Returns the time until the signed distance `h(dt) = height + velocity dt + acceleration/2 dt^2` is `<= 0` and
/// falling. This distance is the overlap function in [`crate::physics::detection`].
#[inline]
#[must_use]
pub fn next_event(height: f64, velocity: f64, acceleration: f64) -> Option<f64> {
    let falls_now = velocity < 0.0 || (velocity == 0.0 && acceleration < 0.0);
    let discriminant = velocity * velocity - 2.0 * acceleration * height;
    if falls_now {
        if height <= 0.0 {
            return Some(0.0);
        }
        if acceleration > 0.0 && discriminant <= 0.0 {
            return None; // turns round before it arrives
        }
        return Some(2.0 * height / (discriminant.sqrt() - velocity));
    }
    if acceleration >= 0.0 {
        return None;
    }
    let turning_point = -velocity / acceleration;
    if discriminant <= 0.0 {
        return Some(turning_point); // still below the plane where it starts to fall
    }
    Some((velocity + discriminant.sqrt()) / -acceleration)
}

/// Returns the interval in which a particle at `height` above a plane falls and is at most `distance` above the plane.
#[must_use]
pub fn falling_stretch(height: f64, distance: f64, velocity: f64, acceleration: f64) -> Option<Stretch> {
    let from = next_event(height - distance, velocity, acceleration)?;
    let until = next_event(height, velocity, acceleration)
        .unwrap_or_else(|| if acceleration > 0.0 { -velocity / acceleration } else { f64::INFINITY });
    let falls_from = if velocity > 0.0 { -velocity / acceleration } else { 0.0 };
    // Despite round-off, the interval of a fall is at least one float long.
    let until = if from > falls_from { until.max(from.next_up()) } else { until };
    Some(Stretch { from, until })
}

#[cfg(test)]
mod tests {
    use super::{Stretch, falling_stretch, next_event};

    #[test]
    fn a_particle_in_free_flight_arrives_if_it_approaches() {
        assert_eq!(next_event(3.0, -2.0, 0.0), Some(1.5));
        assert_eq!(next_event(3.0, 2.0, 0.0), None);
        assert_eq!(next_event(3.0, 0.0, 0.0), None);
        assert_eq!(next_event(-1e-20, -2.0, 0.0), Some(0.0));
        assert_eq!(next_event(-1e-20, 2.0, 0.0), None);
    }

    #[test]
    fn a_falling_particle_arrives_from_rest_from_above_and_after_a_throw() {
        assert_eq!(next_event(2.0, 0.0, -1.0), Some(2.0));
        assert_eq!(next_event(4.0, -1.0, -1.0), Some(2.0));
        assert_eq!(next_event(4.0, 1.0, -1.0), Some(4.0));
        assert_eq!(next_event(0.0, 1.0, -1.0), Some(2.0), "a bounce comes back");
    }

    #[test]
    fn a_particle_that_is_pulled_away_may_turn_round_before_the_plane() {
        assert_eq!(next_event(1.5, -2.0, 1.0), Some(1.0));
        assert_eq!(next_event(2.0, -2.0, 1.0), None, "touches with no speed");
        assert_eq!(next_event(3.0, -2.0, 1.0), None);
        assert_eq!(next_event(3.0, 2.0, 1.0), None);
    }

    #[test]
    fn event_below_the_plane_is_at_turning_point_or_next_arrival() {
        assert_eq!(next_event(-2.0, 1.0, -1.0), Some(1.0));
        assert_eq!(next_event(-2.0, 0.0, -1.0), Some(0.0));
        assert_eq!(next_event(-2.0, 3.0, -1.0), Some(3.0 + 5.0_f64.sqrt()));
    }

    #[test]
    fn stretch_runs_from_contact_distance_to_plane_or_turning_point() {
        let stretch = |height, velocity, acceleration| falling_stretch(height, 1.0, velocity, acceleration);
        assert_eq!(stretch(3.0, -1.0, 0.0), Some(Stretch { from: 2.0, until: 3.0 }));
        assert_eq!(stretch(3.0, -2.5, 1.0), Some(Stretch { from: 1.0, until: 2.0 }));
        assert_eq!(stretch(2.5, -2.0, 1.0), Some(Stretch { from: 1.0, until: 2.0 }));
        assert_eq!(stretch(0.5, 0.25, -1.0).map(|stretch| stretch.from), Some(0.25));
        // The particle is on the other side of the plane, so the interval is empty.
        assert_eq!(stretch(-1.0, -1.0, 0.0), Some(Stretch { from: 0.0, until: 0.0 }));
        assert_eq!(stretch(-2.0, 1.0, -1.0), Some(Stretch { from: 1.0, until: 1.0 }));
    }

    #[test]
    fn a_stretch_shorter_than_floats_resolve_is_not_empty() {
        // Each particle reaches the plane at t = 1.
        for (height, velocity, acceleration) in
            [(0.0, 1.0, -2.0), (1.0, -1.0, 0.0), (2.0, 0.0, -4.0), (0.75, -0.5, -0.5)]
        {
            let found = falling_stretch(height, 1e-18, velocity, acceleration);
            assert_eq!(found, Some(Stretch { from: 1.0, until: 1.0_f64.next_up() }));
        }
    }
}

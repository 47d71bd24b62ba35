use super::error::Unprepared;
use super::replicas::Exchange;
use crate::model::UmbrellaPlan;
use crate::model::space::Space;

fn is_within(distance: f64, [lower, upper]: [f64; 2]) -> bool {
    (lower..=upper).contains(&distance)
}

/// Fraction of a window's width by which a replica may move back on its way to the window. Without this margin,
/// particles between an obstacle and the end of the temporary window would be reflected more and more often.
const BACK: f64 = 0.1;

/// Returns `window` if the distance is inside. Otherwise, returns a temporary window that contains the distance and
/// `window`. It is not wider than the previous temporary window `had`.
fn reaching(distance: f64, window: [f64; 2], had: [f64; 2], space: &Space) -> [f64; 2] {
    if is_within(distance, window) {
        return window;
    }
    // Beyond half a period, the nearest image can change, so the distance cannot be restrained.
    let half = 0.5 * space.periods().min();
    if distance >= half {
        return had;
    }
    let [lower, upper] = window;
    let back = BACK * (upper - lower);
    [had[0].max(lower.min(distance - back)), had[1].min(upper.max(distance + back)).min(half)]
}

impl Exchange {
    /// Restrains the distance of each replica to its window. A window is wider until the distance is inside.
    pub(super) fn begin_windows(&mut self) {
        let Some(UmbrellaPlan { between, windows, .. }) = self.plan.umbrella.clone() else { return };
        for (place, window) in windows.into_iter().enumerate() {
            let simulation = &mut self.replicas[self.places[place]].simulation;
            let free = [0.0, f64::INFINITY];
            simulation.restrain_distance(&between, free);
            let distance = simulation.restrained_distance().unwrap_or(0.0);
            simulation.set_distance_window(reaching(distance, window, free, &simulation.scene().space));
            self.distances.push(distance);
            self.is_outside.push(!is_within(distance, window));
        }
    }

    /// Narrows temporary windows after replicas have moved towards their windows.
    pub(super) fn see_distances(&mut self) {
        let Some(umbrella) = &self.plan.umbrella else { return };
        for (place, window) in umbrella.windows.iter().enumerate() {
            let simulation = &mut self.replicas[self.places[place]].simulation;
            let distance = simulation.restrained_distance().unwrap_or(0.0);
            self.distances[place] = distance;
            if self.is_outside[place] {
                let had = simulation.distance_window().unwrap_or(*window);
                simulation.set_distance_window(reaching(distance, *window, had, &simulation.scene().space));
                self.is_outside[place] = !is_within(distance, *window);
            }
        }
    }

    /// Whether two windows may swap their replicas. The distance of each replica must be in both windows.
    pub(super) fn are_in_both(&self, windows: &[[f64; 2]], lower: usize) -> bool {
        is_within(self.distances[lower], windows[lower + 1]) && is_within(self.distances[lower + 1], windows[lower])
    }

    pub(super) fn swap_windows(&mut self, lower: usize) {
        self.distances.swap(lower, lower + 1);
        let Some(umbrella) = &self.plan.umbrella else { return };
        for place in [lower, lower + 1] {
            self.is_outside[place] = false;
            self.replicas[self.places[place]].simulation.set_distance_window(umbrella.windows[place]);
        }
    }

    pub(super) fn check_windows(&self) -> Result<(), Unprepared> {
        let Some(umbrella) = self.plan.umbrella.as_ref().filter(|_| self.attempts >= self.equilibration / 2) else {
            return Ok(());
        };
        match self.is_outside.iter().position(|is_outside| *is_outside) {
            None => Ok(()),
            Some(place) => Err(Unprepared::Outside {
                window: place,
                ends: umbrella.windows[place],
                distance: self.distances[place],
            }),
        }
    }
}

//! Policies that determine in which periodic images a pair can meet.
//!
//! A policy is chosen when particles are sorted into cells or lists.
//!
//! | policy | applies to | images of a pair |
//! |---|---|---|
//! | nearest | boxes of five or more cells along each period, or with lists | the nearest image |
//! | tied | four cells along a period | the nearest image; at half a period, where rounding decides, also the other image |
//! | several | three or fewer cells | all images in which the pair can meet before either particle changes its cell |
//! | sliding | sheared boxes, see [`lees_edwards`] | the same as without shear, but the images above and below the box are displaced and move at another speed |

pub(super) mod lanes;
mod lees_edwards;
pub(super) mod travelled;

use super::neighbours::Neighbours;
use super::neighbours::cells::Cells;
use super::parts::Engine;
use crate::Vector;
use crate::model::Scene;
use crate::model::space::minimum_image;
use crate::physics::motion::RelativeState;
use lanes::Sliding;
use lees_edwards::LeesEdwards;
use serde::{Deserialize, Serialize};

/// The axis along which the images of a sheared box slide, and the axis of the velocity gradient.
pub(super) const FLOW: usize = 0;
pub(super) const GRADIENT: usize = 1;

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct ImagePolicy {
    /// Images of a small box, except for the nearest image (policy "several").
    pub further: Vec<Vector>,
    /// Axes along which particles in adjacent cells can be half a period apart (policy "tied").
    pub tied: [bool; 3],
    /// Shear of the box (policy "sliding").
    sliding: Option<LeesEdwards>,
}

/// How a prediction tests the images of uncaptured partners.
pub(super) enum Way {
    /// All partners are tested together, in their nearest images.
    Nearest,
    /// All partners are tested together, in all images of a small box.
    Several,
    /// All partners are tested together, including images across the sliding sides.
    Sliding(Sliding),
    /// Each pair is tested separately, in all images.
    OneByOne,
}

impl ImagePolicy {
    pub fn of(scene: &Scene) -> Self {
        Self { further: Vec::new(), tied: [false; 3], sliding: LeesEdwards::of(scene) }
    }

    #[inline]
    pub fn are_sliding(&self) -> bool {
        self.sliding.is_some()
    }

    /// Returns true if the periodic images are at rest, as Verlet lists require.
    pub fn stay(scene: &Scene) -> bool {
        LeesEdwards::of(scene).is_none()
    }

    /// Verlet lists need only the nearest image, because the box limits the width of their skins.
    pub fn choose_for_lists(&mut self) {
        (self.further, self.tied) = (Vec::new(), [false; 3]);
    }

    pub fn choose_for_cells(&mut self, cells: &Cells, periods: &Vector) {
        self.further = cells.grid.further_images(periods);
        self.tied = [false; 3];
        if self.further.is_empty() {
            self.tied = cells.grid.tied_axes();
            if self.are_sliding() {
                // Images along the flow and the gradient are handled separately, because they slide.
                (self.tied[FLOW], self.tied[GRADIENT]) = (false, false);
            }
        }
    }

    /// Time since the epoch at which particles near sliding sides are predicted again; infinite without shear.
    pub fn next_refresh(&self) -> f64 {
        self.sliding.as_ref().map_or(f64::INFINITY, LeesEdwards::next_refresh)
    }

    /// Returns an upper bound of the displacement of sliding images after `time` `[length]`. The displacement at the
    /// beginning is at most one period.
    pub fn farthest_slid(&self, time: f64, periods: &Vector) -> f64 {
        self.sliding.map_or(0.0, |shear| periods[FLOW] + shear.speed.abs() * time)
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Returns the relative state for the nearest image, and true if this image lies across a sliding side.
    #[inline]
    pub(super) fn nearest(&self, position: Vector, velocity: Vector, time: f64) -> (RelativeState, bool) {
        let Some(shear) = &self.images.sliding else {
            return (RelativeState { position: minimum_image(position, &self.state.periods), velocity }, false);
        };
        let mut state = RelativeState { position, velocity };
        let is_across = self.nearest_sheared(&mut state, shear, time);
        (state, is_across)
    }

    /// Calls `visit` for all images, except the nearest, in which an uncaptured pair can meet. `is_across` is true if
    /// the nearest image lies across a sliding side.
    #[inline]
    pub(super) fn for_each_further_image(
        &self,
        nearest: &RelativeState,
        is_across: bool,
        mut visit: impl FnMut(&RelativeState),
    ) {
        if is_across {
            for beside in [-self.state.periods[FLOW], self.state.periods[FLOW]] {
                let mut state = *nearest;
                state.position[FLOW] += beside;
                visit(&state);
            }
        }
        for image in &self.images.further {
            visit(&RelativeState { position: nearest.position + image, ..*nearest });
        }
    }

    /// Calls `visit` for all other images that are as near as `nearest`. An axis is tied if the separation along it is
    /// at least `least`, which is about half a period. Each combination of tied axes gives one image.
    #[inline]
    pub(super) fn for_each_tied_image(
        &self,
        nearest: &RelativeState,
        least: [f64; 3],
        mut visit: impl FnMut(&RelativeState),
    ) {
        let is_tied: [bool; 3] = std::array::from_fn(|axis| nearest.position[axis].abs() >= least[axis]);
        for sides in 1..8_u8 {
            let is_other = |axis: usize| sides >> axis & 1 == 1;
            if (0..3).any(|axis| is_other(axis) && !is_tied[axis]) {
                continue;
            }
            let mut state = *nearest;
            for axis in (0..3).filter(|&axis| is_other(axis)) {
                state.position[axis] -= self.state.periods[axis].copysign(state.position[axis]);
            }
            visit(&state);
        }
    }

    #[inline]
    pub(super) fn way(&self, particle: u32, time: f64) -> Way {
        let has_one_image = self.images.further.is_empty();
        // In a small box, pairs with a relative acceleration or a growing contact distance are tested one by one.
        if !(has_one_image || !(FALLING && TABLE) && self.distances.are_constant()) {
            return Way::OneByOne;
        }
        if !self.images.are_sliding() || self.is_off_sliding_sides(particle) {
            return if has_one_image { Way::Nearest } else { Way::Several };
        }
        match self.sliding(time) {
            Some(sliding) if !(FALLING && TABLE) => Way::Sliding(sliding),
            _ => Way::OneByOne,
        }
    }

    /// Returns true if the nearest images of captured partners are sufficient.
    #[inline]
    pub(super) fn are_captured_nearest(&self, particle: u32) -> bool {
        // A bonded partner can be far away, across a sliding side.
        !self.images.are_sliding()
            || (self.ranges.are_captured_near()
                && !self.is_loosely_bonded(particle)
                && self.is_off_sliding_sides(particle))
    }

    /// Returns true if a particle's predicted contact stays valid when the particle enters another cell. In a small
    /// box, the possible images depend on the cell. Near sliding sides, the adjacent cells change with time.
    #[inline]
    pub(super) fn keeps_contact(&self, particle: u32) -> bool {
        if self.images.are_sliding() { self.is_off_sliding_sides(particle) } else { self.images.further.is_empty() }
    }

    /// For each axis, returns the number of images on either side of the nearest image in which a bonded pair can meet.
    ///
    /// A particle travels at most one cell before it is predicted again, so the separation of a pair grows by at most
    /// two cells. With three or more cells, the separation is at most 1/2 + 2/3 = 7/6 periods. The range is at most
    /// half a period, so images two periods away are out of range. Sliding images add a quarter of a period along x.
    pub(super) fn most_images(&self) -> [i32; 3] {
        let counts = match &self.neighbours {
            Neighbours::Cells(cells) => cells.grid.counts(),
            // With Verlet lists, a particle stays within a narrow skin, as if there were very many cells.
            Neighbours::Lists(_) => [u32::MAX; 3],
        };
        std::array::from_fn(|axis| match counts[axis] {
            _ if self.state.periods[axis] == f64::INFINITY => 0,
            0..3 => 2,
            _ if axis == FLOW && self.images.are_sliding() => 2,
            _ => 1,
        })
    }

    /// Returns the relative state for an image that is `image` periods away from the nearest image.
    pub(super) fn image_of(&self, nearest: &RelativeState, image: [i32; 3], time: f64) -> RelativeState {
        let mut state = *nearest;
        for axis in (0..3).filter(|&axis| image[axis] != 0) {
            state.position[axis] -= f64::from(image[axis]) * self.state.periods[axis];
        }
        if let Some(shear) = &self.images.sliding {
            let up = f64::from(image[GRADIENT]);
            state.position[FLOW] -= up * shear.displacement_within(time, self.state.periods[FLOW]).0;
            state.velocity[FLOW] -= up * shear.speed;
        }
        state
    }

    pub(super) fn displacement(&self) -> (f64, i32) {
        let period = self.state.periods[FLOW];
        self.images.sliding.map_or((0.0, 0), |shear| shear.displacement_within(self.clock.now, period))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::columns::tests::spheres;
    use crate::model::potential::Potential;

    #[test]
    fn all_images_half_a_period_away_are_visited() {
        let scene = spheres(Potential::hard_sphere(1.0).unwrap(), 0.1, 4).build().unwrap();
        let engine = Engine::<false, false>::new(&scene);
        let half = 0.5 * engine.state.periods;
        for axes in 0..8_u8 {
            let is_far = |axis: usize| axes >> axis & 1 == 1;
            let position = Vector::from_fn(|axis, _| if is_far(axis) { half[axis] } else { 0.25 });
            let mut images = vec![position];
            let nearest = RelativeState { position, velocity: Vector::zeros() };
            engine.for_each_tied_image(&nearest, half.into(), |state| images.push(state.position));
            assert_eq!(images.len(), 1 << axes.count_ones(), "{axes:b}");
            for (k, image) in images.iter().enumerate() {
                assert_eq!(image.abs(), position, "as near as the others, and displaced along far axes only");
                assert!(!images[..k].contains(image), "twice: {image}");
            }
        }
    }
}

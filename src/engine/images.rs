//! Images: the periodic images in which a particle can be met.
//!
//! A policy is chosen when particles are sorted into cells or lists. All code that needs a relative state
//! uses this policy:
//!
//! | policy | applies to | images of a pair |
//! |---|---|---|
//! | nearest | boxes of five or more cells along each period, or with lists | the nearest image |
//! | tied | four cells along a period | the nearest image; at half a period, where rounding decides, also the other image |
//! | several | three or fewer cells | all images that can be met before either particle changes its cell |
//! | sliding | sheared boxes, see [`lees_edwards`] | as above, but the images above and below are displaced and move at another speed |

mod lees_edwards;
pub(super) mod travelled;

use super::neighbours::Neighbours;
use super::neighbours::cells::Cells;
use super::parts::Engine;
use super::reach::Sliding;
use crate::Vector;
use crate::model::Scene;
use crate::model::space::minimum_image;
use crate::physics::motion::RelativeState;
use lees_edwards::LeesEdwards;
use serde::{Deserialize, Serialize};

/// The axis along which images slide, and the axis along which their velocity increases.
pub(super) const FLOW: usize = 0;
pub(super) const GRADIENT: usize = 1;

/// The policy.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct ImagePolicy {
    /// Several: the images of a small box other than the nearest; empty for other boxes.
    pub further: Vec<Vector>,
    /// Tied: axes along which neighbours can be half a period apart.
    pub tied: [bool; 3],
    /// Sliding.
    sliding: Option<LeesEdwards>,
}

/// How the first contact with uncaptured partners is found.
pub(super) enum Way {
    /// All partners at once, each in its nearest image.
    Nearest,
    /// As above, and also in the other images of a small box.
    Several,
    /// All partners at once, across sliding sides.
    Sliding(Sliding),
    /// One pair after another, in all images of the pair.
    OneByOne,
}

impl ImagePolicy {
    /// The policy before particles are sorted in.
    pub fn of(scene: &Scene) -> Self {
        Self { further: Vec::new(), tied: [false; 3], sliding: LeesEdwards::of(scene) }
    }

    /// Whether images slide.
    #[inline]
    pub fn slide(&self) -> bool {
        self.sliding.is_some()
    }

    /// Returns whether the images of a scene are at rest. Neighbour lists require this.
    pub fn stay(scene: &Scene) -> bool {
        LeesEdwards::of(scene).is_none()
    }

    /// Chooses the policy for lists: the nearest image. Skins are chosen narrow enough for this.
    pub fn choose_for_lists(&mut self) {
        (self.further, self.tied) = (Vec::new(), [false; 3]);
    }

    /// Chooses the policy for cells.
    pub fn choose_for_cells(&mut self, cells: &Cells, periods: &Vector) {
        self.further = cells.grid.further_images(periods);
        self.tied = [false; 3];
        if self.further.is_empty() {
            self.tied = cells.grid.tied_axes();
            if self.slide() {
                // Images along the flow and the gradient slide and are handled separately.
                (self.tied[FLOW], self.tied[GRADIENT]) = (false, false);
            }
        }
    }

    /// Time since the epoch at which particles next to sliding sides are predicted again; infinite if no
    /// sides slide.
    pub fn next_refresh(&self) -> f64 {
        self.sliding.as_ref().map_or(f64::INFINITY, LeesEdwards::next_refresh)
    }

    /// Returns the largest displacement of sliding images after a time `[length]`. The initial displacement
    /// is at most one period.
    pub fn farthest_slid(&self, time: f64, periods: &Vector) -> f64 {
        self.sliding.map_or(0.0, |shear| periods[FLOW] + shear.speed.abs() * time)
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// The nearest image of a relative state at a time since the epoch, and whether it lies across sliding
    /// sides.
    #[inline]
    pub(super) fn nearest(&self, position: Vector, velocity: Vector, time: f64) -> (RelativeState, bool) {
        let Some(shear) = &self.images.sliding else {
            return (RelativeState { position: minimum_image(position, &self.state.periods), velocity }, false);
        };
        let mut state = RelativeState { position, velocity };
        let is_across = self.nearest_sheared(&mut state, shear, time);
        (state, is_across)
    }

    /// Calls `visit` for the images other than the nearest in which an uncaptured pair can meet; `is_across`
    /// tells whether an image lies across sliding sides.
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

    /// How a particle finds its first contact with uncaptured partners at a time since the epoch.
    #[inline]
    pub(super) fn way(&self, particle: u32, time: f64) -> Way {
        let has_one_image = self.images.further.is_empty();
        // Pairs with a relative acceleration or growing distances are tested in all images at once.
        if !(has_one_image || !(FALLING && TABLE) && self.distances.are_constant()) {
            return Way::OneByOne;
        }
        if !self.images.slide() || self.is_off_sliding_sides(particle) {
            return if has_one_image { Way::Nearest } else { Way::Several };
        }
        match self.sliding(time) {
            Some(sliding) if !(FALLING && TABLE) => Way::Sliding(sliding),
            _ => Way::OneByOne,
        }
    }

    /// Whether all captured partners of a particle are met in their nearest images, as in a box with fixed
    /// images.
    #[inline]
    pub(super) fn are_captured_nearest(&self, particle: u32) -> bool {
        // A distant partner can be across a sliding side even if this particle is far from the sides.
        !self.images.slide()
            || (self.ranges.are_captured_near()
                && !self.has_own_interactions(particle)
                && self.is_off_sliding_sides(particle))
    }

    /// Returns whether the predicted contact of a particle stays valid when it enters another cell. Then only
    /// new neighbours have to be tested. In a small box the possible images change in the new cell, and next
    /// to sliding sides the neighbours change.
    #[inline]
    pub(super) fn keeps_contact(&self, particle: u32) -> bool {
        if self.images.slide() { self.is_off_sliding_sides(particle) } else { self.images.further.is_empty() }
    }

    /// Returns the number of images on either side of the nearest image in which a bonded pair can meet
    /// before either particle is predicted again.
    ///
    /// Until then, each particle travels at most one cell. With three or more cells, a separation of at most
    /// half a period therefore stays below seven sixths of a period. The range is at most half a period.
    /// While images along x slide, separations grow by another quarter of a period.
    pub(super) fn most_images(&self) -> [i32; 3] {
        let counts = match &self.neighbours {
            Neighbours::Cells(cells) => cells.grid.counts(),
            // Skins are smaller than cells.
            Neighbours::Lists(_) => [u32::MAX; 3],
        };
        std::array::from_fn(|axis| match counts[axis] {
            _ if self.state.periods[axis] == f64::INFINITY => 0,
            0..3 => 2,
            _ if axis == FLOW && self.images.slide() => 2,
            _ => 1,
        })
    }

    /// A relative state with another image of the partner, at a time since the epoch.
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

    /// Returns the displacement of the next image above, minus whole periods, and the number of these
    /// periods.
    pub(super) fn displacement(&self) -> (f64, i32) {
        let period = self.state.periods[FLOW];
        self.images.sliding.map_or((0.0, 0), |shear| shear.displacement_within(self.clock.now, period))
    }
}

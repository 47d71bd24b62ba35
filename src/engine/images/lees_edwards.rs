//! Sheared boxes: the periodic images above and below the box slide along x (Lees and Edwards, J. Phys. C 5,
//! 1921, 1972, [doi:10.1088/0022-3719/5/15/006](https://doi.org/10.1088/0022-3719/5/15/006)).
//!
//! Let `g` be the shear rate, and `L_y` the period along y. Each particle has an image that is higher by `L_y`. After a
//! time `t`, this image is displaced by `g L_y t` along x, and its velocity along x is larger by `g L_y`. Particles
//! still fly freely between events, and all equations stay quadratic. Only the images change.

use serde::{Deserialize, Serialize};

use super::lanes::Sliding;
use super::{FLOW, GRADIENT};
use crate::Vector;
use crate::base::numbers::trunc_to_i32;
use crate::engine::neighbours::Neighbours;
use crate::engine::neighbours::cells::Cells;
use crate::engine::neighbours::grid::CellFace;
use crate::engine::parts::Engine;
use crate::engine::sources::Repredict;
use crate::engine::{Invariant, InvariantBroken};
use crate::model::Scene;
use crate::model::space::{displacement_within_period, minimum_image_along};
use crate::physics::motion::RelativeState;

/// When images have slid by this fraction of the box length, pairs across the sliding sides are predicted again. Until
/// then, a particle can meet only the nearest image and its two neighbours.
const SLIDE: f64 = 0.25;

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(in crate::engine) struct LeesEdwards {
    /// Shear rate `g` `[1 / time]`.
    pub rate: f64,
    /// Speed along x of the periodic image above the box `[length / time]`.
    pub speed: f64,
    /// Displacement along x of the periodic image above the box at the epoch, less than one period `[length]`.
    displacement: f64,
    /// Coordinate y at which the streaming velocity is zero `[length]`.
    middle: f64,
    /// Time of the next prediction of pairs across the sliding sides, counted from the epoch.
    next_refresh: f64,
    /// Interval between predictions of the pairs across the sliding sides `[time]`.
    between_refreshes: f64,
}

impl LeesEdwards {
    pub fn of(scene: &Scene) -> Option<Self> {
        let (rate, space, displacement) = (scene.shear_rate?, &scene.space, scene.displacement);
        let speed = rate * space.size[GRADIENT];
        let between_refreshes = SLIDE * space.size[FLOW] / speed.abs();
        let middle = space.lower[GRADIENT] + 0.5 * space.size[GRADIENT];
        Some(Self { rate, speed, displacement, middle, next_refresh: between_refreshes, between_refreshes })
    }

    pub fn next_refresh(&self) -> f64 {
        self.next_refresh
    }

    #[inline]
    fn displacement(&self, time: f64) -> f64 {
        self.displacement + self.speed * time
    }

    /// Returns the displacement along x of the periodic image above the box, in `(-period / 2, period / 2]`, and the
    /// number of whole periods that were subtracted.
    pub fn displacement_within(&self, time: f64, period: f64) -> (f64, i32) {
        let whole = self.displacement(time);
        let within = displacement_within_period(whole, period);
        (within, trunc_to_i32(((whole - within) / period).round()))
    }

    /// Moves the epoch by `shift`. Returns the number of whole periods that were subtracted from the displacement.
    pub fn shift(&mut self, shift: f64, period: f64) -> i32 {
        let before = self.displacement(shift);
        self.displacement = libm::fmod(before, period);
        self.next_refresh -= shift;
        trunc_to_i32(((before - self.displacement) / period).round())
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Returns the streaming velocity at a position, which is `g (y - y_middle)` along x. Zero without shear.
    #[inline]
    pub(in crate::engine) fn streaming_velocity(&self, position: &Vector) -> Vector {
        let mut streaming = Vector::zeros();
        if let Some(shear) = &self.images.sliding {
            streaming[FLOW] = shear.rate * (position[GRADIENT] - shear.middle);
        }
        streaming
    }

    /// Changes `state` to the relative state for the nearest image. Returns true if the image is across a sliding side.
    #[inline]
    pub(in crate::engine) fn nearest_sheared(&self, state: &mut RelativeState, shear: &LeesEdwards, time: f64) -> bool {
        let height = state.position[GRADIENT];
        let is_across = height.abs() > 0.5 * self.state.periods[GRADIENT];
        if is_across {
            let up = 1.0_f64.copysign(height);
            state.position[GRADIENT] -= up * self.state.periods[GRADIENT];
            state.position[FLOW] -= up * shear.displacement(time);
            state.velocity[FLOW] -= up * shear.speed;
        }
        let period = self.state.periods[FLOW];
        state.position[FLOW] -= period * (state.position[FLOW] / period).round();
        state.position[2] = minimum_image_along(state.position[2], self.state.periods[2]);
        is_across
    }

    /// Returns true if a particle has the same contacts as without shear. It then has no neighbours across the sliding
    /// sides, and can meet each neighbour in a single image.
    #[inline]
    pub(in crate::engine) fn is_off_sliding_sides(&self, particle: u32) -> bool {
        let (Some(_), Neighbours::Cells(cells)) = (&self.images.sliding, &self.neighbours) else { return false };
        let tied = cells.grid.tied_axes();
        let is_in_one_image = self.images.further.is_empty() && !tied[FLOW] && !tied[GRADIENT];
        is_in_one_image && !cells.is_outermost(cells.home(particle), GRADIENT)
    }

    /// Returns the displacement and the speed of the images across the sliding sides. `None` without shear, or if a
    /// pair across these sides could meet in several images.
    pub(in crate::engine) fn sliding(&self, time: f64) -> Option<Sliding> {
        let shear = self.images.sliding.as_ref()?;
        let is_in_one_image = self.images.further.is_empty() && !self.images.tied.contains(&true);
        let (displacement, _) = shear.displacement_within(time, self.state.periods[FLOW]);
        is_in_one_image.then_some(Sliding { displacement, speed: shear.speed })
    }

    /// Calls `visit` for the particles across the sliding side next to a particle. All cells along the flow are
    /// visited, because the adjacent cells change with time.
    pub(in crate::engine) fn for_each_across(&self, particle: u32, visit: impl FnMut(u32)) {
        let (Some(_), Neighbours::Cells(cells)) = (&self.images.sliding, &self.neighbours) else { return };
        cells.for_each_across(cells.home(particle), [FLOW, GRADIENT], visit);
    }

    /// Returns true if a particle that leaves its cell through a face crosses a sliding side.
    #[inline]
    pub(in crate::engine) fn slides_behind(&self, cells: &Cells, particle: u32, face: CellFace) -> bool {
        self.images.are_sliding() && usize::from(face.axis) == GRADIENT && cells.wraps_behind(particle, face)
    }

    /// Moves a particle that crosses a sliding side to the position and velocity of its image on the opposite side.
    pub(in crate::engine) fn cross_sliding_side(
        &mut self,
        particle: u32,
        face: CellFace,
        time: f64,
    ) -> Result<(), InvariantBroken> {
        let Some(shear) = self.images.sliding else {
            return Err(self.broken(particle, None, Invariant::Transition));
        };
        self.stream(particle, time);
        let up = if face.is_upper { 1.0 } else { -1.0 };
        let inverse_mass = self.inverse_mass(particle);
        let body = &mut self.state.bodies[particle as usize];
        let before = body.velocity[FLOW];
        body.position[GRADIENT] -= up * self.state.periods[GRADIENT];
        body.position[FLOW] -= up * shear.displacement(time);
        body.velocity[FLOW] -= up * shear.speed;
        let after = body.velocity[FLOW];
        let period = self.state.periods[FLOW];
        let periods = ((body.position[FLOW] - self.state.space.lower[FLOW]) / period).floor();
        body.position[FLOW] -= periods * period;
        let position = body.position;
        self.note_energies(0.0, 0.0, 0.5 / inverse_mass * (after - before) * (after + before));
        self.state.images.add(particle, GRADIENT, trunc_to_i32(up));
        self.state.images.add(particle, FLOW, trunc_to_i32(periods));
        let Neighbours::Cells(cells) = &mut self.neighbours else {
            return Err(self.broken(particle, None, Invariant::Cells));
        };
        cells.slide_in(particle, &position, [FLOW, GRADIENT], !face.is_upper);
        self.repredict(particle, time);
        Ok(())
    }

    /// Moves a particle back to a sliding side if round-off put it beyond. Beyond the side, its velocity would be
    /// wrong, because the images there move at a different speed.
    pub(in crate::engine) fn keep_between_sliding_sides(&mut self, particle: u32) {
        if self.images.are_sliding() {
            let (lower, upper) = (self.state.space.lower[GRADIENT], self.state.space.upper()[GRADIENT].next_down());
            let at = &mut self.state.bodies[particle as usize].position[GRADIENT];
            *at = at.clamp(lower, upper);
        }
    }

    /// Returns the image numbers of a particle for a snapshot. In a snapshot, the displacement of the periodic image
    /// above the box is reduced by `periods` periods. To compensate, the image number along x increases by `periods`
    /// times the image number along y.
    pub(in crate::engine) fn image_numbers(&self, particle: u32, periods: i32) -> [i32; 3] {
        let mut image = self.state.images.of(particle);
        if self.images.are_sliding() {
            image[FLOW] = image[FLOW].wrapping_add(image[GRADIENT].wrapping_mul(periods));
        }
        image
    }

    /// Moves the epoch of the images by `shift`.
    ///
    /// Whole periods are moved from the displacement of the image above to the image numbers along x, so that
    /// `position + image_x (L_x, 0, 0) + image_y (displacement, L_y, 0) + image_z (0, 0, L_z)` stays continuous.
    pub(in crate::engine) fn shift_images(&mut self, shift: f64) {
        let Some(shear) = &mut self.images.sliding else { return };
        let periods = shear.shift(shift, self.state.periods[FLOW]);
        if periods != 0 {
            for particle in self.particles() {
                let along = self.state.images.of(particle)[GRADIENT].wrapping_mul(periods);
                self.state.images.add(particle, FLOW, along);
            }
        }
    }

    /// Returns the particles to predict again after the images have slid.
    pub(in crate::engine) fn refresh_images(&mut self) -> Result<Repredict, InvariantBroken> {
        let (Some(shear), Neighbours::Cells(cells)) = (&mut self.images.sliding, &self.neighbours) else {
            return Err(self.broken(0, None, Invariant::Cells));
        };
        self.clock.now = shear.next_refresh;
        shear.next_refresh += shear.between_refreshes;
        let is_next_to_side = |particle: &u32| cells.is_outermost(cells.home(*particle), GRADIENT);
        // Distant bonded partners can be several rows of cells away from the side.
        let is_found = |particle: &u32| is_next_to_side(particle) || self.is_loosely_bonded(*particle);
        let found = self.particles().filter(|particle| is_found(particle) && !self.is_static(*particle));
        Ok(Repredict::Some(found.collect()))
    }
}

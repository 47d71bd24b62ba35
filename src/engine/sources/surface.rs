//! Contacts of particles with reflecting and thermal surfaces.

use crate::Vector;
use crate::engine::array::Array;
use crate::engine::audit::unit_of_surface;
use crate::engine::contact::apply::{Change, With};
use crate::engine::contact::rough::Push;
use crate::engine::event::CountedKind;
use crate::engine::observe::Observe;
use crate::engine::parts::Engine;
use crate::engine::surfaces::{Placed, Shape, Surface, Surfaces};
use crate::engine::{Invariant, InvariantBroken};
use crate::model::random::{Purpose, Random};
use crate::model::state_point::StatePoint;
use crate::model::surface_motion::Moment;
use crate::model::{ContactLaw, Scene, SurfaceLaw};
use crate::physics::response::Leaving;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// Random numbers of thermal surfaces. The stream depends only on the particle and on the number of its contacts.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(in crate::engine) struct SurfaceRandom {
    pub stream: Random,
    pub contacts: Array<u32>,
}

impl SurfaceRandom {
    pub fn of(scene: &Scene, surfaces: &Surfaces) -> Option<Self> {
        surfaces.are_ever_thermal().then(|| Self {
            stream: Random::new(StatePoint::at_start(scene).seed(scene.seed), Purpose::Surface, scene.first_stream()),
            contacts: vec![0; scene.particles.len()].into(),
        })
    }

    fn next(&mut self, particle: u32, id: u32) -> &mut Random {
        let count = &mut self.contacts[particle as usize];
        self.stream.seek(id, *count);
        *count = count.wrapping_add(1);
        &mut self.stream
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    pub(in crate::engine) fn execute_surface(
        &mut self,
        i: u32,
        index: u32,
        time: f64,
        observe: &mut Observe<'_>,
    ) -> Result<ControlFlow<()>, InvariantBroken> {
        let flown = time - self.state.bodies[i as usize].time;
        self.stream(i, time);
        let Some(placed) = self.sources.surfaces.get(index) else {
            return Err(self.broken(i, None, Invariant::Surface));
        };
        let at = self.touching(i, placed, time);
        let (shape, law) = (at.shape, placed.law);
        if self.sources.sleepers.is_some() && !at.does_no_work() {
            self.note_drive(i);
        }
        let radius = self.radius(i);
        let normal = shape.normal(&at.position);
        let vn = normal.dot(&at.velocity);
        let depth = -shape.gap(&at.position, radius);
        if depth > 0.0 {
            let unit = unit_of_surface(radius);
            self.counts.totals.deepest_overlap = self.counts.totals.deepest_overlap.max(depth / unit);
            self.note_overlap(depth, unit, self.round_off_of_surface(i, &at, flown));
        }
        if vn >= 0.0 {
            self.counts.totals.turning_point += 1;
        }
        let (change, rough) = match law {
            SurfaceLaw::Outlet => return self.leave_at_outlet(i, index, &at, observe),
            SurfaceLaw::Reflecting(law) => self.reflect(i, &at, vn, &law),
            SurfaceLaw::Thermal { temperature } => (self.draw_from_surface(i, &at, temperature)?, None),
        };
        let (counted, other, line) = (Some(CountedKind::Wall), With::Surface(index), at.in_space(&normal));
        let change = Change { counted, other, line, squared: 1.0, distance: radius, ..change };
        Ok(match rough {
            None => self.apply(&change, observe),
            Some(rough) => self.apply_at_rough_surface(change, at, rough, observe),
        })
    }

    /// Returns the state of a particle and a surface at their contact. The argument `time` is counted from the epoch.
    #[inline]
    pub(in crate::engine) fn touching(&self, i: u32, placed: &Placed, time: f64) -> Touching {
        let (position, velocity) = self.state_at(i, time);
        let mut at =
            Touching { shape: placed.shape, moment: None, position, velocity, place: position, material: None };
        if !placed.is_at_rest() {
            at.moment = self.sources.surfaces.moment(placed, self.simulated(time));
            (at.position, at.velocity) =
                at.moment.map_or((position, velocity), |moment| moment.seen(&position, &velocity));
        }
        if placed.has_velocity {
            at.material = self.sources.surfaces.material_velocity(placed, &at.position, self.radius(i));
        }
        at
    }

    /// Returns the smooth part of the change. If the contact is rough, also returns the push of the surface.
    #[inline]
    fn reflect(&mut self, i: u32, at: &Touching, vn: f64, law: &ContactLaw) -> (Change, Option<Push>) {
        let radius = self.radius(i);
        let (shape, normal) = (&at.shape, at.shape.normal(&at.position));
        let bend =
            if self.pairs.contact_times.is_some() { shape.bend(&at.position, &at.velocity, radius) } else { 0.0 };
        let before = self.state.bodies[i as usize].velocity;
        let acceleration = at.acceleration(&before, self.acceleration(i));
        let closing_at_rest = -normal.dot(&acceleration);
        let closing = [closing_at_rest - bend, closing_at_rest];
        // A rough surface with a material acts on the velocity relative to the material.
        let material = at.material.filter(|_| law.roughness.is_some());
        let along = material.map_or(at.velocity, |material| at.velocity - material);
        let Leaving { speed, tangential_scale, roughness, is_lifted, rattle, .. } =
            self.leave_surface(i, (&along, vn), closing, law, self.clock.now);
        let inverse_mass = self.inverse_mass(i);
        let scaled = match material {
            _ if tangential_scale == 1.0 => at.velocity,
            None => along * tangential_scale,
            Some(material) => along * tangential_scale + material,
        };
        let after = at.outwards(shape.with_normal_speed(&at.position, &scaled, speed));
        let dissipated = if tangential_scale == 1.0 { 0.5 / inverse_mass * (vn - speed) * (vn + speed) } else { 0.0 };
        let change = Change::of_one(With::Program, i, &before, after, inverse_mass);
        let supplied = if at.does_no_work() { 0.0 } else { change.supplied + dissipated };
        let rough = roughness.map(|roughness| Push { roughness, impulse: (speed - vn) / inverse_mass, speed, rattle });
        (Change { supplied, dissipated, is_lifted, ..change }, rough)
    }

    /// Draws the velocity of a particle from the flux distribution of a gas. Along the normal, the density is
    /// `(m v / T) exp(- m v^2 / 2 T)`. The other components have a normal distribution. All components are relative to
    /// the material of the surface.
    fn draw_from_surface(&mut self, i: u32, at: &Touching, temperature: f64) -> Result<Change, InvariantBroken> {
        let inverse_mass = self.inverse_mass(i);
        let width = (temperature * inverse_mass).sqrt();
        let body = self.state.bodies[i as usize];
        let Some(random) = &mut self.sources.surface_random else {
            return Err(self.broken(i, None, Invariant::SurfaceRandom));
        };
        let random = random.next(i, body.id);
        let drawn = random.normal_vector(&self.state.space) * width;
        let speed = width * (2.0 * random.exponential()).sqrt();
        let seen = at.shape.with_normal_speed(&at.position, &drawn, speed);
        let after = at.outwards(at.material.map_or(seen, |material| seen + material));
        Ok(Change::of_one(With::Program, i, &body.velocity, after, inverse_mass))
    }
}

/// A particle at a surface, in the frame of the surface.
#[derive(Debug, Clone, Copy)]
pub(in crate::engine) struct Touching {
    pub shape: Shape,
    /// Position and motion of the surface, or `None` if it never moves.
    pub moment: Option<Moment>,
    pub position: Vector,
    pub velocity: Vector,
    /// Position of the particle in the laboratory frame.
    pub place: Vector,
    /// Velocity of the surface's material along the surface. `None` if the material does not move along the surface.
    pub material: Option<Vector>,
}

impl Touching {
    #[inline]
    pub(in crate::engine) fn in_space(&self, direction: &Vector) -> Vector {
        self.moment.as_ref().map_or(*direction, |moment| moment.pose.direction(direction))
    }

    /// Converts the spin of the particle to the frame of the surface, which may rotate.
    pub(in crate::engine) fn spin_seen(&self, spin: &Vector) -> Vector {
        self.moment.as_ref().map_or(*spin, |moment| moment.pose.direction_of_shape(&(spin - moment.spin)))
    }

    /// Whether the surface and its material are at rest.
    #[inline]
    pub fn does_no_work(&self) -> bool {
        self.moment.is_none() && self.material.is_none()
    }

    #[inline]
    fn acceleration(&self, velocity: &Vector, acceleration: Vector) -> Vector {
        let seen = |moment: &Moment| moment.acceleration_seen(&self.place, velocity, &acceleration);
        self.moment.as_ref().map_or(acceleration, seen)
    }

    /// Converts a velocity to the laboratory frame. The result moves the particle away from the surface.
    #[inline]
    fn outwards(&self, seen: Vector) -> Vector {
        self.away(self.moment.as_ref().map_or(seen, |moment| moment.velocity_of(&self.place, &seen)))
    }

    /// If round-off leaves the particle moving into the surface, increases the velocity along the normal.
    /// [`super::super::contact::law`] does the same for pairs.
    #[inline]
    pub(in crate::engine) fn away(&self, mut velocity: Vector) -> Vector {
        if !self.is_closing(&velocity) {
            return velocity;
        }
        let mut change = f64::EPSILON * velocity.amax().max(f64::MIN_POSITIVE);
        let normal = self.in_space(&self.shape.normal(&self.position));
        // The first change has the size of round-off. After 52 doublings, it would be as large as the largest velocity.
        for _ in 0..52 {
            velocity += normal * change;
            if !self.is_closing(&velocity) {
                break;
            }
            change *= 2.0;
        }
        velocity
    }

    #[inline]
    fn is_closing(&self, velocity: &Vector) -> bool {
        match &self.moment {
            None => self.shape.is_closing(&self.position, velocity),
            Some(moment) => self.shape.is_closing(&self.position, &moment.seen(&self.place, velocity).1),
        }
    }
}

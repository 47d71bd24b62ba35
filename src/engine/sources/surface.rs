//! Contacts of particles with surfaces, reflecting or thermal.

use crate::Vector;
use crate::engine::audit::unit_of_surface;
use crate::engine::contact::apply::{Change, With};
use crate::engine::event::CountedKind;
use crate::engine::observe::Observe;
use crate::engine::parts::Engine;
use crate::engine::predict::Streamed;
use crate::engine::prediction::Prediction;
use crate::engine::surfaces::{Flight, Law, Placed, Shape, Surface, Surfaces};
use crate::engine::{Invariant, InvariantBroken};
use crate::model::Scene;
use crate::model::random::{Purpose, Random};
use crate::physics::response::Leaving;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// The random numbers of surfaces are those of a stage that no scene has.
const STAGE: usize = 1 << 40;

/// Random numbers of thermal surfaces. Each contact has its own, by the particle and the number of its contacts so far: the order of contacts of
/// different particles decides nothing.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(in crate::engine) struct SurfaceRandom {
    pub stream: Random,
    /// Contacts with thermal surfaces so far.
    pub contacts: Vec<u32>,
}

impl SurfaceRandom {
    /// Random numbers of the surfaces of a scene, if some are thermal.
    pub fn of(scene: &Scene, surfaces: &Surfaces) -> Option<Self> {
        surfaces.are_ever_thermal().then(|| Self {
            stream: Random::new(scene.seed, Purpose::Thermostat, STAGE + scene.first_stream()),
            contacts: vec![0; scene.particles.len()],
        })
    }

    /// Random numbers of the next contact of a particle.
    fn next(&mut self, particle: u32, name: u32) -> &mut Random {
        let count = &mut self.contacts[particle as usize];
        self.stream.seek(name, *count);
        *count = count.wrapping_add(1);
        &mut self.stream
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Predicts contacts with surfaces: of those without a limited extent, but for those that `is_near` leaves out, and of features that come before
    /// what is foreseen.
    #[inline]
    pub(in crate::engine) fn predict_surfaces(
        &self,
        me: &Streamed,
        is_near: impl Fn(&Placed, f64) -> bool,
        prediction: &mut Prediction,
    ) {
        let flight = self.flight(me);
        self.sources.surfaces.for_each_unlimited(self.row(me.id), |index, surface| {
            if is_near(surface, flight.radius) {
                self.predict_surface(me, &flight, (index, surface), prediction);
            }
        });
        if self.sources.surfaces.has_features() {
            self.predict_features(me, prediction);
        }
    }

    /// Predicts contacts with features that come before what is foreseen. They have to be looked for again whenever the transition comes later than it was.
    pub(in crate::engine) fn predict_features(&self, me: &Streamed, prediction: &mut Prediction) {
        let flight = self.flight(me);
        let swept = flight.swept(prediction.due_time() - me.time);
        self.sources.surfaces.for_each_feature(&swept, self.row(me.id), |index, feature| {
            self.predict_surface(me, &flight, (index, feature), prediction);
        });
    }

    /// Whether surfaces have images in a periodic box. A particle that comes round it meets others of them, and those that it met before are elsewhere.
    pub(in crate::engine) fn has_images_of_surfaces(&self) -> bool {
        !self.sources.surfaces.of_scene().is_empty()
    }

    #[inline]
    fn predict_surface(
        &self,
        me: &Streamed,
        flight: &Flight<'_>,
        (index, surface): (u32, &Placed),
        prediction: &mut Prediction,
    ) {
        if let Some(dt) = surface.shape.next_contact(flight)
            && me.time + dt < prediction.contact_time
        {
            prediction.reach(index, me.time + dt, self.state.bodies[me.id as usize].name);
        }
    }

    /// A particle as a surface sees it.
    #[inline]
    pub(in crate::engine) fn flight<'a>(&self, me: &'a Streamed) -> Flight<'a> {
        let radius = self.pairs.rules.species[usize::from(self.row(me.id))].radius;
        Flight { position: &me.position, velocity: &me.velocity, acceleration: &me.acceleration, radius }
    }

    /// A particle reaches a surface.
    pub(in crate::engine) fn execute_surface(
        &mut self,
        i: u32,
        index: u32,
        time: f64,
        observe: &mut Observe<'_>,
    ) -> Result<ControlFlow<()>, InvariantBroken> {
        let flown = time - self.state.bodies[i as usize].time;
        self.stream(i, time);
        let Some(&Placed { ref shape, law, .. }) = self.sources.surfaces.get(index) else {
            return Err(self.broken(i, None, Invariant::Surface));
        };
        let shape = *shape;
        let radius = self.pairs.rules.species[usize::from(self.row(i))].radius;
        let body = &self.state.bodies[i as usize];
        let normal = shape.normal(&body.position);
        let vn = normal.dot(&body.velocity);
        let depth = -shape.gap(&body.position, radius);
        if depth > 0.0 {
            let unit = unit_of_surface(radius);
            self.counts.totals.deepest_overlap = self.counts.totals.deepest_overlap.max(depth / unit);
            self.note_overlap(depth, unit, self.round_off_of_surface(i, &shape, flown));
        }
        if vn >= 0.0 {
            self.counts.totals.turning_point += 1;
        }
        let change = match law {
            Law::Reflecting { restitution } => self.reflect(i, &shape, &normal, vn, restitution),
            Law::Thermal { temperature } => self.draw_from_surface(i, &shape, temperature)?,
        };
        let change = Change { other: With::Surface(index), ..change };
        let counted = Some(CountedKind::Wall);
        Ok(self.apply(&Change { counted, line: normal, squared: 1.0, distance: radius, ..change }, observe))
    }

    /// A particle is reflected by a surface.
    #[inline]
    fn reflect(&mut self, i: u32, shape: &Shape, normal: &Vector, vn: f64, restitution: f64) -> Change {
        let body = &self.state.bodies[i as usize];
        let radius = self.pairs.rules.species[usize::from(self.row(i))].radius;
        let bend =
            if self.pairs.contact_times.is_some() { shape.bend(&body.position, &body.velocity, radius) } else { 0.0 };
        let closing = -normal.dot(&self.acceleration(i)) - bend;
        let Leaving { speed, tangential_scale } = self.leave_surface(i, vn, closing, restitution, self.clock.now);
        let inverse_mass = self.inverse_mass(i);
        let body = &self.state.bodies[i as usize];
        let before = body.velocity;
        let scaled = if tangential_scale == 1.0 { before } else { before * tangential_scale };
        let after = outwards(shape, &body.position, shape.with_normal_speed(&body.position, &scaled, speed));
        let dissipated = if tangential_scale == 1.0 { 0.5 / inverse_mass * (vn - speed) * (vn + speed) } else { 0.0 };
        let change = Change::of_one(With::Program, i, &before, after, inverse_mass);
        Change { supplied: 0.0, dissipated, ..change }
    }

    /// A particle leaves a surface with a velocity from the flux of a gas of its temperature: its normal component has the density
    /// `(m v / T) exp(- m v^2 / 2 T)`, the others are normal.
    fn draw_from_surface(&mut self, i: u32, shape: &Shape, temperature: f64) -> Result<Change, InvariantBroken> {
        let inverse_mass = self.inverse_mass(i);
        let width = (temperature * inverse_mass).sqrt();
        let body = self.state.bodies[i as usize];
        let Some(random) = &mut self.sources.surface_random else {
            return Err(self.broken(i, None, Invariant::SurfaceRandom));
        };
        let random = random.next(i, body.name);
        let drawn = random.normal_vector(&self.state.space) * width;
        let speed = width * (2.0 * random.exponential()).sqrt();
        let after = outwards(shape, &body.position, shape.with_normal_speed(&body.position, &drawn, speed));
        Ok(Change::of_one(With::Program, i, &body.velocity, after, inverse_mass))
    }
}

/// Rounds a velocity after a contact away from the surface, in the numbers that prediction will see, as [`super::super::contact::law`] does for pairs.
#[inline]
fn outwards(shape: &Shape, position: &Vector, mut velocity: Vector) -> Vector {
    if !shape.is_closing(position, &velocity) {
        return velocity;
    }
    let mut change = f64::EPSILON * velocity.amax().max(f64::MIN_POSITIVE);
    let normal = shape.normal(position);
    // 52 doublings take a float's spacing to the float itself.
    for _ in 0..52 {
        velocity += normal * change;
        if !shape.is_closing(position, &velocity) {
            break;
        }
        change *= 2.0;
    }
    velocity
}

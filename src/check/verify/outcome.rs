//! Checks the outcome of an event against the collision rule, from the states before and after.

use super::barrier::{Arrival, ContactMemory, Leaving};
use super::bounds::{Bounds, Flight, rounded};
use super::certificate::{Margins, note};
use super::contact::Contact;
use super::moving::Carried;
use super::rub::{Rub, Rubbed};
use super::rules::{Side, Step};
use super::violation::{Fault, Quantity};
use super::world::{Wall, World};
use crate::Vector;
use crate::check::reference::Touch;
use crate::engine::States;
use crate::engine::event::{Event, Outcome};
use crate::model::{ContactLaw, Roughness};

/// An event, with all data that determine its outcome.
pub(super) struct Encounter<'a> {
    pub world: &'a World,
    pub event: &'a Event,
    /// States just before the event, calculated from free flights, and states just after the event, as recorded.
    pub before: &'a States,
    pub after: &'a States,
    pub bounds: Bounds,
    pub flights: [Flight; 2],
    pub contacts: &'a Option<ContactMemory>,
    pub margins: &'a mut Margins,
}

/// Curvature and acceleration that may bring a particle back to a barrier.
struct Bend {
    /// Radius of curvature of the barrier `[length]`. Infinite for a plane, negative for a barrier around the particle.
    radius: f64,
    /// Axis of a cylindrical barrier, along which the barrier has no curvature.
    along: Option<Vector>,
    /// Acceleration relative to the partner or the surface, and the magnitude of the terms in it `[length / time^2]`.
    acceleration: Vector,
    rounded_with: f64,
}

/// The relative motion of two particles, or of a particle and a wall or surface, at their contact.
struct Motion<'a> {
    particles: &'a [u32],
    weights: &'a [f64],
    reduced_mass: f64,
    /// Unit vector from the partner, wall or surface towards the particle.
    normal: Vector,
    /// Direction of the valid side: 1 along the normal, -1 against it.
    outwards: f64,
    velocity: Vector,
    radial: f64,
    /// Velocity of the surface at the contact; zero for other contacts `[length / time]`.
    surface: Vector,
    /// Angular velocity of the surface; zero for other contacts `[1 / time]`.
    surface_spin: Vector,
    /// Velocity of the material along the surface, and its uncertainty; zero for other contacts `[length / time]`.
    material: (Vector, f64),
    /// Whether a surface moves, or its material.
    works: bool,
    /// The rough contact; `None` at a smooth barrier.
    rub: Option<Rub>,
}

impl Motion<'_> {
    /// Returns the speed towards the discontinuity, or 0 if the particles recede.
    fn approach(&self) -> f64 {
        (-self.outwards * self.radial).max(0.0)
    }

    fn tangential(&self) -> Vector {
        self.velocity - self.normal * self.radial
    }

    /// Tangential velocity relative to the material of a surface.
    fn slip_of_centre(&self) -> Vector {
        self.tangential() - self.material.0
    }
}

impl Encounter<'_> {
    /// Checks the outcome of a pair event.
    pub fn check_pair(
        &mut self,
        j: u32,
        side: Side,
        seen: &Step,
        law: &ContactLaw,
        found: Outcome,
    ) -> Result<(), Fault> {
        let i = self.event.particle.0;
        let weights = [i, j].map(|p| self.world.inverse_masses[p as usize]);
        let reduced_mass = 1.0 / (weights[0] + weights[1]);
        let apart = self.world.nearest(self.before, i, j);
        let normal = apart.try_normalize(0.0).unwrap_or(self.event.normal);
        let relative = |states: &States| states.velocities[i as usize] - states.velocities[j as usize];
        let velocity = relative(self.before);
        let radial = velocity.dot(&normal);
        let outwards = side.sign();
        let (particles, weights, surface) = (&[i, j][..], &weights[..], Vector::zeros());
        let rub = law.roughness.filter(|_| seen.is_barrier() && side == Side::Positive).map(|roughness| {
            let [a, b] = [i, j].map(|p| self.world.radius(p));
            let arms = [a, b].map(|radius| radius / (a + b) * seen.distance);
            self.rub(roughness, &[Some(i), Some(j)], arms, [normal, velocity, Vector::zeros()])
        });
        let (surface_spin, material, works) = (Vector::zeros(), (Vector::zeros(), 0.0), false);
        let motion = Motion {
            particles,
            weights,
            reduced_mass,
            normal,
            outwards,
            velocity,
            radial,
            surface,
            surface_spin,
            material,
            works,
            rub,
        };

        let (expected, crosses) = self.expected(side, seen, &motion, found);
        let contact = Contact::of(self.event);
        if found != expected {
            return Err(Fault::WrongOutcome { contact, expected, found });
        }
        let arriving = self.bounds;
        self.expect_gain(&motion, seen);
        let energy_step = if crosses { seen.energy } else { 0.0 };
        self.within(Quantity::EnergyStep, (self.event.energy_step - energy_step).abs(), 0.0)?;
        self.within(Quantity::Normal, (self.event.normal - normal).norm(), 2.0 * self.bounds.direction)?;
        let onwards = if crosses { outwards } else { -outwards };
        let wrong_way = onwards * relative(self.after).dot(&normal);
        self.within(Quantity::Direction, wrong_way, self.bounds.normal_velocity)?;
        if !seen.is_barrier() {
            self.check_velocities(&motion, &Vector::zeros(), 0.0, &Rubbed::NONE)?;
            return self.check_energy(&motion, (0.0, 0.0), &Rubbed::NONE);
        }
        let acceleration = self.world.accelerations[i as usize] - self.world.accelerations[j as usize];
        let radius = apart.norm().max(f64::MIN_POSITIVE);
        let bend = Bend { radius, along: None, acceleration, rounded_with: 0.0 };
        self.check_barrier(&motion, law, &bend, &arriving)
    }

    pub fn check_wall(&mut self, wall: &Wall) -> Result<(), Fault> {
        let mut normal = Vector::zeros();
        normal[usize::from(wall.axis)] = wall.inwards();
        self.within(Quantity::Normal, (self.event.normal - normal).norm(), 0.0)?;
        let acceleration = self.world.accelerations[self.event.particle.0 as usize];
        let bend = Bend { radius: f64::INFINITY, along: None, acceleration, rounded_with: 0.0 };
        self.check_reflection(&normal, &wall.law, &bend, &Carried::at_rest(acceleration))
    }

    /// Checks a reflection off a feature of a surface, in the frame of the surface.
    pub fn check_surface(&mut self, touch: &Touch, law: &ContactLaw, carried: &Carried) -> Result<(), Fault> {
        let sign = touch.side.sign();
        let normal = touch.normal * sign;
        self.within(Quantity::Normal, (self.event.normal - normal).norm(), 2.0 * self.bounds.direction)?;
        let Carried { acceleration, rounded_with, .. } = *carried;
        let bend = Bend { radius: sign / touch.curvature, along: touch.along, acceleration, rounded_with };
        self.check_reflection(&normal, law, &bend, carried)
    }

    /// Returns a rough contact. `bodies` contains the particle and, in a pair event, the partner.
    fn rub(
        &self,
        roughness: Roughness,
        bodies: &[Option<u32>; 2],
        arms: [f64; 2],
        [normal, velocity, surface_spin]: [Vector; 3],
    ) -> Rub {
        let spin = |p: u32| self.before.spins.get(p as usize).copied().unwrap_or_default() - surface_spin;
        let all = |of: &[f64]| bodies.map(|body| body.map_or(0.0, |p| of[p as usize]));
        Rub {
            roughness,
            normal,
            velocity,
            spins: bodies.map(|body| body.map_or(Vector::zeros(), spin)),
            arms,
            inverse_inertias: all(&self.world.inverse_inertias),
            inverse_mass: all(&self.world.inverse_masses).iter().sum(),
            material_bound: 0.0,
        }
    }

    /// Checks a reflection. The normal points to the particle.
    fn check_reflection(
        &mut self,
        normal: &Vector,
        law: &ContactLaw,
        bend: &Bend,
        carried: &Carried,
    ) -> Result<(), Fault> {
        let Carried { velocity: surface, spin: surface_spin, material, works, .. } = *carried;
        let i = self.event.particle.0;
        let leaving = normal.dot(&(self.after.velocities[i as usize] - surface));
        self.within(Quantity::Direction, -leaving, self.bounds.normal_velocity)?;
        let weight = self.world.inverse_masses[i as usize];
        let velocity = self.before.velocities[i as usize] - surface;
        let motion = Motion {
            particles: &[i],
            weights: &[weight],
            reduced_mass: 1.0 / weight,
            normal: *normal,
            outwards: 1.0,
            velocity,
            radial: normal.dot(&velocity),
            surface,
            surface_spin,
            works,
            material,
            rub: law.roughness.map(|roughness| {
                let arms = [self.world.radius(i), 0.0];
                let rub = self.rub(roughness, &[Some(i), None], arms, [*normal, velocity - material.0, surface_spin]);
                Rub { material_bound: material.1, ..rub }
            }),
        };
        let bounds = self.bounds;
        self.check_barrier(&motion, law, bend, &bounds)
    }

    /// Adjusts the round-off bounds to the velocities after the event.
    ///
    /// With the reduced mass `mu`, the normal velocity `vn` before and `vn'` after the event, and the energy step `dU`,
    /// the impulse is `mu |vn' - vn|`, and `vn'^2` is at most `vn^2 + 2 |dU| / mu`. In the TC model, the impulse may
    /// depend on the whole relative velocity instead of `vn`.
    fn expect_gain(&mut self, motion: &Motion, seen: &Step) {
        let step = if seen.is_barrier() { 0.0 } else { 2.0 * seen.energy.abs() / motion.reduced_mass };
        let turns = seen.is_barrier() && self.contacts.is_some();
        let speed = if turns { motion.velocity.norm() } else { motion.radial.abs() };
        let change = speed + (speed * speed + step).sqrt();
        // The tangential impulse is at most `2 m v`, with the tangential mass `m` and the velocity `v` of the surfaces.
        let rubbing = motion.rub.map_or(0.0, |rub| 2.0 * (rub.velocity.norm() + rub.turning_speed()));
        self.expect_change(motion, change + rubbing);
    }

    /// Adjusts the round-off bounds to a change of the relative velocity.
    fn expect_change(&mut self, motion: &Motion, change: f64) {
        for (flight, weight) in self.flights.iter_mut().zip(motion.weights) {
            let gained = weight * motion.reduced_mass * change;
            *flight = flight.leaving(gained);
            self.bounds = self.bounds.leaving(gained);
        }
    }

    /// Also returns whether the pair crosses the discontinuity. If the energies are equal within round-off, accepts
    /// `found`.
    fn expected(&self, side: Side, seen: &Step, motion: &Motion, found: Outcome) -> (Outcome, bool) {
        let (crossing, barrier) = match side {
            Side::Positive => (Outcome::Capture, Outcome::Core),
            Side::Negative => (Outcome::Release, Outcome::Bounce),
        };
        if seen.is_barrier() {
            return (barrier, false);
        }
        let (step, vn) = (2.0 * seen.energy / motion.reduced_mass, motion.radial);
        let squared = vn * vn - step;
        let slack = 2.0 * vn.abs() * self.bounds.normal_velocity + rounded(vn * vn + step.abs());
        let crosses = if squared.abs() <= slack { found == crossing } else { squared > 0.0 };
        (if crosses { crossing } else { Outcome::Bounce }, crosses)
    }

    /// Checks a contact with a barrier. The round-off bounds before the contact are `arriving`.
    fn check_barrier(
        &mut self,
        motion: &Motion,
        law: &ContactLaw,
        bend: &Bend,
        arriving: &Bounds,
    ) -> Result<(), Fault> {
        let (approach, slack) = (motion.approach(), arriving.normal_velocity);
        let (tangential, shifted) = (motion.slip_of_centre().norm(), motion.material.1);
        let rebound = |slack: f64| {
            let speed = law.restitution.at(approach, motion.reduced_mass) * approach;
            (
                speed,
                law.restitution.steepness([approach - slack, approach + slack]) * slack
                    + if law.restitution.is_constant() { 0.0 } else { rounded(speed) },
            )
        };
        let plain = || vec![Leaving::at(rebound(slack), None, true)];
        // The contacts of a static particle do not count, even if it is only asleep.
        let moving: Vec<u32> = motion.particles.iter().copied().filter(|&i| !self.world.is_static(i)).collect();
        let leavings = self.contacts.as_ref().map_or_else(plain, |contacts| {
            let Bend { radius, acceleration, .. } = *bend;
            let around = bend.along.map_or(motion.tangential(), |along| {
                let tangential = motion.tangential();
                tangential - along * along.dot(&tangential)
            });
            let centrifugal = around.norm_squared() / radius;
            let closing_at_rest = -motion.outwards * acceleration.dot(&motion.normal);
            let closing = closing_at_rest - motion.outwards * centrifugal;
            let bound = 2.0 * around.norm() * slack / radius.abs()
                + (acceleration.norm() + centrifugal.abs()) * (arriving.direction + rounded(1.0))
                + rounded(bend.rounded_with);
            let (approach, tangential) = ((approach, slack), (tangential, slack + shifted));
            let arrival = Arrival {
                rebound: rebound(slack),
                approach,
                tangential,
                closing: (closing, bound),
                closing_at_rest: (closing_at_rest, bound),
            };
            let leavings = contacts.leavings(&arrival, &moving, &self.after.elapsed);
            let at_moving = |leaving: Leaving| leaving.at_moving_surface((approach.0, slack));
            if motion.works { leavings.into_iter().map(at_moving).collect() } else { leavings }
        });
        let straight = leavings.iter().filter(|leaving| leaving.sliding.is_none());
        let fastest = straight.map(|leaving| leaving.speed.0.max(leaving.fastest.0)).fold(0.0, f64::max);
        if fastest > approach {
            self.expect_change(motion, fastest + approach);
        }
        let mut fault = None;
        let margins = *self.margins;
        for leaving in leavings {
            match self.check_leaving(motion, &leaving) {
                Ok(()) => return Ok(()),
                Err(found) => fault = fault.or(Some(found)),
            }
            *self.margins = margins;
        }
        Err(fault.unwrap_or(Fault::WrongNumbers {
            contact: Contact::of(self.event),
            quantity: Quantity::Impulse,
            by: f64::NAN,
            bound: 0.0,
        }))
    }

    /// Checks whether the velocities after a contact agree with `leaving`, one of the possible motions.
    fn check_leaving(&mut self, motion: &Motion, leaving: &Leaving) -> Result<(), Fault> {
        let (along, mu, approach) = (motion.slip_of_centre(), motion.reduced_mass, motion.approach());
        let (speed, speed_bound) = leaving.speed;
        let slides = leaving.sliding.is_some();
        let (turned, turned_bound) = leaving.sliding.map_or((Vector::zeros(), 0.0), |(left, bound)| {
            (along.try_normalize(0.0).map_or(Vector::zeros(), |direction| direction * left) - along, bound)
        });
        let rubbed = motion.rub.filter(|_| leaving.is_rough).map_or(Rubbed::NONE, |rub| {
            let kick = if approach > 0.0 { approach + speed } else { 0.0 };
            let pushed = (mu * kick, mu * (2.0 * self.bounds.normal_velocity + speed_bound));
            rub.rubbed(pushed, leaving.reverses_slip, &self.bounds)
        });
        let (speed, speed_bound) =
            leaving.speed_with((rubbed.dissipated / mu, rubbed.dissipated_bound / mu), rubbed.slip);
        self.check_velocities(motion, &turned, turned_bound, &rubbed)?;
        self.check_spins(motion, &rubbed)?;
        let lost = if slides { 0.0 } else { 0.5 * mu * (approach * approach - speed * speed) };
        let lost_bound = 2.0 * mu * approach.max(speed) * (self.bounds.normal_velocity + speed_bound);
        self.check_energy(motion, (lost, lost_bound), &rubbed)?;
        // If the particles already recede, and neither slide nor are at rest, the normal velocity does not change.
        let after = if approach > 0.0 || slides || speed > approach { motion.outwards * speed } else { motion.radial };
        let by = (self.event.normal_impulse() / mu - (after - motion.radial)).abs();
        self.within(Quantity::Impulse, by, 2.0 * self.bounds.normal_velocity + speed_bound)
    }

    /// Checks the torques of the event. Only these torques may change the spins.
    fn check_spins(&mut self, motion: &Motion, rubbed: &Rubbed) -> Result<(), Fault> {
        let twist = motion.normal.cross(&rubbed.impulse);
        let arms = motion.rub.map_or([0.0; 2], |rub| rub.arms);
        let size = rubbed.impulse.norm();
        for (k, arm) in arms.into_iter().enumerate() {
            let found = self.event.torques[k];
            let bound = arm * (rubbed.bound + rounded(size) + size * self.bounds.direction);
            self.within(Quantity::Torque, (found + twist * arm).norm(), bound)?;
            let Some(&p) = motion.particles.get(k) else { continue };
            let [old, new] = [self.before, self.after].map(|states| states.spins.get(p as usize));
            if let (Some(old), Some(new)) = (old, new) {
                let turn = found * self.world.inverse_inertias[p as usize];
                let bound = rounded(old.norm() + turn.norm());
                self.within(Quantity::Torque, (new - old - turn).norm(), bound)?;
            }
        }
        Ok(())
    }

    /// Checks that the velocities change only by the normal impulse, the tangential impulse of a rough contact, and
    /// `turned`, a change of the relative tangential velocity.
    fn check_velocities(
        &mut self,
        motion: &Motion,
        turned: &Vector,
        turned_bound: f64,
        rubbed: &Rubbed,
    ) -> Result<(), Fault> {
        let mu = motion.reduced_mass;
        let turned_bound = turned_bound + rubbed.bound / mu;
        let change = |p: &u32| self.after.velocities[*p as usize] - self.before.velocities[*p as usize];
        let changes: Vec<Vector> = motion.particles.iter().map(change).collect();
        if let (&[a, b], &[wa, wb]) = (&changes[..], motion.weights)
            && wa > 0.0
            && wb > 0.0
        {
            let bound = self.flights[0].velocity() / wa + self.flights[1].velocity() / wb + mu * self.bounds.velocity;
            self.within(Quantity::Momentum, (a / wa + b / wb).norm(), bound)?;
        }
        let impulse = self.event.normal * self.event.normal_impulse() + turned * mu + rubbed.impulse;
        let of_particle = self.flights.first().zip(motion.weights.first()).filter(|(_, weight)| **weight > 0.0);
        let rounding = of_particle.map_or(0.0, |(flight, weight)| flight.velocity() / (weight * mu));
        let by = (self.event.impulse - impulse).norm() / mu;
        self.within(Quantity::Impulse, by, self.bounds.velocity + rounding + turned_bound)?;
        for ((change, weight), sign) in changes.iter().zip(motion.weights).zip([1.0, -1.0]) {
            let expected = impulse * (sign * weight);
            let bound = self.bounds.velocity + weight * mu * turned_bound;
            self.within(Quantity::Velocity, (change - expected).norm(), bound)?;
        }
        Ok(())
    }

    /// Checks that the kinetic energy changes only by the energy step and the dissipated energy, in the frame of a
    /// moving surface. `lost` is the energy that the normal motion loses, with its uncertainty.
    fn check_energy(&mut self, motion: &Motion, lost: (f64, f64), rubbed: &Rubbed) -> Result<(), Fault> {
        let (mut gained, mut scale, surface) = (0.0, 0.0, &(motion.surface + motion.material.0));
        let mut work = 0.0;
        for ((&p, &weight), flight) in motion.particles.iter().zip(motion.weights).zip(&self.flights) {
            if weight > 0.0 {
                let (old, new) = (&self.before.velocities[p as usize], &self.after.velocities[p as usize]);
                let change = new - old;
                gained += 0.5 / weight * change.dot(&(new + old - surface * 2.0));
                work += change.dot(surface) / weight;
                scale += (flight.speed + new.norm() + 2.0 * motion.material.0.norm()) * flight.velocity() / weight;
                scale += 2.0 * change.norm() * motion.material.1 / weight;
            }
        }
        for (k, &p) in motion.particles.iter().enumerate() {
            let [old, new] = [self.before, self.after].map(|states| states.spins.get(p as usize));
            let inverse_inertia = self.world.inverse_inertias[p as usize];
            if let (Some(old), Some(new), true) = (old, new, inverse_inertia > 0.0) {
                // The torque is more accurate than the difference of the spins.
                let torque = self.event.torques[k];
                gained += 0.5 * torque.dot(&(new + old - motion.surface_spin * 2.0));
                work += torque.dot(&motion.surface_spin);
                scale += torque.norm() * rounded(new.norm() + old.norm() + motion.surface_spin.norm());
                scale += rounded(new.norm_squared() + old.norm_squared()) / inverse_inertia;
            }
        }
        let (mu, approach) = (motion.reduced_mass, motion.approach());
        let speed: f64 = self.flights.iter().map(|flight| flight.speed).sum();
        let receding = approach.max(motion.radial.abs()) - approach;
        let bound = scale
            + mu * speed * self.bounds.velocity
            + rounded(self.event.energy_step.abs())
            + mu * receding * receding;
        self.within(Quantity::Energy, (gained + (self.event.energy_step - work) + self.event.dissipated).abs(), bound)?;
        let bound = bound + 2.0 * mu * approach * self.bounds.normal_velocity + lost.1;
        let lost = lost.0 + rubbed.dissipated;
        self.within(Quantity::Dissipation, (self.event.dissipated - lost).abs(), bound + rubbed.dissipated_bound)
    }

    fn within(&mut self, quantity: Quantity, by: f64, bound: f64) -> Result<(), Fault> {
        if by <= bound {
            note(&mut self.margins.outcome, by, bound);
            return Ok(());
        }
        Err(Fault::WrongNumbers { contact: Contact::of(self.event), quantity, by, bound })
    }
}

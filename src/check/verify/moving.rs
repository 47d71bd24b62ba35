//! Moving surfaces in the proof: the pieces of their motions, and the round-off that they cause.

use super::bounds::{Bounds, rounded};
use super::facet::Facet;
use super::window::{MARGIN, reach, reach_along};
use crate::Vector;
use crate::check::reference::{Motion, Touch};
use crate::engine::Elapsed;
use crate::model::surface_motion::{Piece, Timeline};
use crate::model::{MotionKind, SceneSurface, SurfaceVelocity};
use std::f64::consts::TAU;

/// Rounding error of a simulated time, relative to its magnitude.
const ROUNDINGS: f64 = 8.0 * f64::EPSILON;
/// Longest window, in periods of an oscillation and in turns of a rotation.
const MOST_OSCILLATIONS: f64 = 8.0;
const MOST_TURNS: f64 = 0.25;
/// Longest interval that is searched at the end of a run, in units of the longest window.
const MOST_SEARCHED: f64 = 1e3;
/// At an oscillating or rotating surface, contact times have the round-off of a sum of times. One term of this sum is
/// this fraction of a period.
const RESOLVED: f64 = 0.125;

#[derive(Debug, Default)]
pub(super) struct Motions {
    /// Simulated time at which the elapsed time is 0 `[time]`.
    start_time: f64,
    /// Motions of each surface of the scene; `None` for a surface that never moves. Empty if no surface moves.
    timelines: Vec<Option<Timeline>>,
}

/// A particle beside a surface, with the current piece of the surface's motions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Beside<'a> {
    pub piece: Option<&'a Piece>,
    /// Motion of the particle in the frame of the box.
    pub motion: Motion,
    pub now: f64,
    pub sway: Sway,
}

/// The motion of a surface where a particle touches it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Carried {
    /// Velocity of the surface at the contact `[length / time]`.
    pub velocity: Vector,
    /// Angular velocity of the surface `[1 / time]`.
    pub spin: Vector,
    /// Acceleration of the particle in the frame of the surface, along the axes of the box `[length / time^2]`.
    pub acceleration: Vector,
    /// Velocity of the material along the surface, relative to the shape, and its uncertainty `[length / time]`.
    pub material: (Vector, f64),
    /// Whether the surface has motions, or its material moves.
    pub works: bool,
    /// Magnitude of the terms of `acceleration`, which determines its rounding error `[length / time^2]`.
    pub rounded_with: f64,
}

/// Magnitudes that determine the rounding errors at a moving surface.
///
/// Positions and velocities of the surface are computed from the simulated time, and contain its rounding error. At an
/// oscillating or rotating surface, contact times also contain the rounding error of a fraction of a period.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sway {
    /// Scale of coordinates `[length]`.
    pub length: f64,
    /// Bound on the speed of the surface at the particle `[length / time]`.
    pub speed: f64,
    /// Scale of the velocity error caused by rounded times `[length / time]`.
    pub falling: f64,
    /// Scale of the direction error caused by rounded times, for a rotating surface; a pure number.
    pub turning: f64,
    /// Scale of the acceleration of the surface, including the error caused by rounded times `[length / time^2]`.
    pub push: f64,
}

impl Motions {
    pub fn of(surfaces: &[SceneSurface], start_time: f64) -> Self {
        let timeline = |surface: &SceneSurface| surface.moves().then(|| Timeline::of(&surface.motions));
        let all: Vec<Option<Timeline>> = surfaces.iter().map(timeline).collect();
        let timelines = if all.iter().any(Option::is_some) { all } else { Vec::new() };
        Self { start_time, timelines }
    }

    pub fn now(&self, elapsed: &Elapsed) -> f64 {
        self.start_time + elapsed.total()
    }

    pub fn moves(&self, surface: u32) -> bool {
        self.timeline(surface).is_some()
    }

    fn timeline(&self, surface: u32) -> Option<&Timeline> {
        self.timelines.get(surface as usize)?.as_ref()
    }

    /// Returns a bound on the rounding error of the simulated time `now` `[time]`.
    fn rounding(&self, now: f64) -> f64 {
        ROUNDINGS * (now.abs() + self.start_time.abs())
    }

    /// Returns the piece of a surface's motions that begins or continues at a time; `None` if the surface never moves.
    pub fn piece(&self, surface: u32, elapsed: &Elapsed) -> Option<&Piece> {
        let now = self.now(elapsed);
        self.timeline(surface).map(|timeline| timeline.piece_at(now + self.rounding(now)))
    }

    pub fn pieces_from(&self, surface: u32, elapsed: &Elapsed) -> impl Iterator<Item = &Piece> {
        let next = move |piece: &&Piece| {
            let until = piece.until;
            self.timeline(surface).filter(|_| until < f64::INFINITY).map(|timeline| timeline.piece_at(until))
        };
        std::iter::successors(self.piece(surface, elapsed), next)
    }

    /// Returns a particle beside a surface, with the current piece of the surface's motions. If rounding makes the
    /// current piece uncertain, returns the particle with each of the two possible pieces.
    pub fn beside(&self, surface: u32, motion: Motion, elapsed: &Elapsed) -> Vec<Beside<'_>> {
        let now = self.now(elapsed);
        let Some(timeline) = self.timeline(surface) else {
            return vec![Beside { piece: None, motion, now, sway: Sway::default() }];
        };
        let slack = self.rounding(now);
        let mut pieces: Vec<&Piece> = [now - slack, now + slack].map(|time| timeline.piece_at(time)).to_vec();
        pieces.dedup_by_key(|piece| piece.from);
        let of = |piece| Beside { piece: Some(piece), motion, now, sway: self.sway(piece, &motion, now) };
        pieces.into_iter().map(of).collect()
    }

    pub fn sway_beside(&self, surface: u32, motion: Motion, elapsed: &Elapsed) -> Sway {
        self.beside(surface, motion, elapsed).iter().fold(Sway::default(), |sway, beside| sway.max(&beside.sway))
    }

    /// Returns the time until a surface begins the next piece of its motions, at most the longest window.
    pub fn steady_for(&self, elapsed: &Elapsed) -> f64 {
        let now = self.now(elapsed);
        let pieces = self.timelines.iter().flatten().map(|timeline| timeline.piece_at(now + self.rounding(now)));
        let steady = |piece: &Piece| (piece.until - now).min(longest(piece));
        pieces.map(steady).fold(f64::INFINITY, f64::min)
    }

    /// For each moving surface, the box that a particle may sweep within `time`, in the frame of the surface.
    pub fn swept(&self, motion: &Motion, elapsed: &Elapsed, time: f64) -> Vec<Option<[Vector; 2]>> {
        let now = self.now(elapsed);
        let of = |surface: u32| {
            let piece = self.piece(surface, elapsed)?;
            let seen = motion.seen(piece, now);
            let sway = self.sway(piece, motion, now);
            let slack = motion.radius + rounded(sway.length) + (MARGIN - 1.0) * seen.position.amax();
            let around = path(piece, motion, &seen, time) * MARGIN;
            let around = around.add_scalar(slack);
            Some([seen.position - around, seen.position + around])
        };
        (0..).zip(&self.timelines).map(|(surface, _)| of(surface)).collect()
    }

    fn sway(&self, piece: &Piece, motion: &Motion, now: f64) -> Sway {
        let Motion { position, velocity, .. } = motion;
        let moment = piece.at(now);
        let mut length = moment.pose.displacement.amax();
        if moment.pose.is_turned {
            length += position.amax();
        }
        // Bounds on the motion of the surface: speed, acceleration, relative rate of change of the acceleration, and
        // angular velocity. The round-off of the time `resolved` is a part of the error of contact times.
        let (speed, push, rate, turning, resolved) = match piece.kind {
            None => (0.0, 0.0, 0.0, 0.0, 0.0),
            Some(MotionKind::Translation { velocity, acceleration }) => {
                (velocity.norm().max(moment.velocity.norm()), acceleration.norm(), 0.0, 0.0, 0.0)
            }
            Some(MotionKind::Oscillation { amplitude, frequency, phase }) => {
                let (rate, amplitude) = (TAU * frequency.abs(), amplitude.norm());
                (rate * amplitude, rate * rate * amplitude, rate, 0.0, (RESOLVED + phase.abs()) / frequency.abs())
            }
            Some(MotionKind::Rotation { point, frequency, .. }) => {
                let (rate, arm) = (TAU * frequency.abs(), (position - point).norm());
                length += point.amax() + arm;
                let push = rate * (rate * (position.amax() + point.amax() + arm) + 2.0 * velocity.norm());
                (rate * arm, push, rate, rate, RESOLVED / frequency.abs())
            }
        };
        let begun = if piece.from.is_finite() { piece.from.abs() } else { 0.0 };
        let time = now.abs() + self.start_time.abs() + begun + resolved;
        Sway {
            length: length + (speed + velocity.norm()) * time,
            speed,
            falling: push * time + turning * (length + velocity.norm() * time),
            turning: turning * time,
            push: push + push * rate * time,
        }
    }
}

/// Returns the longest window during a piece of a motion `[time]`.
fn longest(piece: &Piece) -> f64 {
    match piece.kind {
        Some(MotionKind::Oscillation { frequency, .. }) => MOST_OSCILLATIONS / frequency.abs(),
        Some(MotionKind::Rotation { frequency, .. }) => MOST_TURNS / frequency.abs(),
        _ => f64::INFINITY,
    }
}

/// Whether a time interval in a piece of a motion can be searched completely for events.
pub(super) fn is_searched(piece: &Piece, time: f64) -> bool {
    time <= MOST_SEARCHED * longest(piece)
}

/// Returns an upper bound on the displacement of a particle along each axis within `time`, in the frame of a surface
/// `[length]`. `seen` is the motion in the frame of the surface.
fn path(piece: &Piece, motion: &Motion, seen: &Motion, time: f64) -> Vector {
    let Motion { position, velocity, acceleration, .. } = motion;
    let flown = reach(velocity, acceleration, time);
    match piece.kind {
        Some(MotionKind::Oscillation { amplitude, frequency, .. }) => {
            Vector::repeat(flown + amplitude.norm() * (TAU * frequency.abs() * time).min(2.0))
        }
        Some(MotionKind::Rotation { point, frequency, .. }) => {
            let arm = (position - point).norm();
            Vector::repeat(flown + arm * (TAU * frequency.abs() * time).min(2.0))
        }
        _ => reach_along(&seen.velocity, &seen.acceleration, time),
    }
}

impl Sway {
    fn max(&self, other: &Self) -> Self {
        Self {
            length: self.length.max(other.length),
            speed: self.speed.max(other.speed),
            falling: self.falling.max(other.falling),
            turning: self.turning.max(other.turning),
            push: self.push.max(other.push),
        }
    }
}

impl Carried {
    /// A wall at rest, at which a particle has this acceleration.
    pub fn at_rest(acceleration: Vector) -> Self {
        let still = Vector::zeros();
        Self { velocity: still, spin: still, acceleration, material: (still, 0.0), works: false, rounded_with: 0.0 }
    }
}

impl Beside<'_> {
    pub fn seen(&self) -> Motion {
        self.piece.map_or(self.motion, |piece| self.motion.seen(piece, self.now))
    }

    /// Returns the contact with a facet, with directions in the frame of the box.
    pub fn contact(&self, facet: &Facet) -> Touch {
        let touch = facet.feature.contact(&self.seen().position);
        let Some(piece) = self.piece else { return touch };
        let pose = piece.at(self.now).pose;
        let [normal, along] = [Some(touch.normal), touch.along].map(|it| it.map(|it| pose.direction(&it)));
        Touch { normal: normal.unwrap_or(touch.normal), along, ..touch }
    }

    /// Returns the motion of a surface with this velocity of its material, where the particle touches `facet`.
    pub fn carried(&self, facet: &Facet, velocity: Option<SurfaceVelocity>, bounds: &Bounds) -> Carried {
        let material = velocity.map_or((Vector::zeros(), 0.0), |velocity| self.material(facet, &velocity, bounds));
        let slides = velocity.is_some();
        let Motion { position, velocity, acceleration, .. } = &self.motion;
        let Some(piece) = self.piece else {
            return Carried { material, works: slides, ..Carried::at_rest(*acceleration) };
        };
        let moment = piece.at(self.now);
        let seen = moment.acceleration_seen(position, velocity, acceleration);
        Carried {
            velocity: moment.velocity_at(position),
            spin: moment.spin,
            acceleration: moment.pose.direction(&seen),
            material,
            works: true,
            rounded_with: acceleration.norm() + self.sway.push,
        }
    }

    fn material(&self, facet: &Facet, velocity: &SurfaceVelocity, bounds: &Bounds) -> (Vector, f64) {
        let Motion { position, radius, .. } = self.seen();
        let touch = facet.feature.contact(&position);
        let normal = touch.normal * touch.side.sign();
        let material = velocity.at(&(position - normal * radius), &normal);
        let (size, rate) = match *velocity {
            SurfaceVelocity::Translation { velocity } => (velocity.norm(), 0.0),
            SurfaceVelocity::Rotation { point, frequency, .. } => {
                let rate = TAU * frequency.abs();
                (rate * (position.norm() + point.norm() + radius), rate)
            }
        };
        let turned = self.piece.map_or(material, |piece| piece.at(self.now).pose.direction(&material));
        (turned, rounded(size) + size * bounds.direction + rate * (bounds.distance + rounded(self.sway.length)))
    }
}

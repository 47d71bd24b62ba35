use super::FrameHead;
use super::channel::Channels;
use super::flight::Flights;
use super::turns::Turns;
use crate::Vector;
use crate::base::numbers::trunc_to_u16;
use crate::trajectory::Frame;

/// Number of steps along each axis of the field, and the number for a particle outside the field.
const STEPS: f64 = 65_534.0;
const BEYOND: u16 = u16::MAX;

/// Largest margin on each side of the box, in edge lengths.
const REACH: f64 = 3.0;

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Encoded {
    pub head: FrameHead,
    pub bytes: Vec<u8>,
}

impl Encoded {
    pub fn of(frame: &Frame, channels: &mut Channels, turns: Option<&Turns>) -> Self {
        let moving: Vec<_> = frame.particles.iter().filter(|particle| !frame.is_static(particle)).collect();
        let positions: Vec<Vector> = moving.iter().map(|particle| frame.wrapped(&particle.position)).collect();
        let (lower, size) = field(frame, &positions);
        let mut bytes = Vec::with_capacity(channels.bytes(moving.len()));
        let mut beyond = 0;
        for position in &positions {
            let steps = steps(position, &lower, &size);
            beyond += usize::from(steps[0] == BEYOND);
            steps.iter().for_each(|step| bytes.extend(step.to_le_bytes()));
        }
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        if let Some(turns) = turns {
            turns.encode(&mut bytes);
        }
        let ranges = channels.encode(frame, &moving, &positions, &mut bytes);
        let head = FrameHead {
            time: frame.time,
            lower: frame.lower.into(),
            size: frame.size.into(),
            displacement: frame.displacement,
            field: [lower.into(), size.into()],
            ranges,
            beyond,
            fall: 0,
            poses: Vec::new(),
            surfaces: frame.surfaces.clone(),
        };
        Self { head, bytes }
    }

    /// Adds the free flights until the next frame.
    pub fn with_flights(mut self, flights: Option<&Flights>, moving: usize) -> (FrameHead, Vec<u8>) {
        let end = self.bytes.len() + moving.div_ceil(8);
        if let Some(flights) = flights {
            self.head.fall = flights.fall;
            self.bytes.extend(flights.bits());
        }
        self.bytes.resize(end, 0);
        (self.head, self.bytes)
    }
}

/// Returns the lower corner and the edges of the field: the box, enlarged to particles at most `REACH` edges outside.
fn field(frame: &Frame, positions: &[Vector]) -> (Vector, Vector) {
    let mut lower = frame.lower;
    let mut upper = frame.lower + frame.size;
    let is_empty = frame.size.iter().all(|edge| *edge == 0.0);
    let reach = if is_empty { f64::INFINITY } else { REACH };
    let farthest = frame.size.map(|edge| if reach.is_finite() { reach * edge } else { f64::MAX });
    let outermost = (lower - farthest, upper + farthest);
    for position in positions {
        if (0..3).all(|k| frame.size[k] == 0.0 || (outermost.0[k]..=outermost.1[k]).contains(&position[k])) {
            (lower, upper) = (lower.inf(position), upper.sup(position));
        }
    }
    (lower, upper - lower)
}

/// Returns a position in steps of the field. For a particle outside the field, all three numbers are `BEYOND`.
fn steps(position: &Vector, lower: &Vector, size: &Vector) -> [u16; 3] {
    let fraction = |k: usize| if size[k] > 0.0 { (position[k] - lower[k]) / size[k] } else { 0.0 };
    let fractions = [0, 1, 2].map(fraction);
    if fractions.iter().any(|fraction| !(0.0..=1.0).contains(fraction)) {
        return [BEYOND; 3];
    }
    fractions.map(|fraction| trunc_to_u16((fraction * STEPS).round()))
}

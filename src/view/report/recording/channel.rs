//! Scalars that colour particles.

use super::neighbours::WellNeighbours;
use super::{ChannelHead, turns};
use crate::Vector;
use crate::analysis::instruments::{CONTACT_PRESSURE, CONTACT_STRESS, Scalar};
use crate::base::numbers::trunc_to_u8;
use crate::model::Scene;
use crate::trajectory::Frame;
use crate::trajectory::frame::{FrameParticle, SPINS};
use crate::view::render::legend;

const MOST_GIVEN: usize = 4;

#[derive(Debug, Clone, PartialEq)]
enum Quantity {
    Speed,
    /// The magnitude of the spin.
    Spin,
    /// The coordinate along an axis, times a sign.
    Height(usize, f64),
    /// Number of neighbours within the range of a potential with finite steps.
    Captured(WellNeighbours),
    /// The contact pressure. A few high pressures are beyond the end of its scale.
    Pressure,
    Given(String),
}

/// Scalars of a trajectory, with their descriptions and highest values so far.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Channels(Vec<(Quantity, ChannelHead, f64)>);

impl Channels {
    /// Chooses the scalars: speeds, spins if the frames contain them, heights if particles fall, numbers of neighbours if
    /// potentials have finite steps, and scalars of the trajectory.
    pub fn of(frame: &Frame, scene: Option<&Scene>, (up, is_down): (usize, bool)) -> Self {
        let head = |name: &str, unit: &str, is_count: bool| ChannelHead {
            name: name.to_owned(),
            unit: scene.map_or_else(|| unit.to_owned(), |scene| scene.unit_of(unit)),
            low: 0.0,
            high: 0.0,
            is_exceeded: false,
            is_count,
        };
        let mut channels = vec![(Quantity::Speed, head("speed", "length / time", false), 0.0)];
        if turns::spins(frame).is_some() {
            channels.push((Quantity::Spin, head("spin", "1 / time", false), 0.0));
        }
        let falls = |scene: &Scene| scene.species.iter().any(|species| species.acceleration.norm() > 0.0);
        if scene.is_some_and(falls) {
            let sign = if is_down { -1.0 } else { 1.0 };
            let ends = [frame.lower[up], frame.lower[up] + frame.size[up]].map(|x| sign * x);
            let (low, high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
            let head = ChannelHead { low, high, ..head("height", "length", false) };
            channels.push((Quantity::Height(up, sign), head, high));
        }
        if let Some(neighbours) = scene.and_then(|scene| WellNeighbours::of(scene, frame)) {
            channels.push((Quantity::Captured(neighbours), head("neighbours within a well", "1", true), 0.0));
        }
        let is_other = |scalar: &&Scalar| !SPINS.contains(&&*scalar.name);
        for scalar in frame.scalars.iter().filter(is_other).take(MOST_GIVEN) {
            if scalar.name == CONTACT_PRESSURE {
                channels.push((Quantity::Pressure, head(CONTACT_PRESSURE, "energy / length^D", false), 0.0));
                continue;
            }
            let unit = if scalar.name.starts_with(CONTACT_STRESS) { "energy / length^D" } else { "1" };
            let head = ChannelHead { low: f64::INFINITY, high: f64::NEG_INFINITY, ..head(&scalar.name, unit, false) };
            channels.push((Quantity::Given(scalar.name.clone()), head, f64::NEG_INFINITY));
        }
        Self(channels)
    }

    /// Returns the approximate size of a frame on the page `[bytes]`.
    pub fn bytes(&self, moving: usize) -> usize {
        // Coordinates, scalars, one bit per particle for free flights, and about 300 bytes of JSON for the frame.
        (6 * moving).next_multiple_of(4) + self.0.len() * moving + moving.div_ceil(8) + 300
    }

    /// Appends all scalars to `bytes`. Returns the values of the bytes 0 and 255 for each scalar.
    pub fn encode(
        &mut self,
        frame: &Frame,
        moving: &[&FrameParticle],
        positions: &[Vector],
        bytes: &mut Vec<u8>,
    ) -> Vec<[f64; 2]> {
        let encode = |(quantity, head, highest): &mut (Quantity, ChannelHead, f64)| {
            let values: Vec<f64> = match quantity {
                Quantity::Speed => moving.iter().map(|particle| particle.velocity.norm()).collect(),
                Quantity::Spin => magnitudes(frame, moving.len()),
                Quantity::Height(axis, sign) => positions.iter().map(|position| *sign * position[*axis]).collect(),
                Quantity::Captured(neighbours) => neighbours.count(frame),
                Quantity::Pressure => given(frame, CONTACT_PRESSURE),
                Quantity::Given(name) => given(frame, name),
            };
            let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            match quantity {
                Quantity::Speed | Quantity::Spin | Quantity::Pressure => {
                    head.high = head.high.max(legend::top(values.clone()))
                }
                Quantity::Height(..) => {}
                Quantity::Captured(_) => head.high = head.high.max(largest),
                Quantity::Given(_) => {
                    head.low = values.iter().copied().fold(head.low, f64::min);
                    head.high = head.high.max(largest);
                }
            }
            *highest = highest.max(largest);
            quantise(&values, head.is_count, bytes)
        };
        self.0.iter_mut().map(encode).collect()
    }

    pub fn heads(self) -> Vec<ChannelHead> {
        let finished = |(_, head, highest): (Quantity, ChannelHead, f64)| {
            // If no particles move, the ends of a scale may be infinite.
            let low = if head.low.is_finite() { head.low } else { 0.0 };
            let high = if head.high > low { head.high } else { low + 1.0 };
            ChannelHead { low, high, is_exceeded: highest > high, ..head }
        };
        self.0.into_iter().map(finished).collect()
    }
}

/// Returns a scalar of the moving particles, or zeros if the frame lacks it.
fn given(frame: &Frame, name: &str) -> Vec<f64> {
    let scalar = frame.scalars.iter().find(|scalar| scalar.name == name);
    let value = |place: usize| scalar.and_then(|scalar| scalar.values.get(place)).copied().unwrap_or(0.0);
    let moving = frame.particles.iter().enumerate().filter(|(_, particle)| !frame.is_static(particle));
    moving.map(|(place, _)| value(place)).collect()
}

/// Returns the magnitudes of the spins of the moving particles, or zeros if the frame has no spins.
fn magnitudes(frame: &Frame, moving: usize) -> Vec<f64> {
    turns::spins(frame).map_or_else(|| vec![0.0; moving], |spins| spins.iter().map(Vector::norm).collect())
}

/// Appends one byte per value. Returns the values of the bytes 0 and 255. Counts up to 255 are exact.
fn quantise(values: &[f64], is_count: bool, bytes: &mut Vec<u8>) -> [f64; 2] {
    let finite = || values.iter().copied().filter(|value| value.is_finite());
    let (low, high) = (finite().reduce(f64::min).unwrap_or(0.0), finite().reduce(f64::max).unwrap_or(0.0));
    let [low, high] = if is_count { [0.0, high.max(255.0)] } else { [low, high] };
    let step = if high > low { (high - low) / 255.0 } else { 1.0 };
    bytes.extend(values.iter().map(|value| trunc_to_u8(((value - low) / step).round())));
    [low, high]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_exact_and_other_values_are_within_half_a_step() {
        let mut bytes = Vec::new();
        assert_eq!(quantise(&[0.0, 3.0, 255.0], true, &mut bytes), [0.0, 255.0]);
        assert_eq!(bytes, [0, 3, 255]);
        bytes.clear();
        let values: Vec<f64> = (0..1000).map(|k| -2.0 + 0.01 * f64::from(k)).collect();
        let [low, high] = quantise(&values, false, &mut bytes);
        for (value, byte) in values.iter().zip(&bytes) {
            let back = low + f64::from(*byte) * (high - low) / 255.0;
            assert!((back - value).abs() <= 0.5 * (high - low) / 255.0 * (1.0 + 1e-12));
        }
        bytes.clear();
        assert_eq!(quantise(&[2.0, 2.0], false, &mut bytes), [2.0, 2.0]);
        assert_eq!(bytes, [0, 0]);
    }
}

//! Particles that pass a plane.

mod passages;

use serde::{Deserialize, Serialize};

use super::block_times::BlockTimes;
use super::instrument::{Instrument, Setup};
use super::quantity::{Curve, Measured, Number, Series, Variable};
use super::system::{Sample, SystemDescription};
use crate::Vector;
use crate::base::numbers::trunc_to_i64;
use crate::model::measurement_plan::Flow as Plan;
use crate::model::space::Boundary;
use passages::Passages;

/// Samples of a run unless an interval is given.
const SAMPLES: u32 = 2000;

/// A rectangle is looked at no more often than this for one particle between two samples.
const MOST_CROSSINGS: f64 = 1000.0;

/// Counts passages of a plane between samples, forwards less backwards.
///
/// Where a particle was at two samples decides how often it passed, along a periodic axis with the periods that it travelled: forth and
/// back between two samples is no passage, so that the sum is exact whatever the interval. Whether it passed inside the rectangle, and when,
/// is that of a straight line between both. The interval is a 2000th of the duration if it is not given, and longer in a longer run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Flow {
    name: String,
    axis: usize,
    at: f64,
    rectangle: Option<[Vector; 2]>,
    /// Particles that count, and where they were at the last sample, as if never wrapped.
    ids: Vec<u32>,
    positions: Vec<Vector>,
    time: f64,
    blocks: BlockTimes,
    passages: Passages,
}

impl Flow {
    /// An unknown axis or species counts nothing; reading the scene leaves none.
    pub fn new(plan: &Plan, setup: &Setup<'_>) -> Self {
        let &Setup { system, sample, duration } = setup;
        let axis = ["x", "y", "z"].iter().position(|axis| *axis == plan.axis);
        let is_counted = |id: &u32| {
            let species = system.species[*id as usize] as usize;
            let is_asked_for = |name: &String| system.species_names.get(species) == Some(name);
            axis.is_some() && plan.species.as_ref().is_none_or(is_asked_for)
        };
        let ids: Vec<u32> = system.moving.iter().copied().filter(is_counted).collect();
        let corner = |given: Option<[f64; 3]>, otherwise: Vector| given.map_or(otherwise, Vector::from);
        let rectangle = (plan.lower.is_some() || plan.upper.is_some()).then(|| {
            let unlimited = Vector::repeat(f64::MAX);
            [corner(plan.lower, -unlimited), corner(plan.upper, unlimited)]
        });
        Self {
            name: plan.name.clone(),
            axis: axis.unwrap_or(0),
            at: plan.at,
            rectangle,
            positions: ids.iter().map(|&id| sample.unwrapped(id as usize, &system.space)).collect(),
            ids,
            time: sample.time,
            blocks: BlockTimes::new(sample.time, plan.interval, duration, SAMPLES),
            passages: Passages::new(sample.time),
        }
    }

    /// Counts the passages of one particle on its way between two samples.
    fn pass(&mut self, from: &Vector, to: &Vector, time: f64, system: &SystemDescription) {
        let (axis, at) = (self.axis, self.at);
        let period = system.space.periods()[axis];
        // The number of the plane that was last passed going up, and that of its image; a particle in the plane is beyond it.
        let planes = [from[axis], to[axis]]
            .map(|x| if period.is_finite() { ((x - at) / period).floor() } else { f64::from(u8::from(x >= at)) });
        let crossings = planes[1] - planes[0];
        if crossings == 0.0 || !crossings.is_finite() {
            return;
        }
        let sign = crossings.signum();
        let first = if sign > 0.0 { planes[0] + 1.0 } else { planes[0] };
        let mut crossing = 0.0;
        while crossing < crossings.abs().min(MOST_CROSSINGS) {
            let coordinate = if period.is_finite() { at + (first + sign * crossing) * period } else { at };
            let part = ((coordinate - from[axis]) / (to[axis] - from[axis])).clamp(0.0, 1.0);
            let when = self.time + part * (time - self.time);
            if self.is_inside(&(from + (to - from) * part), system) {
                self.passages.count(trunc_to_i64(sign), when);
            }
            crossing += 1.0;
        }
    }

    /// Whether a point of the plane, or its image in the box, is in the rectangle.
    fn is_inside(&self, point: &Vector, system: &SystemDescription) -> bool {
        let Some([lower, upper]) = &self.rectangle else { return true };
        let space = &system.space;
        (0..3).filter(|&k| k != self.axis && space.boundary[k] != Boundary::Flat).all(|k| {
            let x = if space.boundary[k] == Boundary::Periodic {
                point[k] - ((point[k] - space.lower[k]) / space.size[k]).floor() * space.size[k]
            } else {
                point[k]
            };
            lower[k] <= x && x < upper[k]
        })
    }
}

impl Instrument for Flow {
    fn next_sample(&self) -> f64 {
        self.blocks.next()
    }

    fn sample(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        if sample.time > self.time {
            let before = std::mem::take(&mut self.positions);
            let now: Vec<Vector> = self.ids.iter().map(|&id| sample.unwrapped(id as usize, &system.space)).collect();
            for (from, to) in before.iter().zip(&now) {
                self.pass(from, to, sample.time, system);
            }
            self.positions = now;
            self.time = sample.time;
            self.passages.write(sample.time);
        }
        self.blocks.pass(sample.time);
    }

    /// What came after the last sample counts, too.
    fn end(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        self.sample(sample, system);
    }

    fn report(&self, _: &SystemDescription, measured: &mut Measured) {
        let name = &self.name;
        measured.numbers.push(Number {
            name: format!("flow_{name}_count"),
            title: format!("Particles that passed {name}"),
            unit: "1".to_owned(),
            mean: Some(self.passages.total() as f64),
            standard_error: Some(0.0),
            method: COUNT.to_owned(),
        });
        let title = format!("Rate of particles that pass {name}");
        let rate = self.passages.rate();
        measured.numbers.push(Number::estimated(&format!("flow_{name}_rate"), &title, "1 / time", rate, RATE));
        let rows = self.passages.rows();
        measured.curves.push(Curve {
            name: format!("flow_{name}"),
            title: format!("Particles that passed {name}"),
            method: COUNT.to_owned(),
            variables: vec![Variable {
                name: "t".to_owned(),
                unit: "time".to_owned(),
                values: rows.iter().map(|row| row.time).collect(),
            }],
            series: vec![Series {
                name: "N".to_owned(),
                unit: "1".to_owned(),
                values: rows.iter().map(|row| Some(row.total as f64)).collect(),
                standard_errors: vec![None; rows.len()],
            }],
            is_logarithmic: [false, false],
            published: Vec::new(),
        });
    }
}

const COUNT: &str =
    "Passages towards larger coordinates less those towards smaller ones since the start of the measurement.";
const RATE: &str = "Passages after the first one by the time from the first to the last one; the error is that of the rates in the stretches \
    of the curve between them.";

#[cfg(test)]
mod tests;

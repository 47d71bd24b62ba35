mod passages;

use serde::{Deserialize, Serialize};

use super::block_times::{EARLY, block_times};
use super::instrument::{Instrument, Setup};
use super::quantity::{Curve, Measured, Normalisation, Number};
use super::system::{Sample, SystemDescription};
use crate::Vector;
use crate::analysis::sampling_times::SamplingTimes;
use crate::analysis::statistics::Estimate;
use crate::base::numbers::trunc_to_i64;
use crate::model::measurement_plan::Flow as Plan;
use crate::model::space::Boundary;
use passages::{MASS, NUMBER, Passages};

const SAMPLES: u32 = 2000;

/// With more species than this, the species are not counted separately. A scene may have one species per diameter.
const MOST_SPECIES: usize = 20;

/// Up to this number, crossings of a particle between two samples are handled one by one. More crossings are handled in
/// groups, and the first crossing decides whether its group is counted.
const MOST_CROSSINGS: f64 = 1000.0;

/// Counts passages through a plane between samples, forwards minus backwards, and the mass that passes.
///
/// The number of passages of a particle follows from its unwrapped positions at two samples. A particle that passes and
/// returns in between does not change the net count, so the count is exact for any sampling interval. If the plane is
/// limited to a rectangle, the particle's path is assumed to be straight between samples. The default interval is
/// 1/2000 of the expected duration, and grows if the run takes longer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Flow {
    name: String,
    axis: usize,
    /// Unit normal of a tilted plane; `None` for a plane perpendicular to an axis.
    normal: Option<Vector>,
    at: f64,
    rectangle: Option<[Vector; 2]>,
    /// Ids and unwrapped positions of the counted particles, at the last sample.
    ids: Vec<u32>,
    positions: Vec<Vector>,
    time: f64,
    blocks: SamplingTimes,
    /// 1 if passages towards larger coordinates are forwards, otherwise -1.
    forwards: i64,
    passages: Passages,
    /// Net passages of each species. Empty with one species, or with more than [`MOST_SPECIES`].
    by_species: Vec<(u32, i64)>,
}

impl Flow {
    /// Unknown axes and species count nothing. The reader of scenes rejects them.
    pub fn new(plan: &Plan, setup: &Setup<'_>) -> Self {
        let &Setup { system, sample, .. } = setup;
        let named = |word: &&str| plan.axis.as_deref() == Some(*word);
        let normal = plan.normal.and_then(|normal| Vector::from(normal).try_normalize(0.0));
        let axis = ["x", "y", "z"].iter().position(named).or(normal.map(|_| 0));
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
        let mut species: Vec<u32> = ids.iter().map(|&id| system.species[id as usize]).collect();
        species.sort_unstable();
        species.dedup();
        let is_told_apart = (2..=MOST_SPECIES).contains(&species.len());
        let is_closed = rectangle.is_none()
            && normal.is_none()
            && axis
                .is_some_and(|axis| system.space.boundary[axis] == Boundary::Periodic || system.space.walls(axis) == 2);
        let window = plan.window.map(|window| window.map(|time| sample.time + time));
        Self {
            name: plan.name.clone(),
            axis: axis.unwrap_or(0),
            normal,
            at: plan.at,
            rectangle,
            positions: ids.iter().map(|&id| sample.unwrapped(id as usize, &system.space)).collect(),
            ids,
            time: sample.time,
            blocks: block_times(setup, plan.interval, SAMPLES),
            forwards: if plan.direction.as_deref() == Some("-") { -1 } else { 1 },
            passages: Passages::new(sample.time, window, is_closed),
            by_species: species.into_iter().filter(|_| is_told_apart).map(|species| (species, 0)).collect(),
        }
    }

    fn pass(&mut self, id: u32, [from, to]: [&Vector; 2], time: f64, system: &SystemDescription) {
        let (at, period) = (self.at, self.period(system));
        let [start, end] = [from, to].map(|position| self.along(position));
        // The plane and its images are numbered in ascending order. An end has the number of the next image below.
        let planes = [start, end]
            .map(|x| if period.is_finite() { ((x - at) / period).floor() } else { f64::from(u8::from(x >= at)) });
        let crossings = planes[1] - planes[0];
        if crossings == 0.0 || !crossings.is_finite() {
            return;
        }
        let sign = crossings.signum();
        let first = if sign > 0.0 { planes[0] + 1.0 } else { planes[0] };
        let group = (crossings.abs() / MOST_CROSSINGS).ceil();
        let mut crossing = 0.0;
        while crossing < crossings.abs() {
            let coordinate = if period.is_finite() { at + (first + sign * crossing) * period } else { at };
            let part = ((coordinate - start) / (end - start)).clamp(0.0, 1.0);
            let when = self.time + part * (time - self.time);
            if self.is_inside(&(from + (to - from) * part), system) {
                let counted = self.forwards * trunc_to_i64(sign * group.min(crossings.abs() - crossing));
                self.passages.count(counted, system.masses[id as usize], when);
                let species = system.species[id as usize];
                if let Some((_, count)) = self.by_species.iter_mut().find(|(known, _)| *known == species) {
                    *count += counted;
                }
            }
            crossing += group;
        }
    }

    fn along(&self, position: &Vector) -> f64 {
        self.normal.map_or(position[self.axis], |normal| normal.dot(position))
    }

    /// Distance between the plane and the next periodic image; infinite without images.
    fn period(&self, system: &SystemDescription) -> f64 {
        if self.normal.is_some() { f64::INFINITY } else { system.space.periods()[self.axis] }
    }

    fn go(&mut self, id: u32, way: f64, system: &SystemDescription) {
        let period = self.period(system);
        if period.is_finite() {
            self.passages.go(self.forwards as f64 * way / period, system.masses[id as usize]);
        }
    }

    /// Returns true if the image of a point in the box is inside the rectangle.
    fn is_inside(&self, point: &Vector, system: &SystemDescription) -> bool {
        let Some([lower, upper]) = &self.rectangle else { return true };
        let space = &system.space;
        let is_across = |k: usize| self.normal.is_none() && k == self.axis;
        (0..3).filter(|&k| !is_across(k) && space.boundary[k] != Boundary::Flat).all(|k| {
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
            for (index, way) in before.iter().zip(&now).enumerate() {
                self.pass(self.ids[index], way.into(), sample.time, system);
                self.go(self.ids[index], way.1[self.axis] - way.0[self.axis], system);
            }
            self.positions = now;
            self.time = sample.time;
            self.passages.write(sample.time);
        }
        self.blocks.pass_early(sample.time, EARLY);
    }

    fn end(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        self.sample(sample, system);
    }

    fn report(&self, system: &SystemDescription, measured: &mut Measured) {
        let name = &self.name;
        let passed = self.passages.now().passed;
        let mut number = |key: &str, title: &str, unit: &str, estimate: Option<Estimate>, method: &str| {
            measured.numbers.push(Number::estimated(&format!("flow_{name}_{key}"), title, unit, estimate, method));
        };
        let exact = |mean: f64| Some(Estimate { mean, standard_error: Some(0.0) });
        let title = format!("Particles that passed {name}");
        number("count", &title, "1", exact(passed[NUMBER]), COUNT);
        for (species, count) in &self.by_species {
            let species = &system.species_names[*species as usize];
            let title = format!("Particles of {species} that passed {name}");
            number(&format!("count_{species}"), &title, "1", exact(*count as f64), COUNT);
        }
        number("mass", &format!("Mass that passed {name}"), "mass", exact(passed[MASS]), COUNT);
        let method = if self.passages.has_window() { RATE_IN_WINDOW } else { RATE };
        let rate = |of| self.passages.rate(of);
        number("rate", &format!("Rate of particles that pass {name}"), "1 / time", rate(NUMBER), method);
        number("mass_rate", &format!("Rate of mass that passes {name}"), "mass / time", rate(MASS), method);
        let rows = self.passages.rows();
        let column = |of: usize| -> Vec<Option<Estimate>> {
            rows.iter().map(|row| Some(Estimate { mean: row.passed[of], standard_error: None })).collect()
        };
        let sum = Normalisation::of("number or mass that passed since the start of the measurement");
        measured.curves.push(
            Curve::new(&format!("flow_{name}"), &title, COUNT)
                .variable("t", "time", rows.iter().map(|row| row.time).collect())
                .series("N", "1", &column(NUMBER))
                .normalised(sum.clone())
                .series("mass", "mass", &column(MASS))
                .normalised(sum),
        );
    }
}

const COUNT: &str =
    "Passages in the direction of the flow minus passages against it, since the start of the measurement.";
const RATE: &str = "Number or mass of the passages after the first, divided by the time from the first to the last \
    passage. The error follows from the rates in pieces of the curve during this time.";
const RATE_IN_WINDOW: &str = "Number or mass of the passages in the time window, divided by the length of the \
    window. The error follows from the rates in pieces of the curve in the window.";

#[cfg(test)]
mod tests;

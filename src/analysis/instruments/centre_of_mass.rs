//! Centre of mass over time, and its inclination about the axis of a drum.

use super::budgeted_times::budgeted_times;
use super::instrument::{Instrument, Setup};
use super::quantity::{Curve, Measured, Number};
use super::rows_over_time::RowsOverTime;
use super::system::{Sample, SystemDescription};
use crate::Vector;
use crate::analysis::sampling_times::SamplingTimes;
use crate::analysis::statistics::BlockAverage;
use crate::model::measurement_plan::CentreOfMass as Plan;
use crate::model::space::{AXES, Boundary};
use serde::{Deserialize, Serialize};

/// With more species than this, only the centre of mass of all particles is measured.
const MOST_SPECIES: usize = 8;

/// Number of operations per particle and sample.
const WORK: f64 = 10.0;

/// Centre of mass `R = sum m r / sum m` of all moving particles and of each species, along the axes that are neither
/// periodic nor flat.
///
/// The inclination is the angle between gravity and the direction from a given point to the centre of mass. In a drum,
/// a heap with a plane surface is symmetric about the normal of its surface through the axis of the drum. The
/// inclination about this axis is then the angle of the surface.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct CentreOfMass {
    times: SamplingTimes,
    /// Time of the latest sample.
    time: f64,
    axes: Vec<usize>,
    classes: Vec<Class>,
    inclination: Option<Inclination>,
    /// The centres of all classes along all axes, and the angle.
    rows: RowsOverTime,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
struct Class {
    /// `None` for all moving particles.
    species: Option<u32>,
    /// One average for each axis.
    averages: Vec<BlockAverage>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
struct Inclination {
    point: Vector,
    /// Average angle in degrees.
    average: BlockAverage,
}

/// Values at one time; `None` for the centre of mass of no particles.
struct Now {
    /// For each class, the centre of mass along each axis.
    centres: Vec<Option<f64>>,
    angle: Option<f64>,
}

impl Now {
    fn values(&self) -> Vec<Option<f64>> {
        self.centres.iter().copied().chain([self.angle]).collect()
    }
}

impl CentreOfMass {
    pub fn new(plan: &Plan, setup: &Setup<'_>) -> Self {
        let system = setup.system;
        let is_open = |&axis: &usize| system.space.boundary[axis] != Boundary::Periodic;
        let axes: Vec<usize> = system.axes().filter(is_open).collect();
        let times = budgeted_times(setup, plan.interval, WORK * system.moving.len() as f64);
        let average = BlockAverage::new(times.interval());
        let class = |species: Option<u32>| Class { species, averages: vec![average.clone(); axes.len()] };
        let classes = [None].into_iter().chain(species(system).into_iter().map(Some)).map(class).collect();
        let inclination = plan.axis_point.map(|point| Inclination { point: point.into(), average: average.clone() });
        let rows = RowsOverTime::new();
        let mut centre = Self { times, time: setup.sample.time, axes, classes, inclination, rows };
        let first = centre.now(&setup.sample, system).values();
        centre.rows.add(setup.sample.time, first);
        centre
    }

    fn now(&self, sample: &Sample<'_>, system: &SystemDescription) -> Now {
        // For each species, its mass, and the sum of mass times position.
        let mut sums = vec![(0.0, Vector::zeros()); system.species_masses.len()];
        for (index, (species, position)) in sample.species.iter().zip(sample.positions).enumerate() {
            let mass = system.mass_in(sample, index);
            if mass.is_finite() {
                let (sum, moment) = &mut sums[species.0 as usize];
                *sum += mass;
                *moment += position * mass;
            }
        }
        let counted = |class: &Class| match class.species {
            Some(species) => sums[species as usize],
            None => sums.iter().fold((0.0, Vector::zeros()), |all, one| (all.0 + one.0, all.1 + one.1)),
        };
        let centre = |class: &Class| Some(counted(class)).filter(|(mass, _)| *mass > 0.0).map(|(mass, sum)| sum / mass);
        let centres: Vec<Option<Vector>> = self.classes.iter().map(centre).collect();
        let weight: Vector = sums.iter().zip(&system.accelerations).map(|((mass, _), gravity)| gravity * *mass).sum();
        let angle = self.inclination.as_ref().zip(centres[0]);
        Now {
            angle: angle.and_then(|(about, centre)| self.angle(&weight, &(centre - about.point))),
            centres: centres.iter().flat_map(|centre| self.axes.iter().map(|&axis| Some((*centre)?[axis]))).collect(),
        }
    }

    /// Angle from gravity to a vector in degrees. Only the axes of this instrument count. With two axes, the angle is
    /// positive for rotations from the first axis towards the second.
    fn angle(&self, gravity: &Vector, vector: &Vector) -> Option<f64> {
        let part = |of: &Vector| Vector::from_fn(|axis, _| if self.axes.contains(&axis) { of[axis] } else { 0.0 });
        let (gravity, vector) = (part(gravity), part(vector));
        if gravity == Vector::zeros() || vector == Vector::zeros() {
            return None;
        }
        let across = match self.axes[..] {
            [first, second] => gravity[first] * vector[second] - gravity[second] * vector[first],
            _ => gravity.cross(&vector).norm(),
        };
        Some(libm::atan2(across, gravity.dot(&vector)).to_degrees())
    }

    fn titles(&self, system: &SystemDescription) -> Vec<(String, String)> {
        system.titles_of_all_and_of(self.classes.iter().filter_map(|class| class.species))
    }

    fn curves(&self, system: &SystemDescription) -> Vec<Curve> {
        let curve = |name: &str, title: &str, method: &str| {
            Curve::new(name, title, method).variable("t", "time", self.rows.times())
        };
        let mut centres = curve("centre_of_mass", "Centre of mass", CENTRE);
        let names =
            self.titles(system).into_iter().flat_map(|(_, of)| self.axes.iter().map(move |&axis| (axis, of.clone())));
        for (index, (axis, of)) in names.enumerate() {
            let name = format!("{}{of}", AXES[axis]);
            centres = centres.series(&name, "length", &self.rows.column(index));
        }
        let angles = self.inclination.as_ref().map(|_| {
            let title = "Inclination of the centre of mass";
            let last = self.classes.len() * self.axes.len();
            curve("inclination", title, INCLINATION).series("angle", "degree", &self.rows.column(last))
        });
        [centres].into_iter().chain(angles).collect()
    }
}

/// Moving species that are measured separately.
fn species(system: &SystemDescription) -> Vec<u32> {
    // A species may enter later.
    let is_present = |species: &u32| system.has_flow || system.species.contains(species);
    let present: Vec<u32> = system.moving_species().filter(is_present).collect();
    if (2..=MOST_SPECIES).contains(&present.len()) { present } else { Vec::new() }
}

impl Instrument for CentreOfMass {
    fn next_sample(&self) -> f64 {
        self.times.next()
    }

    fn sample(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        if !self.times.is_due(sample.time) {
            return;
        }
        let elapsed = sample.time - self.time;
        self.time = sample.time;
        let now = self.now(sample, system);
        let averages = self.classes.iter_mut().flat_map(|class| &mut class.averages);
        for (average, centre) in averages.zip(&now.centres) {
            centre.iter().for_each(|centre| average.add(*centre, elapsed));
        }
        if let Some((inclination, angle)) = self.inclination.as_mut().zip(now.angle) {
            inclination.average.add(angle, elapsed);
        }
        self.rows.add(sample.time, now.values());
    }

    fn report(&self, system: &SystemDescription, measured: &mut Measured) {
        for (class, (key, of)) in self.classes.iter().zip(self.titles(system)) {
            for (&axis, average) in self.axes.iter().zip(&class.averages) {
                measured.numbers.push(Number::estimated(
                    &format!("centre_of_mass_{}{key}", AXES[axis]),
                    &format!("Centre of mass{of} along {}", AXES[axis]),
                    "length",
                    average.estimate(),
                    CENTRE,
                ));
            }
        }
        if let Some(inclination) = &self.inclination {
            let (title, angle) = ("Inclination of the centre of mass", inclination.average.estimate());
            measured.numbers.push(Number::estimated("inclination", title, "degree", angle, INCLINATION));
        }
        measured.curves.extend(self.curves(system));
    }
}

const CENTRE: &str = "R = sum m r / sum m over the moving particles, averaged over the samples.";
const INCLINATION: &str = "Angle between gravity and the direction from axis_point to the centre of mass, without the \
    components along periodic axes, averaged over the samples. With two axes, the angle is positive in the sense from \
    the first axis to the second.";

#[cfg(test)]
mod tests;

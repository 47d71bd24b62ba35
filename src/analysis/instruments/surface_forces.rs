use serde::{Deserialize, Serialize};

use super::bins::Bins;
use super::block_times::{EARLY, block_times};
use super::instrument::{Instrument, Setup};
use super::quantity::{Curve, Measured, Normalisation, Number};
use super::system::{Sample, SystemDescription};
use crate::Vector;
use crate::analysis::sampling_times::SamplingTimes;
use crate::analysis::statistics::{BlockAverage, Estimate};
use crate::base::text::identifiers;
use crate::engine::event::{Event, Other};
use crate::model::measurement_plan::{FORCE_BINS, SurfaceForces as Plan};

const BLOCKS: u32 = 1000;

/// Forces on walls and other surfaces, `F = - sum J / t`, from the impulses `J` on particles in contacts.
///
/// The sum of the normal components, divided by the time and by the area of the surface, is the pressure. A curve shows
/// how the normal force depends on the position along an axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct SurfaceForces {
    blocks: SamplingTimes,
    block_start: f64,
    surfaces: Vec<OnSurface>,
    profile: Option<Profile>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct OnSurface {
    number: u32,
    /// Sums over contacts in the current block: impulse along x, y and z, impulse along the normal, number of contacts.
    sums: [f64; 5],
    averages: Vec<BlockAverage>,
    /// For each bin of the profile, the sum of the normal impulses in the current block, and the average normal force.
    bins: Vec<(f64, BlockAverage)>,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Profile {
    axis: usize,
    lower: f64,
    width: f64,
    count: usize,
}

impl Profile {
    fn bins(&self) -> Bins {
        Bins::of_width(self.lower, self.width, self.count)
    }
}

impl SurfaceForces {
    pub fn new(plan: &Plan, setup: &Setup<'_>) -> Self {
        let system = setup.system;
        let blocks = block_times(setup, plan.interval, BLOCKS);
        let average = BlockAverage::new(blocks.interval());
        let axis = plan.axis.as_ref().and_then(|axis| ["x", "y", "z"].iter().position(|known| known == axis));
        let profile = axis.map(|axis| {
            let count = Bins::planned(plan.bins, FORCE_BINS);
            let (lower, upper) = system.extent(axis);
            Profile { axis, lower, width: (upper - lower) / count as f64, count }
        });
        let surfaces = system.surfaces.iter().map(|surface| OnSurface {
            number: surface.number,
            sums: [0.0; 5],
            averages: vec![average.clone(); 5],
            bins: vec![(0.0, average.clone()); profile.map_or(0, |profile| profile.count)],
        });
        Self { block_start: setup.sample.time, surfaces: surfaces.collect(), blocks, profile }
    }
}

impl Instrument for SurfaceForces {
    fn next_sample(&self) -> f64 {
        self.blocks.next()
    }

    fn sample(&mut self, sample: &Sample<'_>, _: &SystemDescription) {
        let duration = sample.time - self.block_start;
        if duration > 0.0 {
            for surface in &mut self.surfaces {
                for (sum, average) in surface.sums.iter_mut().zip(&mut surface.averages) {
                    average.add(std::mem::take(sum) / duration, duration);
                }
                for (sum, average) in &mut surface.bins {
                    average.add(std::mem::take(sum) / duration, duration);
                }
            }
            self.block_start = sample.time;
        }
        self.blocks.pass_early(sample.time, EARLY);
    }

    /// Adds the contacts since the latest sample.
    fn end(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        self.sample(sample, system);
    }

    fn has_events(&self) -> bool {
        true
    }

    fn event(&mut self, event: &Event, _: &SystemDescription) {
        let Other::Surface { surface: number, .. } = event.other else { return };
        let Some(surface) = self.surfaces.iter_mut().find(|surface| surface.number == number) else { return };
        let normal = event.normal_impulse();
        let given: Vector = -event.impulse;
        for (sum, part) in surface.sums.iter_mut().zip([given.x, given.y, given.z, normal, 1.0]) {
            *sum += part;
        }
        if let Some(profile) = self.profile
            && let Some(bin) = profile.bins().index(event.positions[0][profile.axis])
        {
            surface.bins[bin].0 += normal;
        }
    }

    fn report(&self, system: &SystemDescription, measured: &mut Measured) {
        let names = identifiers(system.surfaces.iter().map(|surface| surface.name.as_str()));
        let axes: Vec<usize> = system.axes().collect();
        for ((surface, described), name) in self.surfaces.iter().zip(&system.surfaces).zip(&names) {
            let of = &described.name;
            let mut number = |key: &str, title: String, unit: &str, estimate: Option<Estimate>, method: &str| {
                measured.numbers.push(Number::estimated(
                    &format!("force_{name}_{key}"),
                    &title,
                    unit,
                    estimate,
                    method,
                ));
            };
            for &axis in &axes {
                let letter = ["x", "y", "z"][axis];
                let force = surface.averages[axis].estimate();
                number(letter, format!("Force on {of} along {letter}"), "mass length / time^2", force, FORCE);
            }
            let normal = surface.averages[3].estimate();
            number("normal", format!("Normal force on {of}"), "mass length / time^2", normal, NORMAL);
            if let Some(area) = described.area {
                let pressure = normal.map(|normal| normal.over(area));
                number("pressure", format!("Pressure on {of}"), "energy / length^D", pressure, PRESSURE);
            }
            number("rate", format!("Contacts with {of}"), "1 / time", surface.averages[4].estimate(), RATE);
        }
        if let Some(profile) = self.profile {
            let axis = ["x", "y", "z"][profile.axis];
            let title = format!("Normal force on surfaces along {axis}");
            let mut curve =
                Curve::new("surface_forces", &title, ALONG).variable(axis, "length", profile.bins().centres());
            for (surface, name) in self.surfaces.iter().zip(&names) {
                let per_length =
                    |(_, average): &(f64, BlockAverage)| average.estimate().map(|it| it.over(profile.width));
                let column: Vec<Option<Estimate>> = surface.bins.iter().map(per_length).collect();
                curve = curve
                    .series(name, "mass / time^2", &column)
                    .normalised(Normalisation::of("the force on a bin divided by its width"));
            }
            measured.curves.push(curve);
        }
    }
}

const FORCE: &str = "F = - sum J / t over contacts with the surface, with the impulse J on the particle.";
const NORMAL: &str =
    "Sum of the impulses along the normal per time; for a curved surface it exceeds the magnitude of the force.";
const PRESSURE: &str =
    "The normal force divided by the area of the surface itself; centres stay a radius away from it.";
const RATE: &str = "Contacts with the surface per time.";
const ALONG: &str =
    "Sum of the impulses along the normal per time and length. Each impulse counts at the centre of its particle.";

#[cfg(test)]
mod tests;

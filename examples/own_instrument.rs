//! Adds an instrument for the distribution of speeds to a run.

use std::error::Error;
use std::ops::ControlFlow;
use std::path::Path;

use carom::analysis::instruments::{Curve, Instrument, Measured, Sample, SystemDescription};
use carom::analysis::{SamplingTimes, statistics::BlockAverage};
use carom::io::{Existing, Folder};
use carom::model::{RunPlan, Until};
use carom::run::{Finished, Run};
use carom::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};
use serde::{Deserialize, Serialize};

const WIDTH: f64 = 0.25;

/// Measures the mean fraction of particles in each bin of speeds. All fields are saved in checkpoints.
#[derive(Clone, Serialize, Deserialize)]
pub struct Speeds {
    times: SamplingTimes,
    bins: Vec<BlockAverage>,
}

impl Instrument for Speeds {
    fn next_sample(&self) -> f64 {
        self.times.next()
    }

    fn sample(&mut self, sample: &Sample<'_>, _system: &SystemDescription) {
        for (k, bin) in self.bins.iter_mut().enumerate() {
            let inside = sample.velocities.iter().filter(|v| (v.norm() / WIDTH).floor() == k as f64).count();
            bin.add(inside as f64 / (WIDTH * sample.velocities.len() as f64), 1.0);
        }
        self.times.pass(sample.time);
    }

    fn report(&self, _system: &SystemDescription, measured: &mut Measured) {
        let middles = (0..self.bins.len()).map(|k| WIDTH * (k as f64 + 0.5)).collect();
        let estimates: Vec<_> = self.bins.iter().map(BlockAverage::estimate).collect();
        let curve = Curve::new("speeds", "Distribution of speeds", "probability density of the speed");
        let curve = curve.variable("v", "length / time", middles);
        measured.curves.push(curve.series("p(v)", "time / length", &estimates));
    }
}

/// Runs a fluid with the instrument `Speeds`, and writes the files of the run to a folder.
pub fn measured_in(folder: &Path) -> Result<Finished, Box<dyn Error>> {
    let scene = SceneBuilder::new("fluid")
        .species(SpeciesDraft::new("sphere").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("sphere", "sphere"))
        .fill(Fill::new(Lattice::FaceCentredCubic, "sphere").count(256).packing_fraction(0.3))
        .temperature(1.0)
        .run(RunPlan { equilibration: Until::time(2.0), limit: Until::time(20.0), ..RunPlan::default() })
        .build()?;
    let mut files = Folder::create(folder, &scene, Existing::Keep)?;
    let run = Run::new(scene).instrument("speeds", |setup| Speeds {
        times: SamplingTimes::given(setup.sample.time, 0.1),
        bins: vec![BlockAverage::new(1.0); 20],
    });
    let finished = run.execute(&mut files, &mut |_| ControlFlow::Continue(()))?;
    files.complete(&finished, "")?;
    Ok(finished)
}

/// Returns the most probable speed: an example of how to use an instrument after the run.
pub fn most_probable(finished: &Finished) -> Option<f64> {
    let speeds = finished.instrument::<Speeds>("speeds")?;
    let densities = speeds.bins.iter().map(|bin| bin.estimate().map_or(0.0, |estimate| estimate.mean));
    let (bin, _) = densities.enumerate().max_by(|(_, a), (_, b)| a.total_cmp(b))?;
    Some(WIDTH * (bin as f64 + 0.5))
}

fn main() -> Result<(), Box<dyn Error>> {
    let finished = measured_in(Path::new("runs/speeds"))?;
    if let Some(speed) = most_probable(&finished) {
        println!("the most probable speed is about {speed}");
    }
    println!("the curve is in runs/speeds/measurements/speeds.csv; carom report runs/speeds plots it");
    Ok(())
}

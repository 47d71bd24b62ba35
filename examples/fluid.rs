//! Compares the pressure of a hard-sphere fluid with the equation of state of Carnahan and Starling.

use std::error::Error;

use carom::analysis::instruments::Number;
use carom::analysis::published::carnahan_starling;
use carom::model::measurement_plan::{MeasurementPlan, PressureTensor};
use carom::model::{RunPlan, Until};
use carom::scene::{Fill, InteractionDraft, Lattice, Model, SpeciesDraft};
use carom::{Run, SceneBuilder};

const PACKING_FRACTION: f64 = 0.3;

/// The compressibility factor `p V / (N k T)` of 500 hard spheres.
pub fn compressibility_factor() -> Result<Number, Box<dyn Error>> {
    let scene = SceneBuilder::new("fluid")
        .species(SpeciesDraft::new("sphere").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("sphere", "sphere"))
        .fill(Fill::new(Lattice::FaceCentredCubic, "sphere").count(500).packing_fraction(PACKING_FRACTION))
        .temperature(1.0)
        .run(RunPlan { equilibration: Until::time(5.0), limit: Until::time(50.0), ..RunPlan::default() })
        .measure(MeasurementPlan { pressure_tensor: Some(PressureTensor::default()), ..MeasurementPlan::default() })
        .build()?;
    let finished = Run::new(scene).finish()?;
    Ok(finished.measured.number("compressibility_factor").ok_or("the pressure was not measured")?.clone())
}

fn main() -> Result<(), Box<dyn Error>> {
    let measured = compressibility_factor()?;
    let (mean, error) = (measured.mean.unwrap_or(f64::NAN), measured.standard_error.unwrap_or(f64::NAN));
    println!("measured: Z = {mean:.4} +- {error:.4}");
    println!("Carnahan and Starling: Z = {:.4}", carnahan_starling(PACKING_FRACTION));
    Ok(())
}

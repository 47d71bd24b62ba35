//! Export of the current state as a scene.

use carom::engine::Simulation;
use toml::{Table, Value};

/// Tables that the export replaces by the current particles and bonds.
const START: [&str; 5] = ["particle", "file", "chain", "fill", "bond"];

const EQUILIBRATION: [&str; 3] = ["equilibration", "equilibration_time", "equilibration_events"];

/// Returns the text of a scene that starts with the current positions and velocities. Static meshes stay as written.
/// Stages and equilibration are left out if the measurement has begun.
pub fn scene(text: &str, simulation: &Simulation, is_measuring: bool) -> Result<String, String> {
    if simulation.scale() != 1.0 {
        return Err("the diameters have grown, so the state cannot be exported as a scene: export it before they grow"
            .to_owned());
    }
    let mut table: Table = toml::from_str(text).map_err(|error| error.to_string())?;
    START.iter().for_each(|key| drop(table.remove(*key)));
    let (scene, snapshot) = (simulation.scene(), simulation.snapshot());
    let space = table.entry("space").or_insert_with(|| Value::Table(Table::new()));
    if let Value::Table(space) = space {
        space.insert("size".to_owned(), numbers(scene.space().size.as_slice()));
        space.insert("lower".to_owned(), numbers(scene.space().lower.as_slice()));
    }
    let is_written = |id: u32| !scene.static_surfaces().iter().any(|surface| surface.particles.contains(&id));
    let listed: Vec<u32> = (0..).zip(scene.particles()).map(|(id, _)| id).filter(|id| is_written(*id)).collect();
    let particle = |id: &u32| {
        let at = *id as usize;
        let species = &scene.species()[scene.particles()[at].species.0 as usize];
        let mut particle = Table::new();
        particle.insert("species".to_owned(), Value::String(species.name.clone()));
        particle.insert("position".to_owned(), numbers(snapshot.positions[at].as_slice()));
        particle.insert("velocity".to_owned(), numbers(snapshot.velocities[at].as_slice()));
        Value::Table(particle)
    };
    table.insert("particle".to_owned(), Value::Array(listed.iter().map(particle).collect()));
    let place = |id: u32| listed.binary_search(&id).ok().and_then(|place| i64::try_from(place).ok());
    let bonds: Vec<Value> = scene
        .bonds()
        .iter()
        .filter_map(|bond| {
            let [a, b] = bond.pair.map(|id| place(id.0));
            let name = scene.interactions()[bond.interaction.0 as usize].name.clone()?;
            let mut table = Table::new();
            table.insert("particles".to_owned(), Value::Array(vec![Value::Integer(a?), Value::Integer(b?)]));
            table.insert("interaction".to_owned(), Value::String(name));
            Some(Value::Table(table))
        })
        .collect();
    if !bonds.is_empty() {
        table.insert("bond".to_owned(), Value::Array(bonds));
    }
    table.insert("start_time".to_owned(), Value::Float(snapshot.time));
    if is_measuring {
        table.remove("stage");
        if let Some(Value::Table(run)) = table.get_mut("run") {
            EQUILIBRATION.iter().for_each(|key| drop(run.remove(*key)));
        }
    }
    toml::to_string(&table).map_err(|error| error.to_string())
}

fn numbers(numbers: &[f64]) -> Value {
    Value::Array(numbers.iter().map(|x| Value::Float(*x)).collect())
}

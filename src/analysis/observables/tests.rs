//! Means of temperature and energy against integrals from event to event.

use super::Observer;
use crate::engine::{Simulation, Until};
use crate::model::potential::Potential;
use crate::model::space::{Boundary, Space};
use crate::model::{Scene, Thermostat};
use crate::scene::{Arrangement, Fill, SceneBuilder};

/// Two species that dissipate at their cores and have wells or shoulders around them.
fn mixture(space: Space) -> SceneBuilder {
    let well = |diameter, depth| Potential::square_well(diameter, 1.4, depth).unwrap();
    let fill =
        |species: &str, count| Fill { temperature: Some(1.3), ..Fill::new(Arrangement::Random, species).count(count) };
    SceneBuilder::new("mixture")
        .space(space)
        .species("A", 0.7, 1.0)
        .species("B", 3.1, 1.2)
        .interaction("A", "A", well(1.0, 0.9), 0.8)
        .interaction("A", "B", well(1.1, -0.3), 0.9)
        .interaction("B", "B", well(1.2, 0.5), 0.7)
        .add_fill(fill("A", 12))
        .add_fill(fill("B", 7))
}

/// Means of the kinetic energy and of the energy of the pairs, by the observer from two rows, and from event to event.
fn means(scene: Scene, bath: Option<&Thermostat>) -> [[f64; 2]; 2] {
    let mut observer = Observer::new(&scene);
    observer.set_thermostat(&scene, bath);
    let freedom = observer.applicable().degrees_of_freedom;
    let mut simulation = Simulation::without_plan(scene);
    simulation.set_thermostat(bath, 0);
    simulation.advance(Until::time(0.3)).unwrap();
    observer.row(&simulation);
    let count = simulation.scene().particles.len() as f64;
    let energies = |simulation: &Simulation| [simulation.energy().kinetic, simulation.energy().pair];
    let (mut now, mut last, mut sums) = (simulation.time(), energies(&simulation), [0.0; 2]);
    let (from, to) = (now, 4.0);
    simulation
        .advance_with_state(Until::time(to), |event, simulation| {
            (0..2).for_each(|k| sums[k] += last[k] * (event.time - now));
            (now, last) = (event.time, energies(simulation));
        })
        .unwrap();
    (0..2).for_each(|k| sums[k] += last[k] * (to - now));
    observer.row(&simulation);
    let mean = |name: &str| observer.estimates().iter().find(|(known, _)| *known == name).unwrap().1.mean;
    let observed = [0.5 * freedom * mean("temperature"), count * mean("potential_energy_per_particle")];
    [observed, sums.map(|sum| sum / (to - from))]
}

#[test]
fn means_of_temperature_and_energy_are_exact_however_rare_the_rows_are() {
    let bath = Thermostat::Andersen { temperature: 1.3, rate: 2.0, axes: [true; 3] };
    let cube = Space::periodic_cube(5.3);
    let slit = Space { boundary: [Boundary::walls(0.9), Boundary::Periodic, Boundary::Periodic], ..cube.clone() };
    let flat =
        Space { boundary: [Boundary::Periodic, Boundary::Periodic, Boundary::Flat], ..Space::periodic_cube(9.0) };
    let flat = Space { size: crate::Vector::new(9.0, 9.0, 0.0), ..flat };
    for (what, scene, bath) in [
        ("bath", mixture(cube.clone()), Some(&bath)),
        ("cooling slit", mixture(slit.clone()), None),
        ("thermal walls", mixture(slit).wall_temperature(0, 0.8), None),
        ("bath in a plane", mixture(flat), Some(&bath)),
    ] {
        let [observed, exact] = means(scene.build().unwrap(), bath);
        for k in 0..2 {
            // Some hundred events, each rounded a few times, of energies of some tens.
            let scale = exact[0].abs() + exact[1].abs();
            assert!((observed[k] - exact[k]).abs() < 1e-11 * scale, "{what}, {k}: {observed:?} {exact:?}");
        }
    }
}

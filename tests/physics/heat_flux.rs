//! Heat through walls, with and without collisions.

use std::f64::consts::PI;

use carom::Vector;
use carom::analysis::statistics::Estimate;
use carom::engine::Simulation;
use carom::model::space::{Boundary, Face, Space};
use carom::model::{ContactLaw, RunPlan, Until};
use carom::run::Finished;
use carom::scene::{Arrangement, Fill, InteractionDraft, Model, SceneBuilder, SpeciesDraft};

use super::measure::{finish, hard};

fn flux(finished: &Finished, wall: &str) -> Option<Estimate> {
    finished.observable(&format!("heat_flux_through_{wall}_wall"))
}

fn is_within(flux: &Estimate, expected: f64) -> bool {
    (flux.mean - expected).abs() < 4.0 * flux.standard_error.unwrap()
}

fn plates(size: [f64; 3]) -> Space {
    let other = |size: f64| if size == 0.0 { Boundary::Flat } else { Boundary::Periodic };
    let boundary = [Boundary::walls(1.0), other(size[1]), other(size[2])];
    Space { lower: Vector::zeros(), size: Vector::from(size), boundary }
}

#[test]
fn collisionless_gas_carries_the_exact_heat_flux() {
    // A particle leaves a wall of temperature T with a mean energy of (D + 1) T / 2. The mean time to the other wall is
    // sqrt(pi m / (2 T)) per unit of length.
    let temperatures = [2.0_f64, 0.7];
    for size in [[9.0, 0.0, 0.0], [9.0, 5.0, 0.0], [9.0, 5.0, 6.0]] {
        let space = plates(size);
        let (area, dimensions) = (space.wall_area(0).unwrap(), space.dimensions() as f64);
        let species = [("A", 0.7, 1.0, 40_u32), ("B", 3.0, 1.6, 25)];
        let mut scene = SceneBuilder::new("collisionless").space(space).wall_temperatures(0, temperatures.map(Some));
        let mut expected = 0.0;
        for (name, mass, diameter, count) in species {
            scene = scene.species(SpeciesDraft::new(name).mass(mass).diameter(diameter));
            let slowness: f64 = temperatures.iter().map(|t| (PI * mass / (2.0 * t)).sqrt()).sum();
            let energy = 0.5 * (dimensions + 1.0) * (temperatures[0] - temperatures[1]);
            expected += f64::from(count) * energy / ((9.0 - diameter) * slowness * area);
        }
        for pair in [["A", "A"], ["A", "B"], ["B", "B"]] {
            scene = scene.interaction(InteractionDraft::new(Model::None).between(pair[0], pair[1]));
        }
        for (name, _, _, count) in species {
            scene = scene.fill(Fill::new(Arrangement::Random, name).count(u64::from(count)));
        }
        let run = RunPlan { equilibration: Until::events(20_000), limit: Until::events(120_000), ..RunPlan::default() };
        let finished = finish(scene.temperature(1.0).run(run).build().unwrap());
        for (wall, expected) in [("lower_x", expected), ("upper_x", -expected)] {
            let flux = flux(&finished, wall).unwrap();
            println!("{size:?} {wall}: {flux:?}, expected {expected}");
            assert!(is_within(&flux, expected), "{wall}: {flux:?} {expected}");
            assert!(flux.standard_error.unwrap() < 0.02 * expected.abs(), "{wall}: {flux:?} {expected}");
        }
    }
}

fn gas(temperatures: [Option<f64>; 2]) -> SceneBuilder {
    SceneBuilder::new("gas")
        .space(plates([12.0, 10.0, 10.0]))
        .wall_temperatures(0, temperatures)
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .interaction(InteractionDraft::new(hard(1.0)).between("A", "A"))
        .fill(Fill::new(Arrangement::Random, "A").count(120))
        .temperature(1.3)
        .run(RunPlan { equilibration: Until::events(10_000), limit: Until::events(150_000), ..RunPlan::default() })
}

#[test]
fn between_equal_temperatures_no_heat_flows_on_average() {
    let finished = finish(gas([Some(1.3); 2]).build().unwrap());
    for wall in ["lower_x", "upper_x"] {
        let flux = flux(&finished, wall).unwrap();
        println!("{wall}: {flux:?}");
        assert!(is_within(&flux, 0.0) && flux.standard_error.unwrap() < 0.01, "{flux:?}");
    }
    let temperature = finished.observables[0].1;
    assert!(is_within(&temperature, 1.3), "{temperature:?}");
}

#[test]
fn thermal_wall_sets_the_temperature_and_elastic_wall_has_no_flux() {
    let finished = finish(gas([None, Some(2.1)]).build().unwrap());
    assert!(flux(&finished, "lower_x").is_none());
    let heat = flux(&finished, "upper_x").unwrap();
    let temperature = finished.observables[0].1;
    println!("{heat:?} {temperature:?}");
    assert!(is_within(&heat, 0.0) && heat.standard_error.unwrap() < 0.01, "{heat:?}");
    assert!(is_within(&temperature, 2.1) && temperature.standard_error.unwrap() < 0.03, "{temperature:?}");
}

#[test]
fn heat_through_all_walls_equals_the_energy_change() {
    let wall = |restitution: f64| Face::Wall(ContactLaw::smooth(restitution));
    let boundary = [
        Boundary::walls(1.0),
        Boundary::Bounded { lower: wall(0.8), upper: wall(0.55) },
        Boundary::Bounded { lower: wall(1.0), upper: wall(0.9) },
    ];
    let mut scene = SceneBuilder::new("six")
        .space(Space { boundary, ..Space::periodic_cube(9.0) })
        .wall_temperatures(0, [Some(3.1), Some(0.4)])
        .wall_temperatures(2, [Some(1.7), None])
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .species(SpeciesDraft::new("B").mass(3.0).diameter(1.6));
    for (pair, diameter) in [(["A", "A"], 1.0), (["A", "B"], 1.3), (["B", "B"], 1.6)] {
        scene = scene.interaction(InteractionDraft::new(hard(diameter)).between(pair[0], pair[1]).restitution(0.85));
    }
    for (name, count) in [("A", 40), ("B", 20)] {
        scene = scene.fill(Fill::new(Arrangement::Random, name).count(count));
    }
    let mut simulation = Simulation::without_plan(scene.temperature(1.3).build().unwrap());
    let start = simulation.energy().kinetic;
    let (mut at_walls, mut in_pairs) = ([[0.0; 2]; 3], 0.0);
    simulation
        .advance_with(Until::events(30_000), |event| match event.wall() {
            Some((axis, is_upper)) => {
                let mass = if event.distance == 0.5 { 0.7 } else { 3.0 };
                let [before, after] = [event.before[0], event.after[0]].map(|v| v.norm_squared());
                at_walls[usize::from(axis)][usize::from(is_upper)] += 0.5 * mass * (after - before);
            }
            None => in_pairs += event.dissipated,
        })
        .unwrap();
    let (counts, change) = (simulation.event_counts(), simulation.energy().kinetic - start);
    let heat = counts.wall_heat.map(|walls| walls.map(|wall| wall.total()));
    println!("{heat:?}, {in_pairs} in pairs, {change}");
    // Each total is about ten thousand, and has about 30,000 rounded terms.
    let round_off = 1e-9;
    for (heat, expected) in heat.iter().flatten().zip(at_walls.iter().flatten()) {
        assert!((heat - expected).abs() < round_off, "{heat} {expected}");
    }
    assert!((heat.iter().flatten().sum::<f64>() - in_pairs - change).abs() < round_off);
    assert!((counts.supplied.total() - counts.dissipated.total() - change).abs() < round_off);
    assert!(heat[0][0] > 1000.0 && heat[2][1] < 0.0 && heat[1][0] < 0.0 && heat[1][1] < heat[1][0], "{heat:?}");
}

#[test]
fn each_wall_of_a_line_dissipates_by_its_own_restitution() {
    let wall = |restitution: f64| Face::Wall(ContactLaw::smooth(restitution));
    let walls = Boundary::Bounded { lower: wall(0.9), upper: wall(0.5) };
    let space = Space { boundary: [walls, Boundary::Flat, Boundary::Flat], ..plates([11.0, 0.0, 0.0]) };
    let scene = SceneBuilder::new("line")
        .space(space)
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .interaction(InteractionDraft::new(Model::None).between("A", "A"))
        .particle("A", Vector::new(3.0, 0.0, 0.0), Vector::new(2.0, 0.0, 0.0))
        .run(RunPlan { limit: Until::time(20.0), ..RunPlan::default() });
    let finished = finish(scene.build().unwrap());
    // The particle travels 7.5 to the upper wall at speed 2, then 10 to the lower wall at speed 1. It continues at
    // speed 0.9, and the run ends before a third contact.
    let [lower, upper] = ["lower_x", "upper_x"].map(|wall| flux(&finished, wall).unwrap().mean);
    let energy = |speed: f64| 0.5 * 0.7 * speed * speed;
    assert!((upper * 20.0 - (energy(1.0) - energy(2.0))).abs() < 1e-13, "{upper}");
    assert!((lower * 20.0 - (energy(0.9) - energy(1.0))).abs() < 1e-13, "{lower}");
}

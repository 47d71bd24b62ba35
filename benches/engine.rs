//! Events per second of whole systems: `cargo bench`. Absolute numbers depend on the machine and its mood; compare ratios.

use carom::potential::Potential;
use carom::scene::{Amount, Lattice, Scene, SceneBuilder};
use carom::simulation::{Simulation, Until};
use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};

/// Physical events per measurement.
const EVENTS: u64 = 100_000;

/// A fluid in equilibrium, as far as ten contacts per particle make one.
fn fluid(potential: Potential, count: u64, packing_fraction: f64, temperature: f64) -> Simulation {
    let scene = SceneBuilder::new("fluid")
        .species("A", 1.0, 1.0)
        .interaction("A", "A", potential, 1.0)
        .fill(Lattice::FaceCentredCubic, "A", count, Amount::PackingFraction(packing_fraction))
        .temperature(temperature)
        .build()
        .expect("a valid scene");
    let mut simulation = Simulation::new(scene);
    simulation.advance(Until::events(5 * count)).expect("elastic spheres do not arrest");
    simulation
}

fn configured(name: &str) -> Simulation {
    let scene = Scene::from_file(format!("configs/{name}.toml")).expect("a valid scene");
    let mut simulation = Simulation::new(scene);
    simulation.advance(Until::events(EVENTS)).expect("the TC model prevents an arrest");
    simulation
}

fn measure(criterion: &mut Criterion, name: &str, mut simulation: Simulation) {
    let mut group = criterion.benchmark_group("events");
    group.sample_size(10).throughput(Throughput::Elements(EVENTS));
    group.bench_function(name, |bencher| {
        bencher.iter_batched(
            || (),
            |()| {
                let until = Until::events(simulation.tally().physical() + EVENTS);
                simulation.advance(until).expect("the run goes on")
            },
            BatchSize::PerIteration,
        );
    });
}

fn systems(criterion: &mut Criterion) {
    let hard = || Potential::hard_sphere(1.0).expect("a valid potential");
    for packing_fraction in [0.1, 0.3, 0.49] {
        let name = format!("hard spheres, N = 10976, phi = {packing_fraction}");
        measure(criterion, &name, fluid(hard(), 10_976, packing_fraction, 1.0));
    }
    let well = Potential::square_well(1.0, 1.5, 1.0).expect("a valid potential");
    measure(criterion, "square well 1.5, N = 10976, rho = 0.5", fluid(well, 10_976, 0.2618, 2.0));
    measure(criterion, "hopper", configured("hopper"));
    measure(criterion, "pendulum", configured("pendulum"));
}

criterion_group!(benches, systems);
criterion_main!(benches);

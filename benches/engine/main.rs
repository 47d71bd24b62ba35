//! Times the detection functions and the events of whole systems: `cargo bench --bench engine`. Absolute numbers depend
//! on the machine and its load; compare ratios.

mod kernels;
mod systems;

use carom::engine::Until;
use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use systems::{SYSTEMS, System};

const EVENTS: u64 = 100_000;

fn measure(criterion: &mut Criterion, system: &System) {
    let mut group = criterion.benchmark_group("events");
    group.sample_size(10).throughput(Throughput::Elements(EVENTS));
    if system.is_steady {
        let mut simulation = (system.start)();
        group.bench_function(system.name, |bencher| {
            bencher.iter_batched(
                || (),
                |()| {
                    let events = simulation.event_counts().physical() + EVENTS;
                    simulation.advance(Until::events(events)).expect("the run goes on")
                },
                BatchSize::PerIteration,
            );
        });
    } else {
        group.bench_function(system.name, |bencher| {
            bencher.iter_batched(
                system.start,
                |mut simulation| {
                    let events = simulation.event_counts().physical() + EVENTS;
                    simulation.advance(Until::events(events)).expect("the run goes on");
                    simulation
                },
                BatchSize::PerIteration,
            );
        });
    }
}

fn whole_systems(criterion: &mut Criterion) {
    for system in &SYSTEMS {
        measure(criterion, system);
    }
}

criterion_group!(benches, kernels::all, whole_systems);
criterion_main!(benches);

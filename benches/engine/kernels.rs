//! Times each detection function on a thousand random states.

use carom::Vector;
use carom::physics::detection::{accelerated, inertial, plane};
use carom::physics::motion::RelativeState;
use carom::physics::overlap::{Quadratic, Quartic, Side};
use criterion::{Criterion, Throughput};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};
use std::hint::black_box;

const STATES: u64 = 1_000;

const DISTANCE: f64 = 1.0;

struct State {
    relative: RelativeState,
    acceleration: Vector,
}

/// Random states with distances from `lower` to `upper`.
fn states(lower: f64, upper: f64) -> Vec<State> {
    let mut generator = ChaCha8Rng::seed_from_u64(1);
    let mut uniform = || (generator.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let mut vector = || Vector::from_fn(|_, _| 2.0 * uniform() - 1.0);
    let mut state = || {
        let direction = vector();
        let position = direction.normalize() * (lower + (upper - lower) * 0.5 * (1.0 + direction.x));
        State { relative: RelativeState { position, velocity: vector() }, acceleration: vector() }
    };
    (0..STATES).map(|_| state()).collect()
}

fn measure<T>(criterion: &mut Criterion, name: &str, inputs: &[T], ask: impl Fn(&T) -> Option<f64>) {
    let mut group = criterion.benchmark_group("detection");
    group.throughput(Throughput::Elements(STATES));
    group.bench_function(name, |bencher| {
        bencher.iter(|| {
            for input in inputs {
                black_box(ask(black_box(input)));
            }
        });
    });
}

/// Times Algorithms 2 to 6 of the paper and contacts with a plane.
pub fn all(criterion: &mut Criterion) {
    let (outside, inside) = (states(1.05, 3.0), states(0.1, 0.95));
    let quadratics = |states: &[State]| -> Vec<Quadratic> {
        states.iter().map(|state| Quadratic::new(&state.relative, DISTANCE * DISTANCE)).collect()
    };
    let quartics = |states: &[State]| -> Vec<Quartic> {
        let quartic = |state: &State| Quartic::new(&state.relative, &state.acceleration, DISTANCE * DISTANCE);
        states.iter().map(quartic).collect()
    };
    let heights: Vec<[f64; 3]> = outside
        .iter()
        .map(|state| [state.relative.position.z, state.relative.velocity.z, state.acceleration.z])
        .collect();
    measure(criterion, "Algorithm 2 (inertial, from outside)", &quadratics(&outside), inertial::positive);
    measure(criterion, "Algorithm 3 (inertial, from inside)", &quadratics(&inside), inertial::negative);
    let from = |side| move |f: &Quartic| accelerated::next_event(f, side);
    measure(criterion, "Algorithm 4 (accelerated, from outside)", &quartics(&outside), from(Side::Positive));
    measure(criterion, "Algorithms 5 and 6 (accelerated, from inside)", &quartics(&inside), from(Side::Negative));
    measure(criterion, "plane", &heights, |&[height, velocity, acceleration]| {
        plane::next_event(height, velocity, acceleration)
    });
}

//! Compares every detection function with the exact oracle, on states decoded from bytes.
#![no_main]
#![allow(dead_code)]

#[path = "../../tests/oracle/compare.rs"]
mod compare;
#[path = "../../tests/oracle/crossing.rs"]
mod crossing;
#[path = "../../tests/oracle/detection.rs"]
mod detection;
#[path = "../../tests/oracle/dyadic.rs"]
mod dyadic;
#[path = "../../tests/oracle/exact.rs"]
mod exact;
#[path = "../../tests/oracle/measure.rs"]
mod measure;
#[path = "../../tests/oracle/polynomial.rs"]
mod polynomial;
#[path = "../../tests/oracle/rule.rs"]
mod rule;
#[path = "../../tests/oracle/sturm.rs"]
mod sturm;
#[path = "../../tests/oracle/witness.rs"]
mod witness;

use carom::Vector;
use compare::{Judgement, compare};
use detection::Algorithm;
use exact::State;
use libfuzzer_sys::fuzz_target;

/// One byte selects the kind of number, and eight bytes give its value.
const BYTES: usize = 9;

fuzz_target!(|bytes: &[u8]| {
    let Some((&choice, rest)) = bytes.split_first() else { return };
    let numbers: Vec<f64> = rest.chunks_exact(BYTES).map(number).collect();
    let &[rx, ry, rz, vx, vy, vz, ax, ay, az, s, ..] = numbers.as_slice() else { return };
    let position = Vector::new(rx, ry, rz);
    // In half of the states, the particles are close to contact.
    let distance = if choice & 8 == 0 { s.abs() } else { position.norm() * (1.0 + s * f64::EPSILON) };
    if !(1e-50..=1e50).contains(&distance) {
        return;
    }
    let algorithm = Algorithm::ALL[usize::from(choice & 7) % Algorithm::ALL.len()];
    let mut state = State { position, velocity: Vector::new(vx, vy, vz), acceleration: Vector::new(ax, ay, az), distance };
    match algorithm.takes_acceleration() {
        Some(false) => state.acceleration = Vector::zeros(),
        Some(true) if state.acceleration == Vector::zeros() => return,
        _ => {}
    }
    let comparison = compare(algorithm, &state);
    assert!(!matches!(comparison.judgement, Judgement::Wrong(_)), "{algorithm:?} {state:?}: {comparison:?}");
});

/// Returns zero, a small integer, a small binary fraction, or a float whose magnitude is from `1e-50` to `1e50`.
fn number(bytes: &[u8]) -> f64 {
    let bits = u64::from_le_bytes(bytes[1..].try_into().expect("eight bytes"));
    let small = f64::from(bits as i8);
    match bytes[0] % 4 {
        0 => 0.0,
        1 => small,
        2 => small * 2_f64.powi(i32::from((bits >> 8) as i8) / 4),
        _ => {
            let x = f64::from_bits(bits);
            if (1e-50..=1e50).contains(&x.abs()) { x } else { small / 3.0 }
        }
    }
}

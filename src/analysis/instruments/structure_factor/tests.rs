use super::*;
use crate::Vector;
use crate::analysis::instruments::test_system::{report, sample};
use crate::model::space::{Boundary, Space};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

fn measure(space: &Space, frames: &[Vec<Vector>]) -> StructureFactor {
    let system = SystemDescription::of_points(space.clone(), u32::try_from(frames[0].len()).unwrap());
    let velocities = vec![Vector::zeros(); frames[0].len()];
    let sample = |k: usize| sample(k as f64, &frames[k], &velocities);
    let plan = plan::StructureFactor { largest: Some(9.0), interval: Some(1.0) };
    let setup = Setup { system: &system, sample: sample(0), duration: frames.len() as f64 };
    let mut instrument = StructureFactor::new(&plan, &setup);
    (1..frames.len()).for_each(|k| instrument.sample(&sample(k), &system));
    instrument
}

#[test]
fn modes_of_a_sheared_box_match_direct_sums_for_any_image() {
    let space = Space { lower: Vector::new(-1.0, 3.0, 0.5), ..Space::periodic_cube(1.0) };
    let space = Space { size: Vector::new(8.0, 5.0, 6.0), ..space };
    let positions: Vec<Vector> =
        (0..20).map(|k| Vector::from_fn(|axis, _| (f64::from(k) * (1.3 + axis as f64)).rem_euclid(5.0))).collect();
    let system = SystemDescription::of_points(space.clone(), 20);
    for displacement in [1.1, -3.7] {
        let shells = vectors::all_shells(&space, displacement, 20.0, 20);
        let modes = |positions: &[Vector]| {
            density_modes(&shells, &Sample { positions, displacement, ..Sample::default() }, &system)
        };
        let sums = modes(&positions);
        let up = Vector::new(displacement, space.size.y, 0.0);
        let images = modes(&positions.iter().map(|position| position + up).collect::<Vec<_>>());
        let all: Vec<[i32; 3]> = shells.iter().flat_map(|shell| shell.vectors.clone()).collect();
        assert!(all.iter().filter(|n| n[0] != 0 && n[1] != 0).count() > 300);
        for ((n, [re, im]), image) in all.iter().zip(sums).zip(images) {
            let [x, y, z] = n.map(f64::from);
            let q = 2.0 * PI * Vector::new(x / 8.0, (y - x * displacement / 8.0) / 5.0, z / 6.0);
            let phase = |position: &Vector| q.dot(&(position - space.lower));
            let exact: [f64; 2] = [
                positions.iter().map(|position| phase(position).cos()).sum(),
                positions.iter().map(|position| phase(position).sin()).sum(),
            ];
            // Round-off of powers up to 35 and of phases up to 250, summed over 20 particles.
            assert!((exact[0] - re).abs() < 2e-12 && (exact[1] - im).abs() < 2e-12, "{n:?}");
            assert!((image[0] - re).abs() < 2e-12 && (image[1] - im).abs() < 2e-12, "{n:?}");
        }
    }
}

#[test]
fn sheared_lattice_scatters_only_at_reciprocal_vectors() {
    // A triangular lattice of spacing 1 has peaks at `4 pi / sqrt(3) = 7.26`, in three directions. A box of five rows
    // is periodic if its upper image is displaced by half a spacing.
    let height = 0.75_f64.sqrt();
    let boundary = [Boundary::Periodic, Boundary::Periodic, Boundary::Flat];
    let space = Space { lower: Vector::zeros(), size: Vector::new(6.0, 5.0 * height, 0.0), boundary };
    let site = |k: u32| Vector::new(f64::from(k % 6) + 0.5 * f64::from(k / 6 % 2), f64::from(k / 6) * height, 0.0);
    let positions: Vec<Vector> = (0..30).map(site).collect();
    let system = SystemDescription { shear_rate: 1.0, ..SystemDescription::of_points(space, 30) };
    let plan = plan::StructureFactor { largest: Some(9.0), interval: Some(1.0) };
    let setup = Setup { system: &system, sample: Sample::default(), duration: 10.0 };
    let mut instrument = StructureFactor::new(&plan, &setup);
    // Displacements by whole spacings change the wave vectors of the box, but not the lattice.
    for (time, displacement) in [(1.0, 0.5), (2.0, -1.5), (3.0, 2.5)] {
        let sample = Sample { time, positions: &positions, displacement, ..Sample::default() };
        instrument.sample(&sample, &system);
        let mut peaks = 0;
        let modes = density_modes(&instrument.shells, &sample, &system);
        for [re, im] in modes {
            let square = re * re + im * im;
            let is_peak = (square - 900.0).abs() < 1e-9;
            assert!(is_peak || square < 1e-9, "{square}");
            peaks += u32::from(is_peak);
        }
        assert_eq!(peaks, 3, "{displacement}");
    }
    let measured = report(&instrument, &system);
    let (q, values) = (&measured.curves[0].variables[0].values, &measured.curves[0].series[0].values);
    let peak = 4.0 * PI / 3.0_f64.sqrt();
    let width = q.windows(2).map(|two| two[1] - two[0]).fold(f64::INFINITY, f64::min);
    for (q, value) in q.iter().zip(values) {
        assert!(value.unwrap() < 1e-9 || (q - peak).abs() < width.max(1.0), "{q} {value:?}");
    }
    assert!(values.iter().any(|value| value.unwrap() > 1.0));
}

#[test]
fn modes_match_direct_sums() {
    let boundary = [Boundary::Periodic, Boundary::walls(1.0), Boundary::Periodic];
    let space = Space { lower: Vector::new(-1.0, 3.0, 0.5), size: Vector::new(8.0, 5.0, 6.0), boundary };
    let positions: Vec<Vector> =
        (0..20).map(|k| Vector::from_fn(|axis, _| (f64::from(k) * (1.3 + axis as f64)).rem_euclid(5.0))).collect();
    let system = SystemDescription::of_points(space.clone(), 20);
    let sample = Sample { positions: &positions, ..Sample::default() };
    let shells = vectors::shells(&space, 20.0, 20);
    let sums = density_modes(&shells, &sample, &system);
    let all: Vec<[i32; 3]> = shells.iter().flat_map(|shell| shell.vectors.clone()).collect();
    assert_eq!(sums.len(), all.len());
    for (n, [re, im]) in all.iter().zip(sums) {
        assert_eq!(n[1], 0, "walls have no wave vectors");
        let q = Vector::from_fn(|k, _| 2.0 * PI * f64::from(n[k]) / space.size[k]);
        let phase = |position: &Vector| q.dot(&(position - space.lower));
        let exact: [f64; 2] = [
            positions.iter().map(|position| phase(position).cos()).sum(),
            positions.iter().map(|position| phase(position).sin()).sum(),
        ];
        // Round-off of powers up to 25 and of phases up to 200, summed over 20 particles.
        assert!((exact[0] - re).abs() < 1e-12 && (exact[1] - im).abs() < 1e-12, "{n:?}");
    }
}

#[test]
fn a_lattice_scatters_into_its_reciprocal_lattice_only() {
    // A simple cubic lattice of spacing 1 has peaks along the axes at 2 pi, and no others up to 7.
    let site = |k: u32| Vector::new(f64::from(k % 6), f64::from(k / 6 % 6), f64::from(k / 36));
    let frame: Vec<Vector> = (0..216).map(site).collect();
    let instrument = measure(&Space::periodic_cube(6.0), &vec![frame; 10]);
    let means = instrument.curve.means();
    for (shell, mean) in instrument.shells.iter().zip(means) {
        let is_peak = |n: &&[i32; 3]| n.iter().all(|n| n % 6 == 0);
        let peaks = shell.vectors.iter().filter(is_peak).count() as f64;
        let expected = 216.0 * peaks / shell.vectors.len() as f64;
        assert!((mean.unwrap() - expected).abs() < 1e-9, "q = {}", shell.wave_number);
        assert!((shell.wave_number - 2.0 * PI).abs() > 0.6 || peaks >= 3.0);
    }
}

#[test]
fn an_ideal_gas_has_no_structure() {
    let mut random = ChaCha8Rng::seed_from_u64(8);
    let mut next = || 7.0 * (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let frames: Vec<Vec<Vector>> = (0..65).map(|_| (0..50).map(|_| Vector::from_fn(|_, _| next())).collect()).collect();
    let instrument = measure(&Space::periodic_cube(7.0), &frames);
    let (means, errors) = (instrument.curve.means(), instrument.curve.standard_errors());
    assert!(means.len() >= 9);
    for (shell, (mean, error)) in instrument.shells.iter().zip(means.into_iter().zip(errors)) {
        // At random positions, `|sum_j exp(i q.r_j)|^2 / N` has an exponential distribution with mean and standard
        // deviation 1.
        let exact = (1.0 / (64.0 * shell.vectors.len() as f64)).sqrt();
        assert!((mean.unwrap() - 1.0).abs() < 4.0 * exact, "{mean:?} +- {exact}");
        assert!((error.unwrap() / exact - 1.0).abs() < 0.6, "{error:?} but {exact}");
    }
}

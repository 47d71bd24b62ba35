//! Sheared boxes compared with searches over all images.

use carom::Vector;
use carom::engine::{Simulation, Snapshot};
use carom::model::MeasurementPlan;
use carom::model::measurement_plan as plan;
use carom::model::potential::Potential;
use carom::model::space::{Boundary, Space};
use carom::model::{RunPlan, Thermostat, Until};
use carom::scene::{Arrangement, Chain, Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};
use std::collections::HashSet;

use super::measure::{finish, hard, number};

/// Returns the distances between particle `i` and the images of particle `j` that may be the nearest.
fn distances<'a>(size: &'a Vector, snapshot: &'a Snapshot, rate: f64, i: usize, j: usize) -> impl Iterator<Item = f64> {
    let apart = snapshot.positions[i] - snapshot.positions[j];
    // The shift is less than a period, so two images on either side along x are enough.
    let slid = (rate * size.y * snapshot.time) % size.x;
    let images = (-2..=2).flat_map(|a| (-1..=1).flat_map(move |b| (-1..=1).map(move |c| [a, b, c])));
    images.filter(|[_, _, c]| size.z > 0.0 || *c == 0).map(move |image| {
        let [a, b, c] = image.map(f64::from);
        (apart + Vector::new(a * size.x + b * slid, b * size.y, c * size.z)).norm()
    })
}

/// Images move by up to 1000, with a round-off of about 1e-13.
const ROUND_OFF: f64 = 1e-11;

pub fn boxes() -> [Space; 3] {
    let space = |size: [f64; 3], boundary| Space { lower: Vector::new(-1.0, 2.0, 0.5), size: size.into(), boundary };
    [
        space([6.5, 9.0, 7.0], [Boundary::Periodic; 3]),
        space([11.0, 6.5, 6.5], [Boundary::Periodic; 3]),
        space([9.0, 12.0, 0.0], [Boundary::Periodic, Boundary::Periodic, Boundary::Flat]),
    ]
}

fn fluid(space: &Space, potential: Potential, rate: f64) -> Simulation {
    #[expect(clippy::cast_possible_truncation, reason = "a small box")]
    let count = (0.45 * space.volume()) as u64;
    let fill = Fill::new(Arrangement::Random, "A").count(count);
    let scene = SceneBuilder::new("fluid")
        .space(space.clone())
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(potential).between("A", "A"))
        .fill(fill)
        .temperature(1.0)
        .shear(rate);
    Simulation::without_plan(scene.build().unwrap())
}

#[test]
fn hard_particles_never_overlap_in_boxes_of_any_shape() {
    for space in boxes() {
        for rate in [0.1, 3.0, -1.3] {
            let mut simulation = fluid(&space, hard(1.0), rate);
            for part in 1..=20 {
                simulation.advance(Until::time(0.3 * f64::from(part))).unwrap();
                let now = simulation.snapshot();
                for i in 0..now.positions.len() {
                    for j in 0..i {
                        let nearest = distances(&space.size, &now, rate, i, j).fold(f64::INFINITY, f64::min);
                        assert!(nearest > 1.0 - ROUND_OFF, "{rate} {:?}: {i} {j} {nearest}", space.size);
                    }
                }
            }
            assert!(simulation.event_counts().core > 300, "{}", simulation.event_counts().core);
            assert_eq!(simulation.event_counts().in_invalid_state, 0);
            assert_eq!(simulation.real_overlaps(), []);
        }
    }
}

#[test]
fn captured_pairs_are_those_within_the_range_of_the_well() {
    for space in boxes() {
        for rate in [0.1, 3.0] {
            let mut simulation = fluid(&space, Potential::square_well(1.0, 1.5, 0.7).unwrap(), rate);
            let mut pairs = 0;
            for part in 0..=10 {
                simulation.advance(Until::time(0.6 * f64::from(part))).unwrap();
                let now = simulation.snapshot();
                let captured = simulation.captured_pairs().into_iter();
                let captured: HashSet<[usize; 2]> = captured.map(|(pair, _)| pair.map(|id| id.0 as usize)).collect();
                for i in 0..now.positions.len() {
                    for j in 0..i {
                        let nearest = distances(&space.size, &now, rate, i, j).fold(f64::INFINITY, f64::min);
                        if (nearest - 1.5).abs() < ROUND_OFF {
                            continue;
                        }
                        let is_captured = captured.contains(&[j, i]);
                        assert_eq!(is_captured, nearest < 1.5, "{rate} at {}: {i} {j} {nearest}", now.time);
                        pairs += u64::from(is_captured);
                    }
                }
                assert_eq!(simulation.real_overlaps(), []);
            }
            let event_counts = simulation.event_counts();
            assert!(
                pairs > 500 && event_counts.capture > 100 && event_counts.release > 100,
                "{pairs} {event_counts:?}"
            );
        }
    }
}

#[test]
fn chains_hold_together_across_the_sides_that_slide() {
    let space = Space { size: Vector::new(7.0, 8.0, 9.0), ..Space::periodic_cube(1.0) };
    for rate in [0.1, 2.0] {
        let bath = Thermostat::Rescaling { temperature: 1.0, interval: 0.1 };
        let scene = SceneBuilder::new("polymer")
            .space(space.clone())
            .species(SpeciesDraft::new("bead").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Potential::square_well(1.0, 1.4, 0.5).unwrap()).between("bead", "bead"))
            .interaction(InteractionDraft::new(Potential::bond(0.9, 1.3).unwrap()).named("link"))
            .chain(Chain {
                species: "bead".into(),
                length: 8,
                count: 12,
                bond: "link".into(),
                spacing: None,
                straight: None,
                temperature: Some(1.0),
                speed: None,
            })
            .shear(rate)
            .run(RunPlan { limit: Until::time(10.0), thermostat: Some(bath), ..RunPlan::default() });
        let plan = MeasurementPlan {
            chains: Some(plan::Chains { interval: Some(0.5), bins: None }),
            ..MeasurementPlan::default()
        };
        let finished = finish(scene.measure(plan).build().unwrap());
        let simulation = &finished.simulation;
        let (scene, now) = (simulation.scene(), simulation.snapshot());
        let mut across = 0;
        for bond in scene.bonds() {
            let [a, b] = bond.pair.map(|id| id.0 as usize);
            let nearest = distances(&space.size, &now, rate, a, b).fold(f64::INFINITY, f64::min);
            assert!((0.9 - ROUND_OFF..1.3 + ROUND_OFF).contains(&nearest), "{rate}: {a} {b} {nearest}");
            across += u32::from((now.positions[a].y - now.positions[b].y).abs() > 4.0);
        }
        assert!(across > 0, "no bond across the sides");
        let length = finished.measured.number("bond_length").unwrap();
        assert!((0.9..1.3).contains(&length.mean.unwrap()), "{length:?}");
    }
}

/// A pair next to the sliding sides. A hundred resting particles far away make the engine use many cells.
fn pair_at_the_sides(rate: f64, positions: [Vector; 2], velocities: [Vector; 2]) -> Simulation {
    let mut scene = SceneBuilder::new("pair")
        .space(Space::periodic_cube(24.0))
        .allow_invalid_start(true)
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .shear(rate);
    for (position, velocity) in positions.into_iter().zip(velocities) {
        scene = scene.particle("A", position, velocity);
    }
    for k in 0..12 * 12 * 4 {
        let [x, y, z] = [k % 12, k / 12 % 4, k / 48].map(f64::from);
        scene = scene.particle("A", Vector::new(2.0 * x + 1.0, 2.0 * y + 9.0, 2.0 * z + 1.0), Vector::zeros());
    }
    Simulation::without_plan(scene.build().unwrap())
}

#[test]
fn overlap_across_sliding_sides_is_always_found() {
    // The particles overlap across the sliding side. The image of each particle moves with the other particle.
    let half = Vector::new(0.5 * 0.5 * 24.0, 0.0, 0.0);
    let positions = [Vector::new(5.0, 23.7, 5.0), Vector::new(5.0, 0.3, 5.0)];
    let mut simulation = pair_at_the_sides(0.5, positions, [half, -half]);
    for part in 0..20 {
        simulation.advance(Until::time(0.37 * f64::from(part))).unwrap();
        let overlaps = simulation.real_overlaps();
        assert_eq!(overlaps.len(), 1, "at {}", simulation.time());
        assert!((overlaps[0].depth - 0.4).abs() < 1e-12, "{overlaps:?}");
    }
}

#[test]
fn contact_is_found_after_many_images_have_slid_past() {
    // The particles can touch after a time of 0.92, when their distance along z is less than sqrt(3/4). Images slide
    // past at intervals of 24 / 120 = 0.2, and the first image after 0.92 collides.
    for place in 0..8 {
        let z = 6.0 + 0.25 * f64::from(place);
        let positions = [Vector::new(12.0, 0.25, z), Vector::new(12.0, 23.75, z + 1.05)];
        let mut simulation = pair_at_the_sides(5.0, positions, [Vector::zeros(), Vector::new(0.0, 0.0, -0.2)]);
        simulation.advance(Until::time(0.91)).unwrap();
        assert_eq!(simulation.event_counts().core, 0);
        simulation.advance(Until::time(1.13)).unwrap();
        assert_eq!(simulation.event_counts().core, 1, "{z}");
    }
}

#[test]
fn common_velocity_along_the_gradient_adds_no_pressure() {
    let base = || {
        SceneBuilder::new("fluid")
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
    };
    let fill = Fill::new(Lattice::FaceCentredCubic, "A").count(108).packing_fraction(0.2);
    let still = base().fill(fill).temperature(1.0).build().unwrap();
    let bath = Thermostat::Rescaling { temperature: 1.0, interval: 0.5 };
    let limit = Until::time(40.0);
    let measured = |speed: f64| {
        let mut builder = base().space(still.space().clone()).shear(0.5);
        for particle in still.particles() {
            builder = builder.particle("A", particle.position, particle.velocity + Vector::new(0.0, speed, 0.0));
        }
        let plan =
            MeasurementPlan { pressure_tensor: Some(plan::PressureTensor::default()), ..MeasurementPlan::default() };
        let run = RunPlan { equilibration: Until::time(2.0), limit, thermostat: Some(bath), ..RunPlan::default() };
        finish(builder.measure(plan).run(run).build().unwrap()).measured
    };
    let (rest, moving) = (measured(0.0), measured(0.8));
    for name in ["pressure", "pressure_xx", "pressure_yy"] {
        let [a, b] = [&rest, &moving].map(|measured| number(measured, name));
        let error = a.1.hypot(b.1);
        assert!((a.0 - b.0).abs() < 4.5 * error && error < 0.05 * a.0, "{name}: {a:?} {b:?}");
    }
}

#[test]
fn a_slow_shear_changes_neither_diffusion_nor_structure() {
    let bath = Thermostat::Rescaling { temperature: 1.0, interval: 0.5 };
    let limit = Until::time(40.0);
    let measured = |rate: Option<f64>| {
        let run = RunPlan { equilibration: Until::time(5.0), limit, thermostat: Some(bath), ..RunPlan::default() };
        let fluid = SceneBuilder::new("fluid")
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(256).packing_fraction(0.3))
            .temperature(1.0)
            .measure(MeasurementPlan {
                diffusion: Some(plan::Diffusion { span: Some(2.5), ..plan::Diffusion::default() }),
                radial_distribution: Some(plan::RadialDistribution::default()),
                structure_factor: Some(plan::StructureFactor::default()),
                bond_order: Some(plan::BondOrder::default()),
                free_paths: Some(plan::FreePaths::default()),
                ..MeasurementPlan::default()
            })
            .run(run);
        let fluid = match rate {
            Some(rate) => fluid.shear(rate),
            None => fluid,
        };
        finish(fluid.build().unwrap()).measured
    };
    let (rest, sheared) = (measured(None), measured(Some(0.05)));
    // The shear strain in a mean free time is only 0.005, and the effects are of second order.
    for name in ["diffusion_coefficient", "contact_value_A_A", "neighbours", "q6", "mean_free_time"] {
        let [a, b] = [&rest, &sheared].map(|measured| number(measured, name));
        let error = a.1.hypot(b.1);
        // The standard errors are uncertain by 1/8, so the limit is 4.5 instead of 4.
        assert!((a.0 - b.0).abs() < 4.5 * error && error < 0.05 * a.0, "{name}: {a:?} {b:?}");
    }
    let path = sheared.number("mean_free_path").unwrap();
    assert_eq!(path.mean, None, "relative to what streams no particle flies straight on");
    for name in ["radial_distribution", "structure_factor"] {
        let [a, b] = [&rest, &sheared].map(|measured| measured.curve(name).unwrap());
        assert_eq!(a.series[0].values.len(), b.series[0].values.len());
        let mut worst = 0.0_f64;
        let mut known = 0;
        for index in 0..a.series[0].values.len() {
            let at = |of: &carom::analysis::instruments::Curve| {
                Some((of.series[0].values[index]?, of.series[0].standard_errors[index]?))
            };
            let Some((one, other)) = at(a).zip(at(b)) else { continue };
            known += 1;
            // Where S(q) rises, the means of different wave vectors differ by up to a fifth.
            let shells = if name == "structure_factor" { 0.2 * one.0 } else { 0.0 };
            worst = worst.max(((one.0 - other.0).abs() - shells) / one.1.hypot(other.1).max(1e-3));
        }
        // The largest of about a hundred differences. A few bins have no standard error.
        assert!(worst < 6.0 && 10 * known > 9 * a.series[0].values.len(), "{name}: {worst} {known}");
    }
}

use super::{assert_resumes, fluid, ran, spread};
use crate::Vector;
use crate::exchange::mean_force::MeanForce;
use crate::exchange::{Distances, Exchange, ExchangeError};
use crate::model::{ExchangeEnsemble, ExchangePlan, ParticleId, Potential, RunPlan, Scene, Space, UmbrellaPlan, Until};
use crate::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};
use std::convert::Infallible;
use std::ops::ControlFlow;

fn plan(windows: &[[f64; 2]], interval: f64) -> ExchangePlan {
    let between = [vec![ParticleId(0)], vec![ParticleId(1)]];
    ExchangePlan {
        temperatures: vec![0.8],
        interval,
        rate: 0.7,
        ensemble: ExchangeEnsemble::Umbrella,
        umbrella: Some(UmbrellaPlan { between, windows: windows.to_vec(), bins: 12 }),
    }
}

/// Some checkpoints are written before the replicas are in their windows.
#[test]
fn window_exchange_resumes_bitwise() {
    let mut parts = fluid(0.2, 12).into_parts();
    parts.exchange = Some(plan(&[[1.0, 1.3], [1.2, 1.6], [1.5, 2.0]], 0.2));
    parts.run.equilibration = Until::time(10.0);
    parts.output.frame_interval = Some(0.4);
    let scene = Scene::new(parts).unwrap();
    let (whole, told) = ran(Exchange::new(scene.clone()).unwrap(), 1, usize::MAX);
    assert_eq!(whole.results().faults, [""; 0]);
    assert_eq!(told.lines.len(), 12 + 3 * 6);
    assert_resumes(&scene, (&whole, &told), 7, |kept| spread(kept, 5));
}

fn pair(windows: &[[f64; 2]], attempts: u32) -> Scene {
    SceneBuilder::new("pair")
        .space(Space::periodic_cube(6.0))
        .species(SpeciesDraft::new("A").mass(1.3).diameter(1.0))
        .species(SpeciesDraft::new("B").mass(0.37).diameter(1.0))
        .interaction(InteractionDraft::new(Model::None).between("A", "A"))
        .interaction(InteractionDraft::new(Model::None).between("B", "B"))
        .interaction(InteractionDraft::new(Potential::square_well(1.0, 1.5, 0.9).unwrap()).between("A", "B"))
        .particle("A", Vector::new(1.0, 1.0, 1.0), Vector::zeros())
        .particle("B", Vector::new(3.9, 3.9, 3.9), Vector::zeros())
        .exchange(plan(windows, 1.0))
        .run(RunPlan {
            equilibration: Until::time(200.0),
            limit: Until::time(f64::from(attempts)),
            ..RunPlan::default()
        })
        .build()
        .unwrap()
}

/// The initial distance is larger than half a period. At such distances, windows have no effect.
#[test]
fn replicas_come_into_their_windows_and_stay() {
    let windows = [[1.0, 1.2], [1.1, 1.5], [1.4, 2.2], [2.0, 2.9]];
    let mut exchange = Exchange::new(pair(&windows, 10)).unwrap();
    assert_eq!(exchange.is_outside, [true; 4]);
    assert!(exchange.distances.iter().all(|distance| *distance > 3.0));
    let mut farthest = [f64::INFINITY; 4];
    while exchange.attempts < 100 {
        let time = exchange.next_time();
        for replica in &mut exchange.replicas {
            assert!(replica.go(time, || false).unwrap());
        }
        let was_outside = exchange.is_outside.clone();
        exchange.attempt().unwrap();
        for (place, [lower, upper]) in windows.into_iter().enumerate() {
            let distance = exchange.distances[place];
            let beyond = (distance - upper).max(lower - distance).max(0.0);
            assert_eq!(exchange.is_outside[place], beyond > 0.0);
            assert!(was_outside[place] || beyond == 0.0, "window {place}: {distance}");
            // Windows act only on distances below 3, half a period. At these distances, a replica may move away from
            // its window by at most a tenth of the window's width.
            if distance < 3.0 {
                let most = farthest[place] + 0.1 * (upper - lower);
                assert!(beyond <= most + 1e-12, "window {place}: {beyond} after {}", farthest[place]);
                farthest[place] = beyond.min(farthest[place]);
            }
        }
    }
    assert_eq!(exchange.is_outside, [false; 4]);
}

#[test]
fn a_window_that_no_replica_can_come_into_ends_the_exchange() {
    // A window inside a hard core would be rejected, so this potential has a very high step instead.
    let mut parts = pair(&[[1.0, 1.9], [1.8, 2.2]], 10).into_parts();
    let cores = parts.interactions.iter_mut().filter(|it| it.potential.core().is_some());
    cores.for_each(|it| it.potential = Potential::penetrable(1.0, 500.0).unwrap());
    parts.exchange = Some(plan(&[[0.5, 0.9], [0.8, 2.2]], 1.0));
    let ended = Exchange::new(Scene::new(parts).unwrap()).unwrap().finish();
    let Err(error @ ExchangeError::OutsideOfWindow { window: 0, ends: [0.5, 0.9], distance }) = ended else {
        panic!("{ended:?}")
    };
    assert!((1.0..1.1).contains(&distance), "{distance}");
    let expected = format!(
        "window 1, from 0.5 to 0.9, was not reached: after half of the equilibration, the distance is still {distance:.5}"
    );
    assert!(error.to_string().starts_with(&expected[..85]), "{error}");
}

/// Swaps must not change the distribution of distances.
#[test]
fn windows_with_and_without_swaps_have_the_same_potential_of_mean_force() {
    let windows = [[1.0, 1.5], [1.3, 2.0], [1.8, 2.6]];
    let scene = pair(&windows, 8000);
    let mut distances = Distances::default();
    let watch = &mut |_| ControlFlow::Continue(());
    let swapped = Exchange::new(scene.clone()).unwrap().execute(1, &mut distances, watch).unwrap();
    let with_swaps = distances.mean_force(&swapped);
    let mut alone = Exchange::new(scene).unwrap();
    let mut rows = Vec::new();
    while !alone.is_over() {
        let time = alone.next_time();
        for replica in &mut alone.replicas {
            assert!(replica.go(time, || false).unwrap());
        }
        alone.attempts += 1;
        alone.see_distances();
        if alone.is_measured() {
            rows.push(alone.distances.clone());
        }
    }
    assert_eq!((alone.places.clone(), alone.is_outside.clone()), (vec![0, 1, 2], vec![false; 3]));
    let visit = |see: &mut dyn FnMut(&[f64])| {
        rows.iter().for_each(|row| see(row));
        Ok::<(), Infallible>(())
    };
    let without = MeanForce::of(&alone, visit).unwrap();
    assert!(with_swaps.points.len() >= 10 && with_swaps.points.len() == without.points.len());
    // Differences between neighbouring bins do not depend on the reference of the potential.
    for (a, b) in with_swaps.points.windows(2).zip(without.points.windows(2)) {
        let step = |pair: &[crate::exchange::MeanForcePoint]| {
            let of = |it: &crate::exchange::MeanForcePoint| it.potential_of_mean_force;
            let errors = pair.iter().map(|it| of(it).standard_error.unwrap().powi(2)).sum::<f64>();
            (of(&pair[1]).mean - of(&pair[0]).mean, errors)
        };
        let ((one, of_one), (other, of_other)) = (step(a), step(b));
        assert!((one - other).abs() < 4.0 * (of_one + of_other).sqrt(), "{a:?} {b:?}");
    }
}

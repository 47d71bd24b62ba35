use super::*;
use crate::engine::Until;
use crate::engine::neighbours::Search;
use crate::engine::neighbours::candidates::Candidates;
use crate::engine::predict::batch::tests::falling;
use crate::engine::predict::{Scratch, is_out_of_reach};
use crate::model::Scene;
use crate::model::potential::Potential;
use crate::physics::detection::lanes::Simd;
use crate::scene::{Fill, InteractionDraft, Lattice, SceneBuilder, SpeciesDraft};

pub(in crate::engine) fn box_of_spheres(count: u64, packing_fraction: f64, is_mixture: bool, shear_rate: f64) -> Scene {
    let hard_sphere = |diameter| Potential::hard_sphere(diameter).unwrap();
    let mut scene = SceneBuilder::new("small")
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(hard_sphere(1.0)).between("A", "A"));
    let mut fill = Fill::new(Lattice::FaceCentredCubic, "A");
    if is_mixture {
        fill.composition.push(("B".to_owned(), 1.0));
        scene = scene
            .species(SpeciesDraft::new("B").mass(0.7).diameter(0.6))
            .interaction(InteractionDraft::new(hard_sphere(0.8)).between("A", "B").restitution(0.9))
            .interaction(InteractionDraft::new(hard_sphere(0.6)).between("B", "B"));
    }
    fill = fill.count(count).packing_fraction(packing_fraction);
    if shear_rate != 0.0 {
        scene = scene.shear(shear_rate);
    }
    scene.fill(fill).temperature(1.0).build().unwrap()
}

/// Compares the predictions of the engine with tests of all pairs in all images. The engine must use cells.
fn meets_in_all_images<const TABLE: bool>(scene: &Scene) {
    let mut engine = Engine::<false, TABLE>::new(scene);
    let mut scratch = Scratch::new(scene.particles().len());
    let mut near = Candidates::default();
    let mut met = 0;
    for part in 1..=30 {
        engine.advance(Until::events(50 * part), &mut None).unwrap();
        let now = engine.clock.now;
        if engine.neighbours.verlet().is_some() {
            engine.stream_all(now);
            engine.sort_in(Search::Cells);
            engine.particles().for_each(|particle| engine.repredict(particle, now));
        }
        for particle in engine.particles() {
            let mut one_by_one = Prediction::NONE;
            let me = engine.streamed(particle, now);
            engine.neighbours.find_candidates(particle, engine.row(particle), &mut near);
            engine.for_each_across(particle, |other| near.put(other));
            near.found().iter().for_each(|&other| engine.predict_uncaptured_pair(&me, other, &mut one_by_one));
            let prediction = engine.predict(particle, now, &mut scratch);
            if one_by_one.contact_time < prediction.transition_time {
                assert_eq!(prediction.contact_time, one_by_one.contact_time, "{particle}");
                assert_eq!(prediction.partner, one_by_one.partner, "{particle}");
                met += 1;
            } else {
                assert!(prediction.is_transition() || prediction.contact_time == one_by_one.contact_time);
            }
        }
    }
    assert!(met > 10, "{met}");
}

#[test]
fn small_box_search_covers_all_images() {
    for (count, packing_fraction) in [(4, 0.1), (8, 0.3), (16, 0.2), (32, 0.45), (32, 0.2)] {
        for is_mixture in [false, true] {
            let scene = box_of_spheres(count, packing_fraction, is_mixture, 0.0);
            let mut engine = Engine::<false, true>::new(&scene);
            engine.sort_in(Search::Cells);
            let images = engine.images;
            assert!(!images.further.is_empty() || images.tied == [true; 3], "{count} {is_mixture}");
            if is_mixture { meets_in_all_images::<true>(&scene) } else { meets_in_all_images::<false>(&scene) }
        }
    }
}

#[test]
fn search_across_sheared_sides_covers_all_images() {
    for (count, rate) in [(256, 0.3), (256, -2.0), (500, 0.1)] {
        meets_in_all_images::<false>(&box_of_spheres(count, 0.15, false, rate));
        meets_in_all_images::<true>(&box_of_spheres(count, 0.15, true, rate));
    }
}

#[test]
fn simd_reach_test_keeps_every_pair_within_reach() {
    let mut engine = Engine::<true, true>::new(&falling());
    let others: Vec<u32> = engine.particles().collect();
    let (mut within, mut beyond) = (0, 0);
    for part in 1..=20 {
        engine.advance(Until::events(100 * part), &mut None).unwrap();
        let now = engine.clock.now;
        for particle in engine.particles().filter(|&particle| !engine.is_static(particle)) {
            let me = engine.streamed(particle, now);
            let species = |id: u32| engine.row(id);
            let reaches = engine.pairs.rules.accelerated(species(particle)).unwrap();
            for (width, horizon) in Simd::all().into_iter().zip([0.01, 0.1, 1.0].into_iter().cycle()) {
                let batch = Batch { width, ..engine.batch_of(&me, true) };
                for some in others.chunks_exact(MOST_LANES) {
                    let bits = batch.within_reach(&me, some, &reaches, horizon);
                    for (k, &other) in some.iter().enumerate() {
                        let meeting = engine.pairs.rules.meeting(species(particle), species(other));
                        let (state, _) = engine.relative(&me, other);
                        let is_reached = meeting.is_accelerated
                            && !is_out_of_reach(&state, &me.acceleration, meeting.squared, horizon);
                        let is_kept = bits >> k & 1 == 1;
                        assert_eq!(is_kept, is_reached, "{particle} {other} {horizon}");
                        within += u32::from(is_kept);
                        beyond += u32::from(!is_kept && meeting.is_accelerated);
                    }
                }
            }
        }
    }
    assert!(within > 1_000 && beyond > 1_000, "{within} {beyond}");
}

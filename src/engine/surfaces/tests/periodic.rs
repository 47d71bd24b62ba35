//! Tests of contacts with surfaces across the sides of a periodic box.

use super::run;
use crate::Vector;
use crate::engine::event::Other;
use crate::engine::neighbours::Neighbours;
use crate::engine::parts::Engine;
use crate::model::SurfaceShape;
use crate::model::space::Space;
use crate::scene::{Arrangement, Fill, InteractionDraft, Model, SceneBuilder, SpeciesDraft, SurfaceDraft};

const EDGE: f64 = 7.0;

/// A gas around a rod along x and two balls, all close to the sides of a periodic box.
fn gas(count: u64, gravity: f64) -> SceneBuilder {
    let ball = |centre: Vector| SurfaceShape::Sphere { centre, radius: 0.8, is_inside: false };
    let rod =
        SurfaceShape::Cylinder { point: Vector::new(0.1, 0.3, 5.0), axis: Vector::x(), radius: 0.5, is_inside: false };
    SceneBuilder::new("rod")
        .space(Space::periodic_cube(EDGE))
        .gravity(Vector::new(0.1, 0.2, -1.0) * gravity)
        .species(SpeciesDraft::new("A").mass(1.0).diameter(0.5))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .surface(SurfaceDraft::new("rod", rod))
        .surface(SurfaceDraft::new("ball", ball(Vector::new(6.9, 3.0, 3.0))))
        .surface(SurfaceDraft::new("other", ball(Vector::new(3.0, 0.2, 6.8))))
        .fill(Fill::new(Arrangement::Random, "A").count(count))
        .temperature(1.0)
}

/// Returns the vector from the axis or centre of a surface to a position, in the nearest image.
fn from_surface(surface: u32, place: &Vector) -> Vector {
    let centres = [Vector::new(0.0, 0.3, 5.0), Vector::new(6.9, 3.0, 3.0), Vector::new(3.0, 0.2, 6.8)];
    let apart = place - centres[surface as usize - 6];
    let nearest = apart.map(|x| x - EDGE * (x / EDGE).round());
    if surface == 6 { Vector::new(0.0, nearest.y, nearest.z) } else { nearest }
}

fn assert_normals<const FALLING: bool>(count: u64, gravity: f64) -> bool {
    let scene = gas(count, gravity).build().unwrap();
    let mut engine = Engine::<FALLING, true>::new(&scene);
    let mut met = [0; 3];
    run(&mut engine, 20_000, |event, _| {
        let Other::Surface { surface, .. } = event.other else { return };
        met[surface as usize - 6] += 1;
        let normal = from_surface(surface, &event.positions[0]).normalize();
        assert!((event.normal - normal).norm() < 1e-9, "{surface}: {} {normal}", event.normal);
    });
    assert!(met.iter().all(|count| *count > 100), "{met:?}");
    assert_eq!(engine.counts.totals.in_invalid_state, 0);
    assert_eq!(engine.real_overlaps(), []);
    matches!(engine.neighbours, Neighbours::Lists(_))
}

#[test]
fn particle_is_reflected_by_the_surface_image_it_meets() {
    let mut taken = [false; 2];
    for count in [3, 40, 300] {
        taken[usize::from(assert_normals::<false>(count, 0.0))] = true;
        taken[usize::from(assert_normals::<true>(count, 0.3))] = true;
    }
    assert_eq!(taken, [true; 2], "cells and lists");
}

#[test]
fn surface_displaced_by_periods_acts_through_its_image_in_the_box() {
    let scene = |by: Vector| {
        let rod = SurfaceShape::Cylinder {
            point: Vector::new(0.1, 0.3, 5.0) + by,
            axis: Vector::x(),
            radius: 0.5,
            is_inside: false,
        };
        let ends = [Vector::new(6.5, 2.0, 1.0) + by, Vector::new(7.9, 3.0, 1.5) + by];
        let capsule = SurfaceShape::Capsule { ends, radius: 0.2 };
        let scene = SceneBuilder::new("far")
            .space(Space::periodic_cube(EDGE))
            .species(SpeciesDraft::new("A").mass(1.0).diameter(0.5));
        scene
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .surface(SurfaceDraft::new("rod", rod))
            .surface(SurfaceDraft::new("capsule", capsule))
            .particle("A", Vector::new(3.0, 3.5, 3.0), Vector::new(0.31, 0.27, 0.93))
            .particle("A", Vector::new(2.0, 5.5, 1.0), Vector::new(-0.5, 0.37, 0.13))
            .build()
            .unwrap()
    };
    let number = |event: &crate::engine::event::Event| match event.other {
        Other::Surface { surface, .. } => surface,
        _ => 0,
    };
    let near = super::meshes::contacts(scene(Vector::zeros()), 6);
    for by in [Vector::new(0.0, 14.0, -21.0), Vector::new(140.0, 14.0, -21.0)] {
        let far = super::meshes::contacts(scene(by), 6);
        assert_eq!(near.len(), far.len());
        assert!(near.len() >= 4, "{}", near.len());
        // Surfaces that are shifted by many periods have larger rounding errors. Each event multiplies these errors by
        // the path length divided by the radius.
        let mut bound = 1e-12;
        for (one, other) in near.iter().zip(&far) {
            assert_eq!((one.particle, number(one)), (other.particle, number(other)));
            let off = (one.time - other.time).abs().max((one.after[0] - other.after[0]).norm());
            assert!(off < bound, "{off} {bound} {by}");
            bound *= 20.0;
        }
    }
}

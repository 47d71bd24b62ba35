use carom::Vector;
use carom::model::{MotionKind, Restitution, SurfaceMotion, SurfaceShape, TriangleMesh};
use carom::scene::SurfaceDraft;
use nalgebra::Rotation3;

pub fn motions(kind: usize) -> Vec<SurfaceMotion> {
    let always = |kind| vec![SurfaceMotion { from: 0.0, until: f64::INFINITY, kind }];
    let flies =
        MotionKind::Translation { velocity: Vector::new(0.2, -0.1, 0.15), acceleration: Vector::new(-0.05, 0.1, 0.02) };
    let shakes = MotionKind::Oscillation { amplitude: Vector::new(0.1, 0.07, -0.2), frequency: 0.7, phase: 0.1 };
    let turns =
        MotionKind::Rotation { point: Vector::new(3.0, 3.5, 2.5), axis: Vector::new(1.0, -0.3, 0.5), frequency: 0.08 };
    match kind {
        0 => vec![],
        1 => always(flies),
        2 => always(shakes),
        3 => always(turns),
        _ => vec![
            SurfaceMotion { from: 0.3, until: 0.9, kind: turns },
            SurfaceMotion { from: 0.9, until: 1.6, kind: flies },
            SurfaceMotion { from: 1.8, until: 3.0, kind: shakes },
            SurfaceMotion { from: 3.0, until: 4.0, kind: turns },
        ],
    }
}

/// Returns surfaces around the box, which stop particles that leave through open sides.
pub fn surfaces(kind: usize, length: f64, restitution: Restitution) -> Vec<SurfaceDraft> {
    let middle = Vector::repeat(0.5 * length);
    let sphere = |radius: f64, is_inside| SurfaceShape::Sphere { centre: middle, radius, is_inside };
    // All faces are tilted. Particles on a lattice would touch an axis-aligned face at the same time.
    let turned = |mesh: TriangleMesh| {
        let rotation = Rotation3::from_euler_angles(0.3, -0.2, 0.5);
        SurfaceShape::Mesh(mesh.transformed(1.0, &rotation, &(middle - rotation * middle)))
    };
    let box_of = |half: f64| TriangleMesh::cuboid(&(middle.add_scalar(-half)), &(middle.add_scalar(1.1 * half)));
    let shapes = match kind {
        0 => vec![],
        1 => vec![turned(box_of(0.8 * length))],
        2 => vec![sphere(length, true)],
        3 => vec![SurfaceShape::Cylinder {
            point: middle,
            axis: Vector::new(0.2, 1.0, -0.3),
            radius: 0.9 * length,
            is_inside: true,
        }],
        4 => (0..8)
            .map(|k| {
                let sign = |bit: u32| if k >> bit & 1 == 0 { 1.0 } else { -1.1 };
                let normal = Vector::new(sign(0), 1.2 * sign(1), 0.9 * sign(2));
                SurfaceShape::Plane { point: middle - normal.normalize() * length, normal }
            })
            .collect(),
        // A cuboid around the box, with three bars and a sphere inside.
        _ => {
            let at = |x: f64, y: f64, z: f64| middle + Vector::new(x, y, z) * length;
            let bar = |a: Vector, b: Vector| SurfaceShape::Capsule { ends: [a, b], radius: 0.1 * length };
            let mut bars = vec![turned(box_of(1.2 * length))];
            bars.push(bar(at(-0.7, -0.8, -0.9), at(-0.75, 0.8, -0.6)));
            bars.push(bar(at(0.8, -0.7, -0.8), at(0.7, 0.9, 0.75)));
            bars.push(SurfaceShape::Capsule { ends: [at(-0.6, -0.7, 0.8), at(0.8, 0.6, 0.9)], radius: 0.0 });
            bars.push(SurfaceShape::Sphere { centre: at(0.0, 0.0, -1.0), radius: 0.3 * length, is_inside: false });
            bars
        }
    };
    let draft = |(k, shape)| SurfaceDraft::new(&format!("surface {k}"), shape).restitution(restitution);
    shapes.into_iter().enumerate().map(draft).collect()
}

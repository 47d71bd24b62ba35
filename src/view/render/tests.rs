use proptest::prelude::*;

use super::*;
use crate::analysis::instruments::Scalar;
use crate::base::numbers::trunc_to_usize;
use crate::io::Existing;
use crate::model::{ParticleId, SpeciesId, Units};
use crate::trajectory::extended_xyz::write_frame;
use crate::trajectory::frame::{FrameParticle, FrameSpecies};

/// Returns a frame with balls, given by species, position and radius. Species 0 and 1 move, and species 2 is static.
pub(in crate::view) fn frame(size: [f64; 3], balls: &[(u32, [f64; 3], f64)]) -> Frame {
    let species = [("a", false), ("b", false), ("static", true)];
    Frame {
        time: 0.0,
        lower: Vector::zeros(),
        size: size.into(),
        periodic: size.map(|edge| edge > 0.0),
        displacement: 0.0,
        species: species.map(|(name, is_static)| FrameSpecies { name: name.into(), is_static, mass: None }).into(),
        particles: (0..)
            .zip(balls)
            .map(|(id, &(species, position, radius))| FrameParticle {
                id: ParticleId(id),
                species: SpeciesId(species),
                position: position.into(),
                velocity: Vector::zeros(),
                radius,
            })
            .collect(),
        ..Frame::default()
    }
}

/// Front view: x points right, y into the image, and z up.
pub(super) fn level() -> Style {
    Style {
        width: 240,
        height: 240,
        palette: vec![[220, 30, 30], [30, 220, 30]],
        has_box: false,
        azimuth: 0.0,
        elevation: 0.0,
        ..Style::default()
    }
}

pub(super) fn pixel(image: &Image, x: f64, y: f64) -> [u8; 4] {
    let (column, row) = (trunc_to_usize(x * f64::from(image.width())), trunc_to_usize(y * f64::from(image.height())));
    image.pixels()[row * image.width() as usize + column]
}

pub(super) fn is_red(pixel: [u8; 4]) -> bool {
    pixel[0] / 2 > pixel[1] && pixel[0] > 100
}

fn is_green(pixel: [u8; 4]) -> bool {
    pixel[1] / 2 > pixel[0] && pixel[1] > 100
}

pub(super) fn is_background(pixel: [u8; 4]) -> bool {
    pixel[..3] == colour::BACKGROUND
}

fn area(image: &Image) -> f64 {
    image.pixels().iter().filter(|&&pixel| !is_background(pixel)).count() as f64
}

/// The tolerance is the circumference in pixels.
fn assert_disc(area: f64, radius: f64) {
    let (disc, ring) = (std::f64::consts::PI * radius * radius, std::f64::consts::TAU * radius);
    assert!((area - disc).abs() < ring, "{area} pixels, expected {disc} up to {ring}");
}

#[test]
fn silhouette_of_a_disc_has_the_area_of_its_projection() {
    let image = draw(&frame([10.0, 10.0, 0.0], &[(0, [3.0, 6.0, 0.0], 1.7)]), &level()).unwrap();
    let scale = 240.0 * (1.0 - 2.0 * 0.035) / 10.0;
    assert_disc(area(&image), 1.7 * scale);
}

#[test]
fn silhouette_in_perspective_fills_the_picture() {
    let style = Style { framing: Framing::Particles, ..level() };
    let image = draw(&frame([10.0; 3], &[(0, [3.0, 6.0, 1.0], 1.7)]), &style).unwrap();
    assert_disc(area(&image), 0.5 * 240.0 * (1.0 - 2.0 * 0.035));
    assert!(image.width().abs_diff(240) < 3 && image.height().abs_diff(240) < 3);
}

#[test]
fn nearer_sphere_hides_the_farther_in_either_order() {
    let (near, far) = ([5.0, 2.0, 5.0], [5.0, 8.0, 5.0]);
    for balls in [[(0, near, 1.0), (1, far, 1.0)], [(1, far, 1.0), (0, near, 1.0)]] {
        let image = draw(&frame([10.0; 3], &balls), &level()).unwrap();
        assert!(is_red(pixel(&image, 0.5, 0.5)));
        assert!(!image.pixels().iter().any(|&pixel| is_green(pixel)));
    }
}

#[test]
fn image_axes_follow_scene_axes() {
    for (size, red, green) in [
        ([10.0; 3], [8.0, 5.0, 8.0], [2.0, 5.0, 2.0]),
        ([10.0, 10.0, 0.0], [8.0, 8.0, 0.0], [2.0, 2.0, 0.0]),
        ([10.0, 0.0, 10.0], [8.0, 0.0, 8.0], [2.0, 0.0, 2.0]),
        ([0.0, 10.0, 10.0], [0.0, 8.0, 8.0], [0.0, 2.0, 2.0]),
    ] {
        let image = draw(&frame(size, &[(0, red, 1.0), (1, green, 1.0)]), &level()).unwrap();
        assert!(is_red(pixel(&image, 0.76, 0.24)) && is_green(pixel(&image, 0.24, 0.76)), "{size:?}");
    }
    let down = Style { up: Some(-Vector::z()), ..level() };
    let image = draw(&frame([10.0; 3], &[(0, [8.0, 5.0, 2.0], 1.0)]), &down).unwrap();
    assert!(is_red(pixel(&image, 0.76, 0.24)));
}

#[test]
fn particle_behind_translucent_static_sphere_is_visible() {
    let held = frame([10.0; 3], &[(0, [5.0, 6.0, 5.0], 1.0), (2, [5.0, 2.0, 5.0], 1.0)]);
    assert!(is_red(pixel(&draw(&held, &level()).unwrap(), 0.5, 0.5)));
    let opaque = Style { static_opacity: 1.0, ..level() };
    assert!(!is_red(pixel(&draw(&held, &opaque).unwrap(), 0.5, 0.5)));
    let clear = Style { static_opacity: 0.0, ..level() };
    let without = frame([10.0; 3], &[(0, [5.0, 6.0, 5.0], 1.0)]);
    assert_eq!(draw(&held, &clear).unwrap(), draw(&without, &clear).unwrap());
}

#[test]
fn colour_by_speed_ends_at_the_top_speed() {
    let mut moving = frame([10.0, 10.0, 0.0], &[(0, [2.0, 5.0, 0.0], 1.0), (0, [8.0, 5.0, 0.0], 1.0)]);
    moving.particles[1].velocity = Vector::new(0.0, 3.0, 0.0);
    let style = Style { colour_by: ColourBy::Speed, top_speed: Some(3.0), ..level() };
    let image = draw(&moving, &style).unwrap();
    let height = f64::from(image.height());
    let middle = 0.5 * (height - f64::from(legend::STRIP * 240.0)) / height;
    let (slow, fast) = (pixel(&image, 0.25, middle), pixel(&image, 0.75, middle));
    assert!(slow[2] > slow[1] && fast[0] > 200 && fast[1] > 180 && fast[2] < 120, "{slow:?} {fast:?}");
    let own_scale = draw(&moving, &Style { top_speed: None, ..style }).unwrap();
    assert_eq!(own_scale, image);
}

#[test]
fn colours_show_contact_pressures() {
    let mut pressed = frame([10.0, 10.0, 0.0], &[(0, [2.0, 5.0, 0.0], 1.0), (0, [8.0, 5.0, 0.0], 1.0)]);
    pressed.particles[0].velocity = Vector::new(0.0, 3.0, 0.0);
    let style = Style { colour_by: ColourBy::Pressure, ..level() };
    assert!(matches!(draw(&pressed, &style), Err(ViewError::NoPressure)));
    pressed.scalars = vec![Scalar::new("contact_pressure", vec![-1.0, 7.0])];
    let image = draw(&pressed, &style).unwrap();
    let height = f64::from(image.height());
    let middle = 0.5 * (height - f64::from(legend::STRIP * 240.0)) / height;
    // The particle without pressure is dark blue, although it is fast, and the other is yellow.
    let (low, high) = (pixel(&image, 0.25, middle), pixel(&image, 0.75, middle));
    assert!(low[2] > low[1] && high[0] > 200 && high[1] > 180 && high[2] < 120, "{low:?} {high:?}");
    assert_eq!(Scale::of(&pressed, &[-3.0, -2.0], &style).top, 1.0, "without positive numbers");
    pressed.scalars[0].values.pop();
    assert!(matches!(draw(&pressed, &style), Err(ViewError::NoPressure)));
}

#[test]
fn numbers_in_images_have_the_units_of_the_scene() {
    let style = Style { units: Some(Units::new("mm", "g", "ms")), ..level() };
    assert_eq!(style.with_unit("0.5".into(), "length / time", 3), "0.5 mm / ms");
    assert_eq!(style.with_unit("0.5".into(), "energy / length^D", 2), "0.5 g / ms^2");
    assert_eq!(level().with_unit("0.5".into(), "length / time", 3), "0.5");
    // The font has no Greek letters, and metres are not micrometres.
    let micro = Style { units: Some(Units::new("µm", "g", "ms")), ..level() };
    assert_eq!(micro.with_unit("0.5".into(), "length / time", 3), "0.5");
    assert_eq!(micro.with_unit("0.5".into(), "time", 3), "0.5 ms");
    let mut moving = frame([10.0, 10.0, 0.0], &[(0, [2.0, 5.0, 0.0], 1.0)]);
    moving.particles[0].velocity = Vector::new(0.0, 3.0, 0.0);
    let with_speed = |style: &Style| draw(&moving, &Style { colour_by: ColourBy::Speed, ..style.clone() }).unwrap();
    assert_ne!(with_speed(&style), with_speed(&level()), "the unit is beside the scale");
    assert_eq!(draw(&moving, &style).unwrap(), draw(&moving, &level()).unwrap(), "there is no scale");
}

#[test]
fn scale_fits_into_a_narrow_image() {
    // The words left and right of the scale must not touch the border.
    let mut moving = frame([4.0, 40.0, 0.0], &[(0, [2.0, 5.0, 0.0], 1.0)]);
    moving.particles[0].velocity = Vector::new(0.0, 123.0, 0.0);
    let image = draw(&moving, &Style { colour_by: ColourBy::Speed, width: 600, height: 600, ..level() }).unwrap();
    assert!(image.width() < 120, "the image is cropped");
    let [width, height] = [image.width(), image.height()].map(|side| side as usize);
    let rows = height - trunc_to_usize(legend::STRIP * 600.0)..height;
    let at = |row: usize, column: usize| is_background(image.pixels()[row * width + column]);
    assert!(rows.clone().all(|row| at(row, 0) && at(row, width - 1)));
    assert!(!rows.clone().all(|row| (0..width).all(|column| at(row, column))), "the scale is there");
}

#[test]
fn bond_across_a_periodic_side_is_not_drawn_through_the_box() {
    let ends = [(0, [1.0, 5.0, 0.0], 0.4), (0, [9.0, 5.0, 0.0], 0.4)];
    let grey_between = |size: f64, is_bonded: bool| {
        let mut pair = frame([10.0, 10.0, 0.0], &ends);
        pair.size.x = size;
        pair.bonds = if is_bonded { vec![[ParticleId(0), ParticleId(1)]] } else { Vec::new() };
        let image = draw(&pair, &level()).unwrap();
        !is_background(pixel(&image, 0.4, 0.5))
    };
    assert!(!grey_between(10.0, true) && grey_between(20.0, true) && !grey_between(20.0, false));
}

#[test]
fn box_has_twelve_edges_or_fewer_if_flat() {
    let inked = Style { has_box: true, ..level() };
    let with_box = |size: [f64; 3]| area(&draw(&frame(size, &[(0, size.map(|x| x / 2.0), 0.1)]), &inked).unwrap());
    assert!(with_box([10.0; 3]) > 1.5 * with_box([10.0, 10.0, 0.0]));
    assert_eq!(
        [[10.0; 3], [10.0, 0.0, 10.0], [0.0, 9.0, 0.0]].map(|size| box_edges(&frame(size, &[])).len()),
        [12, 4, 1]
    );
}

#[test]
fn image_is_reproducible_and_saved_unchanged() {
    let folder = tempfile::tempdir().unwrap();
    let (trajectory, file) = (folder.path().join("trajectory.xyz"), folder.path().join("frame.png"));
    let shown = frame([10.0; 3], &[(0, [5.0, 6.0, 5.0], 2.0), (2, [4.0, 2.0, 5.0], 1.0), (1, [7.0, 3.0, 4.0], 1.5)]);
    write_frame(std::fs::File::create(&trajectory).unwrap(), &shown).unwrap();
    let image = draw(&shown, &level()).unwrap();
    assert_eq!(image, of_trajectory(&trajectory, None, &level()).unwrap());
    image.write_png(&file, Existing::Keep).unwrap();
    let other = draw(&shown, &Style { width: 40, ..level() }).unwrap();
    assert!(matches!(other.write_png(&file, Existing::Keep), Err(ViewError::Exists(_))));
    let decoder = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&file).unwrap()));
    let mut reader = decoder.read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    assert_eq!((info.width, info.height), (image.width(), image.height()));
    assert_eq!(bytes, image.pixels().as_flattened());
    assert!(matches!(image.write_png(folder.path(), Existing::Replace), Err(ViewError::Write { .. })));
    let none = folder.path().join("none.xyz");
    assert!(matches!(of_trajectory(&none, None, &level()), Err(ViewError::Trajectory { .. })));
}

#[test]
fn invalid_frames_and_styles_are_rejected() {
    let refusal = |change: &dyn Fn(&mut Frame, &mut Style)| {
        let (mut frame, mut style) = (frame([10.0; 3], &[(0, [5.0; 3], 1.0)]), level());
        change(&mut frame, &mut style);
        draw(&frame, &style).unwrap_err()
    };
    assert!(matches!(refusal(&|frame, _| frame.particles.clear()), ViewError::Empty));
    assert!(matches!(refusal(&|f, _| f.particles[0].position.y = f64::NAN), ViewError::Particle(ParticleId(0))));
    assert!(matches!(refusal(&|f, _| f.particles[0].velocity.y = f64::INFINITY), ViewError::Particle(_)));
    assert!(matches!(refusal(&|f, _| f.particles[0].radius = 0.0), ViewError::Particle(_)));
    assert!(matches!(refusal(&|f, _| f.size.x = f64::NAN), ViewError::Box));
    assert!(matches!(refusal(&|f, _| f.size.x = f64::MAX), ViewError::Box));
    assert!(matches!(refusal(&|_, s| s.width = 0), ViewError::Size { width: 0, .. }));
    assert!(matches!(refusal(&|_, s| s.height = u32::MAX), ViewError::Size { .. }));
    assert!(matches!(refusal(&|_, s| s.palette.clear()), ViewError::NoColour));
    assert!(matches!(
        refusal(&|_, s| s.static_opacity = 1.1),
        ViewError::Option { name: "static_opacity of an image", .. }
    ));
    assert!(matches!(
        refusal(&|_, s| s.top_speed = Some(0.0)),
        ViewError::Option { name: "top_speed of an image", .. }
    ));
    assert!(matches!(refusal(&|_, s| s.azimuth = f64::NAN), ViewError::Option { name: "azimuth of an image", .. }));
    assert!(matches!(refusal(&|_, s| s.up = Some(Vector::zeros())), ViewError::Option { .. }));
    assert!(matches!(refusal(&|_, s| s.from = Some(Vector::zeros())), ViewError::Option { .. }));
    assert!(matches!(refusal(&|_, s| s.gravity = Some(Vector::repeat(f64::NAN))), ViewError::Option { .. }));
    assert!(matches!(refusal(&|_, s| s.zoom = 0.0), ViewError::Option { name: "zoom of an image", .. }));
}

#[test]
fn an_image_that_is_not_cut_has_the_size_of_the_style() {
    for colour_by in [ColourBy::Species, ColourBy::Speed] {
        let style = Style { width: 240, height: 100, is_cut: false, colour_by, ..level() };
        let image = draw(&frame([10.0; 3], &[(0, [5.0; 3], 1.0)]), &style).unwrap();
        assert_eq!((image.width(), image.height()), (240, 100));
    }
}

#[test]
fn camera_looks_from_the_given_direction() {
    let balls = [(0, [8.0, 5.0, 5.0], 1.0), (1, [2.0, 5.0, 5.0], 1.0)];
    let seen_from = |from: Vector| {
        let style = Style { from: Some(from), elevation: 50.0, ..level() };
        pixel(&draw(&frame([10.0; 3], &balls), &style).unwrap(), 0.5, 0.5)
    };
    assert!(is_red(seen_from(Vector::x())) && is_green(seen_from(-2.0 * Vector::x())));
    // From above, x points right and y points up.
    let above = Style { from: Some(Vector::z()), ..level() };
    let image = draw(&frame([10.0; 3], &[(0, [8.0, 8.0, 5.0], 1.0), (1, [2.0, 2.0, 5.0], 1.0)]), &above).unwrap();
    assert!(is_red(pixel(&image, 0.76, 0.24)) && is_green(pixel(&image, 0.24, 0.76)));
    // The azimuth is measured from the direction `from`.
    let turned = Style { from: Some(-Vector::y()), azimuth: 90.0, ..level() };
    assert!(is_red(pixel(&draw(&frame([10.0; 3], &balls), &turned).unwrap(), 0.5, 0.5)));
}

#[test]
fn zoom_enlarges_about_the_middle() {
    let flat =
        |zoom: f64| draw(&frame([10.0, 10.0, 0.0], &[(0, [5.0, 5.0, 0.0], 1.0)]), &Style { zoom, ..level() }).unwrap();
    let scale = 240.0 * (1.0 - 2.0 * 0.035) / 10.0;
    assert_disc(area(&flat(1.0)), scale);
    assert_disc(area(&flat(2.5)), 2.5 * scale);
}

#[test]
fn shadows_fall_on_the_ground_where_there_is_gravity() {
    let mut scene = frame([10.0; 3], &[(0, [5.0, 5.0, 1.0], 1.0)]);
    scene.periodic = [false; 3];
    let raised = Style { gravity: Some(-Vector::z()), framing: Framing::Box, elevation: 30.0, ..level() };
    let drawn = |style: &Style, scene: &Frame| draw(scene, style).unwrap();
    let with = drawn(&raised, &scene);
    let without = drawn(&Style { has_ground: false, ..raised.clone() }, &scene);
    assert!(area(&with) > 1.4 * area(&without), "{} {}", area(&with), area(&without));
    assert_eq!(without, drawn(&Style { gravity: None, ..raised.clone() }, &scene));
    let shades: std::collections::BTreeSet<u8> =
        with.pixels().iter().zip(without.pixels()).filter(|(a, b)| a != b).map(|(a, _)| a[1]).collect();
    assert!(shades.len() > 20, "{shades:?}");
    // The shadow almost vanishes if the ball is far above the ground. There is none if the box is periodic along z.
    scene.particles[0].position.z = 9.0;
    let above = [&raised, &Style { has_ground: false, ..raised.clone() }].map(|style| area(&drawn(style, &scene)));
    assert!(above[0] < 1.2 * above[1], "{above:?}");
    scene.particles[0].position.z = 1.0;
    scene.periodic[2] = true;
    assert_eq!(drawn(&raised, &scene), without);
}

#[test]
fn sphere_shades_what_is_below_but_not_beside() {
    let brightness = |balls: &[(u32, [f64; 3], f64)]| {
        let image = draw(&frame([10.0; 3], balls), &level()).unwrap();
        image
            .pixels()
            .iter()
            .filter(|pixel| pixel[1].saturating_sub(pixel[0]) > 20)
            .map(|pixel| u64::from(pixel[1]))
            .sum::<u64>()
    };
    let lower = (1, [5.0, 5.0, 3.0], 1.0);
    let alone = brightness(&[lower]);
    let shaded = brightness(&[lower, (0, [3.6, 4.0, 5.2], 1.0)]);
    assert!(shaded < alone * 95 / 100, "{shaded} {alone}");
    // The red ball is far above the green ball and not in front of the sun, but it blocks the sky.
    let below = brightness(&[lower, (0, [5.0, 5.0, 8.5], 1.0)]);
    assert!(below < alone * 98 / 100, "{below} {alone}");
    let beside = brightness(&[lower, (0, [9.5, 5.0, 3.0], 0.5)]);
    assert_eq!(beside, alone);
}

#[test]
fn box_edges_do_not_cover_particles() {
    let scene = frame([10.0; 3], &[(0, [5.0; 3], 4.9)]);
    let style = Style { azimuth: 45.0, elevation: 35.0, ..level() };
    let [without, with] = [false, true].map(|has_box| draw(&scene, &Style { has_box, ..style.clone() }).unwrap());
    assert!(area(&with) > area(&without));
    // A pixel at the rim of the ball partly shows the background, so its colour may change slightly.
    let is_like = |before: &[u8; 4], after: &[u8; 4]| (0..3).all(|k| before[k].abs_diff(after[k]) < 24);
    let is_kept = |(before, after): (&[u8; 4], &[u8; 4])| !is_red(*before) || is_like(before, after);
    assert!(without.pixels().iter().zip(with.pixels()).all(is_kept));
}

#[test]
fn image_is_cropped_to_the_particles_under_gravity() {
    let mut scene = frame([10.0; 3], &[(0, [2.0, 2.0, 1.0], 1.0), (1, [8.0, 8.0, 3.0], 1.0)]);
    let size = |scene: &Frame, style: &Style| {
        let image = draw(scene, style).unwrap();
        (image.width(), image.height())
    };
    let falls = Style { gravity: Some(-Vector::z()), ..level() };
    let boxed = Style { framing: Framing::Box, ..falls.clone() };
    assert_eq!(size(&scene, &falls), size(&scene, &boxed), "periodic");
    scene.periodic = [false; 3];
    assert!(size(&scene, &falls).1 < size(&scene, &boxed).1 * 6 / 10);
    // A single ball fills too little of the box for cropping.
    scene.particles.truncate(1);
    assert_eq!(size(&scene, &falls), size(&scene, &boxed));
}

fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![4 => -2.0..12.0, 2 => Just(0.0), 1 => Just(5.0), 1 => Just(1e300), 1 => Just(-1e-300), 1 => Just(1e9)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn any_frame_is_drawn_or_refused(
        size in [coordinate(), coordinate(), coordinate()],
        balls in prop::collection::vec((0..4_u32, [coordinate(), coordinate(), coordinate()], coordinate()), 1..6),
        bonds in prop::collection::vec([0..6_u32, 0..6_u32], 0..3),
        (has_all, by_speed, has_wide) in any::<(bool, bool, bool)>(),
    ) {
        let balls: Vec<_> = balls.into_iter().map(|(species, at, radius)| (species, at, radius.abs())).collect();
        let mut any = frame(size.map(f64::abs), &balls);
        any.particles.iter_mut().for_each(|particle| particle.velocity = particle.position);
        any.bonds = bonds.into_iter().map(|ends| ends.map(ParticleId)).collect();
        let style = Style {
            width: if has_wide { 64 } else { 16 },
            height: 32,
            has_box: true,
            framing: if has_all { Framing::Particles } else { Framing::Box },
            colour_by: if by_speed { ColourBy::Speed } else { ColourBy::Species },
            ..level()
        };
        if let Ok(image) = draw(&any, &style) {
            prop_assert!((16..=style.width).contains(&image.width()) && (16..=style.height).contains(&image.height()));
        }
    }
}

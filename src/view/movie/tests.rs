use std::fs;
use std::path::PathBuf;

use super::*;
use crate::Vector;
use crate::model::{ParticleId, SpeciesId};
use crate::trajectory::Frame;
use crate::trajectory::extended_xyz::write_frame;
use crate::trajectory::frame::{FrameParticle, FrameSpecies};
use crate::view::render::{BACKGROUND, ColourBy, Framing};

struct Place(tempfile::TempDir);

impl Place {
    fn with(frames: &[Frame]) -> Self {
        let mut text = Vec::new();
        frames.iter().for_each(|frame| write_frame(&mut text, frame).unwrap());
        Self::of(&text)
    }

    fn of(text: &[u8]) -> Self {
        let place = Self(tempfile::tempdir().unwrap());
        fs::write(place.path("trajectory.xyz"), text).unwrap();
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, movie: &Movie) -> Result<WrittenMovie, ViewError> {
        let trajectory = self.path("trajectory.xyz");
        write(&trajectory, &self.path(name), movie, Existing::Keep, &mut |_| ControlFlow::Continue(()))
    }

    fn seen(&self, name: &str, movie: &Movie) -> Vec<Seen> {
        self.write(name, movie).unwrap();
        let seen = if name.ends_with("gif") { gif_images(&self.path(name)) } else { apng_images(&self.path(name)) };
        fs::remove_file(self.path(name)).unwrap();
        assert_eq!(fs::read_dir(self.0.path()).unwrap().count(), 1, "something else is left behind");
        seen
    }
}

#[derive(Debug, Clone, PartialEq)]
struct Seen {
    width: usize,
    pixels: Vec<[u8; 4]>,
    seconds: f64,
}

impl Seen {
    fn scene(&self) -> &[[u8; 4]] {
        let rows = self.pixels.len() / self.width * 4 / 5;
        &self.pixels[..rows * self.width]
    }

    fn is_within(&self) -> bool {
        let is_free = |pixel: &[u8; 4]| pixel[..3] == BACKGROUND;
        let mut rows = self.scene().chunks(self.width);
        rows.next().unwrap().iter().all(is_free) && rows.all(|row| is_free(&row[0]) && is_free(&row[self.width - 1]))
    }
}

fn gif_images(path: &Path) -> Vec<Seen> {
    let mut options = ::gif::DecodeOptions::new();
    options.set_color_output(::gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(fs::File::open(path).unwrap()).unwrap();
    assert_eq!(decoder.repeat(), ::gif::Repeat::Infinite);
    let (width, height) = (usize::from(decoder.width()), usize::from(decoder.height()));
    let mut canvas = vec![[0; 4]; width * height];
    let mut seen = Vec::new();
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        let part = [frame.left, frame.top, frame.width].map(usize::from);
        put(&mut canvas, width, part, frame.buffer.as_chunks().0);
        seen.push(Seen { width, pixels: canvas.clone(), seconds: f64::from(frame.delay) / 100.0 });
    }
    seen
}

fn apng_images(path: &Path) -> Vec<Seen> {
    let mut reader = png::Decoder::new(std::io::BufReader::new(fs::File::open(path).unwrap())).read_info().unwrap();
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    let animation = *reader.info().animation_control().unwrap();
    assert_eq!(animation.num_plays, 0);
    let mut canvas = vec![[0; 4]; width * height];
    let mut seen = Vec::new();
    for _ in 0..animation.num_frames {
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut bytes).unwrap();
        let control = *reader.info().frame_control().unwrap();
        let part = [control.x_offset, control.y_offset, control.width].map(|pixels| pixels as usize);
        let count = control.width as usize * control.height as usize;
        put(&mut canvas, width, part, &bytes.as_chunks().0[..count]);
        let seconds = f64::from(control.delay_num) / f64::from(control.delay_den);
        seen.push(Seen { width, pixels: canvas.clone(), seconds });
    }
    assert!(reader.next_frame(&mut vec![0; 4 * width * height]).is_err(), "more images than are announced");
    seen
}

fn put(canvas: &mut [[u8; 4]], width: usize, [left, top, columns]: [usize; 3], pixels: &[[u8; 4]]) {
    for (row, pixels) in pixels.chunks(columns).enumerate() {
        let line = &mut canvas[(top + row) * width + left..][..columns];
        line.iter_mut().zip(pixels).filter(|(_, new)| new[3] > 0).for_each(|(old, new)| *old = *new);
    }
}

/// Returns a frame at time `number / 4` of a cubic box of edge 8, with a small ball in each corner and a moving ball.
fn frame(number: u32, speed: f64) -> Frame {
    let ball = |id, species, position: [f64; 3], radius, speed| FrameParticle {
        id: ParticleId(id),
        species: SpeciesId(species),
        position: position.into(),
        velocity: Vector::new(speed, 0.0, 0.0),
        radius,
    };
    let side = |number: u32, bit: u32| if number >> bit & 1 == 1 { 7.5 } else { 0.5 };
    let mut particles: Vec<_> =
        (0..8).map(|corner| ball(corner, 0, [0, 1, 2].map(|bit| side(corner, bit)), 0.5, 0.0)).collect();
    particles.push(ball(8, 1, [2.0 + 0.5 * f64::from(number), 4.0, 4.0], 1.5, speed));
    let species = ["corner", "runner"];
    Frame {
        time: 0.25 * f64::from(number),
        lower: Vector::zeros(),
        size: Vector::repeat(8.0),
        periodic: [true; 3],
        displacement: 0.0,
        species: species.map(|name| FrameSpecies { name: name.into(), is_static: false, mass: Some(1.0) }).into(),
        particles,
        ..Frame::default()
    }
}

fn frames(count: u32) -> Vec<Frame> {
    (0..count).map(|number| frame(number, f64::from(number))).collect()
}

fn still() -> Movie {
    let style = Style { width: 96, height: 72, ..Style::default() };
    Movie { style, turn: 0.0, frames_per_second: 30, ..Movie::default() }
}

#[test]
fn movie_frames_equal_single_images() {
    let place = Place::with(&frames(7));
    let alone = |first| {
        let movie = Movie { first, last: Some(first), ..still() };
        place.seen("alone.apng", &movie).pop().unwrap().pixels
    };
    let apng = place.seen("film.apng", &still());
    assert_eq!(apng.len(), 7);
    assert!(apng.iter().all(|image| image.width == 96 && image.pixels.len() == 96 * 72 && image.seconds == 1.0 / 30.0));
    for (first, image) in (0..).zip(&apng) {
        assert!(alone(first) == image.pixels, "image {first}");
    }
    // The mean error of the colours is less than two steps per component.
    let gif = place.seen("film.gif", &still());
    assert_eq!(gif.len(), 7);
    for (image, exact) in gif.iter().zip(&apng) {
        let pairs = image.pixels.as_flattened().iter().zip(exact.pixels.as_flattened());
        let off: u32 = pairs.map(|(a, b)| u32::from(a.abs_diff(*b))).sum();
        assert!(off < 2 * 3 * 96 * 72, "{off}");
        let pairs = image.pixels.iter().zip(&exact.pixels);
        assert!(pairs.filter(|(_, exact)| exact[..3] == BACKGROUND).all(|(pixel, exact)| pixel == exact));
    }
    let seconds: f64 = gif.iter().map(|image| image.seconds).sum();
    assert!((seconds - 7.0 / 30.0).abs() < 0.005, "{seconds}");
}

#[test]
fn frame_selection_works_and_output_is_reproducible() {
    let place = Place::with(&frames(9));
    let movie = Movie { first: 1, last: Some(7), every: 3, ..still() };
    let seen = place.seen("film.apng", &movie);
    let all = place.seen("film.apng", &still());
    assert_eq!(seen.len(), 3);
    for (image, index) in seen.iter().zip([1, 4, 7]) {
        assert!(image.scene() == all[index].scene());
    }
    for ending in ["gif", "apng"] {
        let names = ["a", "b"].map(|name| format!("{name}.{ending}"));
        let movie = Movie { turn: -70.0, ..movie.clone() };
        let [one, other] = names.map(|name| {
            place.write(&name, &movie).unwrap();
            fs::read(place.path(&name)).unwrap()
        });
        assert!(one == other && one.len() > 1000);
    }
}

#[test]
fn resting_scene_changes_only_if_the_camera_moves() {
    let mut resting = vec![frame(3, 0.0); 4];
    for (frame, time) in resting.iter_mut().zip([0.0, 10.0, 20.0, 30.0]) {
        frame.time = time;
    }
    let place = Place::with(&resting);
    for name in ["film.gif", "film.apng"] {
        let seen = place.seen(name, &still());
        assert!(seen.len() == 4 && seen.iter().all(|image| image.scene() == seen[0].scene()));
        assert!(seen[0].pixels != seen[1].pixels, "the time is another one");
        let seen = place.seen(name, &Movie { turn: 40.0, ..still() });
        assert!(seen.windows(2).all(|pair| pair[0].scene() != pair[1].scene()));
        let round = place.seen(name, &Movie { turn: 360.0, ..still() });
        // After a full turn, images differ only by the rounding of angles.
        let off = |k: usize| round[0].scene().iter().zip(round[k].scene()).filter(|(a, b)| a != b).count();
        assert!(off(3) < 50 && off(1) > 200, "{} {}", off(3), off(1));
    }
    resting.iter_mut().for_each(|frame| frame.time = 0.0);
    let seen = Place::with(&resting).seen("film.gif", &still());
    assert!(seen.len() == 4 && seen.iter().all(|image| image.pixels == seen[0].pixels));
}

#[test]
fn nothing_leaves_the_image_from_any_direction() {
    let place = Place::with(&vec![frame(0, 0.0); 9]);
    for turn in [0.0, 90.0, -360.0, 1000.0] {
        let seen = place.seen("film.apng", &Movie { turn, ..still() });
        assert!(seen.iter().all(Seen::is_within), "{turn}");
    }
    // There is no box, and one particle leaves the region of the first frame.
    let flight = |x: f64| format!("2\n\nball 0 0 0\nball {x} 0 {x}\n");
    let text: String = [1.0, 5.0, 20.0, -30.0].map(flight).concat();
    let place = Place::of(text.as_bytes());
    let seen = place.seen("film.apng", &Movie { turn: 120.0, ..still() });
    assert!(seen.len() == 4 && seen.iter().all(Seen::is_within));
    assert!(seen.iter().all(|image| image.scene().iter().any(|pixel| pixel[..3] != BACKGROUND)));
    let leaving: Vec<Frame> = (0..50).step_by(3).map(|number| frame(number, 0.0)).collect();
    let beyond = Place::with(&leaving);
    let style = Style { framing: Framing::Particles, ..still().style };
    assert!(beyond.seen("film.apng", &Movie { style, ..still() }).iter().all(Seen::is_within));
    assert!(!beyond.seen("film.apng", &still()).iter().all(Seen::is_within), "they leave the box");
}

#[test]
fn the_scale_of_speeds_is_that_of_all_frames() {
    let yellow = |image: &Seen| image.scene().iter().filter(|p| p[0] > 150 && p[1] > 130 && p[2] < 110).count();
    let speeds = |speeds: [f64; 3]| {
        let style = Style { colour_by: ColourBy::Speed, has_box: false, height: 96, ..still().style };
        let frames: Vec<Frame> = speeds.iter().map(|speed| frame(2, *speed)).collect();
        let seen = Place::with(&frames).seen("film.apng", &Movie { style, ..still() });
        seen.iter().map(|image| yellow(image) > 20).collect::<Vec<_>>()
    };
    assert_eq!(speeds([1.0, 8.0, 2.0]), [false, true, false]);
    assert_eq!(speeds([1.0, 1.0, 1.0]), [true; 3]);
}

#[test]
fn particles_may_come_and_go() {
    let mut coming = frames(5);
    coming[0].particles.clear();
    coming[2].particles.truncate(3);
    coming[3].particles.clear();
    coming[4].particles.iter_mut().for_each(|particle| particle.id.0 += 100);
    let place = Place::with(&coming);
    for colour_by in [ColourBy::Species, ColourBy::Speed] {
        let style = Style { colour_by, ..still().style };
        let seen = place.seen("film.gif", &Movie { style, ..still() });
        // The lower half of the image contains the caption and the scale of speeds.
        let above = |image: usize| &seen[image].pixels[..seen[image].pixels.len() / 2];
        assert!(seen.len() == 5 && above(0) == above(3) && above(0) != above(4));
    }
    let framing_particles = Style { framing: Framing::Particles, ..still().style };
    assert_eq!(place.seen("film.apng", &Movie { style: framing_particles, ..still() }).len(), 5);
    assert_eq!(Place::with(&frames(1)).seen("film.gif", &Movie::default()).len(), 1);
    let nobody = Movie { last: Some(0), ..still() };
    assert!(matches!(place.write("film.gif", &nobody), Err(ViewError::EmptyMovie(_))));
}

#[test]
fn a_frame_that_was_cut_off_is_left_out() {
    let mut text = Vec::new();
    frames(3).iter().for_each(|frame| write_frame(&mut text, frame).unwrap());
    let lines = text.split_inclusive(|byte| *byte == b'\n').map(<[u8]>::len);
    let last_frame: usize = lines.take(2 * 11).sum();
    for (cut, count, is_cut) in [
        (text.len(), 3, false),
        (text.len() - 1, 3, false),
        (text.len() - 12, 2, true),
        (last_frame + 5, 2, true),
        (last_frame + 1, 2, true),
        (last_frame, 2, false),
    ] {
        let place = Place::of(&text[..cut]);
        let done = place.write("film.apng", &still()).unwrap();
        assert_eq!((done.frames, done.is_truncated), (count, is_cut), "{cut}");
        assert_eq!(apng_images(&place.path("film.apng")).len() as u64, count);
        assert_eq!(done.bytes, fs::metadata(place.path("film.apng")).unwrap().len());
    }
    let place = Place::of(&text[..100]);
    assert!(matches!(place.write("film.gif", &still()), Err(ViewError::Trajectory { .. })));
}

#[test]
fn rejected_movie_leaves_no_files() {
    let place = Place::with(&frames(3));
    fs::create_dir(place.path("folder.gif")).unwrap();
    fs::write(place.path("there.gif"), "mine").unwrap();
    let refusal = |name: &str, change: &dyn Fn(&mut Movie)| {
        let mut movie = still();
        change(&mut movie);
        let error = place.write(name, &movie).unwrap_err();
        assert_eq!(fs::read_dir(place.0.path()).unwrap().count(), 3);
        error
    };
    assert!(matches!(refusal("film.avi", &|_| ()), ViewError::Format(_)));
    assert!(matches!(refusal("film", &|_| ()), ViewError::Format(_)));
    assert!(matches!(refusal("film.gif", &|m| m.frames_per_second = 51), ViewError::FastGif(51)));
    assert!(matches!(refusal("film.apng", &|m| m.frames_per_second = 121), ViewError::Option { .. }));
    assert!(matches!(refusal("film.apng", &|m| m.frames_per_second = 0), ViewError::Option { .. }));
    assert!(matches!(refusal("film.mp4", &|m| m.style.width = 97), ViewError::OddSize { width: 97, height: 72 }));
    assert!(matches!(refusal("film.gif", &|m| m.every = 0), ViewError::Option { .. }));
    assert!(matches!(refusal("film.gif", &|m| m.turn = f64::NAN), ViewError::Option { .. }));
    assert!(matches!(refusal("film.gif", &|m| m.style.width = 3), ViewError::Size { .. }));
    assert!(matches!(refusal("film.gif", &|m| m.first = 3), ViewError::NoSuchFrame { first: 3, count: 3, .. }));
    assert!(matches!(refusal("folder.gif", &|_| ()), ViewError::NotReplaceable(_)));
    assert!(matches!(refusal("there.gif", &|_| ()), ViewError::Exists(_)));
    assert!(matches!(refusal("none/film.gif", &|_| ()), ViewError::Write { .. }));
    let mut bad = frames(6);
    bad[4].particles[2].radius = 0.0;
    let place = Place::with(&bad);
    let error = place.write("film.apng", &still()).unwrap_err();
    let ViewError::Frame { index: 4, source, .. } = &error else { panic!("{error}") };
    assert!(matches!(**source, ViewError::Particle(ParticleId(2))), "{source}");
    assert_eq!(fs::read_dir(place.0.path()).unwrap().count(), 1);
}

#[test]
fn interrupted_movie_leaves_no_files() {
    let place = Place::with(&frames(6));
    let trajectory = place.path("trajectory.xyz");
    for (is_drawing, name) in [(false, "film.gif"), (true, "film.gif"), (true, "film.apng")] {
        let mut watch = |progress: &MovieProgress| {
            assert!((0.0..=1.0).contains(&progress.fraction));
            if progress.is_drawing == is_drawing { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let result = write(&trajectory, &place.path(name), &still(), Existing::Keep, &mut watch);
        assert!(matches!(result, Err(ViewError::Interrupted)));
        assert_eq!(fs::read_dir(place.0.path()).unwrap().count(), 1);
    }
}

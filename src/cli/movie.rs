use std::path::PathBuf;

use crate::base::text::{plural, printable, size};
use crate::io::refuse_input;
use crate::model::ParticleId;
use crate::view::movie::{self, Follow, Movie as Options};
use crate::view::render::{ColourBy, Style};
use clap::Args;

use super::camera::Camera;
use super::convert::frames;
use super::failure::Failure;
use super::progress::Display;
use super::render::{COLOURS, width_and_height};
use super::{one_of, run, signals};

/// Draws all frames of a run as a movie: MP4, GIF or APNG
#[derive(Debug, Args)]
#[command(after_help = "\
The file extension of --out selects the format. GIF opens everywhere and has 256 colours. APNG has all colours, opens in browsers and is large.
MP4 is small and opens in players and slides; it needs the program ffmpeg, which must be installed.

Examples:
  carom movie runs/hopper --out hopper.mp4
  carom movie runs/hopper --out hopper.gif --size 480x360 --colour speed --turn 0
  carom movie runs/polymer --out chain.mp4 --follow com --zoom 2 --no-box
  carom movie runs/fluid --out fluid.apng --frames 100..199 --every 2 --fps 10")]
pub struct Movie {
    /// The folder of a run, or a trajectory in extended XYZ
    run: PathBuf,
    /// The file to write; .mp4, .gif or .apng
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Draws only these frames, both ends included; frames count from 0; either end is optional
    #[arg(long, value_name = "FIRST..LAST", value_parser = frames)]
    frames: Option<(u64, Option<u64>)>,
    /// Draws every N-th frame
    #[arg(long, value_name = "N", default_value = "1", allow_negative_numbers = true, value_parser = run::count)]
    every: u64,
    /// Frames shown per second, 1 to 120
    #[arg(long, value_name = "N", default_value = "25", allow_negative_numbers = true,
        value_parser = clap::value_parser!(u32).range(1..=120))]
    fps: u32,
    /// Quantity shown by colours
    #[arg(long, value_name = "WHAT", default_value = "species", visible_alias = "color", value_parser = one_of(&COLOURS))]
    colour: ColourBy,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x960", value_parser = width_and_height)]
    size: (u32, u32),
    /// Angle by which the camera turns around the scene from the first to the last frame, in degrees; 0 for a
    /// fixed camera. Flat scenes always have a fixed camera
    #[arg(long, value_name = "DEGREES", default_value = "30", allow_negative_numbers = true, value_parser = degrees)]
    turn: f64,
    #[command(flatten)]
    camera: Camera,
    /// Centre of the picture: com for the centre of mass of all moving particles, or the id of a particle
    #[arg(long, value_name = "com|ID", allow_negative_numbers = true, value_parser = follow)]
    follow: Option<Follow>,
    /// Replaces an existing file
    #[arg(long)]
    force: bool,
    /// Shows no progress
    #[arg(long, short)]
    quiet: bool,
}

fn degrees(text: &str) -> Result<f64, String> {
    let degrees = text.parse().ok().filter(|degrees| (-3600.0..=3600.0).contains(degrees));
    degrees.ok_or_else(|| "expected an angle from -3600 to 3600 degrees".to_owned())
}

fn follow(text: &str) -> Result<Follow, String> {
    match text {
        "com" => Ok(Follow::CentreOfMass),
        id => id
            .parse()
            .map(|id| Follow::Particle(ParticleId(id)))
            .map_err(|_| "expected com or the id of a particle".to_owned()),
    }
}

impl Movie {
    pub fn execute(&self) -> Result<(), Failure> {
        let trajectory = super::trajectory_of(&self.run)?;
        refuse_input(&self.out, super::files_beside(&trajectory))?;
        let (first, last) = self.frames.unwrap_or((0, None));
        let (width, height) = self.size;
        let style = self.camera.applied_to(Style { width, height, colour_by: self.colour, ..Style::default() });
        let Self { fps: frames_per_second, every, turn, follow, .. } = *self;
        let movie = Options { style, frames_per_second, first, last, every, turn, follow };
        signals::watch();
        let mut display = Display::named(printable(&self.out.display().to_string()).into_owned(), self.quiet);
        let result = movie::write(&trajectory, &self.out, &movie, super::existing(self.force), &mut |progress| {
            display.show(progress);
            signals::flow()
        });
        display.clear();
        let done = result?;
        let seconds = done.frames as f64 / f64::from(self.fps);
        let cut = if done.is_truncated { "; the trajectory ends within the next one, which is left out" } else { "" };
        let frames = plural(done.frames, "frame");
        let bytes = size(done.bytes as f64);
        super::print(&format!("{}: {frames} in {seconds:.1} s, {bytes}{cut}\n", self.out.display()))
    }
}

#[cfg(test)]
mod tests {
    use super::{Follow, ParticleId, degrees, follow};

    #[test]
    fn the_centre_of_mass_or_a_particle_is_followed() {
        assert_eq!(follow("com"), Ok(Follow::CentreOfMass));
        assert_eq!(follow("17"), Ok(Follow::Particle(ParticleId(17))));
        assert!(["", "-1", "mass", "1.5", "99999999999"].iter().all(|text| follow(text).is_err()));
    }

    #[test]
    fn angles_are_finite() {
        assert_eq!(["-90", "0", "1e1", "3600"].map(degrees), [-90.0, 0.0, 10.0, 3600.0].map(Ok));
        assert!(["nan", "inf", "3601", "right", ""].iter().all(|text| degrees(text).is_err()));
    }
}

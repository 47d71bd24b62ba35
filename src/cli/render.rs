use std::path::{Path, PathBuf};

use crate::io::{refuse_input, refuse_link};
use crate::view::render::{self, ColourBy, Style};
use clap::Args;

use super::camera::Camera;
use super::failure::Failure;
use super::{Choice, one_of};

/// Draws a frame of a run as a PNG
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  carom render runs/hopper --time 30 --colour speed --size 1200x900
  carom render runs/hopper --view -60,25 --zoom 1.5 --no-box")]
pub struct Render {
    /// The folder of a run, or a trajectory in extended XYZ
    run: PathBuf,
    /// Simulated time of the frame; draws the nearest frame, by default the last
    #[arg(long, value_name = "T", allow_negative_numbers = true, value_parser = time)]
    time: Option<f64>,
    /// The file to write; by default picture.png in the folder of the run
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Quantity shown by colours
    #[arg(long, value_name = "WHAT", default_value = "species", visible_alias = "color", value_parser = one_of(&COLOURS))]
    colour: ColourBy,
    /// Width and height in pixels; by default at most 1600x1200, cut to the shape of the scene
    #[arg(long, value_name = "WxH", value_parser = width_and_height)]
    size: Option<(u32, u32)>,
    #[command(flatten)]
    camera: Camera,
    /// Replaces an existing file
    #[arg(long)]
    force: bool,
}

pub const COLOURS: [Choice<ColourBy>; 3] =
    [("species", None, ColourBy::Species), ("speed", None, ColourBy::Speed), ("pressure", None, ColourBy::Pressure)];

fn time(text: &str) -> Result<f64, String> {
    let time = text.parse().ok().filter(|time: &f64| time.is_finite());
    time.ok_or_else(|| "expected a finite time".to_owned())
}

pub fn width_and_height(text: &str) -> Result<(u32, u32), String> {
    let numbers = text.split_once(['x', 'X']).map(|(width, height)| (width.trim().parse(), height.trim().parse()));
    match numbers {
        Some((Ok(width), Ok(height))) => Ok((width, height)),
        _ => Err("expected WIDTHxHEIGHT in pixels, such as 1600x1200".to_owned()),
    }
}

const OTHER_FORMATS: [&str; 9] = ["bmp", "gif", "jpeg", "jpg", "pdf", "svg", "tif", "tiff", "webp"];

fn refuse_other_format(out: &Path) -> Result<(), Failure> {
    let extension = out.extension().and_then(|extension| extension.to_str()).map(str::to_ascii_lowercase);
    match extension {
        Some(extension) if OTHER_FORMATS.contains(&extension.as_str()) => Err(Failure::bad_input(
            format!("{} ends with .{extension}, but pictures are PNG files", out.display()),
            Some("choose a name that ends with .png, and convert the picture; `carom movie` writes GIF files"),
        )),
        _ => Ok(()),
    }
}

impl Render {
    pub fn execute(&self) -> Result<(), Failure> {
        self.out.as_deref().map_or(Ok(()), refuse_other_format)?;
        let trajectory = super::trajectory_of(&self.run)?;
        let out = self.out.clone().unwrap_or_else(|| {
            trajectory.parent().map_or_else(|| PathBuf::from("picture.png"), |folder| folder.join("picture.png"))
        });
        if self.out.is_none() {
            refuse_link(&out)?;
        }
        refuse_input(&out, super::files_beside(&trajectory))?;
        let sized = match self.size {
            Some((width, height)) => Style { width, height, is_cut: false, ..Style::default() },
            None => Style::default(),
        };
        let style = self.camera.applied_to(Style { colour_by: self.colour, ..sized });
        let image = render::of_trajectory(&trajectory, self.time, &style)?;
        image.write_png(&out, super::existing(self.force))?;
        super::print(&format!("{}\n", out.display()))
    }
}

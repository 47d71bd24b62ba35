//! `carom picture`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::failure::Failure;

/// Draws a frame of a run as a PNG
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  carom picture runs/hopper --time 30 --colour speed --size 1200x900")]
pub struct Picture {
    /// The folder of a run, or a trajectory in extended XYZ
    run: PathBuf,
    /// Simulated time; the frame nearest to it is drawn, otherwise the last one
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    time: Option<f64>,
    /// The file to write; picture.png in the folder of the run if not given
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// What colours tell
    #[arg(long, value_name = "WHAT", default_value = "species", visible_alias = "color")]
    colour: Colour,
    /// Most pixels across and down
    #[arg(long, value_name = "WxH", default_value = "1600x1200", value_parser = width_and_height)]
    size: (u32, u32),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Colour {
    Species,
    Speed,
}

fn width_and_height(text: &str) -> Result<(u32, u32), String> {
    let numbers = text.split_once(['x', 'X']).map(|(width, height)| (width.trim().parse(), height.trim().parse()));
    match numbers {
        Some((Ok(width), Ok(height))) => Ok((width, height)),
        _ => Err("expected WIDTHxHEIGHT in pixels, such as 1600x1200".to_owned()),
    }
}

impl Picture {
    pub fn execute(&self) -> Result<(), Failure> {
        let _ = (&self.run, self.time, &self.out, self.colour, self.size);
        Err(Failure::failed("pictures are not drawn yet", None, None))
    }
}

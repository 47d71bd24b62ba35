use std::path::PathBuf;
use std::sync::LazyLock;

use crate::base::text::plural;
use crate::io::convert::{Options, convert};
use crate::io::refuse_input;
use crate::model::Format;
use clap::Args;

use super::failure::Failure;
use super::{Choice, one_of};

/// Writes a trajectory in the format of another program
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  carom convert runs/hopper --to vtk                    the folder runs/hopper/trajectory-vtk, for ParaView
  carom convert runs/fluid --to gsd --out fluid.gsd
  carom convert runs/fluid --to xyz --frames 10..20     these frames, in runs/fluid/trajectory-piece.xyz")]
pub struct Convert {
    /// The folder of a run, or a trajectory in extended XYZ
    run: PathBuf,
    /// The format to write
    #[arg(long, value_name = "FORMAT", value_parser = one_of(&*FORMATS))]
    to: Format,
    /// The file or folder to write; by default beside the trajectory
    #[arg(long, value_name = "PATH")]
    out: Option<PathBuf>,
    /// Converts only these frames, both ends included; frames count from 0; either end is optional
    #[arg(long, value_name = "FIRST..LAST", value_parser = frames)]
    frames: Option<(u64, Option<u64>)>,
    /// Replaces an existing file, or a folder that holds only files of the format
    #[arg(long)]
    force: bool,
}

static FORMATS: LazyLock<[Choice<Format>; Format::ALL.len()]> =
    LazyLock::new(|| Format::ALL.map(|format| (format.name(), Some(format.about()), format)));

/// Parses a range of frames: `3..7`, `3..`, `..7`, or `3` for one frame.
pub fn frames(text: &str) -> Result<(u64, Option<u64>), String> {
    let number = |text: &str| text.trim().parse::<u64>().ok();
    let range = match text.split_once("..") {
        None => number(text).map(|frame| (frame, Some(frame))),
        Some((first, "")) => number(first).map(|first| (first, None)),
        Some(("", last)) => number(last).map(|last| (0, Some(last))),
        Some((first, last)) => number(first).zip(number(last)).map(|(first, last)| (first, Some(last))),
    };
    let is_forward = |&(first, last): &(u64, Option<u64>)| last.is_none_or(|last| first <= last);
    range.filter(is_forward).ok_or_else(|| "expected FIRST..LAST, such as 0..99, 10.., ..5 or 7".to_owned())
}

impl Convert {
    pub fn execute(&self) -> Result<(), Failure> {
        let source = super::trajectory_of(&self.run)?;
        let target = self.out.clone().unwrap_or_else(|| self.to.target_beside(&source));
        refuse_input(&target, super::files_beside(&source))?;
        let (first, last) = self.frames.unwrap_or((0, None));
        let done = convert(&source, self.to, &target, &Options { first, last, replace: self.force })?;
        let cut = if done.is_truncated { "; the trajectory ends within the next one, which is left out" } else { "" };
        super::print(&format!("{}: {}{cut}\n", target.display(), plural(done.frames, "frame")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_ranges_are_parsed() {
        assert_eq!(frames("3..7"), Ok((3, Some(7))));
        assert_eq!(frames("3.."), Ok((3, None)));
        assert_eq!(frames("..7"), Ok((0, Some(7))));
        assert_eq!(frames("3"), Ok((3, Some(3))));
        for bad in ["", "..", "7..3", "-1..3", "1..2..3", "a..b", "1.5"] {
            assert!(frames(bad).is_err(), "{bad}");
        }
    }
}

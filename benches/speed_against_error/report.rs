//! The report on all measurements.

use super::{FOLDER, Outcome, SECTIONS};

const OPENING: &str = "# Speed against error

What accuracy a speed comes with, for Carom and for what one would use instead. Made by

    cargo bench --bench speed_against_error

and redrawn by `cargo bench --bench speed_against_error -- report`. Reduced units. Times are processor times of one thread;
machine, compiler and date stand at each table. The numbers behind the plots are the csv files in `speed_against_error/`.
";

/// Writes the Markdown file and the plots of all measured sections.
pub fn write() -> Outcome {
    let mut text = OPENING.to_owned();
    for section in &SECTIONS {
        (section.describe)(&mut text)?;
    }
    Ok(std::fs::write(format!("{FOLDER}.md"), text)?)
}

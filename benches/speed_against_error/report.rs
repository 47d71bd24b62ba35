use super::{FOLDER, Outcome, SECTIONS};

const OPENING: &str = "# Speed against error

This page shows the accuracy that Carom and the usual alternatives reach at a given speed. Made by

    cargo bench --bench speed_against_error

The numbers behind the plots are in the csv files in `speed_against_error/`, from which `cargo bench --bench speed_against_error -- report`
writes this page again. All quantities are in reduced units. Times are processor times of one thread. The machine, the compiler and the date
are given with each table.
";

pub fn write() -> Outcome {
    let mut text = OPENING.to_owned();
    for section in &SECTIONS {
        (section.describe)(&mut text)?;
    }
    Ok(std::fs::write(format!("{FOLDER}.md"), text)?)
}

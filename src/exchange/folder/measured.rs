//! Results of the instruments of an exchange. The file has the format of a run with a stage for each temperature.

use crate::analysis::instruments::Measured;
use crate::exchange::TemperatureResult;
use crate::exchange::results::ExchangeResults;
use crate::io::measurements::TABLES;
use crate::io::{Measurements, StageMeasured};

fn name_of(number: usize) -> String {
    format!("temperature-{number}")
}

pub(super) fn folders(temperatures: usize) -> impl Iterator<Item = String> {
    let each = (1..=temperatures).map(|number| format!("{TABLES}/{}/", name_of(number)));
    std::iter::once(format!("{TABLES}/")).chain(each)
}

pub(super) fn measurements(results: &ExchangeResults) -> Measurements {
    let of_temperature = |(at, number): (&TemperatureResult, usize)| StageMeasured {
        name: name_of(number),
        measured: at.measured.clone(),
    };
    let all: Vec<StageMeasured> = results.temperatures.iter().zip(1..).map(of_temperature).collect();
    let has_any = all.iter().any(|it| it.measured != Measured::default());
    Measurements { stages: if has_any { all } else { Vec::new() }, ..Measurements::default() }
}

pub(super) fn read(text: &str, results: &mut ExchangeResults) -> Result<(), String> {
    let read: Measurements = serde_json::from_str(text).map_err(|error| error.to_string())?;
    let [found, expected] = [read.stages.len(), results.temperatures.len()];
    if found != expected {
        return Err(format!("it has {found} temperatures, expected {expected}"));
    }
    results.temperatures.iter_mut().zip(read.stages).for_each(|(at, stage)| at.measured = stage.measured);
    Ok(())
}

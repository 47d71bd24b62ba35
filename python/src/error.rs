//! Converts errors of the library to exceptions of the package. The classes are in `carom._errors`.

use std::error::Error;

use carom::analysis::instruments::InstrumentError;
use carom::base::text::{printable, with_causes};
use carom::engine::{EngineError, InvariantBroken, NeedsRun};
use carom::exchange::{ExchangeError, ExchangeFolderError, StartError};
use carom::io::convert::ConvertError;
use carom::io::{OutputError, SavedError};
use carom::model::ThermostatError;
use carom::run::{Blocked, Ending, Jam, RunError};
use carom::scene::{SceneError, SceneErrorKind};
use carom::sweep::SweepError;
use carom::view::ViewError;
use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Width of a message in columns. Tracebacks and notebooks do not wrap lines of this width.
const WIDTH: usize = 100;

pub fn exception(class: &str, message: &str, attributes: &[(&str, Option<String>)]) -> PyErr {
    Python::attach(|py| {
        let made = (|| {
            let class = py.import("carom._errors")?.getattr(class)?;
            let keywords = PyDict::new(py);
            for (name, value) in attributes {
                keywords.set_item(name, value)?;
            }
            class.call((printable(message),), Some(&keywords))
        })();
        made.map_or_else(|error| error, PyErr::from_value)
    })
}

pub fn cured(class: &str, message: &str, cure: Option<&str>) -> PyErr {
    let text = cure.map_or_else(|| message.to_owned(), |cure| format!("{message}\n  help: {cure}"));
    exception(class, &text, &[("cure", cure.map(str::to_owned))])
}

pub fn scene(error: &SceneError) -> PyErr {
    let mut text = String::new();
    let handler = GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor()).with_width(WIDTH);
    if handler.render_report(&mut text, error).is_err() {
        text = with_causes(error);
    }
    let known = error.config_path().to_string();
    let missing = match error.kind() {
        SceneErrorKind::Missing { key, .. } if known.is_empty() => Some((*key).to_owned()),
        SceneErrorKind::Missing { key, .. } => Some(format!("{known}.{key}")),
        _ => None,
    };
    let key = if known.is_empty() { key_of(error) } else { Some(known) };
    exception(
        "SceneError",
        text.trim_end(),
        &[
            ("problem", Some(with_causes(error))),
            ("key", key),
            ("missing", missing),
            ("line", error.line().map(|line| line.to_string())),
            ("cure", error.help().map(|help| help.to_string())),
        ],
    )
}

/// Returns the key in which TOML or serde found an error, if any.
fn key_of(error: &SceneError) -> Option<String> {
    let label = error.labels()?.next()?;
    let code = error.source_code()?.read_span(label.inner(), usize::MAX, usize::MAX).ok()?;
    let text = std::str::from_utf8(code.data()).ok()?;
    // The source named `override` is not a TOML file. It is the text `key = value` of an override.
    if code.name() == Some("override") {
        let mut steps = text.split_once('=')?.0.split('.').map(str::trim);
        let first = steps.next()?.to_owned();
        return Some(steps.fold(first, |path, step| match step.parse::<usize>() {
            Ok(index) => format!("{path}[{index}]"),
            Err(_) => format!("{path}.{step}"),
        }));
    }
    key_in(DeTable::parse(text).ok()?.get_ref(), "", label.offset())
}

/// Path of the innermost key in a table at the position `at` in the text.
fn key_in(table: &DeTable<'_>, path: &str, at: usize) -> Option<String> {
    table.iter().find_map(|(key, value)| {
        let name = key.get_ref();
        let path = if path.is_empty() { name.to_string() } else { format!("{path}.{name}") };
        let inner = key_within(value, &path, at);
        inner.or_else(|| (key.span().contains(&at) || value.span().contains(&at)).then_some(path))
    })
}

/// Path of the innermost key in a value at the position `at` in the text.
fn key_within(value: &Spanned<DeValue<'_>>, path: &str, at: usize) -> Option<String> {
    match value.get_ref() {
        DeValue::Table(table) => key_in(table, path, at),
        DeValue::Array(array) => array.iter().enumerate().find_map(|(index, value)| {
            let path = format!("{path}[{index}]");
            key_within(value, &path, at).or_else(|| value.span().contains(&at).then_some(path))
        }),
        _ => None,
    }
}

pub fn output(error: &OutputError) -> PyErr {
    match error {
        OutputError::Instrument(error) => instrument(error),
        error => cured("FolderError", &with_causes(error), error.cure()),
    }
}

/// The user's functions differ from the functions at the start of the run.
fn instrument(error: &InstrumentError) -> PyErr {
    cured("SimulationError", &error.to_string(), Some("pass observe with the same names as at the start of the run"))
}

pub fn saved(error: &SavedError) -> PyErr {
    cured("FolderError", &with_causes(error), Some(error.cure()))
}

pub fn thermostat(error: &ThermostatError) -> PyErr {
    PyValueError::new_err(error.to_string())
}

pub fn engine(error: &EngineError) -> PyErr {
    let cure = match error {
        EngineError::Arrest(arrest) => Some(arrest.cure()),
        EngineError::InvariantBroken(_) => Some(InvariantBroken::CURE),
        _ => None,
    };
    cured("SimulationError", &error.to_string(), cure)
}

pub fn needs_run(error: &NeedsRun) -> PyErr {
    let what = match error {
        NeedsRun::Stage { name } => format!("the scene has the stage `{name}`"),
        NeedsRun::Equilibration => "the scene has an equilibration".to_owned(),
        NeedsRun::Rescaling => "the scene has a thermostat that scales velocities".to_owned(),
        NeedsRun::Barostat => "the scene has a barostat that changes the volume".to_owned(),
        NeedsRun::Swap => "the scene has swap moves".to_owned(),
        NeedsRun::Exchange => "the scene has [exchange] with several replicas".to_owned(),
        _ => error.to_string(),
    };
    let cure = match error {
        NeedsRun::Exchange => "use carom.exchange, or Simulation(scene, plan=False) for the dynamics alone",
        NeedsRun::Rescaling => "use carom.run, or Simulation(scene, plan=False) and its rescale",
        NeedsRun::Barostat | NeedsRun::Swap => "use carom.run, or Simulation(scene, plan=False) for the dynamics alone",
        _ => {
            "use carom.run; or Simulation.prepared(scene), which starts at the measurement; or Simulation(scene, plan=False) for the dynamics alone"
        }
    };
    let text = format!("{what}, which carom.Simulation(scene) does not carry out\n  help: {cure}");
    exception("SceneError", &text, &[("problem", Some(what)), ("cure", Some(cure.to_owned()))])
}

pub fn run(error: &RunError<OutputError>) -> PyErr {
    match error {
        RunError::Recorder(error) => output(error),
        RunError::Instrument(error) => instrument(error),
        error => cured("SimulationError", &with_causes(error), None),
    }
}

/// The simulation ended before the measurement.
pub fn unprepared(ending: &Ending) -> PyErr {
    let why = ending.trouble().unwrap_or_else(|| "no events are left, and the measurement has not begun".to_owned());
    let cure = match ending {
        Ending::Arrested(arrest) => Some(arrest.cure()),
        Ending::Broken(_) => Some(InvariantBroken::CURE),
        Ending::Jammed(_) => Some(Jam::CURE),
        Ending::Blocked(_) => Some(Blocked::CURE),
        _ => None,
    };
    cured("SimulationError", &why, cure)
}

pub fn sweep(error: &SweepError) -> PyErr {
    match error {
        SweepError::Scene(error) => scene(error),
        SweepError::Output(error) => output(error),
        error => cured("SweepError", &with_causes(error), error.cure()),
    }
}

pub fn exchange_folder(error: &ExchangeFolderError) -> PyErr {
    match error {
        ExchangeFolderError::Start(error) => exchange_start(error),
        error => cured("FolderError", &with_causes(error), error.cure()),
    }
}

pub fn exchange_start(error: &StartError) -> PyErr {
    cured("SceneError", &with_causes(error), None)
}

pub fn exchange(error: &ExchangeError<OutputError>) -> PyErr {
    match error {
        ExchangeError::Recorder(error) => output(error),
        ExchangeError::Engine { source, .. } => engine(source),
        ExchangeError::NoOverlap => {
            cured("SimulationError", &with_causes(error), Some(ExchangeError::<OutputError>::NO_OVERLAP_CURE))
        }
        ExchangeError::OutsideOfWindow { .. } => {
            cured("SimulationError", &with_causes(error), Some(ExchangeError::<OutputError>::OUTSIDE_OF_WINDOW_CURE))
        }
        error => cured("SimulationError", &with_causes(error), None),
    }
}

pub fn report(error: &ViewError) -> PyErr {
    cured("FolderError", &with_causes(error), error.cure())
}

pub fn convert(error: &ConvertError) -> PyErr {
    cured("FolderError", &with_causes(error), error.cure())
}

pub fn unreadable(path: &std::path::Path, error: &(dyn Error + 'static)) -> PyErr {
    cured("FolderError", &format!("cannot read {}: {}", path.display(), with_causes(error)), None)
}

pub fn busy(what: &str) -> PyErr {
    PyRuntimeError::new_err(format!("{what} is advancing in another thread; wait for it, or give each thread a copy"))
}

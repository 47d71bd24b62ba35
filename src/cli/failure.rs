use std::error::Error;
use std::fmt;
use std::io::{self, Write};

use crate::base::text::{printable, with_causes};
use crate::engine::{EngineError, InvariantBroken};
use crate::exchange::{ExchangeError, ExchangeFolderError};
use crate::io::OutputError;
use crate::io::convert::ConvertError;
use crate::run::RunError;
use crate::scene::SceneError;
use crate::sweep::SweepError;
use crate::view::ViewError;
use miette::{Diagnostic, Report};

/// The reason for an exit code other than 0.
#[derive(Debug)]
pub struct Failure {
    report: Report,
    code: u8,
}

const FAILED: u8 = 1;
const BAD_INPUT: u8 = 2;

impl Failure {
    /// Returns a failure of a command whose input was valid.
    pub fn failed(message: impl Into<String>, help: Option<&str>) -> Self {
        Self::new(message, help, FAILED)
    }

    /// Returns a failure of a command whose input was invalid.
    pub fn bad_input(message: impl Into<String>, help: Option<&str>) -> Self {
        Self::new(message, help, BAD_INPUT)
    }

    /// Returns the failure of a command whose audit found faults.
    pub fn of_audit(faults: &[String]) -> Self {
        let help = "the results cannot be trusted; this is a bug in Carom: please report the scene";
        Self::failed(format!("the audit failed: {}", faults.join("; ")), Some(help))
    }

    fn new(message: impl Into<String>, help: Option<&str>, code: u8) -> Self {
        // Messages contain text from the user and from files, so control characters are replaced.
        let message = printable(&message.into()).into_owned();
        Self { report: Report::new(Problem { message, help: help.map(str::to_owned) }), code }
    }

    /// Returns the error message.
    #[must_use]
    pub fn message(&self) -> String {
        self.report.to_string()
    }

    /// Returns advice, if there is any.
    #[must_use]
    pub fn cure(&self) -> Option<String> {
        self.report.help().map(|help| help.to_string())
    }

    /// Prints the failure on standard error, and returns the exit code.
    pub fn report(&self) -> u8 {
        // If standard error is closed, the exit code still reports the failure.
        let _ = writeln!(std::io::stderr().lock(), "{:?}", self.report);
        self.code
    }
}

/// Returns the exit code for an error in writing a file. A bad path is bad input; other errors are failures.
fn code_of(error: &io::Error) -> u8 {
    use io::ErrorKind::{
        InvalidFilename, InvalidInput, IsADirectory, NotADirectory, NotFound, PermissionDenied, ReadOnlyFilesystem,
    };
    match error.kind() {
        NotFound | PermissionDenied | NotADirectory | IsADirectory | ReadOnlyFilesystem | InvalidFilename
        | InvalidInput => BAD_INPUT,
        _ => FAILED,
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Self { report: Report::new(error), code: BAD_INPUT }
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        let code = match error {
            // A part of the path can only be missing if it was deleted during the run.
            OutputError::Write { ref source, .. } if source.kind() != io::ErrorKind::NotFound => code_of(source),
            OutputError::Write { .. }
            | OutputError::Frame { .. }
            | OutputError::TooMuch { .. }
            | OutputError::Convert(_) => FAILED,
            _ => BAD_INPUT,
        };
        Self::new(with_causes(&error), error.cure(), code)
    }
}

impl From<SweepError> for Failure {
    fn from(error: SweepError) -> Self {
        match error {
            SweepError::Scene(error) => error.into(),
            SweepError::Output(error) => error.into(),
            error => Self::new(with_causes(&error), error.cure(), BAD_INPUT),
        }
    }
}

impl From<ExchangeFolderError> for Failure {
    fn from(error: ExchangeFolderError) -> Self {
        match error {
            ExchangeFolderError::Output(OutputError::Busy(path)) => {
                let message = format!("another process runs the exchange in {}", path.display());
                Self::bad_input(message, Some("wait for it, or choose another folder with --out"))
            }
            // The advice about a damaged checkpoint is different for a run.
            error @ ExchangeFolderError::Output(OutputError::Checkpoint(_)) => {
                Self::bad_input(with_causes(&error), error.cure())
            }
            ExchangeFolderError::Output(error) => error.into(),
            error => Self::bad_input(with_causes(&error), error.cure()),
        }
    }
}

impl From<ExchangeError<OutputError>> for Failure {
    fn from(error: ExchangeError<OutputError>) -> Self {
        match error {
            ExchangeError::Recorder(error) => error.into(),
            ExchangeError::NoOverlap => {
                Self::failed(error.to_string(), Some(ExchangeError::<OutputError>::NO_OVERLAP_CURE))
            }
            ExchangeError::OutsideOfWindow { .. } => {
                Self::failed(error.to_string(), Some(ExchangeError::<OutputError>::OUTSIDE_OF_WINDOW_CURE))
            }
            ExchangeError::Engine { ref source, .. } => {
                let cure = match source {
                    EngineError::Arrest(arrest) => Some(arrest.cure()),
                    EngineError::InvariantBroken(_) => Some(InvariantBroken::CURE),
                };
                Self::failed(error.to_string(), cure)
            }
        }
    }
}

impl From<RunError<OutputError>> for Failure {
    fn from(error: RunError<OutputError>) -> Self {
        match error {
            RunError::Recorder(error) => error.into(),
            error => {
                let cure = "continue with the program that started the run and defines its instruments";
                Self::bad_input(error.to_string(), Some(cure))
            }
        }
    }
}

impl From<ViewError> for Failure {
    fn from(error: ViewError) -> Self {
        let code = match error {
            ViewError::Write { ref source, .. } => code_of(source),
            ViewError::Ffmpeg(_) | ViewError::Threads | ViewError::Interrupted => FAILED,
            _ => BAD_INPUT,
        };
        Self::new(with_causes(&error), error.cure(), code)
    }
}

impl From<ConvertError> for Failure {
    fn from(error: ConvertError) -> Self {
        let code = if let ConvertError::Write { source, .. } = &error { code_of(source) } else { BAD_INPUT };
        Self::new(with_causes(&error), error.cure(), code)
    }
}

#[derive(Debug)]
struct Problem {
    message: String,
    help: Option<String>,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl Error for Problem {}

impl Diagnostic for Problem {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.help.as_ref().map(|help| Box::new(help) as Box<dyn fmt::Display>)
    }
}

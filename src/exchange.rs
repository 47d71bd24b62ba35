//! Replica exchange: replicas of a scene at several temperatures that are swapped now and then (parallel tempering).
mod averages;
mod error;
mod execute;
mod populations;
mod replicas;
mod results;
mod walk;

pub use error::{ExchangeError, ExchangeFolderError, StartError};
pub use execute::ExchangeRecorder;
pub use replicas::{Exchange, ExchangeRow};
pub use results::{ExchangeResults, Measured, Neighbours, Population, TemperatureResult};

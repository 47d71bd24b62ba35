//! The program, as its users meet it.

mod commands;
mod endings;
mod exchange;
mod inputs;
mod kept;
mod memory;
mod movie;
mod names;
mod normalisation;
mod place;
mod replaced;
mod run;
mod stages;
mod start;
mod sweep;
mod sweep_inputs;

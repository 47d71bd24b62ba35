//! The program, as its users meet it.

mod commands;
mod endings;
mod kept;
mod memory;
mod place;
mod run;

//! The program, as its users meet it.

mod commands;
mod endings;
mod kept;
mod place;
mod run;

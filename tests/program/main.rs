//! The program, as its users meet it.

mod commands;
mod endings;
mod place;
mod run;

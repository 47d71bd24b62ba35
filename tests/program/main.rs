//! The program, as its users meet it.

mod commands;
mod damaged;
mod drafts;
mod endings;
mod exchange;
mod exchange_resumed;
mod files;
mod inputs;
mod kept;
mod links;
mod live;
mod memory;
mod meshes;
mod motions;
mod movie;
mod names;
mod normalisation;
mod outputs;
mod place;
mod replaced;
mod run;
mod stages;
mod start;
mod sweep;
mod sweep_inputs;
mod threads;

//! `carom new`: scenes to start from. They are those of `configs/`, which the tests run.

use clap::Args;

use super::failure::Failure;
use super::{Choice, one_of};

/// Prints a commented scene to start from
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  carom new hopper > hopper.toml && carom run hopper.toml")]
pub struct New {
    /// Kind of scene
    #[arg(value_parser = one_of(&SCENES))]
    kind: &'static str,
}

const SCENES: [Choice<&str>; 15] = [
    ("fluid", Some("Hard spheres in a periodic box"), include_str!("../../configs/hard_sphere_fluid.toml")),
    (
        "equation-of-state",
        Some("Hard spheres with pressure, structure and diffusion measured"),
        include_str!("../../configs/equation_of_state.toml"),
    ),
    ("well", Some("A square-well fluid"), include_str!("../../configs/square_well_fluid.toml")),
    (
        "well-law",
        Some("A square-well fluid in a heat bath, with its events counted by kind"),
        include_str!("../../configs/square_well_law.toml"),
    ),
    (
        "lennard-jones",
        Some("A Lennard-Jones liquid in steps"),
        include_str!("../../configs/stepped_lennard_jones.toml"),
    ),
    ("hopper", Some("Grains that run out of a hopper of static spheres"), include_str!("../../configs/hopper.toml")),
    (
        "pendulum",
        Some("A chain of bonded beads with a bob, under gravity"),
        include_str!("../../configs/pendulum.toml"),
    ),
    ("polymer", Some("Bonded chains that attract each other"), include_str!("../../configs/polymer.toml")),
    ("granular", Some("A granular gas that cools"), include_str!("../../configs/granular_cooling.toml")),
    ("shear", Some("A granular gas in steady shear"), include_str!("../../configs/sheared_granular_gas.toml")),
    ("packing", Some("Spheres that grow into a random packing"), include_str!("../../configs/random_packing.toml")),
    ("ball", Some("A ball that bounces until it rests"), include_str!("../../configs/bouncing_ball.toml")),
    (
        "maxwell",
        Some("Disks of equal speeds, whose distribution becomes Maxwell's"),
        include_str!("../../configs/maxwell.toml"),
    ),
    ("brownian", Some("A large disk among small ones"), include_str!("../../configs/brownian.toml")),
    ("cradle", Some("Newton's cradle: five balls on strings"), include_str!("../../configs/cradle.toml")),
];

impl New {
    pub fn execute(&self) -> Result<(), Failure> {
        super::print(self.kind)
    }
}

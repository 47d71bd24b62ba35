//! `carom new`: scenes to start from. They are those of `configs/`, which the tests run.

use clap::{Args, ValueEnum};

use super::failure::Failure;

/// Prints a commented scene to start from
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  carom new hopper > hopper.toml && carom run hopper.toml")]
pub struct New {
    /// Kind of scene
    kind: Kind,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// Hard spheres in a periodic box
    Fluid,
    /// Hard spheres with pressure, structure and diffusion measured
    EquationOfState,
    /// A square-well fluid
    Well,
    /// A square-well fluid in a heat bath, with its events counted by kind
    WellLaw,
    /// A Lennard-Jones liquid in steps
    LennardJones,
    /// Grains that run out of a hopper of static spheres
    Hopper,
    /// A chain of bonded beads with a bob, under gravity
    Pendulum,
    /// Bonded chains that attract each other
    Polymer,
    /// A granular gas that cools
    Granular,
    /// A granular gas in steady shear
    Shear,
    /// Spheres that grow into a random packing
    Packing,
    /// A ball that bounces until it rests
    Ball,
    /// Disks of equal speeds, whose distribution becomes Maxwell's
    Maxwell,
    /// A large disk among small ones
    Brownian,
    /// Newton's cradle: five balls on strings
    Cradle,
}

impl Kind {
    fn text(self) -> &'static str {
        match self {
            Self::Fluid => include_str!("../../configs/hard_sphere_fluid.toml"),
            Self::EquationOfState => include_str!("../../configs/equation_of_state.toml"),
            Self::WellLaw => include_str!("../../configs/square_well_law.toml"),
            Self::Well => include_str!("../../configs/square_well_fluid.toml"),
            Self::LennardJones => include_str!("../../configs/stepped_lennard_jones.toml"),
            Self::Hopper => include_str!("../../configs/hopper.toml"),
            Self::Pendulum => include_str!("../../configs/pendulum.toml"),
            Self::Polymer => include_str!("../../configs/polymer.toml"),
            Self::Granular => include_str!("../../configs/granular_cooling.toml"),
            Self::Shear => include_str!("../../configs/sheared_granular_gas.toml"),
            Self::Packing => include_str!("../../configs/random_packing.toml"),
            Self::Ball => include_str!("../../configs/bouncing_ball.toml"),
            Self::Maxwell => include_str!("../../configs/maxwell.toml"),
            Self::Brownian => include_str!("../../configs/brownian.toml"),
            Self::Cradle => include_str!("../../configs/cradle.toml"),
        }
    }
}

impl New {
    pub fn execute(&self) -> Result<(), Failure> {
        super::print(self.kind.text())
    }
}

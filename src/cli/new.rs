//! Templates of scenes for `carom new`. Most of them are files in `configs/`, which the tests run.

use clap::Args;

use super::failure::Failure;
use super::{Choice, one_of};

/// Returns the name and the text of each template.
pub fn scenes() -> impl Iterator<Item = (&'static str, &'static str)> {
    SCENES.iter().map(|(kind, _, text)| (*kind, *text))
}

/// Prints a commented template of a scene
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  carom new hopper > hopper.toml && carom run hopper.toml")]
pub struct New {
    /// Kind of scene; without it, lists all kinds
    #[arg(value_parser = one_of(&SCENES))]
    kind: Option<&'static str>,
}

const SCENES: [Choice<&str>; 28] = [
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
        Some("A Lennard-Jones liquid with a stepped potential"),
        include_str!("../../configs/stepped_lennard_jones.toml"),
    ),
    ("hopper", Some("Grains that flow out of a hopper of static spheres"), include_str!("../../configs/hopper.toml")),
    (
        "pendulum",
        Some("A chain of bonded beads with a bob, under gravity"),
        include_str!("../../configs/pendulum.toml"),
    ),
    ("polymer", Some("Bonded chains that attract each other"), include_str!("../../configs/polymer.toml")),
    ("granular", Some("A granular gas that cools"), include_str!("../../configs/granular_cooling.toml")),
    ("shear", Some("A granular gas in steady shear"), include_str!("../../configs/sheared_granular_gas.toml")),
    ("packing", Some("Spheres that grow into a random packing"), include_str!("../../configs/random_packing.toml")),
    ("ball", Some("A ball that bounces until it comes to rest"), include_str!("../../configs/bouncing_ball.toml")),
    (
        "maxwell",
        Some("Disks of equal speed that relax to Maxwell's distribution"),
        include_str!("../../configs/maxwell.toml"),
    ),
    ("brownian", Some("A large disk among small ones"), include_str!("../../configs/brownian.toml")),
    ("cradle", Some("Newton's cradle: five balls on strings"), include_str!("../../configs/cradle.toml")),
    ("anneal", Some("A square-well fluid that is cooled in steps"), include_str!("../../configs/anneal.toml")),
    (
        "exchange",
        Some("Replicas of a chain at several temperatures, for carom exchange"),
        include_str!("new/exchange.toml"),
    ),
    (
        "constant-pressure",
        Some("Hard spheres whose volume changes at constant pressure"),
        include_str!("../../configs/isobaric_fluid.toml"),
    ),
    (
        "free-energy",
        Some("Two large spheres among small ones, in windows of the distance between them, for carom exchange"),
        include_str!("../../configs/depletion.toml"),
    ),
    (
        "sweep",
        Some("The equation of state of hard spheres, for carom sweep with --vary fill.0.packing_fraction=0.1..0.4/4"),
        include_str!("../../configs/equation_of_state.toml"),
    ),
    ("live", Some("Disks with sliders, for carom live"), include_str!("../../configs/maxwell.toml")),
    ("outlet", Some("Grains that flow out of a silo with smooth walls"), include_str!("../../configs/outlet.toml")),
    ("funnel", Some("Grains of three sizes in a smooth funnel"), include_str!("../../configs/funnel.toml")),
    ("piston", Some("A gas below a moving piston"), include_str!("../../configs/piston.toml")),
    ("drum", Some("Rough grains in a rotating drum"), include_str!("../../configs/rotating_drum.toml")),
    ("conveyor", Some("Rough grains on a belt"), include_str!("../../configs/conveyor.toml")),
    ("shaker", Some("Grains in a box that vibrates"), include_str!("../../configs/vibrated_box.toml")),
    ("heat-flux", Some("A gas between a warm wall and a cold one"), include_str!("../../configs/heat_flux.toml")),
];

impl New {
    pub fn execute(&self) -> Result<(), Failure> {
        let Some(text) = self.kind else {
            let widest = SCENES.iter().map(|(kind, ..)| kind.len()).max().unwrap_or(0);
            let line = |(kind, about, _): &Choice<&str>| format!("\n  {kind:widest$}  {}", about.unwrap_or_default());
            let list: String = SCENES.iter().map(line).collect();
            return super::print(&format!(
                "Kinds of scenes:{list}\n\n`carom new hopper > hopper.toml` writes one of them\n"
            ));
        };
        super::print(text)
    }
}

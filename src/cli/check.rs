//! `carom check`.

use clap::Args;

use super::SceneArgs;
use super::failure::Failure;

/// Says in words what will be simulated, and finds what is wrong
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  carom check hopper.toml --set mesh.funnel.spacing=2.5")]
pub struct Check {
    #[command(flatten)]
    scene: SceneArgs,
}

impl Check {
    pub fn execute(&self) -> Result<(), Failure> {
        let scene = self.scene.load()?;
        super::print(&format!("{}\n", super::describe::population(&scene)))
    }
}

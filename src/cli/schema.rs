use clap::Args;

use super::failure::Failure;

const HELP: &str = "\
Example:
  carom schema > scene.schema.json

First line of a scene in the same folder:

  #:schema scene.schema.json

Editors with Taplo (Even Better TOML in VS Code) then complete, explain and check the keys.";

/// Prints the JSON Schema of scene files, for completion and checks in editors
#[derive(Debug, Args)]
#[command(after_help = HELP)]
pub struct Schema {}

impl Schema {
    pub fn execute(&self) -> Result<(), Failure> {
        super::print(&(crate::scene::schema() + "\n"))
    }
}

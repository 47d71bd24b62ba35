//! `carom completions` and `carom man`: shell completions and manual pages.

use clap::{Args, CommandFactory};
use clap_complete::Shell;
use clap_mangen::Man;

use super::failure::Failure;
use super::{Choice, Cli, one_of};

const SHELLS: [Choice<Shell>; 5] = [
    ("bash", None, Shell::Bash),
    ("elvish", None, Shell::Elvish),
    ("fish", None, Shell::Fish),
    ("powershell", None, Shell::PowerShell),
    ("zsh", None, Shell::Zsh),
];

/// Prints a shell script that completes commands and options
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  carom completions bash > ~/.local/share/bash-completion/completions/carom
  carom completions zsh > ~/.zfunc/_carom                                       with ~/.zfunc in fpath
  carom completions fish > ~/.config/fish/completions/carom.fish")]
pub struct Completions {
    /// The shell
    #[arg(value_parser = one_of(&SHELLS))]
    shell: Shell,
}

impl Completions {
    pub fn execute(&self) -> Result<(), Failure> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut Cli::command(), "carom", &mut script);
        super::print(&String::from_utf8_lossy(&script))
    }
}

/// Prints the manual page of the program, or of one of its commands
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  carom man > ~/.local/share/man/man1/carom.1
  carom man run > ~/.local/share/man/man1/carom-run.1")]
pub struct Manual {
    /// The command, such as run; without it, prints the page of the program
    command: Option<String>,
}

impl Manual {
    pub fn execute(&self) -> Result<(), Failure> {
        let mut cli = Cli::command();
        // `build` sets the full names of the commands, such as `carom run`.
        cli.build();
        let page = match &self.command {
            None => Some(cli),
            Some(name) => cli.find_subcommand(name).cloned(),
        };
        let Some(page) = page else {
            let name = self.command.as_deref().unwrap_or_default();
            return Err(Failure::bad_input(format!("there is no command `{name}`"), Some("carom --help lists them")));
        };
        let mut text = Vec::new();
        let rendered = Man::new(page).render(&mut text);
        rendered.map_err(|error| Failure::failed(format!("the manual page cannot be made: {error}"), None))?;
        super::print(&String::from_utf8_lossy(&text))
    }
}

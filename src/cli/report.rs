use std::path::PathBuf;

use crate::exchange::ExchangeFolder;
use crate::io::{Folder, refuse_input, refuse_link};
use crate::sweep::SweepFolder;
use crate::view::report;
use clap::Args;

use super::failure::Failure;

/// Writes a page about a run for a browser: results, audit, plots and the moving particles
#[derive(Debug, Args)]
#[command(after_help = "\
The page is a single file that needs no network. It can be sent or archived.

Example:
  carom report runs/hopper --out hopper.html")]
pub struct Report {
    /// The folder of a run, or of a replica exchange
    run: PathBuf,
    /// The file to write; by default report.html in the folder of the run
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Replaces an existing file
    #[arg(long)]
    force: bool,
}

impl Report {
    pub fn execute(&self) -> Result<(), Failure> {
        if ExchangeFolder::is_one(&self.run) {
            return self.of_exchange();
        }
        if SweepFolder::existing(&self.run).is_ok() {
            let folder = self.run.display();
            let help = format!(
                "its page is {folder}/sweep.html, which carom sweep {folder} writes again; for the page of a run: carom report {folder}/RUN"
            );
            return Err(Failure::bad_input(format!("{folder} is the folder of a sweep"), Some(&help)));
        }
        let out = self.place(self.run.join("report.html"))?;
        refuse_input(&out, Folder::files_of(&self.run))?;
        let page = report::page(&self.run)?;
        report::write(&page, &out, super::existing(self.force))?;
        for note in &page.notes {
            super::warn(&format!("note: {note}"));
        }
        super::print(&format!("{}\n", out.display()))
    }

    /// The default file must not be a link.
    fn place(&self, default: PathBuf) -> Result<PathBuf, Failure> {
        if let Some(out) = &self.out {
            return Ok(out.clone());
        }
        refuse_link(&default)?;
        Ok(default)
    }

    fn of_exchange(&self) -> Result<(), Failure> {
        let page = report::exchange_page(&self.run)?;
        let out = self.place(report::exchange_page_in(&self.run))?;
        refuse_input(&out, ExchangeFolder::files_of(&self.run))?;
        report::write(&page, &out, super::existing(self.force))?;
        super::print(&format!("{}\n", out.display()))
    }
}

//! The page of a run for a browser: the scene, the audit, the results, and the moving particles.
//!
//! The page is one file without external references, and needs no network. Only `summary.json` is required. The page
//! names other files that are missing or damaged.
//!
//! ```no_run
//! use carom::io::Existing;
//! use carom::view::report;
//!
//! let page = report::page("runs/hopper".as_ref())?;
//! report::write(&page, "hopper.html".as_ref(), Existing::Keep)?;
//! # Ok::<(), carom::view::ViewError>(())
//! ```

mod audit;
pub(super) mod base64;
mod exchange;
mod families;
mod figures;
pub(super) mod html;
mod inputs;
pub(super) mod motion;
mod plot;
pub(super) mod recording;
mod results;
mod setting;
mod stages;
mod sweep;
mod table;
#[cfg(test)]
mod tests;

use std::path::Path;

use super::ViewError;
use crate::analysis::observables::Answer;
use crate::io::atomic::write_atomically;
use crate::io::{Existing, note};

pub use exchange::{exchange_page, exchange_page_in};
pub use sweep::{run_page_in, sweep_page, sweep_page_in, write_run_pages};

use html::escape;

/// A page may run only its own scripts.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";
use inputs::Inputs;

pub(super) const STYLE: &str = include_str!("report/page.css");

const FIGURES: &str = concat!(include_str!("report/save.js"), include_str!("report/figures.js"));

/// Maximum size of a trajectory file for a small page `[bytes]`. The page contains about a third of this size.
const MOST_OF_SMALL: u64 = 3_000_000;

/// HTML report of a run.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Page {
    /// The whole document.
    pub html: String,
    /// Notes on omitted content, with reasons. The page shows the notes.
    pub notes: Vec<String>,
}

/// Makes the page of a run from its files. Memory is limited to two frames and a page of about 40 MB.
///
/// # Errors
/// [`ViewError::NotFolder`] if there is no such folder, [`ViewError::Unreadable`] or [`ViewError::Summary`] if
/// `summary.json` is missing or damaged.
pub fn page(run: &Path) -> Result<Page, ViewError> {
    page_within(run, u64::MAX)
}

/// Makes a small page of a run. A trajectory of more than a few megabytes has no player.
///
/// # Errors
/// The errors of [`page`].
pub fn small_page(run: &Path) -> Result<Page, ViewError> {
    page_within(run, MOST_OF_SMALL)
}

fn page_within(run: &Path, most_bytes: u64) -> Result<Page, ViewError> {
    let inputs = inputs::read(run, most_bytes)?;
    Ok(Page { html: document(&inputs), notes: inputs.notes })
}

/// Writes a page to a file. The file appears once it is complete.
///
/// # Errors
/// [`ViewError::Exists`] if a file exists and must be kept, [`ViewError::Write`] if the file cannot be written.
pub fn write(page: &Page, path: &Path, existing: Existing) -> Result<(), ViewError> {
    let written = write_atomically(path, existing, |file| file.write_all(page.html.as_bytes()));
    written.map_err(ViewError::write(path))?;
    note(path);
    Ok(())
}

fn document(inputs: &Inputs) -> String {
    let summary = &inputs.summary;
    let name = escape(&summary.scene);
    let mut sections = vec![
        ("trajectory", "Trajectory", motion::section(inputs.recording.as_ref())),
        ("results", "Results", results::section(&inputs.last())),
        ("plots", "Plots", figures::section(&inputs.last())),
        ("trust", "Can it be trusted?", audit::section(summary, inputs.scene.as_ref())),
        ("simulated", "What was simulated", setting::section(inputs)),
        ("scene", "The scene", scene(inputs)),
    ];
    if let Some(stages) = stages::section(inputs) {
        sections.insert(1, ("stages", "Measured stages", stages));
    }
    let engine = escape(&summary.engine);
    let verdict = verdict(&summary.faults);
    let state = match summary.equilibrated.verdict {
        Answer::Yes => " <span class=\"verdict sound\">✓ equilibrated</span>",
        Answer::No => " <span class=\"verdict failed\">✗ not equilibrated</span>",
        Answer::Unknown => "",
    };
    let heading = format!(
        "<h1>{name} {verdict}{state}</h1>\n<p class=\"subtitle\">{}</p>\n<p class=\"facts\">seed {} · {engine} · carom {}</p>\n",
        escape(&setting::subtitle(inputs)),
        summary.seed,
        escape(&summary.version),
    );
    shell(&summary.scene, &heading, &notes(&inputs.notes), &sections)
}

fn shell(title: &str, heading: &str, notes: &str, sections: &[(&str, &str, String)]) -> String {
    let links: String = sections.iter().map(|(id, title, _)| format!("<a href=\"#{id}\">{title}</a>\n")).collect();
    let body: String = sections
        .iter()
        .map(|(id, title, body)| format!("<section id=\"{id}\">\n<h2>{title}</h2>\n{body}</section>\n"))
        .collect();
    let body = format!(
        "<header>\n<p class=\"kind\">Event-driven particle dynamics</p>\n{heading}<nav aria-label=\"Sections\">\n{links}</nav>\n\
         </header>\n<main>\n{notes}{body}</main>\n\
         <script>\n\"use strict\";\n(() => {{\n{FIGURES}}})();\n</script>\n",
    );
    html::document(title, POLICY, STYLE, &body)
}

fn notes(notes: &[String]) -> String {
    listed("Notes", "Not everything is on this page:", notes)
}

/// Returns a box with a list, or nothing without items.
fn listed(label: &str, heading: &str, items: &[String]) -> String {
    if items.is_empty() {
        return String::new();
    }
    let items: String = items.iter().map(|item| format!("<li>{}</li>\n", escape(item))).collect();
    format!("<aside class=\"notes\" aria-label=\"{label}\">\n<p>{heading}</p>\n<ul>\n{items}</ul>\n</aside>\n")
}

fn verdict(faults: &[String]) -> &'static str {
    if faults.is_empty() {
        "<span class=\"verdict sound\">✓ audit sound</span>"
    } else {
        "<span class=\"verdict failed\">✗ audit failed</span>"
    }
}

fn scene(inputs: &Inputs) -> String {
    match &inputs.scene_text {
        Some(text) => scene_text("the run can be repeated bit for bit", text),
        None => "<p>The scene of this run was not kept.</p>\n".to_owned(),
    }
}

fn scene_text(what: &str, text: &str) -> String {
    format!(
        "<p>From this text and seed {what}.</p>\n\
         <details>\n<summary>scene.toml</summary>\n<pre><code>{}</code></pre>\n</details>\n",
        escape(text)
    )
}

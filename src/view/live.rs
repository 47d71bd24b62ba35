//! A scene that runs in a browser: a page of its own, which needs no network.
//!
//! The page carries the engine as WebAssembly, the *module* that `web/build` makes, and so the bits of the program. In it a worker runs the scene
//! (`live/worker*.js`, `live/observables*.js`, with the calls of `live/engine.js`), and the page shows it: the picture with the renderer of the player of
//! reports (`live/live*.js`), plots (`live/plots*.js`), sliders and the text of the scene (`live/editor*.js`).

mod head;
mod markdown;
#[cfg(test)]
mod tests;

use std::io::{self, Write};

use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::json;

use super::report::html::{document, escape_json};
use super::report::motion::{RENDERER, SHADERS};
use super::report::{Page, base64};
use crate::model::Scene;
use crate::scene::schema;

pub use head::Shown;

/// Fingerprint of the sources that decide the bits of a run, which a module of the same sources contains.
pub const SOURCES: &str = env!("CAROM_FINGERPRINT");

/// The program of the page, in the order in which it is read, after the renderer of the player.
const PROGRAM: [&str; 24] = [
    include_str!("report/save.js"),
    include_str!("live/plots_axis.js"),
    include_str!("live/plots_figure.js"),
    include_str!("live/plots_frame.js"),
    include_str!("live/plots_kinds.js"),
    include_str!("live/plots_path.js"),
    include_str!("live/plots.js"),
    include_str!("live/editor_completion.js"),
    include_str!("live/editor_history.js"),
    include_str!("live/editor_schema.js"),
    include_str!("live/editor_share.js"),
    include_str!("live/editor_sliders.js"),
    include_str!("live/editor_text.js"),
    include_str!("live/editor_toml.js"),
    include_str!("live/editor.js"),
    include_str!("live/live_controls.js"),
    include_str!("live/live_hand.js"),
    include_str!("live/live_head.js"),
    include_str!("live/live_lines.js"),
    include_str!("live/live_next.js"),
    include_str!("live/live_picture.js"),
    include_str!("live/live_words.js"),
    include_str!("live/live_worker.js"),
    include_str!("live/live.js"),
];

/// The program of the worker.
const WORKER: [&str; 12] = [
    include_str!("live/engine.js"),
    include_str!("live/observables_displacement.js"),
    include_str!("live/observables_pressure.js"),
    include_str!("live/observables_radial.js"),
    include_str!("live/observables_series.js"),
    include_str!("live/observables_speeds.js"),
    include_str!("live/observables_system.js"),
    include_str!("live/observables.js"),
    include_str!("live/worker_frame.js"),
    include_str!("live/worker_neighbours.js"),
    include_str!("live/worker_pace.js"),
    include_str!("live/worker.js"),
];

/// Shaders besides those of the player.
const LINES: [(&str, &str); 2] =
    [("line.vert", include_str!("live/line.vert")), ("line.frag", include_str!("live/line.frag"))];

/// How the page looks, after the style of reports.
const STYLE: [&str; 3] =
    [include_str!("live/live.css"), include_str!("live/editor.css"), include_str!("live/plots.css")];

/// Policy of the page: it runs only what it carries.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline' 'wasm-unsafe-eval' blob:; \
                      worker-src blob:; img-src data: blob:";

/// Page on which a scene runs. `text` is the scene's text, and `module` the engine for it.
#[must_use]
pub fn page(scene: &Scene, text: &str, module: &[u8]) -> Page {
    let mut body = include_str!("live/page.html").to_owned();
    element(&mut body, "application/json", "scene", &escape_json(&description(scene, text)));
    for (name, text) in SHADERS.iter().chain(&LINES) {
        element(&mut body, "text/plain", &format!("shader-{name}"), text);
    }
    element(&mut body, "text/plain", "worker-source", &format!("\"use strict\";\n{}", WORKER.concat()));
    body.push_str("<script type=\"application/octet-stream\" id=\"module\">");
    base64::encode(&compressed(module), &mut body);
    body.push_str("</script>\n");
    let program = RENDERER.concat() + &PROGRAM.concat();
    body.push_str(&format!("<script>\n\"use strict\";\n(() => {{\n{program}}})();\n</script>\n"));
    let style = format!("{}{}", super::report::STYLE, STYLE.concat());
    Page { html: document(scene.name(), POLICY, &style, &body), notes: Vec::new() }
}

fn element(page: &mut String, kind: &str, id: &str, text: &str) {
    page.push_str(&format!("<script type=\"{kind}\" id=\"{id}\">{text}</script>\n"));
}

/// The scene as the page reads it.
fn description(scene: &Scene, text: &str) -> String {
    let live = scene.live();
    let html = live.description.as_deref().map(markdown::html).unwrap_or_default();
    json!({ "name": scene.name(), "text": text, "description": html, "live": live, "schema": schema() }).to_string()
}

/// In gzip, which browsers undo.
fn compressed(module: &[u8]) -> Vec<u8> {
    let mut gzip = GzEncoder::new(Vec::new(), Compression::best());
    // Memory takes all that is written to it.
    let written: io::Result<Vec<u8>> = gzip.write_all(module).and_then(|()| gzip.finish());
    written.unwrap_or_default()
}

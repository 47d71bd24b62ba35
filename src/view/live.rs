//! A self-contained page that runs a scene in a browser without network access.
//!
//! The page contains the engine as WebAssembly, the *module* built by `web/build`, which computes the same bits as the
//! program. A worker runs the scene (`live/worker*.js`, `live/observables*.js`, `live/engine.js`). The page shows the
//! picture (`live/live*.js`), plots (`live/plots*.js`), sliders and the text of the scene (`live/editor*.js`).

mod engine;
mod head;
mod markdown;
mod packed;
mod source;
#[cfg(test)]
mod tests;

use serde_json::{Map, json};

use super::report::html::{document, escape_json};
use super::report::motion::{RENDERER, SHADERS};
use super::report::{Page, base64};
use crate::model::Scene;
use crate::scene::schema_value;

pub use engine::Engine;
pub use head::Shown;
pub use source::Source;

/// Scripts of the page, loaded after the scripts in `RENDERER`.
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

const WORKER: [&str; 13] = [
    include_str!("live/engine.js"),
    include_str!("live/observables_displacement.js"),
    include_str!("live/observables_pressure.js"),
    include_str!("live/observables_radial.js"),
    include_str!("live/observables_series.js"),
    include_str!("live/observables_speeds.js"),
    include_str!("live/observables_system.js"),
    include_str!("live/observables.js"),
    include_str!("live/unpack.js"),
    include_str!("live/worker_frame.js"),
    include_str!("live/worker_neighbours.js"),
    include_str!("live/worker_pace.js"),
    include_str!("live/worker.js"),
];

/// Shaders that the report player does not have.
const LINES: [(&str, &str); 2] =
    [("line.vert", include_str!("live/line.vert")), ("line.frag", include_str!("live/line.frag"))];

const STYLE: [&str; 3] =
    [include_str!("live/live.css"), include_str!("live/editor.css"), include_str!("live/plots.css")];

/// The page may run only its own scripts.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline' 'wasm-unsafe-eval' blob:; \
                      worker-src blob:; img-src data: blob:";

/// Returns a page that runs a scene. `source` contains the scene as text.
#[must_use]
pub fn page(scene: &Scene, source: &Source, engine: Engine) -> Page {
    let mut body = include_str!("live/page.html").to_owned();
    element(&mut body, "application/json", "scene", &escape_json(&description(scene, source)));
    element(&mut body, "application/octet-stream", "scripts", &packed::letters(scripts().as_bytes()));
    let mut module = String::new();
    base64::encode(engine.packed, &mut module);
    element(&mut body, "application/octet-stream", "module", &module);
    body.push_str(&format!("<script>\n\"use strict\";\n{}</script>\n", include_str!("live/boot.js")));
    let style = format!("{}{}", super::report::STYLE, STYLE.concat());
    Page { html: document(scene.name(), POLICY, &style, &body), notes: Vec::new() }
}

fn element(page: &mut String, kind: &str, id: &str, text: &str) {
    page.push_str(&format!("<script type=\"{kind}\" id=\"{id}\">{text}</script>\n"));
}

/// Returns the comment at the start of a scene.
#[must_use]
pub fn first_comment(text: &str) -> String {
    let lines = text.lines().map_while(|line| line.strip_prefix('#'));
    lines.map(|line| line.strip_prefix(' ').unwrap_or(line)).collect::<Vec<_>>().join("\n")
}

/// Returns the script of the page, and the texts that it finds by id.
fn scripts() -> String {
    let mut texts = Map::new();
    for (name, text) in SHADERS.iter().chain(&LINES) {
        texts.insert(format!("shader-{name}"), json!(text));
    }
    texts.insert("schema".to_owned(), json!(schema_value().to_string()));
    texts.insert("worker-source".to_owned(), json!(format!("\"use strict\";\n{}", WORKER.concat())));
    let program = RENDERER.concat() + &PROGRAM.concat();
    json!({ "texts": texts, "program": format!("\"use strict\";\n(() => {{\n{program}}})();\n") }).to_string()
}

fn description(scene: &Scene, source: &Source) -> String {
    let live = scene.live();
    let written = live.description.clone().unwrap_or_else(|| first_comment(&source.text));
    let html = markdown::html(&written);
    json!({
        "name": scene.name(),
        "text": source.text,
        "changes": source.changes,
        "files": source.files(),
        "description": html,
        "live": live,
    })
    .to_string()
}

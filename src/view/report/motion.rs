//! The player of the trajectory.

use super::base64;
use super::html::{escape, escape_json, number};
use super::recording::Recording;

/// Scripts that draw particles and surfaces. Pages that run a scene use the same scripts.
pub(in crate::view) const RENDERER: [&str; 9] = [
    include_str!("player/matrix.js"),
    include_str!("player/colours.js"),
    include_str!("player/camera.js"),
    include_str!("player/surfaces.js"),
    include_str!("player/shapes.js"),
    include_str!("player/images.js"),
    include_str!("player/occlusion.js"),
    include_str!("player/renderer.js"),
    include_str!("player/pointer.js"),
];

const PROGRAM: [&str; 4] = [
    include_str!("player/recording.js"),
    include_str!("player/poses.js"),
    include_str!("player/flight.js"),
    include_str!("player/player.js"),
];

pub(in crate::view) const SHADERS: [(&str, &str); 11] = [
    ("light", include_str!("player/light.glsl")),
    ("sphere.vert", include_str!("player/sphere.vert")),
    ("sphere.frag", include_str!("player/sphere.frag")),
    ("rod.vert", include_str!("player/rod.vert")),
    ("rod.frag", include_str!("player/rod.frag")),
    ("surface.vert", include_str!("player/surface.vert")),
    ("surface.frag", include_str!("player/surface.frag")),
    ("occlusion.vert", include_str!("player/occlusion.vert")),
    ("occlusion.frag", include_str!("player/occlusion.frag")),
    ("edge.vert", include_str!("player/edge.vert")),
    ("edge.frag", include_str!("player/edge.frag")),
];

/// The script of the player adds controls that depend on the data.
const CONTROLS: &str = include_str!("player/controls.html");

/// Size of a text element with frames `[bytes]`. A few large elements open faster than many small ones.
const CHUNK: usize = 1 << 18;

pub(super) fn section(recording: Option<&Recording>) -> String {
    let Some(recording) = recording else {
        return "<p>There is no trajectory to play.</p>\n".to_owned();
    };
    let Ok(head) = serde_json::to_string(&recording.head) else {
        return "<p>The trajectory cannot be shown.</p>\n".to_owned();
    };
    let mut section = format!("{}<p class=\"aside\">{}</p>\n", CONTROLS, escape(&about(recording)));
    section
        .push_str(&format!("<script type=\"application/json\" id=\"player-head\">{}</script>\n", escape_json(&head)));
    data(&mut section, "player-constants", &recording.constants);
    if let Some(surfaces) = &recording.surfaces {
        data(&mut section, "player-surface-data", surfaces);
    }
    let mut chunk = Vec::new();
    let mut number = 0;
    for (index, frame) in recording.frames.iter().enumerate() {
        chunk.extend_from_slice(frame);
        if chunk.len() >= CHUNK || index + 1 == recording.frames.len() {
            data(&mut section, &format!("player-frames-{number}"), &chunk);
            chunk.clear();
            number += 1;
        }
    }
    for (name, text) in SHADERS {
        section.push_str(&format!("<script type=\"text/plain\" id=\"shader-{name}\">{text}</script>\n"));
    }
    let program = RENDERER.concat() + &PROGRAM.concat();
    section.push_str(&format!("<script>\n\"use strict\";\n(() => {{\n{program}}})();\n</script>\n"));
    section
}

fn data(section: &mut String, id: &str, bytes: &[u8]) {
    section.push_str(&format!("<script type=\"application/octet-stream\" id=\"{id}\">"));
    base64::encode(bytes, section);
    section.push_str("</script>\n");
}

fn about(recording: &Recording) -> String {
    let head = &recording.head;
    let (shown, all) = (head.frames.len(), head.frames_in_file);
    let mut text = if shown < all {
        format!("{shown} of the {all} frames of trajectory.xyz, so that the page stays small. ")
    } else {
        format!("All {all} frames of trajectory.xyz. ")
    };
    text.push_str(
        "Between two frames, a particle without an event is drawn on its exact path. The file does not contain the \
         events, so a particle with an event is drawn on a smooth curve, on which it may overlap others. ",
    );
    let step = head.frames.iter().flat_map(|frame| frame.field[1]).fold(0.0, f64::max) / 131_068.0;
    let step = number(&format!("{step:.0e}"));
    text.push_str(&format!("Positions are rounded to 16 bits, by at most {step} along an axis. "));
    if head.periodic.iter().any(|is_periodic| *is_periodic) {
        text.push_str("They are wrapped into the periodic box. ");
    }
    if head.surfaces.is_some() {
        text.push_str(
            "Surfaces are read from the folder surfaces/, and drawn where they are at the time of the frame. ",
        );
    }
    let beyond = head.frames.iter().map(|frame| frame.beyond).max().unwrap_or(0);
    if beyond > 0 {
        text.push_str(&format!(
            "Up to {beyond} particles are more than three box lengths outside the box and are not drawn. "
        ));
    }
    text
}

//! Pages on which a scene runs, and pictures of scenes.

use std::io;

use carom::model::Scene;
use carom::run::Run;
use carom::trajectory::Frame;
use carom::view::Surfaces;
use carom::view::render::{Style, draw_with};
use carom::{Until, mesh};

use crate::Site;
use crate::layout::Page;
use crate::scene::ScenePage;

/// Events after which a picture is taken, or earlier where a third of the time of the scene has passed.
const PICTURE_EVENTS: u64 = 40_000;

/// Width and height of a picture, in pixels.
const PICTURE_SIZE: [u32; 2] = [960, 720];

/// The page on which a scene runs, within the site; nothing where it cannot run in a browser.
pub fn scene_page(_scene: &ScenePage) -> Option<String> {
    None
}

/// The gas of the home page; its address.
#[expect(clippy::unnecessary_wraps, reason = "it writes a page as soon as there is one")]
pub fn write_gas(_site: &Site) -> io::Result<Option<String>> {
    Ok(None)
}

/// The page on which one writes a scene of one's own.
pub fn write_editor(site: &Site) -> io::Result<()> {
    let (address, about) = ("editor.html", "Write a scene and see it run.");
    let body = "<h1>Editor</h1>".to_owned();
    site.write(address, Page { address, title: "Editor", about, aside: String::new(), body }.html().as_bytes())
}

/// Draws a scene some time after its start. False where there is nothing to draw.
pub fn draw(site: &Site, scene: &Scene, address: &str) -> io::Result<bool> {
    let frame = later(scene);
    let meshes: Vec<_> = mesh::shown(scene).map(|(_, mesh)| mesh).collect();
    let style = Style { width: PICTURE_SIZE[0], height: PICTURE_SIZE[1], ..Style::default() };
    let Ok(image) = draw_with(&frame, &Surfaces::of(meshes.iter().map(|mesh| &**mesh)), &style) else {
        return Ok(false);
    };
    let mut bytes = Vec::new();
    image.encode_png(&mut bytes)?;
    site.write(address, &bytes)?;
    Ok(true)
}

/// The particles after some events; those of the start where the scene does not run so far.
fn later(scene: &Scene) -> Frame {
    let mut frame = Frame::start_of(scene);
    let time = scene.run().limit.time.map_or(f64::INFINITY, |time| time / 3.0);
    let Ok((run, _)) = Run::new(scene.clone()).advance(Until { time, events: PICTURE_EVENTS }, &mut ()) else {
        return frame;
    };
    let snapshot = run.simulation().snapshot();
    frame.time = snapshot.time;
    for (particle, (position, velocity)) in
        frame.particles.iter_mut().zip(snapshot.positions.iter().zip(&snapshot.velocities))
    {
        (particle.position, particle.velocity) = (*position, *velocity);
        particle.radius *= snapshot.scale;
    }
    frame
}

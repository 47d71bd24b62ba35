//! Pages that run a scene, and pictures of scenes.

use std::io;

use carom::model::Scene;
use carom::run::Run;
use carom::trajectory::Frame;
use carom::view::Surfaces;
use carom::view::live;
use carom::view::render::{Style, draw_with};
use carom::{Until, Vector, mesh};

use crate::Site;
use crate::layout::{Page, navigation};
use crate::links::{escaped, relative};
use crate::scene::ScenePage;

/// The picture is drawn after this number of events, or after a third of the scene's time limit.
const PICTURE_EVENTS: u64 = 40_000;

const PICTURE_SIZE: [u32; 2] = [960, 720];

/// The scene on the home page and in the editor.
const GAS: &str = "maxwell";

/// Shows only the picture, as large as its frame.
const BARE: &str = "body { padding: 0; } .live { display: block; max-width: none; } .live-head, .live-beside, .live-editor, .live .scale, .live .controls \
                    { display: none !important; } .live .player { border: 0; border-radius: 0; } .live #live-view { height: calc(100vh - 2.6rem); }";

/// Shows the editor beside the picture in wide windows.
const BESIDE: &str = "@media (min-width: 62rem) { .live:has(> .live-editor:not([hidden])) { grid-template-columns: minmax(0, 1fr) minmax(0, 1fr); \
                      max-width: none; } .live > .live-head { grid-column: 1 / -1; } .live > .live-figure { grid-column: 1; position: static; } \
                      .live > .live-editor { grid-column: 2; grid-row: 2 / span 2; } .live > .live-beside { grid-column: 1; } \
                      #live-view { height: 52vh; } }";

/// A page that runs a scene, with additions of the site.
struct Frames<'a> {
    address: &'a str,
    style: &'a str,
    has_navigation: bool,
    /// Content below the scene, in HTML.
    below: String,
}

impl Frames<'_> {
    /// Returns the page, or `None` if the site has no engine.
    fn around(&self, site: &Site, shown: &ScenePage) -> Option<String> {
        let engine = live::Engine::of(site.module.as_ref()?)?;
        let page = live::page(&shown.scene, &shown.live, engine).html;
        let style = if self.has_navigation {
            format!("{}{}", include_str!("site.css"), self.style)
        } else {
            self.style.to_owned()
        };
        let page = page.replacen("</head>", &format!("<style>{style}</style>\n</head>"), 1);
        let top = if self.has_navigation { navigation(self.address) } else { String::new() };
        let page = page.replacen("<body>", &format!("<body class=\"site-live\">\n{top}"), 1);
        Some(page.replacen("</main>", &format!("</main>\n{}", self.below), 1))
    }
}

/// Returns the page of a scene, or `None` for a replica exchange or if the site has no engine.
pub fn scene_page(site: &Site, page: &ScenePage, scenes: &[ScenePage]) -> Option<String> {
    if page.scene.exchange().is_some() {
        return None;
    }
    let address = page.address();
    let place = scenes.iter().position(|scene| scene.name == page.name)?;
    let beside = [place.checked_sub(1), Some(place + 1)].map(|place| place.and_then(|place| scenes.get(place)));
    let link = |scene: &ScenePage| {
        format!("<a href=\"{}\">{}</a>", relative(&address, &scene.address()), escaped(&scene.title))
    };
    let [before, after] = beside.map(|scene| scene.map_or(String::new(), link));
    let below = format!(
        "<nav class=\"site-beside\" aria-label=\"Other scenes\">{before}<a href=\"index.html\">All scenes</a>{after}</nav>"
    );
    Frames { address: &address, style: "", has_navigation: true, below }.around(site, page)
}

/// Writes the page with the gas for the home page. Returns its address, or `None` if the site has no engine.
pub fn write_gas(site: &Site, scenes: &[ScenePage]) -> io::Result<Option<String>> {
    let address = "gas.html";
    let Some(gas) = scenes.iter().find(|scene| scene.name == GAS) else { return Ok(None) };
    let frames = Frames { address, style: BARE, has_navigation: false, below: String::new() };
    let Some(page) = frames.around(site, gas) else { return Ok(None) };
    site.write(address, page.as_bytes())?;
    Ok(Some(address.to_owned()))
}

pub fn write_editor(site: &Site, scenes: &[ScenePage]) -> io::Result<()> {
    let (address, about) = ("editor.html", "Write a scene, see it run, and share it as a link.");
    let frames = Frames { address, style: BESIDE, has_navigation: true, below: String::new() };
    let start = scenes.iter().find(|scene| scene.name == GAS);
    if let Some(page) = start.and_then(|scene| frames.around(site, scene)) {
        return site.write(address, page.as_bytes());
    }
    let body =
        "<h1>Editor</h1>\n<p>This site was made without the engine: <code>web/build</code> makes it.</p>".to_owned();
    site.write(address, Page { address, title: "Editor", about, aside: String::new(), body }.html().as_bytes())
}

/// Draws a scene some time after its start. Returns false if there is nothing to draw.
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

/// Returns the particles after some events, or the initial particles if the run fails or most particles leave the box.
fn later(scene: &Scene) -> Frame {
    let mut frame = Frame::start_of(scene);
    let time = scene.run().limit.time.map_or(f64::INFINITY, |time| time / 3.0);
    let Ok((run, _)) = Run::new(scene.clone()).advance(Until::time(time).or_events(PICTURE_EVENTS), &mut ()) else {
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
    let inside = frame.particles.iter().filter(|particle| is_inside(&frame, particle.position)).count();
    if 2 * inside < frame.particles.len() { Frame::start_of(scene) } else { frame }
}

fn is_inside(frame: &Frame, place: Vector) -> bool {
    (0..3).all(|axis| frame.size[axis] == 0.0 || (0.0..=frame.size[axis]).contains(&(place[axis] - frame.lower[axis])))
}

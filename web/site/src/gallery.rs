//! The home page and the list of all scenes.

use std::io;

use crate::Site;
use crate::layout::Page;
use crate::links::relative;
use crate::live;
use crate::scene::ScenePage;

/// Scenes on the home page.
const CHOSEN: [&str; 8] = [
    "hopper_smooth",
    "maxwell",
    "cradle",
    "granular_cooling",
    "polymer",
    "square_well_fluid",
    "brownian",
    "rotating_drum",
];

pub fn cards<'a>(from: &str, scenes: impl Iterator<Item = &'a ScenePage>) -> String {
    format!("<ul class=\"site-cards\">{}</ul>", scenes.map(|scene| scene.card(from)).collect::<String>())
}

pub fn write(site: &Site, scenes: &[ScenePage]) -> io::Result<()> {
    let address = "scenes/index.html";
    let about = "Scenes of Carom: each shows one idea of physics, and runs in the browser.";
    let body = format!(
        "<h1>Scenes</h1>\n<p>Each shows one idea of physics. It runs on its page, with sliders and its text beside it.</p>\n{}",
        cards(address, scenes.iter())
    );
    site.write(address, Page { address, title: "Scenes", about, aside: String::new(), body }.html().as_bytes())?;
    home(site, scenes)
}

fn home(site: &Site, scenes: &[ScenePage]) -> io::Result<()> {
    let address = "index.html";
    let chosen = CHOSEN.iter().filter_map(|name| scenes.iter().find(|scene| scene.name == *name));
    let gas = match live::write_gas(site, scenes)? {
        Some(place) => {
            format!("<iframe class=\"site-gas\" src=\"{place}\" title=\"A gas of disks that runs\"></iframe>")
        }
        None => {
            scenes.iter().find(|scene| scene.name == "hopper" && scene.has_picture).map_or(String::new(), |scene| {
                format!(
                    "<img class=\"site-gas\" src=\"{}\" alt=\"Grains run out of a hopper\">",
                    relative(address, &scene.picture())
                )
            })
        }
    };
    let body = format!(
        "<section class=\"site-opening\">\n<div>\n<h1>Carom</h1>\n<p class=\"site-claim\">Event-driven particle dynamics</p>\n\
         <p>Hard spheres, square wells, bonds and stepped potentials, with gravity, walls, surfaces from CAD and dissipation. Between events particles \
         fly freely, so nothing is integrated and there is no time step: the time of the next event is solved for, the event is executed, the next one is \
         predicted.</p>\n<p>Every run measures its own correctness and says so. The same scene and seed give the same bits, in the program and in this \
         window.</p>\n<p class=\"site-ways\"><a class=\"site-button\" href=\"editor.html\">Write a scene</a> <a href=\"docs/index.html\">Read the \
         documents</a></p>\n</div>\n{gas}\n</section>\n<section>\n<h2>Scenes that run here</h2>\n{}\n<p><a href=\"scenes/index.html\">All {} \
         scenes</a></p>\n</section>\n<section>\n<h2>On your own machine</h2>\n<pre class=\"site-source\"><code>cargo install --path .\n\
         carom new fluid &gt; fluid.toml              # a scene to start from, with comments\n\
         carom run fluid.toml                      # results in runs/fluid\n\
         carom report runs/fluid                   # a page about the run\n\
         carom live fluid.toml                     # a page on which it runs</code></pre>\n\
         <p>A library for Rust and a package for Python come with it: <a href=\"docs/library.html\">library</a>, <a href=\"docs/python.html\">Python</a>. \
         How accurate it is, and how that is checked: <a href=\"docs/accuracy.html\">accuracy</a>. How fast: <a href=\"docs/speed.html\">speed</a>.</p>\n\
         </section>",
        cards(address, chosen),
        scenes.len()
    );
    let about = "Carom simulates particles event by event: hard spheres, square wells, bonds, granular flow. Try it in the browser.";
    site.write(address, Page { address, title: "Carom", about, aside: String::new(), body }.html().as_bytes())
}

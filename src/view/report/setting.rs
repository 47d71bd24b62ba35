//! Simulated system, in words.

use super::html::{brackets, escape, number};
use super::inputs::Inputs;
use crate::base::numbers::trunc_to_u64;
use crate::base::text::{digits, plural, unit};
use crate::io::summary::System;
use crate::model::{Limit, Scene, Species};
use crate::view::describe::{self};

/// Subtitle of the page, in one line: `1 372 hard spheres, φ = 0.3`.
pub(super) fn subtitle(inputs: &Inputs) -> String {
    let Some(scene) = &inputs.scene else { return plural(inputs.summary.particles, "particle") };
    let counts = describe::counts(scene);
    let present = scene.species.iter().zip(&counts).filter(|(_, count)| **count > 0);
    let (moving, standing): (Vec<_>, Vec<_>) = present.partition(|(species, _)| !species.is_static());
    let number = |some: &[(&Species, &usize)]| some.iter().map(|(_, count)| **count).sum::<usize>();
    let noun = match scene.space.dimensions() {
        3 => "sphere",
        2 => "disk",
        _ => "rod",
    };
    let count = number(&moving);
    let noun = if count == 1 { noun.to_owned() } else { format!("{noun}s") };
    let mut text = format!("{} {}{noun}", grouped(count as u64), describe::kind_of_potential(scene));
    if moving.len() > 1 {
        text.push_str(&format!(" of {} species", moving.len()));
    }
    if !scene.bonds.is_empty() {
        text.push_str(", bonded");
    }
    if !standing.is_empty() {
        text.push_str(&format!(", {} static", grouped(number(&standing) as u64)));
    }
    let fraction = inputs.summary.system.as_ref().and_then(|system| system.packing_fraction);
    if let Some(fraction) = fraction.filter(|_| standing.is_empty()) {
        text.push_str(&format!(", φ = {}", digits(fraction)));
    }
    if scene.shear_rate.is_some() {
        text.push_str(", sheared");
    }
    if moving.iter().any(|(species, _)| species.acceleration.norm() > 0.0) {
        text.push_str(", falling");
    }
    text
}

/// The section of the page.
pub(super) fn section(inputs: &Inputs) -> String {
    let summary = &inputs.summary;
    let mut list = Pairs::default();
    match &inputs.scene {
        Some(scene) => of_scene(&mut list, scene, summary.diameter_factor),
        None => list.text("particles", &plural(summary.particles, "particle")),
    }
    if let Some(system) = &summary.system {
        of_system(&mut list, system);
    }
    list.text("engine", &summary.engine);
    let run = inputs.scene.as_ref().map(|scene| &scene.run);
    if let Some(run) = run.filter(|run| run.until_stationary || run.equilibration != Limit::default()) {
        list.text("equilibrated", &describe::equilibration(run));
    }
    let events = &summary.events;
    let kinds = [
        ("core", events.core),
        ("capture", events.capture),
        ("release", events.release),
        ("bounce", events.bounce),
        ("wall", events.wall),
    ];
    let kinds: Vec<String> = kinds
        .iter()
        .filter(|(_, count)| *count > 0)
        .map(|(name, count)| format!("{} {name}", grouped(*count)))
        .collect();
    let kinds = if kinds.is_empty() { String::new() } else { format!(" ({})", kinds.join(", ")) };
    let total = events.total;
    let noun = if total == 1 { "event" } else { "events" };
    list.text("measured", &format!("{} {noun}{kinds}, up to t = {}", grouped(total), number(&digits(summary.time))));
    let speed = &summary.speed;
    let rate = speed
        .events_per_second
        .map_or_else(String::new, |rate| format!(", {} events per second", grouped(trunc_to_u64(rate))));
    list.text("wall time", &format!("{} s{rate}", digits(speed.wall_seconds)));
    list.html()
}

/// Volume and densities, where the box has a volume.
fn of_system(list: &mut Pairs, system: &System) {
    let dimensions = system.dimensions;
    let word = ["length", "area", "volume"][dimensions.clamp(1, 3) - 1];
    let shown = |value: f64, of: &str| format!("{}{}", number(&digits(value)), brackets(&unit(of, dimensions)));
    if let Some(volume) = system.volume {
        list.text(word, &shown(volume, "length^D"));
    }
    if let Some(density) = system.number_density {
        list.text("number density", &shown(density, "1 / length^D"));
    }
    if let Some(fraction) = system.packing_fraction {
        list.text("packing fraction", &number(&digits(fraction)));
    }
}

/// `factor` is the growth of the diameters before the measurement.
fn of_scene(list: &mut Pairs, scene: &Scene, factor: f64) {
    let mut scene = scene.clone();
    let has_grown = factor.is_finite() && factor > 0.0 && factor != 1.0;
    if has_grown {
        scene.grow(factor);
    }
    let scene = &scene;
    if let Some(start) = describe::start(scene) {
        list.text("start", &start);
    }
    list.text("particles", &describe::population(scene));
    list.items("species", &species(scene));
    list.items("interactions", &describe::interactions(scene));
    if has_grown {
        let fraction = number(&digits(scene.packing_fraction()));
        let factor = number(&digits(factor));
        let what = format!(
            "diameters are {factor} times those at the start, and all of this is as measured, at a packing fraction of {fraction}"
        );
        list.text("after growth", &what);
    }
    list.items("space", &describe::space(scene).split("; ").map(str::to_owned).collect::<Vec<_>>());
    let shown = |x: f64| number(&digits(x));
    let gravity = scene.species.iter().map(|species| species.acceleration).find(|a| a.norm() > 0.0);
    if let Some(a) = gravity {
        list.text("acceleration", &format!("({}, {}, {}) [length / time²]", shown(a.x), shown(a.y), shown(a.z)));
    }
    if let Some(time) = scene.contact_time {
        let what = "contacts of a particle that had another one less than this time before are elastic (TC model)";
        list.text("contact time", &format!("{}: {what}", number(&digits(time))));
    }
    if let Some(rate) = scene.shear_rate {
        list.text("shear rate", &format!("{} [1 / time], along x across y", number(&digits(rate))));
    }
    if !scene.run.stages.is_empty() {
        list.items("stages before", &scene.run.stages.iter().map(describe::stage).collect::<Vec<_>>());
    }
    if let Some(thermostat) = &scene.run.thermostat {
        list.text("thermostat", &describe::thermostat(thermostat));
    }
    if !scene.static_surfaces.is_empty() {
        let surfaces = scene.static_surfaces.iter().map(|surface| {
            let count = plural(surface.particles.len(), "particle");
            format!("{}: {count}", surface.name)
        });
        list.items("meshes", &surfaces.collect::<Vec<_>>());
    }
}

fn species(scene: &Scene) -> Vec<String> {
    let counts = describe::counts(scene);
    let line = |(species, count): (&crate::model::Species, usize)| {
        let what =
            if species.is_static() { "static".to_owned() } else { format!("mass {}", number(&digits(species.mass))) };
        format!("{}: {count} of diameter {}, {what}", species.name, number(&digits(species.diameter)))
    };
    scene.species.iter().zip(counts).map(line).collect()
}

/// Digits in groups of three: `1 234 567`, with narrow spaces.
fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) && digits.len() > 4 {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

/// A list of names and what they are.
#[derive(Default)]
struct Pairs(String);

impl Pairs {
    fn text(&mut self, name: &str, value: &str) {
        self.0.push_str(&format!("<dt>{}</dt><dd>{}</dd>\n", escape(name), escape(value)));
    }

    fn items(&mut self, name: &str, values: &[String]) {
        let items: String = values.iter().map(|value| format!("<li>{}</li>", escape(value))).collect();
        self.0.push_str(&format!("<dt>{}</dt><dd><ul>{items}</ul></dd>\n", escape(name)));
    }

    fn html(self) -> String {
        format!("<dl>\n{}</dl>\n", self.0)
    }
}

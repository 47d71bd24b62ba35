use super::html::{brackets, escape, numbers};
use super::inputs::Inputs;
use crate::base::numbers::trunc_to_u64;
use crate::base::text::{digits, plural};
use crate::io::summary::{Events, System};
use crate::model::{Scene, Species, StageSwaps, Units};
use crate::view::describe;
use crate::view::final_table::kinds;

/// Subtitle of the page, such as `1372 hard spheres, φ = 0.3`.
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

pub(super) fn section(inputs: &Inputs) -> String {
    let summary = &inputs.summary;
    let mut list = Pairs::default();
    match &inputs.scene {
        Some(scene) => of_scene(&mut list, scene, summary.diameter_factor),
        None => list.text("particles", &plural(summary.particles, "particle")),
    }
    if let Some(system) = &summary.system {
        of_system(&mut list, system, &summary.units, if summary.volume_moves.is_some() { " at the end" } else { "" });
    }
    if let Some(moves) = &summary.volume_moves {
        list.text("volume moves", &describe::volume_moves(moves));
    }
    for StageSwaps { stage, moves } in &summary.swaps {
        list.text(&format!("swap moves in {stage}"), &describe::swap_moves(moves));
    }
    list.text("engine", &summary.engine);
    let Events { total, core, capture, release, bounce, wall, .. } = summary.events;
    let kinds = kinds([core, capture, release, bounce, wall], grouped);
    let kinds = if kinds.is_empty() { kinds } else { format!(" ({kinds})") };
    let noun = if total == 1 { "event" } else { "events" };
    list.text(
        "measured",
        &format!("{} {noun}{kinds}, up to t = {}", grouped(total), summary.units.of_time(summary.time)),
    );
    let speed = &summary.speed;
    let rate = speed
        .events_per_second
        .map_or_else(String::new, |rate| format!(", {} events per second", grouped(trunc_to_u64(rate))));
    list.text("wall time", &format!("{} s{rate}", digits(speed.wall_seconds)));
    list.html()
}

/// Adds the volume and the densities, with labels that end with `when`.
fn of_system(list: &mut Pairs, system: &System, units: &Units, when: &str) {
    let dimensions = system.dimensions;
    let word = ["length", "area", "volume"][dimensions.clamp(1, 3) - 1];
    let shown = |value: f64, of: &str| format!("{}{}", digits(value), brackets(&units.of(of, dimensions)));
    if let Some(volume) = system.volume {
        list.text(&format!("{word}{when}"), &shown(volume, "length^D"));
    }
    if let Some(density) = system.number_density {
        list.text(&format!("number density{when}"), &shown(density, "1 / length^D"));
    }
    if let Some(fraction) = system.packing_fraction {
        list.text(&format!("packing fraction{when}"), &digits(fraction));
    }
}

/// The diameters have grown by `factor` before the measurement.
fn of_scene(list: &mut Pairs, scene: &Scene, factor: f64) {
    let mut scene = scene.clone();
    let has_grown = factor.is_finite() && factor > 0.0 && factor != 1.0;
    if has_grown {
        scene.grow(factor);
    }
    for fact in describe::facts(&scene) {
        list.items(fact.label, &fact.values);
    }
    if has_grown {
        let (factor, fraction) = (digits(factor), digits(scene.packing_fraction()));
        list.text(
            "after growth",
            &format!("the diameters have grown by a factor of {factor}, and all numbers here are for the grown particles, at a packing fraction of {fraction}"),
        );
    }
}

/// Groups the digits of a number by three, with narrow spaces: `12 345`.
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

#[derive(Default)]
struct Pairs(String);

impl Pairs {
    fn text(&mut self, name: &str, value: &str) {
        self.0.push_str(&format!("<dt>{}</dt><dd>{}</dd>\n", escape(name), escape(&numbers(value))));
    }

    fn items(&mut self, name: &str, values: &[String]) {
        if let [value] = values {
            return self.text(name, value);
        }
        let items: String = values.iter().map(|value| format!("<li>{}</li>", escape(&numbers(value)))).collect();
        self.0.push_str(&format!("<dt>{}</dt><dd><ul>{items}</ul></dd>\n", escape(name)));
    }

    fn html(self) -> String {
        format!("<dl>\n{}</dl>\n", self.0)
    }
}

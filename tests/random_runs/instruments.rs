//! All instruments in scenes with little or nothing to measure, for example without particles or without motion.

use std::fmt::Write;
use std::ops::ControlFlow;

use carom::io::estimate::SizeEstimate;
use carom::io::{Existing, Folder};
use carom::model::Scene;
use carom::run::{Finished, Run, burdens, foreseen_rate};
use carom::view::{description, final_table, report};

use super::choices::{Choices, temporary};

/// A run is abandoned after this number of progress calls.
const PATIENCE: u32 = 5;

pub fn scene(bytes: &[u8]) -> String {
    let choices = &mut Choices::new(bytes);
    let mut text = String::from("name = \"degenerate\"\n");
    if choices.once_in(3) {
        text += "allow_invalid_start = true\n";
    }
    let dimensions = choices.pick(&[3, 2, 1, 3]);
    let edge = choices.pick(&[4.0, 2.5, 1.0, 100.0]);
    let sides = ["periodic", "open", "walls", "periodic"];
    let lower = choices.pick(&[0.0, 0.0, -2.0, 1e5]);
    let at = |place: f64, axis: usize| if axis < dimensions { lower + place * edge } else { 0.0 };
    let corner: [f64; 3] = std::array::from_fn(|axis| at(0.0, axis));
    let size: [f64; 3] = std::array::from_fn(|axis| if axis < dimensions { edge } else { 0.0 });
    let _ = write!(text, "[space]\nlower = {corner:?}\nsize = {size:?}\n");
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let side = if axis < dimensions { choices.pick(&sides) } else { "flat" };
        let _ = writeln!(text, "{name} = \"{side}\"");
    }
    if choices.once_in(8) {
        let _ = writeln!(text, "shear_rate = {:?}", choices.pick(&[0.5, -2.0]));
    }
    if choices.once_in(4) {
        let _ = writeln!(text, "[dynamics]\ngravity = [{:?}, 0.0, 0.0]", choices.pick(&[-1.0, 1e-3]));
    }
    let has_static = choices.once_in(3);
    text += "[[species]]\nname = \"A\"\nmass = 1.0\ndiameter = 1.0\n";
    if has_static {
        text += "[[species]]\nname = \"S\"\nstatic = true\ndiameter = 0.5\n";
    }
    let restitution = choices.pick(&["", "", "restitution = 0.9\n", "restitution = 0.0\n"]);
    for other in if has_static { &["A", "S"][..] } else { &["A"] } {
        let potential = choices.pick(&[
            "\"hard-sphere\"",
            "\"square-well\"\nlambda = 1.5\nwell_depth = 1.0",
            "\"none\"",
            "\"penetrable\"\nheight = 1.0",
        ]);
        let held = if potential.contains("none") || potential.contains("penetrable") { "" } else { restitution };
        let _ = write!(text, "[[interaction]]\nspecies = [\"A\", \"{other}\"]\npotential = {potential}\n{held}");
    }
    text += "[[interaction]]\nname = \"link\"\npotential = \"bond\"\nshortest = 0.5\nlongest = 1.5\n";
    let count = choices.pick(&[2, 0, 1, 3, 2]);
    for particle in 0..count {
        let kind = if has_static && choices.once_in(2) { "S" } else { "A" };
        let first = choices.pick(&[0.25, 0.5, 0.75, 0.6]);
        let place: [f64; 3] = std::array::from_fn(|axis| at(if axis == 0 { first } else { 0.5 }, axis));
        let _ = write!(text, "[[particle]]\nspecies = \"{kind}\"\nposition = {place:?}\n");
        let speed = choices.pick(&[0.0, 1.0, -1.0, 1e-6, 300.0]);
        if kind == "A" && speed != 0.0 {
            let _ = writeln!(text, "velocity = [{speed:?}, 0.0, 0.0]");
        }
        if particle > 0 && choices.once_in(3) {
            let _ = write!(text, "[[bond]]\nparticles = [{}, {particle}]\ninteraction = \"link\"\n", particle - 1);
        }
    }
    if choices.once_in(8) {
        text += "[[stage]]\nname = \"before\"\nmeasure = true\nuntil_events = 20\nuntil_time = 1.0\n";
    }
    run(&mut text, choices);
    measurements(&mut text, choices, lower + 0.5 * edge);
    text
}

fn run(text: &mut String, choices: &mut Choices<'_>) {
    let limits = [
        "until_events = 200",
        "until_events = 1",
        "until_time = 1e-9",
        "until_time = 5.0",
        "until_time = 5.0\nuntil_events = 100",
        "until_time = 1e-30",
        "until_time = 1e-9\nequilibration_time = 2.0",
        "until_events = 100\nequilibration_events = 10",
        "until_events = 100\nequilibration_time = 1.0\nequilibration = \"auto\"",
    ];
    let _ = writeln!(text, "[run]\n{}", choices.pick(&limits));
    let baths = ["kind = \"andersen\", rate = 2.0", "kind = \"rescaling\", interval = 0.1"];
    if choices.once_in(4) {
        let _ = writeln!(text, "thermostat = {{ {}, temperature = 1.0 }}", choices.pick(&baths));
    }
    if choices.once_in(4) {
        let _ = writeln!(text, "[output]\nthermo_interval = {}", choices.pick(&["0.1", "1e3", "1e-3"]));
    }
}

fn measurements(text: &mut String, choices: &mut Choices<'_>, middle: f64) {
    let names = [
        "pressure_tensor",
        "radial_distribution",
        "structure_factor",
        "diffusion",
        "transport",
        "free_paths",
        "speeds",
        "chains",
        "bond_order",
        "particle_stress",
    ];
    let has_bins = ["radial_distribution", "free_paths", "speeds", "chains", "bond_order", "particle_stress"];
    *text += "[measure]\n";
    for name in names {
        // Most instruments that Carom would reject are left out.
        let is_possible = match name {
            "pressure_tensor" => !text.contains("= \"open\""),
            "structure_factor" => text.contains("= \"periodic\""),
            "chains" => text.contains("[[bond]]"),
            _ => true,
        };
        if choices.once_in(3) || !(is_possible || choices.once_in(16)) {
            continue;
        }
        let mut keys = Vec::new();
        if name != "free_paths" && choices.once_in(4) {
            keys.push(format!("interval = {}", choices.pick(&["0.01", "1.0", "1e3"])));
        }
        if has_bins.contains(&name) && choices.once_in(4) {
            keys.push(format!("bins = {}", choices.pick(&["1", "2", "2000"])));
        }
        if name == "speeds" && choices.once_in(3) {
            keys.push(format!("windows = {}", choices.pick(&["1", "16"])));
        }
        if name == "radial_distribution" && choices.once_in(3) {
            keys.push(format!("cutoff = {}", choices.pick(&["0.1", "2.0", "50.0"])));
        }
        let value = if keys.is_empty() { "true".to_owned() } else { format!("{{ {} }}", keys.join(", ")) };
        let _ = writeln!(text, "{name} = {value}");
    }
    if choices.once_in(2) {
        let bins = choices.pick(&[[4, 1, 1], [1, 1, 1], [1, 3, 1], [10, 10, 10]]);
        let kind = choices.pick(&["profile", "stress", "mixing"]);
        let _ = write!(text, "[[measure.{kind}]]\nname = \"p\"\nbins = {bins:?}\n");
    }
    if choices.once_in(2) {
        let axis = choices.pick(&["x", "y", "z"]);
        let at = choices.pick(&[middle, 0.0, 1e9]);
        let _ = write!(text, "[[measure.flow]]\nname = \"f\"\naxis = \"{axis}\"\nat = {at:?}\n");
    }
    if choices.once_in(2) {
        let _ = write!(text, "[measure.contacts]\nduration = {}\n", choices.pick(&["0.01", "1.0", "1e3", "1e-9"]));
    }
    let has_sides = text.contains("= \"open\"") || text.contains("= \"walls\"");
    if (has_sides || choices.once_in(16)) && choices.once_in(2) {
        *text += "[measure.centre_of_mass]\n";
        if text.contains("gravity") && choices.once_in(2) {
            let _ = writeln!(text, "axis_point = [{:?}, 0.0, {middle:?}]", choices.pick(&[middle, -1e9]));
        }
    }
}

#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum End {
    Refused(String),
    Over(&'static str),
}

/// Builds a scene from `bytes`, describes it, and runs it. With `is_kept`, writes the results to a folder. Panics if a
/// step panics, or if a printed number is NaN.
pub fn judge(bytes: &[u8], is_kept: bool) -> End {
    let text = scene(bytes);
    let made = match Scene::from_toml(&text, "degenerate.toml") {
        Ok(made) => made,
        Err(error) => return End::Refused(error.to_string()),
    };
    let _ = (description::text(&made), description::warnings(&made), burdens(&made));
    let estimate = SizeEstimate::of(&made, foreseen_rate(&made).ok()).bytes;
    assert!(estimate >= 0.0, "an estimate of {estimate} bytes");
    // Scenes with very large outputs would take minutes.
    if estimate > 1e7 {
        return End::Refused("large".to_owned());
    }
    let mut asked = 0;
    let mut watch = |_: &carom::run::Progress| {
        asked += 1;
        if asked > PATIENCE { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let run = Run::new(made.clone());
    let finished = if is_kept {
        let place = temporary();
        let target = place.path().join("run");
        let mut folder = Folder::create(&target, &made, Existing::Keep).expect("a folder");
        folder.keep_scene(&text).expect("a scene that is kept");
        let finished = run.execute(&mut folder, &mut watch).expect("a run that is kept");
        folder.complete(&finished, &final_table::text(&finished)).expect("results");
        let page = report::page(&target).unwrap_or_else(|error| panic!("{error}"));
        // Only scripts may contain the word NaN.
        let scripts = page.html.split("<script>").enumerate();
        let mut besides = scripts
            .map(|(k, part)| if k == 0 { part } else { part.split_once("</script>").map_or("", |(_, rest)| rest) });
        assert!(besides.all(|part| !part.contains("NaN")), "a page with numbers that are none");
        finished
    } else {
        run.execute(&mut (), &mut watch).expect("a run")
    };
    check(&finished);
    End::Over(finished.ending.word())
}

fn check(finished: &Finished) {
    let text = final_table::text(finished);
    assert!(!text.contains("NaN") && !text.contains("inf "), "{text}");
    for (name, estimate) in &finished.observables {
        is_number(name, estimate.mean, estimate.standard_error);
    }
    for number in &finished.measured.numbers {
        if let Some(mean) = number.mean {
            is_number(&number.name, mean, number.standard_error);
        }
    }
}

fn is_number(name: &str, mean: f64, error: Option<f64>) {
    assert!(mean.is_finite(), "{name} is {mean}");
    let error = error.unwrap_or(0.0);
    assert!(error.is_finite() && error >= 0.0, "the error of {name} is {error}");
}

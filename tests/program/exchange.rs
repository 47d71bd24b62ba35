//! Files of `carom exchange`, and inputs that `carom exchange` rejects.

use std::path::Path;

use super::place::{FLUID, Place, code, contents, errors, killed, line, wait_until, words};

pub const CHAIN: &str = r#"
name = "chain"
seed = 3

[space]
size = [9.0, 9.0, 9.0]

[[species]]
name = "bead"
mass = 1.3
diameter = 1.0

[[interaction]]
species = ["bead", "bead"]
potential = "square-well"
lambda = 1.5
well_depth = 1.0

[[interaction]]
name = "spring"
potential = "bond"
diameter = 1.0
lambda = 1.2

[[chain]]
species = "bead"
bond = "spring"
length = 4
count = 1
spacing = 1.1
start = [2.0, 4.0, 4.0]
direction = [1.0, 0.0, 0.0]

[exchange]
temperatures = [0.35, 0.6, 1.0]
interval = 1.5
rate = 0.8

[run]
equilibration_time = 15.0
until_time = 900.0
"#;

pub fn measured_chain() -> String {
    format!("{CHAIN}\n[measure]\nchains = true\nradial_distribution = {{ bins = 40, interval = 4.0 }}\n")
}

pub fn exchange<'a>(more: &[&'a str]) -> Vec<&'a str> {
    ["exchange", "scene.toml", "--quiet"].into_iter().chain(more.iter().copied()).collect()
}

fn files(folder: &Path) -> Vec<String> {
    contents(folder).into_keys().collect()
}

#[test]
fn an_exchange_leaves_tables_trajectories_and_a_page() {
    let place = Place::with(&measured_chain());
    let output = place.done(&exchange(&["--jobs", "2"]));
    assert!(words(&output).contains("chain, 600 attempts to swap"), "{}", words(&output));
    let folder = "runs/chain-exchange";
    let expected = [
        ".exchange",
        "curves.csv",
        "density_of_states.csv",
        "energies.csv",
        "exchange.checkpoint",
        "exchange.csv",
        "exchange.html",
        "measurements.json",
        "scene.toml",
        "summary.json",
        "trajectory-1.xyz",
        "trajectory-2.xyz",
        "trajectory-3.xyz",
    ];
    let (tables, others): (Vec<String>, Vec<String>) =
        files(&place.path().join(folder)).into_iter().partition(|name| name.starts_with("measurements/"));
    assert_eq!(others, expected);
    let of_each = ["bond_length", "chain_size", "end_to_end_distance_4", "radial_distribution"];
    let of_each = (1..=3).flat_map(|at| of_each.map(|name| format!("measurements/temperature-{at}/{name}.csv")));
    assert_eq!(tables, of_each.collect::<Vec<_>>());
    let summary = place.summary(folder);
    assert_eq!((&summary["seed"], &summary["attempts"], &summary["duration"]), (&3.into(), &600.into(), &900.0.into()));
    assert_eq!(summary["faults"].as_array().unwrap().len(), 0);
    let rows = place.read(&format!("{folder}/exchange.csv"));
    let mut lines = rows.lines();
    let heads = "time,replica_1,potential_1,replica_2,potential_2,replica_3,potential_3,mean_square_radius_of_gyration_1,mean_square_end_to_end_distance_1,\
                 mean_square_radius_of_gyration_2,mean_square_end_to_end_distance_2,mean_square_radius_of_gyration_3,mean_square_end_to_end_distance_3";
    assert_eq!(lines.next(), Some(heads));
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect::<Vec<f64>>()).collect();
    assert_eq!((rows.len(), rows[0][0], rows[599][0]), (600, 16.5, 915.0));
    for row in &rows {
        let mut replicas = [row[1], row[3], row[5]];
        replicas.sort_by(f64::total_cmp);
        assert_eq!(replicas, [1.0, 2.0, 3.0]);
    }
    let energies = place.read(&format!("{folder}/energies.csv"));
    for (at, temperature) in [0.35, 0.6, 1.0].into_iter().enumerate() {
        let mean = rows.iter().map(|row| row[2 + 2 * at]).sum::<f64>() / 600.0;
        let of = |name: &str, key: &str| summary["temperatures"][at]["observables"][name][key].as_f64().unwrap();
        assert!((4.0 * of("potential_energy_per_particle", "mean") - mean).abs() < 1e-12);
        let square = rows.iter().map(|row| (row[2 + 2 * at] - mean).powi(2)).sum::<f64>() / 600.0;
        // The variance about the true mean exceeds the sample variance by at most the squared error.
        let missed = (4.0 * of("potential_energy_per_particle", "standard_error")).powi(2);
        let variance = (of("heat_capacity_per_particle", "mean") - 1.5) * 4.0 * temperature * temperature;
        assert!(variance > square + 0.2 * missed && variance < square + missed, "{variance}, {square}, {missed}");
        let bound = rows.iter().filter(|row| row[2 + 2 * at] == -3.0).count() as f64 / 600.0;
        let line = energies.lines().find(|line| line.starts_with(&format!("{temperature},-3,0,"))).unwrap();
        let population: f64 = line.split(',').nth(3).unwrap().parse().unwrap();
        assert!((population - bound).abs() < 1e-12, "{line}, {bound}");
        let trajectory = place.read(&format!("{folder}/trajectory-{}.xyz", at + 1));
        assert_eq!(trajectory.matches("Properties").count(), 20);
    }
    check_page(&place, folder);
}

fn check_page(place: &Place, folder: &str) {
    let page = place.read(&format!("{folder}/exchange.html"));
    let words = ["Populations", "Heat capacity per particle", "Replica paths", "Round trips", "audit sound", "✓ mixed"];
    let of_instruments = ["Radial distribution function", "in the folder of each temperature"];
    for word in
        words.into_iter().chain(["Entropy per particle", "Mean square end to end distance"]).chain(of_instruments)
    {
        assert!(page.contains(word), "{word}");
    }
    let measured = place.path().join(folder).join("measurements.json");
    std::fs::write(&measured, place.read(&format!("{folder}/measurements.json")).replacen("radial", "lateral", 1))
        .unwrap();
    let output = place.carom(&["report", folder, "--force"]);
    assert!(code(&output) == 2 && line(&output).contains("measurements.json"), "{}", errors(&output));
    place.done(&["convert", "runs/chain-exchange/trajectory-2.xyz", "--to", "csv"]);
}

#[test]
fn an_exchange_has_the_surfaces_of_its_scene_beside_its_trajectories() {
    let place = Place::with(CHAIN);
    let scene = format!(
        "{CHAIN}\n[[surface]]\nname = \"rod\"\nshape = \"cylinder\"\nbase = [1.0, 1.0, 0.0]\naxis = [0.0, 0.0, 1.0]\nradius = 0.3\n"
    );
    place.write("scene.toml", &scene);
    let folder = place.path().join("runs/chain-exchange/surfaces");
    let run = |end: &str| {
        place.done(&exchange(&["--until-time", end]));
        assert_eq!(files(&folder), ["rod.stl"]);
    };
    run("6.0");
    std::fs::remove_file(folder.join("rod.stl")).unwrap();
    run("12.0");
    place.done(&["render", "runs/chain-exchange/trajectory-1.xyz", "--out", "chain.png"]);
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let place = Place::with(CHAIN);
    for (out, jobs) in [("one", "1"), ("two", "2"), ("many", "9")] {
        place.done(&exchange(&["--jobs", jobs, "--out", out, "--set", "run.until_time=300"]));
    }
    let one = contents(&place.path().join("one"));
    assert!(one == contents(&place.path().join("two")));
    assert!(one == contents(&place.path().join("many")));
    place.done(&exchange(&["--out", "other", "--seed", "4", "--set", "run.until_time=300"]));
    assert!(one["exchange.csv"] != contents(&place.path().join("other"))["exchange.csv"]);
}

#[test]
fn complete_exchange_is_kept_and_other_folders_are_untouched() {
    let place = Place::with(CHAIN);
    let short = ["--set", "run.until_time=150"];
    let with = |more: &[&'static str]| exchange(&[short.as_slice(), more].concat());
    place.done(&with(&[]));
    let folder = place.path().join("runs/chain-exchange");
    let before = contents(&folder);
    std::fs::remove_file(folder.join("exchange.html")).unwrap();
    for arguments in [with(&[]), vec!["exchange", "runs/chain-exchange"]] {
        let output = place.done(&arguments);
        assert!(words(&output).contains("It was complete already"), "{}", words(&output));
        assert!(contents(&folder) == before);
    }
    let refused = |arguments: &[&str], expected: &str| place.refused(arguments, &[expected]);
    refused(&with(&["--seed", "8"]), "holds the exchange of another scene");
    refused(&["exchange", "runs/chain-exchange", "--seed", "8"], "an exchange continues unchanged");
    std::fs::create_dir(place.path().join("thesis")).unwrap();
    place.write("thesis/thesis.tex", "");
    refused(&with(&["--out", "thesis"]), "holds something that is not a replica exchange");
    refused(&["exchange", "thesis"], "is not the folder of a replica exchange");
    refused(&["run", "scene.toml"], "has [exchange]");
    refused(&["run", "scene.toml", "--out", "runs/chain-exchange"], "run it with `carom exchange`");
    refused(&["verify", "scene.toml"], "has [exchange]");
    refused(&["sweep", "scene.toml", "--vary", "seed=1..2"], "a sweep varies runs");
    place.write("next.toml", "run.until_time = 1.0");
    refused(&["run", "next.toml", "--from", "runs/chain-exchange"], "not the folder of a run");
    let table = "[exchange]\ntemperatures = [0.35, 0.6, 1.0]\ninterval = 1.5\nrate = 0.8\n";
    place.write("plain.toml", &CHAIN.replace(table, ""));
    refused(&["exchange", "plain.toml"], "plain.toml has no [exchange]");
    refused(&["run", "plain.toml", "--out", "runs/chain-exchange"], "something that is not a run");
    assert!(contents(&folder) == before);
    place.done(&["report", "runs/chain-exchange", "--out", "page.html"]);
    assert!(place.read("page.html").as_bytes() == before["exchange.html"]);
    let output = place.done(&["check", "scene.toml"]);
    let expected =
        "3 replicas at temperatures 0.35, 0.6, 1, in heat baths of rate 0.8, are swapped at intervals of 1.5";
    assert!(words(&output).contains(expected), "{}", words(&output));
}

#[test]
fn two_processes_do_not_write_to_one_folder() {
    let place = Place::with(CHAIN);
    let child = place.start(&exchange(&["--set", "run.until_time=1.5e7"]));
    let checkpoint = place.path().join("runs/chain-exchange/exchange.checkpoint");
    wait_until(|| checkpoint.exists());
    let output = place.carom(&exchange(&["--set", "run.until_time=1.5e7"]));
    killed(child);
    assert_eq!(code(&output), 2, "{}", errors(&output));
    assert!(line(&output).contains("another process runs the exchange"), "{}", line(&output));
    std::fs::write(&checkpoint, "carom checkpoint").unwrap();
    let before = contents(&place.path().join("runs/chain-exchange"));
    let output = place.carom(&exchange(&["--set", "run.until_time=1.5e7"]));
    assert_eq!(code(&output), 2, "{}", errors(&output));
    assert!(line(&output).contains("is damaged"), "{}", line(&output));
    assert!(contents(&place.path().join("runs/chain-exchange")) == before);
    assert!(!line(&output).contains("previous"), "{}", line(&output));
    assert!(line(&output).contains("here without exchange.checkpoint"), "{}", line(&output));
}

#[test]
fn scene_in_the_exchange_document_runs() {
    let page = include_str!("../../docs/exchange.md");
    let scenes: Vec<&str> = page.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next()).collect();
    let [scene] = scenes.as_slice() else { panic!("{} scenes", scenes.len()) };
    let place = Place::with(scene);
    place.done(&exchange(&["--set", "run.until_time=400", "--set", "run.equilibration_time=20"]));
    let summary = place.summary("runs/chain-exchange");
    assert_eq!((summary["temperatures"].as_array().unwrap().len(), &summary["attempts"]), (6, &200.into()));
}

#[test]
fn an_exchange_starts_from_the_end_of_a_run() {
    let place = Place::with(FLUID);
    place.done(&["run", "scene.toml", "--quiet"]);
    place.write(
        "next.toml",
        "start.from = \"runs/scene\"\n[exchange]\ntemperatures = [1.0, 2.5]\ninterval = 0.5\nrate = 1.0\n[run]\nuntil_time = 10.0\n",
    );
    place.done(&["exchange", "next.toml", "--quiet"]);
    let (run, summary) = (place.summary("runs/scene"), place.summary("runs/next-exchange"));
    assert_eq!(summary["start"], run["time"]);
    // Hard spheres have no potential energy, so every swap is accepted.
    let neighbours = &summary["neighbours"][0];
    assert_eq!((&neighbours["attempts"], &neighbours["accepted"]), (&20.into(), &20.into()));
    for (at, temperature) in [1.0, 2.5].into_iter().enumerate() {
        let observables = &summary["temperatures"][at]["observables"];
        let number = |name: &str| observables[name]["mean"].as_f64().unwrap();
        // Carnahan and Starling's equation gives Z = 3.97 at a packing fraction of 0.3.
        assert!((number("temperature") / temperature - 1.0).abs() < 0.15, "{observables}");
        assert!((number("compressibility_factor") / 3.97 - 1.0).abs() < 0.1, "{observables}");
    }
    let before = words(&place.carom(&["exchange", "runs/next-exchange"]));
    std::fs::remove_dir_all(place.path().join("runs/scene")).unwrap();
    let output = place.carom(&["exchange", "runs/next-exchange"]);
    assert_eq!((code(&output), words(&output)), (0, before), "{}", errors(&output));
}

#[test]
fn surfaces_that_supply_or_take_energy_are_refused() {
    let sphere = "[[surface]]\nshape = \"sphere\"\ncentre = [7.0, 7.0, 7.0]\nradius = 0.5\n";
    let moves = "motion = [{ kind = \"translation\", velocity = [0.0, 0.0, 0.1] }]\n";
    let still = CHAIN.replace("[space]\nsize = [9.0, 9.0, 9.0]\n", "[space]\nsize = [9.0, 9.0, 9.0]\nz = \"walls\"\n");
    for (law, key) in [
        ("", None),
        (moves, Some("motion")),
        ("restitution = 0.9\n", Some("restitution")),
        ("temperature = 1.0\n", Some("temperature")),
    ] {
        let place = Place::with(&still.replace("[exchange]", &format!("{sphere}{law}\n[exchange]")));
        let output = place.carom(&["check", "scene.toml"]);
        let text = errors(&output);
        match key {
            None => assert_eq!(code(&output), 0, "{text}"),
            Some(key) => {
                assert_eq!(code(&output), 2, "{key}");
                assert!(text.contains(&format!("surface[0].{key}")), "{text}");
            }
        }
    }
}

//! Results of `carom exchange`.

use super::exchange::{CHAIN, exchange};
use super::place::{Place, code, errors, words};

#[test]
fn an_exchange_has_curves_through_its_temperatures() {
    let place = Place::with(CHAIN);
    place.done(&exchange(&[]));
    let (summary, curves) = (place.summary("runs/chain-exchange"), place.read("runs/chain-exchange/curves.csv"));
    assert_eq!(summary["warnings"], serde_json::json!([]));
    let heads =
        "temperature,potential_energy_per_particle,potential_energy_per_particle_error,heat_capacity_per_particle,";
    assert!(curves.starts_with(heads) && curves.lines().count() == 122, "{curves}");
    let rows: Vec<Vec<f64>> =
        curves.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    // The curves use the data of all temperatures, so the errors should not be larger than at a single temperature.
    for at in summary["temperatures"].as_array().unwrap() {
        let row = rows.iter().find(|row| Some(row[0]) == at["temperature"].as_f64()).unwrap();
        let names = ["potential_energy_per_particle", "heat_capacity_per_particle"];
        for (name, column) in names.into_iter().zip([1, 3]) {
            let of = |key: &str| at["observables"][name][key].as_f64().unwrap();
            let deviation = (row[column] - of("mean")) / of("standard_error");
            assert!(deviation.abs() < 3.0 && row[column + 1] < 1.5 * of("standard_error"), "{name}: {row:?} {at}");
        }
    }
}

#[test]
fn temperatures_are_found_for_a_requested_acceptance() {
    let place = Place::with(CHAIN);
    place.done(&exchange(&[]));
    let found = place.done(&["exchange", "runs/chain-exchange", "--temperatures-for", "0.75"]);
    let text = words(&found).trim().to_owned();
    let list = text.strip_prefix("exchange.temperatures=[").unwrap().trim_end_matches(']');
    let temperatures: Vec<f64> = list.split(", ").map(|it| it.parse().unwrap()).collect();
    assert_eq!((temperatures[0], temperatures.last()), (0.35, Some(&1.0)));
    place.done(&exchange(&["--set", &text, "--out", "runs/even"]));
    let neighbours = place.summary("runs/even")["neighbours"].as_array().unwrap().clone();
    let all: Vec<f64> = neighbours.iter().map(|it| it["acceptance"]["mean"].as_f64().unwrap()).collect();
    assert!(all.iter().all(|it| *it > 0.65 && (it - all[0]).abs() < 0.15), "{all:?}");
    let output = place.carom(&["exchange", "runs/chain-exchange", "--temperatures-for", "0.99999"]);
    assert!(code(&output) == 2 && errors(&output).contains("more than a thousand"), "{}", errors(&output));
    let output = place.carom(&["verify", "runs/chain-exchange"]);
    assert!(code(&output) == 2 && errors(&output).contains("the folder of a replica exchange"), "{}", errors(&output));
    let output = place.carom(&["exchange", "runs/chain-exchange", "--temperatures-for", "1"]);
    assert!(code(&output) == 2 && errors(&output).contains("between 0 and 1"), "{}", errors(&output));
}

#[test]
fn a_multicanonical_exchange_has_means_at_its_temperatures_and_no_swaps() {
    let place = Place::with(CHAIN);
    let ensemble = "exchange.ensemble=\"multicanonical\"";
    let output = place.done(&exchange(&["--set", ensemble, "--set", "run.equilibration_time=600"]));
    assert!(words(&output).contains("600 samples of each replica in a multicanonical ensemble"), "{}", words(&output));
    let folder = "runs/chain-exchange";
    let summary = place.summary(folder);
    assert_eq!((&summary["ensemble"], &summary["warnings"]), (&"multicanonical".into(), &serde_json::json!([])));
    assert_eq!(summary["neighbours"], serde_json::json!([]));
    let tables =
        ["curves.csv", "energies.csv", "density_of_states.csv"].map(|name| place.read(&format!("{folder}/{name}")));
    let [curves, energies, levels] = tables.map(|text| -> Vec<Vec<f64>> {
        let row = |line: &str| line.split(',').map(|cell| cell.parse().unwrap()).collect();
        text.lines().skip(1).map(row).collect()
    });
    assert_eq!(levels.iter().map(|row| row[0]).collect::<Vec<_>>(), [-3.0, -2.0, -1.0, 0.0]);
    // The density of states is normalised: g(E) exp(-E / T) adds up to one at the highest temperature.
    let sum: f64 = levels.iter().map(|row| (row[1] - row[0]).exp()).sum();
    assert!((sum - 1.0).abs() < 1e-9, "{sum}");
    for (at, temperature) in [0.35, 0.6, 1.0].into_iter().enumerate() {
        let observables = &summary["temperatures"][at]["observables"];
        let point = curves.iter().find(|row| row[0] == temperature).unwrap();
        for (name, column) in [("potential_energy_per_particle", 1), ("heat_capacity_per_particle", 3)] {
            assert_eq!(observables[name]["mean"].as_f64(), Some(point[column]));
        }
        let of: Vec<&Vec<f64>> = energies.iter().filter(|row| row[0] == temperature).collect();
        let mean: f64 = of.iter().map(|row| row[1] * row[3]).sum();
        assert!((mean / 4.0 - point[1]).abs() < 1e-9, "{mean}");
        assert!(observables.get("pressure").is_none() && observables.get("entropy_per_particle").is_none());
    }
    let page = place.read(&format!("{folder}/exchange.html"));
    for (word, is_there) in [("Multicanonical ensemble", true), ("Density of states", true), ("acceptance", false)] {
        assert_eq!(page.contains(word), is_there, "{word}");
    }
}

#[test]
fn an_exchange_without_round_trips_is_not_shown_as_sound() {
    let place = Place::with(CHAIN);
    let frozen = exchange(&["--until-time", "60", "--set", "exchange.temperatures=[0.02, 40.0]"]);
    let output = place.done(&frozen);
    assert!(words(&output).contains("warning: equilibrium is not shown"), "{}", words(&output));
    let page = place.read("runs/chain-exchange/exchange.html");
    assert!(
        page.contains("✗ equilibrium not shown") && page.contains("between the lowest and the highest temperature")
    );
}

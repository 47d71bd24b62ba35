//! `carom exchange` between umbrella windows of a distance.

use super::exchange::{CHAIN, exchange};
use super::place::{Place, code, errors, line, words};

fn in_windows(windows: &str) -> String {
    let umbrella = format!("temperatures = [0.7]\nensemble = \"umbrella\"\n{windows}");
    CHAIN.replace("temperatures = [0.35, 0.6, 1.0]", &umbrella)
}

#[test]
fn an_exchange_between_windows_has_a_potential_of_mean_force() {
    let windows = "umbrella = { between = [[0], [3]], windows = [[1.0, 1.6], [1.4, 2.2], [2.0, 3.3]], bins = 20 }";
    let scene = in_windows(windows);
    let place = Place::with(&scene.replace("equilibration_time = 15.0", "equilibration_time = 150.0"));
    let output = place.done(&exchange(&["--jobs", "2"]));
    for expected in [
        "600 attempts to swap",
        "1.4 to 2.2",
        "the free energy is lowest at the distance",
        "potential_of_mean_force.csv",
    ] {
        assert!(words(&output).contains(expected), "{expected}: {}", words(&output));
    }
    let folder = "runs/chain-exchange";
    let summary = place.summary(folder);
    assert_eq!((&summary["ensemble"], &summary["faults"]), (&"umbrella".into(), &serde_json::json!([])));
    assert_eq!(summary["umbrella"]["between"], serde_json::json!([[0], [3]]));
    assert_eq!(summary["temperatures"][1]["window"], serde_json::json!([1.4, 2.2]));
    let rows = place.read(&format!("{folder}/exchange.csv"));
    let heads = rows.lines().next().unwrap().to_owned();
    assert!(heads.contains(",potential_3,distance_1,mean_square_radius_of_gyration_1,"), "{heads}");
    let column = heads.split(',').position(|head| head == "distance_2").unwrap();
    let distances = rows.lines().skip(1).map(|line| line.split(',').nth(column).unwrap().parse::<f64>().unwrap());
    assert!(distances.clone().count() == 600 && distances.into_iter().all(|it| (1.4..=2.2).contains(&it)));
    let text = place.read(&format!("{folder}/potential_of_mean_force.csv"));
    // In bins with few samples, the standard errors are empty.
    let number = |cell: &str| if cell.is_empty() { f64::NAN } else { cell.parse().unwrap() };
    let table: Vec<Vec<f64>> = text.lines().skip(1).map(|line| line.split(',').map(number).collect()).collect();
    assert!(table.len() > 18 && table.iter().all(|row| row.len() == 6), "{text}");
    assert!(table.iter().all(|row| [0, 1, 2, 4].iter().all(|&column| row[column].is_finite())), "{text}");
    assert!(table[..15].iter().all(|row| row[3] > 0.0 && row[5] > 0.0), "{text}");
    // The ends of three bonds of up to 1.2 are rarely 3.6 apart.
    let lowest = table.iter().map(|row| row[4]).fold(f64::INFINITY, f64::min);
    assert!(table.last().unwrap()[4] - lowest > 1.0, "{text}");
    // Only exchanges between temperatures write these files.
    for name in ["energies.csv", "curves.csv", "density_of_states.csv"] {
        assert!(!words(&output).contains(name) && !place.path().join(folder).join(name).exists(), "{name}");
    }
    let page = place.read(&format!("{folder}/exchange.html"));
    for (word, is_there) in [
        ("Umbrella sampling", true),
        ("Potential of mean force", true),
        ("Replica paths", true),
        ("Heat capacity per particle", false),
    ] {
        assert_eq!(page.contains(word), is_there, "{word}");
    }
    let output = place.carom(&["exchange", folder, "--temperatures-for", "0.3"]);
    assert!(code(&output) == 2 && line(&output).contains("the same temperature in all windows"), "{}", errors(&output));
    place.write(&format!("{folder}/potential_of_mean_force.csv"), "distance\n");
    let output = place.carom(&["exchange", folder]);
    assert!(
        code(&output) == 2 && line(&output).contains("potential_of_mean_force.csv is not the table"),
        "{}",
        errors(&output)
    );
    std::fs::remove_file(place.path().join(folder).join("summary.json")).unwrap();
    place.done(&["exchange", folder, "-q"]);
    assert_eq!(place.read(&format!("{folder}/potential_of_mean_force.csv")), text);
}

#[test]
fn a_window_that_cannot_be_reached_is_named() {
    let windows = "umbrella = { between = [[0], [3]], windows = [[1.0, 1.6], [1.4, 4.0], [3.9, 4.4]] }";
    let scene = in_windows(windows);
    let place = Place::with(&scene.replace("equilibration_time = 15.0", "equilibration_time = 150.0"));
    let output = place.carom(&exchange(&[]));
    assert_eq!(code(&output), 1, "{}", errors(&output));
    assert!(
        line(&output).contains(
            "window 3, from 3.9 to 4.4, was not reached: after half of the equilibration, the distance is still 3."
        ),
        "{}",
        errors(&output)
    );
    assert!(errors(&output).contains("give a longer equilibration_time"), "{}", errors(&output));
    let output = place.carom(&["report", "runs/chain-exchange"]);
    assert!(code(&output) == 2 && line(&output).contains("unfinished replica exchange"), "{}", errors(&output));
    place.write("scene.toml", &scene.replace("], [3.9, 4.4]]", "]]").replace("time = 15.0", "time = 150.0"));
    place.done(&exchange(&["--until-time", "30"]));
}

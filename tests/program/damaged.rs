//! Damaged files of an exchange are rejected with helpful messages.

use super::exchange::CHAIN;
use super::place::{Place, code, contents, errors, line};

#[test]
fn damaged_exchange_files_are_rejected_with_a_remedy() {
    let place = Place::with(CHAIN);
    let short = ["exchange", "scene.toml", "-q", "--set", "run.until_time=150", "--out", "pair"];
    assert_eq!(code(&place.carom(&short)), 0);
    let folder = place.path().join("pair");
    let whole = contents(&folder);
    let refused = |arguments: &[&str], expected: &[&str]| {
        let output = place.carom(arguments);
        assert_eq!(code(&output), 2, "{arguments:?}: {}", errors(&output));
        for expected in expected {
            assert!(line(&output).contains(expected), "{arguments:?}: {}", line(&output));
        }
    };
    refused(&["run", "--resume", "pair"], &["is the folder of a replica exchange", "carom exchange pair"]);
    for (name, remedy) in [
        ("energies.csv", "summary.json"),
        ("curves.csv", "summary.json"),
        ("density_of_states.csv", "summary.json"),
        ("exchange.csv", ""),
    ] {
        let text = place.read(&format!("pair/{name}"));
        let lines: Vec<&str> = text.lines().collect();
        place.write(&format!("pair/{name}"), &(lines[..lines.len() - 2].join("\n") + "\n"));
        let expected = [name, "is not the table that the exchange wrote", "remove summary.json"];
        refused(&["exchange", "pair"], &expected);
        refused(&short, &expected);
        refused(&["report", "pair", "--out", "page.html"], &expected);
        if remedy.is_empty() {
            place.write(&format!("pair/{name}"), &text);
        } else {
            std::fs::remove_file(folder.join(remedy)).unwrap();
        }
        assert_eq!(code(&place.carom(&["exchange", "pair", "-q"])), 0);
        assert!(contents(&folder) == whole, "{name}");
    }
    std::fs::write(folder.join("exchange.checkpoint"), "carom checkpoint").unwrap();
    refused(&["exchange", "pair", "--until-time", "300"], &["is damaged", "exchange.checkpoint and summary.json"]);
    for name in ["exchange.checkpoint", "summary.json"] {
        std::fs::remove_file(folder.join(name)).unwrap();
    }
    assert_eq!(code(&place.carom(&["exchange", "pair", "-q"])), 0);
    assert!(contents(&folder) == whole);
}

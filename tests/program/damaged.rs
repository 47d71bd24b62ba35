//! Damaged files of an exchange are rejected with helpful messages.

use super::exchange::CHAIN;
use super::place::{Place, contents};

#[test]
fn damaged_exchange_files_are_rejected_with_a_remedy() {
    let place = Place::with(CHAIN);
    let short = ["exchange", "scene.toml", "-q", "--set", "run.until_time=150", "--out", "pair"];
    place.done(&short);
    let folder = place.path().join("pair");
    let whole = contents(&folder);
    place.refused(&["run", "--resume", "pair"], &["is the folder of a replica exchange", "carom exchange pair"]);
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
        place.refused(&["exchange", "pair"], &expected);
        place.refused(&short, &expected);
        place.refused(&["report", "pair", "--out", "page.html"], &expected);
        if remedy.is_empty() {
            place.write(&format!("pair/{name}"), &text);
        } else {
            std::fs::remove_file(folder.join(remedy)).unwrap();
        }
        place.done(&["exchange", "pair", "-q"]);
        assert!(contents(&folder) == whole, "{name}");
    }
    std::fs::write(folder.join("exchange.checkpoint"), "carom checkpoint").unwrap();
    place
        .refused(&["exchange", "pair", "--until-time", "300"], &["is damaged", "exchange.checkpoint and summary.json"]);
    for name in ["exchange.checkpoint", "summary.json"] {
        std::fs::remove_file(folder.join(name)).unwrap();
    }
    place.done(&["exchange", "pair", "-q"]);
    assert!(contents(&folder) == whole);
}

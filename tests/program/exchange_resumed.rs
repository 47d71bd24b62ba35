//! Exchanges that are killed, interrupted or extended write the same bytes as undisturbed exchanges.

use std::process::{Child, Stdio};
use std::time::Duration;

use super::exchange::{exchange, measured_chain};
use super::place::{Place, code, contents, errors, kill_until_done, line, send_signal, wait_until, words};

fn start(place: &Place, out: &str) -> Child {
    let jobs = ["--jobs", "2", "--checkpoint-every", "0.005", "--set", "run.until_time=3000", "--out", out];
    place.start(&exchange(&jobs))
}

#[test]
fn an_exchange_that_is_killed_again_and_again_comes_to_the_same_bytes() {
    let place = Place::with(&measured_chain());
    assert!(start(&place, "whole").wait().unwrap().success());
    let kills = kill_until_done(10, || start(&place, "killed"));
    let [whole, killed] = ["whole", "killed"].map(|out| contents(&place.path().join(out)));
    assert_eq!(whole.keys().collect::<Vec<_>>(), killed.keys().collect::<Vec<_>>());
    for (name, bytes) in &whole {
        assert!(*bytes == killed[name], "{name} after {kills} kills");
    }
    assert!(kills > 0);
}

#[test]
fn extended_exchange_equals_one_with_the_later_end() {
    let place = Place::with(&measured_chain());
    let frames = ["--set", "output.frame_interval=75"];
    let with = |more: &[&'static str]| exchange(&[frames.as_slice(), more].concat());
    let done = |arguments: &[&str], attempts: &str| {
        let output = place.done(arguments);
        assert!(words(&output).contains(attempts), "{arguments:?}: {}", words(&output));
    };
    done(&with(&["--out", "whole", "--until-time", "900"]), "600 attempts to swap");
    done(&with(&["--out", "parts", "--until-time", "300"]), "200 attempts to swap");
    let folder = place.path().join("parts");
    let short = contents(&folder);
    let refused = |arguments: &[&str], expected: &str| {
        place.refused(arguments, &[expected]);
        assert!(contents(&folder) == short);
    };
    refused(&["exchange", "parts", "--until-time", "150"], "has measured a time of 300 already");
    refused(&["exchange", "parts", "--until-time", "450.7"], "until_time");
    refused(&["exchange", "parts", "--until-time", "450", "--seed", "8"], "an exchange continues unchanged");
    refused(&with(&["--out", "parts", "--until-time", "450", "--seed", "8"]), "holds the exchange of another scene");
    done(&["exchange", "parts", "--until-time", "3e2"], "It was complete already");
    assert!(contents(&folder) == short);
    done(&["exchange", "parts", "--until-time", "450", "--jobs", "2"], "300 attempts to swap");
    done(&with(&["--out", "parts", "--until-time", "900", "--jobs", "1"]), "600 attempts to swap");
    let [whole, parts] = ["whole", "parts"].map(|out| contents(&place.path().join(out)));
    assert_eq!(whole.keys().collect::<Vec<_>>(), parts.keys().collect::<Vec<_>>());
    // The checkpoints differ, because they contain the initial scenes, which have different end times.
    for (name, bytes) in whole.iter().filter(|(name, _)| *name != "exchange.checkpoint") {
        assert!(*bytes == parts[name], "{name}");
    }
    done(&["exchange", "parts"], "It was complete already");
}

#[test]
fn exchange_killed_during_an_extension_ends_with_identical_bytes() {
    let place = Place::with(&measured_chain());
    let frames = ["--set", "output.frame_interval=75"];
    let whole = exchange(&[frames.as_slice(), &["--out", "whole", "--until-time", "3000"]].concat());
    place.done(&whole);
    let short = exchange(&[frames.as_slice(), &["--out", "parts", "--until-time", "300"]].concat());
    place.done(&short);
    let on = || {
        let arguments = ["exchange", "parts", "--until-time", "3000", "--checkpoint-every", "0.005", "--quiet"];
        place.start(&arguments)
    };
    let kills = kill_until_done(10, on);
    let [whole, parts] = ["whole", "parts"].map(|out| contents(&place.path().join(out)));
    for (name, bytes) in whole.iter().filter(|(name, _)| *name != "exchange.checkpoint") {
        assert!(*bytes == parts[name], "{name} after {kills} kills");
    }
}

#[cfg(unix)]
#[test]
fn an_interrupted_exchange_goes_on_to_the_same_bytes() {
    let place = Place::with(&measured_chain());
    let arguments = exchange(&["--set", "run.until_time=12000", "--jobs", "2"]);
    let child = place.command(&arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    // The first checkpoint is written after a second.
    let checkpoint = place.path().join("runs/chain-exchange/exchange.csv.partial");
    wait_until(|| checkpoint.exists());
    std::thread::sleep(Duration::from_millis(100));
    send_signal(&child, "-INT");
    let output = child.wait_with_output().unwrap();
    assert_eq!(code(&output), 1, "{}", errors(&output));
    assert!(line(&output).contains("interrupted; the simulated part is kept"), "{}", line(&output));
    assert!(line(&output).contains("or: carom exchange runs/chain-exchange --jobs 2"), "{}", line(&output));
    place.done(&["exchange", "runs/chain-exchange", "--jobs", "1"]);
    let whole = exchange(&["--set", "run.until_time=12000", "--jobs", "1", "--out", "whole"]);
    place.done(&whole);
    assert!(contents(&place.path().join("whole")) == contents(&place.path().join("runs/chain-exchange")));
}

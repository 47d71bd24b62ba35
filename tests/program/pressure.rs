//! Runs with a changing volume, and runs that continue from their last state.

use carom::trajectory::Frame;
use carom::trajectory::extended_xyz::FrameReader;

use super::place::{FLUID, Place, code};

fn pressed() -> Place {
    let run = "[run]\nequilibration_time = 5.0\nuntil_time = 4.0\nthermostat = { kind = \"andersen\", temperature = 1.0, rate = 1.0 }\n\
               barostat = { pressure = 4.0, interval = 0.02 }\n[output]\nthermo_interval = 0.1\nframe_interval = 0.5\n";
    let (head, _) = FLUID.split_once("[run]").unwrap();
    Place::with(&format!("{head}{run}"))
}

#[test]
fn each_row_and_frame_has_the_box_of_its_time() {
    let place = pressed();
    place.done(&["run", "scene.toml", "--quiet"]);
    let text = place.read("runs/scene/thermo.csv");
    let heads: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let column = heads.iter().position(|head| *head == "volume").unwrap();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        [cells[0], cells[column]].map(|cell| cell.parse::<f64>().unwrap())
    };
    let rows: Vec<[f64; 2]> = text.lines().skip(1).map(row).collect();
    let text = place.read("runs/scene/trajectory.xyz");
    let frames: Vec<Frame> = FrameReader::new(text.as_bytes()).collect::<Result<_, _>>().unwrap();
    assert!(frames.len() >= 9 && frames.windows(2).all(|pair| pair[0].size != pair[1].size));
    for frame in &frames {
        let volume = frame.size.product();
        let at = rows.iter().find(|[time, _]| (time - frame.time).abs() < 1e-9).unwrap();
        assert!((volume / at[1] - 1.0).abs() < 1e-12, "{} {volume} {}", frame.time, at[1]);
        let is_inside = |x: &f64| (-1e-9..frame.size.x * (1.0 + 1e-9)).contains(x);
        assert!(frame.particles.iter().all(|particle| particle.position.iter().all(is_inside)));
    }
    let summary = place.summary("runs/scene");
    let moves = &summary["volume_moves"];
    assert_eq!(moves["attempted"], 200);
    assert!(moves["accepted"].as_u64().unwrap() > 20 && moves["amplitude"].as_f64().unwrap() < 0.05, "{moves}");
    let last = rows.last().unwrap()[1];
    assert!((summary["system"]["volume"].as_f64().unwrap() / last - 1.0).abs() < 1e-12);
    // Published values are for a fixed density.
    assert_eq!(summary["published"].as_array().unwrap().len(), 0);
    let mean = summary["observables"]["volume"]["mean"].as_f64().unwrap();
    let measured: Vec<f64> = rows.iter().filter(|[time, _]| *time >= 5.0).map(|[_, volume]| *volume).collect();
    let average = measured.iter().sum::<f64>() / measured.len() as f64;
    assert!((mean / average - 1.0).abs() < 0.01, "{mean} {average}");
    let report = place.read("runs/scene/report.txt");
    assert!(report.contains("volume moves                    200, ") && report.contains("isothermal compressibility"));
    for format in ["gsd", "lammps", "vtk"] {
        place.done(&["convert", "runs/scene", "--to", format]);
    }
    place.done(&["report", "runs/scene"]);
    assert!(place.read("runs/scene/report.html").contains("volume moves"));
}

#[test]
fn the_next_run_has_the_box_that_the_last_one_has_left() {
    let place = pressed();
    place.done(&["run", "scene.toml", "--quiet"]);
    let volume = |run: &str| place.summary(run)["system"]["volume"].as_f64().unwrap();
    place.write("next.toml", "[run]\nuntil_time = 1.0\n[measure]\nradial_distribution = true\n");
    let next = ["run", "next.toml", "--from", "runs/scene", "--quiet"];
    place.done(&next);
    assert_eq!(volume("runs/next"), volume("runs/scene"));
    // Unlike `next.toml`, this scene has a barostat.
    let again = ["run", "scene.toml", "--from", "runs/scene", "--out", "again", "--quiet"];
    place.done(&again);
    assert!(volume("again") != volume("runs/scene"));
    let longer = ["run", "--resume", "runs/scene", "--until-time", "6.0", "--quiet"];
    place.done(&longer);
    assert_eq!(place.summary("runs/scene")["volume_moves"]["attempted"], 300);
}

#[test]
fn verify_and_live_reject_a_barostat() {
    let place = pressed();
    let verified = place.carom(&["verify", "scene.toml"]);
    assert!(code(&verified) != 0);
    place.refused(&["live", "scene.toml"], &["has a barostat, but the box of a page has a constant size"]);
}

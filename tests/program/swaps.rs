//! Runs whose particles exchange their species.

use carom::trajectory::Frame;
use carom::trajectory::extended_xyz::FrameReader;

use super::place::{Place, code, line};

const MIXTURE: &str = r#"
seed = 3
[[species]]
name = "sphere"
mass = 1.3
diameter = { distribution = "power-law", exponent = 3.0, lower = 0.725, upper = 1.613, classes = 5 }
[[interaction]]
species = ["sphere", "sphere"]
potential = "hard-sphere"
[[fill]]
species = "sphere"
arrangement = "random"
count = 100
packing_fraction = 0.30
temperature = 1.0
[[stage]]
name = "mix"
until_time = 2.0
swap = { interval = 0.1 }
[run]
until_time = 3.0
swap = { interval = 0.25, attempts = 40, largest_ratio = 1.5 }
[measure]
relaxation = { span = 1.0 }
pressure_tensor = true
radial_distribution = true
structure_factor = true
speeds = true
bond_order = true
[output]
frame_interval = 0.5
"#;

fn species(frame: &Frame) -> Vec<u32> {
    frame.particles.iter().map(|particle| particle.species.0).collect()
}

#[test]
fn frames_tables_and_pages_show_the_exchanged_species() {
    let place = Place::with(MIXTURE);
    place.done(&["run", "scene.toml", "--quiet"]);
    let text = place.read("runs/scene/trajectory.xyz");
    let frames: Vec<Frame> = FrameReader::new(text.as_bytes()).collect::<Result<_, _>>().unwrap();
    assert!(frames.len() >= 7, "{}", frames.len());
    let sorted = |frame: &Frame| {
        let mut all = species(frame);
        all.sort_unstable();
        all
    };
    assert!(
        frames.windows(2).all(|pair| species(&pair[0]) != species(&pair[1]) && sorted(&pair[0]) == sorted(&pair[1]))
    );
    let swaps = place.summary("runs/scene")["swaps"].clone();
    assert_eq!([&swaps[0]["stage"], &swaps[1]["stage"]], ["mix", "measurement"]);
    assert_eq!([&swaps[0]["moves"]["attempted"], &swaps[1]["moves"]["attempted"]], [2_000, 480]);
    for stage in [0, 1] {
        let count = |key: &str| swaps[stage]["moves"][key].as_u64().unwrap();
        assert!(count("accepted") > 50 && count("alike") > 50, "{swaps}");
        assert_eq!(count("too_unlike") > 0, stage == 1, "{swaps}");
    }
    let report = place.read("runs/scene/report.txt");
    assert!(
        report.contains("swap moves in mix               2000")
            && report.contains("swap moves in measurement       480")
    );
    for format in ["gsd", "lammps", "vtk", "csv"] {
        place.done(&["convert", "runs/scene", "--to", format]);
    }
    place.done(&["report", "runs/scene"]);
    let page = place.read("runs/scene/report.html");
    assert!(page.contains("swap moves in mix") && page.contains("four_point_susceptibility"));
}

#[test]
fn the_next_run_begins_with_the_last_species() {
    let place = Place::with(MIXTURE);
    place.done(&["run", "scene.toml", "--quiet"]);
    place.write("next.toml", "[run]\nuntil_time = 0.5\n[output]\nframe_interval = 0.5\n");
    place.done(&["run", "next.toml", "--from", "runs/scene", "--quiet"]);
    let frames = |run: &str| -> Vec<Frame> {
        let text = place.read(&format!("{run}/trajectory.xyz"));
        FrameReader::new(text.as_bytes()).collect::<Result<_, _>>().unwrap()
    };
    let (before, after) = (frames("runs/scene"), frames("runs/next"));
    assert_eq!(species(&after[0]), species(before.last().unwrap()));
    assert_eq!(species(after.last().unwrap()), species(&after[0]));
    let longer = ["run", "--resume", "runs/scene", "--until-time", "4.0", "--quiet"];
    place.done(&longer);
    assert_eq!(place.summary("runs/scene")["swaps"][1]["moves"]["attempted"], 640);
}

#[test]
fn verify_and_live_reject_swap_moves() {
    let place = Place::with(MIXTURE);
    let verified = place.carom(&["verify", "scene.toml"]);
    assert!(code(&verified) != 0);
    assert!(line(&verified).contains("swap moves"), "{}", line(&verified));
    place.refused(&["live", "scene.toml"], &["has swap moves, but the particles of a page keep their sizes"]);
}

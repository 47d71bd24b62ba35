//! Files, promises and rejected inputs of `carom run`.

use std::fs;

use super::place::{COLLAPSE, FLUID, Place, code, errors, keys, sorted, words};

#[test]
fn a_run_leaves_its_files_and_a_table() {
    let place = Place::with(FLUID);
    let output = place.done(&["run", "scene.toml"]);
    assert!(words(&output).contains("compressibility factor"), "{}", words(&output));
    assert!(words(&output).contains("one hard-sphere species"));
    let files = fs::read_dir(place.path().join("runs/scene")).unwrap();
    let mut names: Vec<String> = files.map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    assert_eq!(
        names,
        [".carom", "checkpoint", "report.txt", "scene.toml", "summary.json", "thermo.csv", "trajectory.xyz"]
    );

    let thermo = place.measured("runs/scene");
    let mut lines = thermo.lines();
    let columns = lines.next().unwrap().split(',').count();
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert!((100..=420).contains(&rows.len()), "{} rows", rows.len());
    assert!(rows.iter().all(|row| row.len() == columns));
    let times: Vec<f64> = rows.iter().map(|row| row[0].parse().unwrap()).collect();
    let interval = times[1] - times[0];
    for pair in times[..times.len() - 1].windows(2) {
        assert!(((pair[1] - pair[0]) / interval - 1.0).abs() < 1e-9);
    }
    let frames = place.read("runs/scene/trajectory.xyz").matches("Lattice=").count();
    assert!((10..=42).contains(&frames), "{frames} frames");
}

#[test]
fn summary_has_exactly_the_agreed_keys() {
    let place = Place::with(FLUID);
    place.done(&["run", "scene.toml", "--seed", "9"]);
    let summary = place.summary("runs/scene");
    let top = "version scene seed inputs engine particles diameter_factor time ending measured system events energy momentum overlap faults equilibrated observables published columns rates speed";
    assert_eq!(keys(&summary), sorted(top.split(' ').collect()));
    for (key, contents) in [
        (
            "events",
            "total before core capture release bounce wall transition turning_point in_invalid_state tc_contacts tc_altered tc_kept tc_slid tc_lifted tc_returned",
        ),
        ("energy", "initial final kinetic potential dissipated supplied ledger_error_relative ledger_limit"),
        ("measured", "start duration"),
        ("system", "dimensions size volume number_density packing_fraction species"),
        ("momentum", "drift limit"),
        ("overlap", "deepest_executed deepest_final limit initial final resolved_after"),
        ("observables", "temperature pressure compressibility_factor collision_rate"),
        ("speed", "wall_seconds events_per_second contacts_per_second peak_memory_bytes"),
    ] {
        assert_eq!(keys(&summary[key]), sorted(contents.split(' ').collect()), "{key}");
    }
    assert_eq!(summary["seed"], 9);
    assert_eq!(summary["particles"], 108);
    assert_eq!(summary["events"]["total"], 4000, "the equilibration is not counted");
    assert_eq!(summary["events"]["core"], 4000);
    let rate = &summary["observables"]["collision_rate"];
    assert!(rate["standard_error"].as_f64().unwrap() > 0.0);
    let thermo = place.measured("runs/scene");
    let times: Vec<f64> = thermo.lines().skip(1).map(|line| line.split(',').next().unwrap().parse().unwrap()).collect();
    let duration = times[times.len() - 1] - times[0];
    assert!((rate["mean"].as_f64().unwrap() / (2.0 * 4000.0 / (108.0 * duration)) - 1.0).abs() < 1e-12);
    assert!(summary["momentum"]["drift"].as_f64().unwrap() < 1e-12);
}

#[test]
fn run_depends_on_its_scene_and_not_on_its_output_rows() {
    let place = Place::with(FLUID);
    for (folder, more) in [("a", "seed=1"), ("b", "seed=1"), ("c", "output.thermo_interval=0.001"), ("d", "seed=2")] {
        place.done(&["run", "scene.toml", "--out", folder, "--set", more]);
    }
    let last_frame = |folder: &str| {
        let text = place.read(&format!("{folder}/trajectory.xyz"));
        text[text.rfind("Lattice=").unwrap()..].to_owned()
    };
    assert_eq!(place.read("a/trajectory.xyz"), place.read("b/trajectory.xyz"));
    assert_eq!(place.read("a/thermo.csv"), place.read("b/thermo.csv"));
    assert_eq!(last_frame("a"), last_frame("c"));
    assert!(place.read("c/thermo.csv").len() > 5 * place.read("a/thermo.csv").len());
    assert_ne!(last_frame("a"), last_frame("d"));
}

#[test]
fn runs_limited_by_events_write_rows_and_frames_from_the_start() {
    let place = Place::with(FLUID);
    let times_of = |folder: &str| -> Vec<f64> {
        let thermo = place.measured(folder);
        thermo.lines().skip(1).map(|line| line.split(',').next().unwrap().parse().unwrap()).collect()
    };
    // All rows except the last must be equally spaced, including the rows of the pilot run.
    let ahead = ["run", "scene.toml", "--until-events", "100000", "--set", "output.thermo_interval=0.05"];
    for (folder, more) in [
        ("rows", vec![]),
        ("frames", vec!["--set", "output.frame_interval=0.1"]),
        ("measured", vec!["--set", "output.frame_interval=0.1", "--set", "measure.pressure_tensor=true"]),
    ] {
        place.done(&[&ahead[..], &["--out", folder], &more[..]].concat());
        let times = times_of(folder);
        assert!(times.len() > 3_000, "{}", times.len());
        for (k, time) in times[..times.len() - 1].iter().enumerate() {
            assert!((time - times[0] - 0.05 * k as f64).abs() < 1e-9, "{folder}: row {k} is at {time}");
        }
        if !more.is_empty() {
            let trajectory = place.read(&format!("{folder}/trajectory.xyz"));
            let frames: Vec<f64> = trajectory
                .lines()
                .filter_map(|line| line.split("Time=").nth(1)?.split(' ').next()?.parse().ok())
                .collect();
            assert!(frames.len() > 1_500, "{}", frames.len());
            for (k, time) in frames[..frames.len() - 1].iter().enumerate() {
                assert!((time - frames[0] - 0.1 * k as f64).abs() < 1e-9, "{folder}: frame {k} is at {time}");
            }
        }
    }
}

#[test]
fn rows_start_with_the_first_stage_and_name_their_stage() {
    let stage = "[[stage]]\nname = \"first warm\"\nuntil_time = 1.0\n\
        thermostat = { kind = \"andersen\", temperature = 2.0, rate = 1.0 }\n";
    let place = Place::with(&format!("{FLUID}\n{stage}"));
    place.done(&["run", "scene.toml", "--set", "output.thermo_interval=0.25"]);
    let thermo = place.read("runs/scene/thermo.csv");
    assert!(thermo.lines().next().unwrap().ends_with(",stage"), "{thermo}");
    let lines: Vec<&str> = thermo.lines().skip(1).collect();
    for time in ["0,", "0.25,", "0.5,", "0.75,"] {
        let line = lines.iter().find(|line| line.starts_with(time)).unwrap();
        assert!(line.ends_with(",first warm"), "{line}");
    }
    let begin = |stage: &str| lines.iter().position(|line| line.ends_with(stage)).unwrap();
    assert!(begin(",first warm") == 0 && begin(",equilibration") == 4, "{thermo}");
    let measured = begin(",measurement");
    assert!(measured > 4 && lines[measured..].iter().all(|line| line.ends_with(",measurement")), "{thermo}");
    // The first row of a stage has no rates.
    assert!([0, 4, measured].iter().all(|row| lines[*row].contains(",,")), "{thermo}");
    assert!(!lines[measured + 1].contains(",,"), "{thermo}");
    let summary = place.summary("runs/scene");
    assert_eq!(summary["events"]["total"], 4000, "rows do not change what is measured");
}

/// A crystal melts before the measurement only if the equilibration is long.
#[test]
fn report_says_whether_the_run_is_equilibrated() {
    let place = Place::with(FLUID);
    let scene = ["--set", "fill.0.count=500", "--set", "fill.0.packing_fraction=0.49", "--until-events", "200000"];
    for (folder, events, expected) in [("soon", "1", "no"), ("late", "300000", "yes")] {
        let equilibration = format!("run.equilibration_events={events}");
        let arguments = ["run", "scene.toml", "--out", folder, "--set", &equilibration];
        let output = place.carom(&[&arguments[..], &scene[..]].concat());
        assert_eq!(code(&output), 0, "the audit is another question: {}", errors(&output));
        let summary = place.summary(folder);
        assert_eq!(summary["equilibrated"]["verdict"], expected, "{summary}");
        let text = words(&output).split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(text.contains(&format!("equilibrated {expected}")), "{text}");
        assert_eq!(summary["faults"].as_array().unwrap().len(), 0);
        let pressure = &summary["observables"]["pressure"]["stationarity"];
        match expected {
            "no" => assert!(pressure["verdict"] == "drifting" && pressure["by"].as_f64().unwrap() > 1.0, "{summary}"),
            _ => assert_eq!(pressure["verdict"], "stationary", "{summary}"),
        }
        assert_eq!(summary["observables"]["temperature"]["stationarity"]["verdict"], "constant", "{summary}");
    }
}

#[test]
fn conserved_temperature_is_constant_with_zero_error() {
    // The verdict must not depend on round-off in the temperature, which differs between the runs.
    let place = Place::with(&format!(
        "{FLUID}[[stage]]\nname = \"warm\"\nuntil_time = 2.0\nthermostat = {{ kind = \"andersen\", temperature = 2.0, rate = 1.0 }}\n"
    ));
    for (seed, interval) in [("1", "0.01"), ("2", "0.01"), ("3", "0.01"), ("4", "0.3"), ("5", "0.3"), ("6", "1.0")] {
        let set = format!("output.thermo_interval={interval}");
        let arguments =
            ["run", "scene.toml", "-q", "--seed", seed, "--out", seed, "--until-events", "2000", "--set", &set];
        let output = place.done(&arguments);
        let temperature = &place.summary(seed)["observables"]["temperature"];
        assert_eq!(temperature["stationarity"]["verdict"], "constant", "{temperature}");
        assert_eq!(temperature["standard_error"].as_f64(), Some(0.0), "{temperature}");
        let text = words(&output);
        let line = text.lines().find(|line| line.starts_with("temperature")).unwrap();
        assert!(line.ends_with("(conserved) [energy]"), "{line}");
    }
}

#[test]
fn integers_may_have_an_exponent_or_a_point_in_scene_files() {
    let typed = FLUID.replace("108", "1.08e2").replace("= 500", "= 5e2").replace("4000", "4e3");
    let typed = format!(
        "seed = 1.0\n{typed}\n[measure]\nradial_distribution = {{ bins = 5e1 }}\n[[measure.profile]]\nname = \"x\"\nbins = [2.0, 1, 1e0]\n"
    );
    let place = Place::with(&typed);
    let set = ["--set", "fill.0.count=108", "--set", "run.until_events=4000", "--set", "run.equilibration_events=500"];
    let more = [
        "--set",
        "seed=1",
        "--set",
        "measure.radial_distribution.bins=50",
        "--set",
        "measure.profile.x.bins=[2, 1, 1]",
    ];
    for (out, set) in
        [("typed", vec![]), ("plain", [&set[..], &more].concat()), ("set", vec!["--set", "run.until_events=4.0e3"])]
    {
        place.done(&[&["run", "scene.toml", "-q", "--out", out], &set[..]].concat());
        assert!(place.read(&format!("{out}/trajectory.xyz")) == place.read("typed/trajectory.xyz"), "{out}");
    }
    place.done(&["run", "typed/scene.toml", "-q", "--out", "again"]);
}

#[test]
fn results_without_events_are_marked() {
    let thin = FLUID.replace("count = 108", "count = 4").replace("0.3", "1e-9");
    let place = Place::with(&thin.replace("equilibration_events = 500\nuntil_events = 4000", "until_time = 1.0"));
    let output = place.done(&["run", "scene.toml", "-q"]);
    let text = words(&output);
    for (name, value) in [("compressibility factor", "1 (no event) [1]"), ("temperature", "1 (conserved) [energy]")] {
        let line = text.lines().find(|line| line.starts_with(name)).unwrap();
        assert!(line.ends_with(value), "{line}");
    }
}

#[test]
fn automatic_equilibration_does_not_depend_on_the_output() {
    let place = Place::with(&FLUID.replace("equilibration_events = 500", "equilibration = \"auto\""));
    let start = |folder: &str, more: &str| -> (f64, String) {
        let dense = "fill.0.packing_fraction=0.49";
        let arguments =
            ["run", "scene.toml", "--out", folder, "--set", more, "--set", dense, "--set", "fill.0.count=500"];
        place.done(&arguments);
        let measured = place.measured(folder);
        let line = measured.lines().nth(1).unwrap();
        let cells: Vec<&str> = line.split(',').take(4).collect();
        (cells[0].parse().unwrap(), cells.join(","))
    };
    let (time, plain) = start("plain", "output.contacts=false");
    // The equilibration needs at least a hundred samples, which take 11 units of time.
    assert!((10.0..200.0).contains(&time), "{time}");
    assert_eq!(start("often", "output.thermo_interval=0.037").1, plain);
    let (time, _) = start("limited", "run.equilibration_time=2.0");
    assert_eq!(time, 2.0);
}

#[test]
fn limits_on_the_command_line_replace_those_of_the_scene() {
    let place = Place::with(FLUID);
    place.done(&["run", "scene.toml", "--until-events", "1e3", "--out", "events"]);
    assert_eq!(place.summary("events")["events"]["total"], 1000);
    let arguments =
        ["run", "scene.toml", "--until-time", "0.5", "--set", "run.equilibration_events=1", "--out", "time"];
    place.done(&arguments);
    let thermo = place.measured("time");
    assert_eq!(thermo.lines().count(), 1 + 201, "rows at both ends and between them");
}

#[test]
fn bad_input_is_reported_before_anything_is_written() {
    let place = Place::with(FLUID);
    fs::write(place.path().join("binary.toml"), [0xff, 0xfe, 0, 1]).unwrap();
    fs::create_dir(place.path().join("empty")).unwrap();
    for (arguments, expected) in [
        (vec!["run", "missing.toml"], "missing.toml"),
        (vec!["run", "binary.toml"], "UTF-8"),
        (vec!["run", "."], "cannot read"),
        (vec!["run", "scene.toml", "--set", "run.until_event=5"], "until_events"),
        (vec!["run", "scene.toml", "--set", "nonsense"], "KEY=VALUE"),
        (vec!["run", "scene.toml", "--set", "fill.0.packing_fraction=0.9"], "0.74"),
        (vec!["run", "scene.toml", "--until-time", "nan"], "positive finite"),
        (vec!["run", "scene.toml", "--until-time", "1e300"], "from 1e-50 to 1e50"),
        (vec!["run", "scene.toml", "--set", "run.until_time=1e300"], "is 1e300, expected a number from 1e-50 to 1e50"),
        (vec!["run", "scene.toml", "--until-events", "0"], "at least 1"),
        (vec!["run", "scene.toml", "--seed", "-1"], "--seed"),
        (vec!["run"], "SCENE"),
        (vec!["fly"], "unrecognized subcommand"),
        (vec!["check", "missing.toml"], "missing.toml"),
        (vec!["new", "soup"], "hopper"),
        (vec!["verify", "missing.toml"], "missing.toml"),
        (vec!["verify", "empty"], "no scene.toml"),
        (vec!["verify", "scene.toml", "--events", "0"], "at least 1"),
        (vec!["verify", "scene.toml", "-q", "--from-events", "1e5"], "only 4500 events"),
        (vec!["validate", "soup"], "validate --list"),
        (vec!["validate", "--seed", "-1"], "-1"),
        (vec!["render", "missing"], "missing"),
        (vec!["render", ".", "--size", "10"], "WIDTH"),
        (vec!["report", "missing"], "not the folder of a run"),
        (vec!["report", "empty"], "summary.json"),
    ] {
        let output = place.carom(&arguments);
        assert_eq!(code(&output), 2, "{arguments:?}: {}", errors(&output));
        assert!(errors(&output).contains(expected), "{arguments:?}: {}", errors(&output));
        assert!(!errors(&output).contains("panicked"), "{}", errors(&output));
        assert!(!place.path().join("runs").exists(), "{arguments:?}");
    }
}

#[test]
fn a_folder_is_only_replaced_if_it_is_a_run() {
    let place = Place::with(FLUID);
    let thesis = place.path().join("thesis");
    fs::create_dir(&thesis).unwrap();
    fs::write(thesis.join("chapter.tex"), "years of work").unwrap();
    let output = place.carom(&["run", "scene.toml", "--out", "thesis"]);
    assert_eq!(code(&output), 2);
    assert!(errors(&output).contains("not a run of carom"), "{}", errors(&output));
    assert_eq!(fs::read_dir(&thesis).unwrap().count(), 1);
    assert_eq!(code(&place.carom(&["run", "scene.toml", "--out", "scene.toml"])), 2);
    assert_eq!(place.read("scene.toml"), FLUID);

    fs::create_dir(place.path().join("empty")).unwrap();
    place.done(&["run", "scene.toml", "--out", "empty", "--set", "output.contacts=true"]);
    assert!(place.path().join("empty/contacts.csv").exists());
    place.done(&["run", "scene.toml", "--out", "empty", "--seed", "2", "--force"]);
    assert!(!place.path().join("empty/contacts.csv").exists(), "a file of the earlier run");
    assert_eq!(place.summary("empty")["seed"], 2);
}

#[test]
fn contacts_lists_every_physical_event() {
    let place = Place::with(FLUID);
    place.done(&["run", "scene.toml", "--set", "output.contacts=true"]);
    let contacts = place.read("runs/scene/contacts.csv");
    assert_eq!(contacts.lines().count(), 1 + 4000);
    assert!(contacts.lines().skip(1).all(|line| line.split(',').count() == 7 && line.contains(",core,")));
    let times: Vec<f64> =
        contacts.lines().skip(1).map(|line| line.split(',').next().unwrap().parse().unwrap()).collect();
    assert!(times.is_sorted());
}

#[test]
fn counting_regions_and_heights_are_columns() {
    let counting =
        format!("{COLLAPSE}\n[[output.count]]\nname = \"floor\"\nlower = [0.0, 0.0, 0.0]\nupper = [4.0, 4.0, 1.0]\n");
    let place = Place::with(&counting);
    let arguments = ["run", "scene.toml", "--set", "space.z.restitution=1.0", "--until-time", "2"];
    place.done(&arguments);
    let thermo = place.measured("runs/scene");
    assert!(thermo.starts_with("time,events,kinetic,potential"), "{thermo}");
    assert!(thermo.lines().next().unwrap().ends_with("height,in_floor,stage"), "{thermo}");
    // At time 1, the ball has fallen by 1/2 to a height of 1. It touches the floor at sqrt(2).
    let row: Vec<&str> = thermo.lines().nth(3).unwrap().split(',').collect();
    assert_eq!((row[0], row[row.len() - 2]), ("1", "0"));
    assert!((row[row.len() - 3].parse::<f64>().unwrap() - 1.0).abs() < 1e-14);
    let row: Vec<&str> = thermo.lines().nth(4).unwrap().split(',').collect();
    assert_eq!((row[0], row[row.len() - 2]), ("1.5", "1"));
    assert!(place.summary("runs/scene")["momentum"]["drift"].is_null());
}

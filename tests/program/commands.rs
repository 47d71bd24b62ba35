use std::fs;
use std::process::Stdio;

use super::place::{FLUID, Place, code, errors, line, words};

#[test]
fn a_run_can_be_proven_from_its_folder() {
    let place = Place::with(FLUID);
    let arguments = ["run", "scene.toml", "--seed", "9", "--set", "fill.0.temperature=2.0", "--until-events", "700"];
    place.done(&arguments);
    fs::remove_file(place.path().join("scene.toml")).unwrap();
    let kept = place.read("runs/scene/scene.toml");
    for line in ["name = \"scene\"", "seed = 9", "temperature = 2.0", "until_events = 700"] {
        assert!(kept.lines().any(|other| other == line), "{line}: {kept}");
    }
    let output = place.done(&["verify", "runs/scene"]);
    let text = words(&output);
    for expected in ["scene, seed 9", "over all 5778 pairs", "1200 (1200 core)", "PROVEN", "up to the end of the run"] {
        assert!(text.contains(expected), "{expected}: {text}");
    }
    let output = place.carom(&["verify", "runs/scene", "--events", "100", "--from-events", "900", "--quiet"]);
    assert!(words(&output).contains("event 901 to 1000"), "{}", words(&output));
    assert_eq!(errors(&output), "");
}

#[test]
fn proof_of_a_folder_ends_at_the_last_event_of_its_run() {
    // The equilibration ends by a criterion, so only the summary contains the final time of the run.
    let place = Place::with(&FLUID.replace("equilibration_events = 500", "equilibration = \"auto\""));
    let few = ["run", "scene.toml", "--until-events", "300", "--set", "run.equilibration_time=1.0", "--quiet"];
    place.done(&few);
    let events = &place.summary("runs/scene")["events"];
    let all = events["before"].as_u64().unwrap() + events["total"].as_u64().unwrap();
    assert!(events["total"] == 300 && all > 500, "{events}");
    let output = place.done(&["verify", "runs/scene", "-q", "--from-events", &(all - 100).to_string()]);
    let text = words(&output);
    let last = format!("event {} to {all}", all - 99);
    for expected in [last.as_str(), "up to the end of the run", "agree with summary.json"] {
        assert!(text.contains(expected), "{expected}: {text}");
    }
    let output = place.carom(&["verify", "runs/scene", "-q", "--from-events", &all.to_string(), "--events", "100"]);
    assert!(code(&output) == 2 && errors(&output).contains(&format!("only {all} events")), "{}", errors(&output));
}

#[test]
fn verify_rejects_a_folder_with_a_different_scene() {
    let place = Place::with(FLUID);
    place.done(&["run", "scene.toml", "--seed", "1", "--until-events", "700", "-q"]);
    let file = place.path().join("runs/scene/scene.toml");
    let kept = fs::read_to_string(&file).unwrap();
    for (was, is, exit, message) in [
        ("seed = 1\n", "seed = 2\n", 2, "its seed is 2, but 1 in summary.json"),
        ("count = 108", "count = 32", 2, "its number of particles is 32, but 108 in summary.json"),
        ("temperature = 1.0", "temperature = 2.0", 1, "does not reproduce the end of this run: it gives 1201 events"),
    ] {
        assert!(kept.contains(was), "{kept}");
        fs::write(&file, kept.replace(was, is)).unwrap();
        let output = place.carom(&["verify", "runs/scene", "-q"]);
        assert_eq!(code(&output), exit, "{is}: {}", errors(&output));
        let told = line(&output);
        assert!(told.contains(message), "{message}: {told}");
        assert!(!words(&output).contains("PROVEN: no event"), "{}", words(&output));
    }
    fs::write(&file, &kept).unwrap();
    let output = place.carom(&["verify", "runs/scene", "--seed", "1"]);
    assert!(code(&output) == 2 && errors(&output).contains("need a scene"), "{}", errors(&output));
    fs::remove_file(place.path().join("runs/scene/summary.json")).unwrap();
    let output = place.carom(&["verify", "runs/scene"]);
    assert!(code(&output) == 2 && errors(&output).contains("summary.json"), "{}", errors(&output));
}

#[test]
fn closed_output_pipe_is_not_an_error() {
    let place = Place::with(FLUID);
    let mut child = place.command(&["new", "hopper"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(code(&output), 0, "{}", errors(&output));
    assert_eq!(errors(&output), "");
}

#[test]
fn every_kind_of_new_scene_is_valid() {
    let place = Place::with(FLUID);
    let output = place.done(&["new"]);
    let list = words(&output);
    let lines = list.lines().skip_while(|line| *line != "Kinds of scenes:").skip(1);
    let kinds: Vec<&str> = lines.map_while(|line| line.split_whitespace().next()).collect();
    assert!(kinds.len() == 28 && kinds.contains(&"exchange"), "{list}");
    for kind in kinds {
        let text = words(&place.carom(&["new", kind]));
        assert!(text.starts_with('#'), "{kind} begins with a comment");
        fs::write(place.path().join("new.toml"), text).unwrap();
        let output = place.carom(&["check", "new.toml"]);
        assert_eq!(code(&output), 0, "{kind}: {}", errors(&output));
        assert!(words(&output).contains("The scene is valid.\n"), "{kind}: {}", words(&output));
    }
}

#[test]
fn keys_of_unsupported_features_get_an_explanation() {
    for (table, answer) in [
        ("outlet = true\n", "a [[surface]] with `outlet = true` lets particles leave"),
        ("unit = { length = \"mm\" }\n", "the table [units] names the units"),
        ("friction = 0.5\n", "are keys of an [[interaction]]"),
    ] {
        let place = Place::with(&format!("{table}{FLUID}"));
        let output = place.carom(&["check", "scene.toml"]);
        assert_eq!(code(&output), 2);
        let text = line(&output);
        assert!(text.contains(answer) && text.contains("scene.toml:1:1"), "{text}");
    }
}

#[test]
fn completions_and_man_pages_cover_all_commands() {
    let place = Place::with(FLUID);
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = words(&place.carom(&["completions", shell]));
        assert!(["exchange", "until-events"].iter().all(|word| script.contains(word)), "{shell}: {script}");
    }
    assert_eq!(code(&place.carom(&["completions", "dos"])), 2);
    let manual = words(&place.carom(&["man"]));
    assert!(
        manual.starts_with(".ie") && manual.contains(".TH carom 1") && manual.contains("carom\\-exchange(1)"),
        "{manual}"
    );
    let page = words(&place.carom(&["man", "run"]));
    assert!(page.contains(".TH carom-run 1") && page.contains("\\-\\-until\\-events"), "{page}");
    let output = place.carom(&["man", "walk"]);
    assert!(code(&output) == 2 && errors(&output).contains("there is no command `walk`"), "{}", errors(&output));
}

#[test]
fn validate_lists_what_it_measures_and_prints_a_table() {
    let place = Place::with(FLUID);
    let list = words(&place.carom(&["validate", "--list"]));
    assert!(list.contains("hard_spheres/0.40") && list.contains("diffusion coefficient"), "{list}");
    let output = place.carom(&["validate", "--brief", "spheres"]);
    let table = words(&output);
    assert_eq!(code(&output), 0, "{table}{}", errors(&output));
    assert!(table.starts_with("quantity") && table.ends_with("PASSED: 10 of 10\n"), "{table}");
    assert!(table.contains("1.01") && table.contains("mKLM 2019") && !table.contains("FAIL"), "{table}");
    assert_eq!(words(&place.carom(&["validate", "--brief", "spheres"])), table, "the same seed gives the same table");
}

#[test]
fn check_says_what_will_be_simulated_and_writes_nothing() {
    let place = Place::with(FLUID);
    let text = words(&place.carom(&["check", "scene.toml"]));
    for expected in ["108 sphere", "packing fraction 0.3,", "hard spheres of contact distance 1", "for 4000 events"] {
        assert!(text.contains(expected), "{expected}: {text}");
    }
    assert_eq!(fs::read_dir(place.path()).unwrap().count(), 1);
}

#[test]
fn check_temperature_of_few_particles_excludes_streaming() {
    let scene = "[space]\nsize = [9.0, 9.0, 9.0]\n[[species]]\nname = 'A'\nmass = 1.0\ndiameter = 1.0\n\
         [[interaction]]\nspecies = ['A', 'A']\npotential = 'hard-sphere'\n\
         [[fill]]\nspecies = 'A'\narrangement = 'random'\ncount = 4\ntemperature = 1.0\n[run]\nuntil_events = 10\n";
    let place = Place::with(scene);
    for set in [&[][..], &["--set", "space.shear_rate=2.0"]] {
        let text = words(&place.carom(&[&["check", "scene.toml"], set].concat()));
        assert!(text.contains("temperature 1 at the start"), "{set:?} {text}");
    }
}

#[test]
fn a_rendered_frame_is_a_png() {
    let place = Place::with(FLUID);
    place.done(&["run", "scene.toml", "--until-events", "100"]);
    place.done(&["render", "runs/scene", "--size", "160x120", "--colour", "speed"]);
    let png = fs::read(place.path().join("runs/scene/picture.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG"));
    // Earlier versions had the command `picture`.
    place.done(&["picture", "runs/scene", "--size", "160x120", "--colour", "speed", "--out", "again.png"]);
    assert_eq!(fs::read(place.path().join("again.png")).unwrap(), png);
}

#[test]
fn a_page_about_a_run_is_one_file_and_names_what_is_missing() {
    let place = Place::with(FLUID);
    place.done(&["run", "scene.toml", "--until-events", "100"]);
    let output = place.carom(&["report", "runs/scene"]);
    assert_eq!((code(&output), errors(&output).as_str()), (0, ""));
    assert_eq!(words(&output).trim(), "runs/scene/report.html");
    assert!(place.read("runs/scene/report.html").contains("108 sphere"));
    fs::remove_file(place.path().join("runs/scene/thermo.csv")).unwrap();
    let output = place.done(&["report", "runs/scene", "--out", "page.html"]);
    assert!(errors(&output).contains("thermo.csv") && place.read("page.html").contains("thermo.csv: "));
    assert_eq!(code(&place.carom(&["report", "runs/scene", "--out", "nowhere/page.html"])), 2);
}

#[test]
fn check_and_run_give_the_same_reproducible_size_estimate() {
    // 4,000 spheres are too many for a trial run. The number of frames is estimated from the number of events.
    let scene = FLUID.replace("count = 108", "count = 4000").replace("until_events = 4000", "until_events = 40000000");
    let place = Place::with(&format!("{scene}[output]\nframe_interval = 0.01\n"));
    let said = || {
        let text = words(&place.carom(&["check", "scene.toml"]));
        text.lines().find(|line| line.contains("writes ")).unwrap().to_owned()
    };
    let first = said();
    assert_eq!(said(), first);
    // The 4,000 spheres have 20,000 collisions per unit of time, so 40,000,000 collisions take a time of 2,000.
    assert!(first.contains(" GB") && first.contains("e5 frames"), "{first}");
    let output = place.carom(&["run", "scene.toml"]);
    assert_eq!(code(&output), 2, "{}", words(&output));
    let bytes = first.rsplit(", ").next().unwrap().trim_start_matches("some ");
    assert!(errors(&output).contains(&format!("would write about {bytes}")), "{first}: {}", errors(&output));
}

#[test]
fn check_warns_of_boxes_and_energies_that_leave_too_few_digits() {
    let scene = |size: f64, depth: f64| {
        format!(
            "[space]\nsize = [{size:e}, 10.0, 10.0]\n[[species]]\nname = 'A'\nmass = 1.3\ndiameter = 1.0\n\
             [[interaction]]\nspecies = ['A', 'A']\npotential = 'square-well'\nlambda = 1.5\nwell_depth = {depth:e}\n\
             [[particle]]\nspecies = 'A'\nposition = [1.0, 1.0, 1.0]\nvelocity = [1.0, 0.0, 0.0]\n\
             [[particle]]\nspecies = 'A'\nposition = [5.0, 1.0, 1.0]\n[run]\nuntil_events = 10\n"
        )
    };
    for (size, depth, expected) in
        [(10.0, 1.0, None), (1e12, 1.0, Some("coordinates")), (10.0, 1e30, Some("steps of up to"))]
    {
        let output = Place::with(&scene(size, depth)).carom(&["check", "scene.toml"]);
        assert_eq!(code(&output), 0, "{}", words(&output));
        let has_warning = words(&output).contains("to rounding") || words(&output).contains("round-off");
        assert_eq!(has_warning, expected.is_some(), "{}", words(&output));
        assert!(expected.is_none_or(|expected| words(&output).contains(expected)), "{}", words(&output));
    }
}

#[test]
fn check_and_run_warn_about_measurements_without_a_value() {
    let measured = |instrument: &str, more: &str| format!("{FLUID}{more}\n[measure]\n{instrument} = true\n");
    let obstacle = "[[species]]\nname = 'post'\nstatic = true\ndiameter = 1.0\n[[particle]]\nspecies = 'post'\nposition = [0.1, 0.1, 0.1]\n\
        [[interaction]]\nspecies = ['sphere', 'post']\npotential = 'hard-sphere'\n";
    let sparse = ["--set", "fill.0.packing_fraction=0.1", "--set", "fill.0.arrangement=random"];
    let elastic = ["--set", "interaction.0.restitution=1.0"];
    let cases: [(&str, &str, &[&str], Option<&str>); 8] = [
        ("transport", "", &elastic, None),
        (
            "transport",
            "",
            &["--set", "interaction.0.restitution=0.9"],
            Some("no results with contacts that lose energy"),
        ),
        ("transport", "", &["--set", "dynamics.gravity=[0.0, 0.0, -1.0]"], Some("no results with gravity")),
        (
            "transport",
            "",
            &["--set", "run.thermostat={ kind = 'andersen', temperature = 1.0, rate = 1.0 }"],
            Some("no results with a heat bath"),
        ),
        ("transport", obstacle, &sparse, Some("no results in a box with non-periodic axes")),
        ("pressure_tensor", "", &elastic, None),
        ("pressure_tensor", obstacle, &sparse, Some("event rates but no pressure")),
        ("free_paths", obstacle, &sparse, None),
    ];
    for (instrument, more, set, expected) in cases {
        let place = Place::with(&measured(instrument, more));
        let told = |command: &[&str]| {
            let output = place.carom(&[command, set].concat());
            assert_eq!(code(&output), 0, "{command:?}: {}", errors(&output));
            words(&output) + &errors(&output)
        };
        for told in [told(&["check", "scene.toml"]), told(&["run", "scene.toml", "-q", "--until-events", "100"])] {
            let warning = told.lines().find(|line| line.starts_with(&format!("warning: measure.{instrument}")));
            let is_told = expected.map(|expected| warning.is_some_and(|line| line.contains(expected)));
            assert_eq!(is_told, warning.map(|_| true), "{instrument}, {set:?}: {told}");
        }
    }
}

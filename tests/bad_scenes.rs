//! Every invalid scene gives the error in `bad_scenes/cases.toml`, with the line number.

#[path = "bad_scenes/cases.rs"]
mod cases;

use std::path::{Path, PathBuf};

use carom::model::{Restitution, Scene};
use carom::scene::{
    ConfigPath, EXCLUSIONS, Exclusion, InteractionDraft, PathStep, SceneError, SceneErrorKind, SpeciesDraft,
};
use cases::{Case, FOLDER, bases, cases};
use miette::Diagnostic;
use proptest::prelude::*;

fn path_of(name: &str) -> PathBuf {
    Path::new(FOLDER).join(name).with_extension("toml")
}

fn error_of(name: &str) -> SceneError {
    Scene::from_toml(cases()[name].scene.as_str(), path_of(name)).unwrap_err()
}

fn rendered(error: &SceneError) -> String {
    let mut text = String::new();
    let handler = miette::GraphicalReportHandler::new_themed(miette::GraphicalTheme::unicode_nocolor()).with_width(200);
    handler.render_report(&mut text, error).unwrap();
    text
}

#[test]
fn every_bad_scene_gives_its_expected_error() {
    let mut failures = Vec::new();
    let cases = cases();
    assert!(cases.len() > 200, "only {} bad scenes", cases.len());
    for (name, Case { scene, line, message }) in &cases {
        let path = path_of(name);
        match Scene::from_toml(scene.as_str(), &path) {
            Ok(_) => failures.push(format!("{name}: no error")),
            Err(error) => {
                if !error.to_string().contains(message) {
                    failures.push(format!("{name}: expected `{message}`, got `{error}`"));
                }
                if error.line() != Some(*line) {
                    failures.push(format!("{name}: expected line {line}, got {:?}: {error}", error.line()));
                }
                if !rendered(&error).contains(&format!("{}:{line}:", path.display())) {
                    failures.push(format!("{name}: the report does not show the place:\n{}", rendered(&error)));
                }
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// The keys of a path without indices, such as `surface.motion`.
fn keys(at: &ConfigPath) -> String {
    let keys = at.steps().iter().filter_map(|step| match step {
        PathStep::Key(key) => Some(key.as_ref()),
        _ => None,
    });
    keys.collect::<Vec<&str>>().join(".")
}

#[test]
fn every_exclusion_is_the_error_of_a_bad_scene() {
    let cases = cases();
    let errors = cases.iter().filter_map(|(name, case)| Scene::from_toml(case.scene.as_str(), path_of(name)).err());
    let errors: Vec<SceneError> = errors.collect();
    let is_for = |row: &Exclusion, error: &SceneError| {
        let SceneErrorKind::Value { value, expected } = error.kind() else { return false };
        let key = keys(error.config_path());
        let is_at = row.feature.keys.is_empty() || row.feature.keys.contains(&key.as_str());
        is_at && value.ends_with(row.circumstance) && *expected == row.expected()
    };
    let missing: Vec<_> = EXCLUSIONS.iter().filter(|row| !errors.iter().any(|error| is_for(row, error))).collect();
    assert!(missing.is_empty(), "no scene in {FOLDER}/cases.toml has these errors: {missing:#?}");
}

#[test]
fn every_base_is_valid() {
    for (name, text) in bases() {
        Scene::from_toml(text, path_of(&format!("base/{name}")))
            .unwrap_or_else(|error| panic!("{name}: {}", rendered(&error)));
    }
}

#[test]
fn the_nearest_key_is_suggested() {
    let help_of = |name| error_of(name).help().unwrap().to_string();
    assert_eq!(help_of("unknown_key"), "did you mean `restitution`?");
    assert_eq!(help_of("unknown_potential"), "did you mean `hard-sphere`?");
}

#[test]
fn empty_and_non_text_files_are_errors() {
    let directory = tempfile::tempdir().unwrap();
    let kind_of = |bytes: &[u8]| {
        let path = directory.path().join("scene.toml");
        std::fs::write(&path, bytes).unwrap();
        let error = Scene::from_file(&path).unwrap_err();
        assert!(!rendered(&error).is_empty());
        error
    };
    assert!(matches!(kind_of(b"").kind(), SceneErrorKind::Empty));
    assert!(matches!(kind_of(b"\n# nothing\n").kind(), SceneErrorKind::Empty));
    assert!(matches!(kind_of(b"seed = 1\n\xff\xfe").kind(), SceneErrorKind::NotText { offset: 9 }));
    assert!(matches!(kind_of(b"\x7fELF\x01\x00\x00").kind(), SceneErrorKind::Syntax { .. }));
    let unreadable = |path: &std::path::Path| Scene::from_file(path).unwrap_err();
    assert!(matches!(unreadable(directory.path()).kind(), SceneErrorKind::Unreadable { .. }));
    assert!(matches!(unreadable(&directory.path().join("none")).kind(), SceneErrorKind::Unreadable { .. }));
}

const GOOD: &str = include_str!("../configs/pendulum.toml");

#[test]
fn overrides_replace_and_add_values_by_index_or_name() {
    let scene = Scene::from_toml_with(
        GOOD,
        "pendulum.toml",
        &[
            ("seed", "5"),
            ("interaction.0.restitution", "0.1"),
            ("interaction.link.restitution", "1"),
            ("species.bob.mass", "2.5"),
            ("run.until_events", "1000"),
            ("output.frame_interval", " 0.5"),
            ("name", "swing"),
        ],
    )
    .unwrap();
    assert_eq!((scene.seed(), scene.name(), scene.run().limit.events), (5, "swing", Some(1000)));
    assert_eq!(scene.interactions()[0].law.restitution, Restitution::Constant(0.1));
    assert_eq!(
        scene.interactions()[scene.bonds()[0].interaction.0 as usize].law.restitution,
        Restitution::Constant(1.0)
    );
    assert_eq!(scene.species()[2].mass, 2.5);
    assert_eq!(scene.output().frame_interval, Some(0.5));
}

#[test]
fn error_in_an_override_shows_the_override() {
    let refused = |key: &str, value: &str| {
        let error = Scene::from_toml_with(GOOD, "pendulum.toml", &[("seed", "2"), (key, value)]).unwrap_err();
        rendered(&error)
    };
    for (key, value, expected) in [
        ("interaction.0.restitution", "1.5", "interaction[0].restitution is 1.5"),
        ("interaction.9.restitution", "1", "`interaction` has 5 entries"),
        ("seed.x", "1", "so there is no `x` in it"),
        ("seed", "fast", "invalid type: string \"fast\""),
        ("run.until_tme", "1", "did you mean `until_time`?"),
        ("", "1", "a part of the key is empty"),
        ("species.bob.mass", "1\nx = 2", "invalid type: string"),
    ] {
        let report = refused(key, value);
        assert!(report.contains(expected), "{report}");
        assert!(report.contains("override"), "{report}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1024, ..ProptestConfig::default() })]

    #[test]
    fn arbitrary_text_never_panics(text in any::<String>(), bytes in any::<Vec<u8>>()) {
        let _ = Scene::from_toml(text, "scene.toml").map_err(|error| rendered(&error));
        let _ = Scene::from_toml(String::from_utf8_lossy(&bytes), "scene.toml").map_err(|error| rendered(&error));
    }

    #[test]
    fn mutations_of_a_scene_never_panic(
        which in 0_usize..4,
        cuts in prop::collection::vec((any::<prop::sample::Index>(), 0_usize..6, "[-0-9einaf.\\[\\]{}\"=#\n ]{0,4}"), 1..4),
    ) {
        let base = [GOOD, FLUID, MESHED, CHAINS][which];
        let mut characters: Vec<char> = base.chars().collect();
        for (at, length, inserted) in cuts {
            let start = at.index(characters.len());
            let end = (start + length).min(characters.len());
            characters.splice(start..end, inserted.chars());
        }
        let text: String = characters.into_iter().collect();
        let _ = Scene::from_toml(text, "scene.toml").map_err(|error| rendered(&error));
    }

    #[test]
    fn any_numbers_in_a_scene_never_panic(
        values in prop::array::uniform8(prop_oneof![
            any::<f64>(), Just(0.0), Just(1.0), Just(f64::INFINITY), Just(f64::NAN), Just(1e-300), -3.0..30.0_f64,
        ]),
        count in prop_oneof![0_u64..40, any::<u64>()],
        arrangement in prop::sample::select(vec!["sc", "bcc", "fcc", "hcp", "random", "line", "square"]),
    ) {
        let [a, b, c, d, e, f, g, h] = values.map(|value| format!("{value:?}").replace("NaN", "nan"));
        let text = format!(
            "[space]\nsize = [{a}, {b}, {c}]\nlower = [{h}, 0.0, 0.0]\nx = \"walls\"\n[dynamics]\ngravity = [0.0, {d}, 0.0]\n\
             [[species]]\nname = \"A\"\nmass = {e}\ndiameter = {f}\n\
             [[species]]\nname = \"M\"\nstatic = true\ndiameter = {f}\n\
             [[interaction]]\nspecies = [\"A\", \"A\"]\npotential = \"square-well\"\nlambda = {g}\nwell_depth = 1\n\
             [[interaction]]\nspecies = [\"A\", \"M\"]\npotential = \"hard-sphere\"\n\
             [[fill]]\nspecies = \"A\"\narrangement = \"{arrangement}\"\ncount = {count}\ntemperature = {h}\n\
             [[mesh]]\nspecies = \"M\"\nsurface = \"sphere\"\ncentre = [{a}, 1, 1]\nradius = {g}\n[run]\nuntil_time = {e}\n",
        );
        let _ = Scene::from_toml(text, "scene.toml").map_err(|error| rendered(&error));
    }
}

const FLUID: &str = "[[species]]\nname = \"A\"\nmass = 1.0\ndiameter = 1.0\n[[interaction]]\nspecies = [\"A\", \"A\"]\n\
    potential = \"square-well\"\nlambda = 1.5\nwell_depth = 1.0\n[[fill]]\nspecies = \"A\"\narrangement = \"fcc\"\n\
    count = 32\nnumber_density = 0.3\ntemperature = 1.0\n[run]\nuntil_events = 10\n";

const MESHED: &str = "[space]\nsize = [20.0, 20.0, 20.0]\nx = \"open\"\ny = \"walls\"\nz = { lower = \"wall\", upper = \
    \"open\", restitution = 0.5 }\n[[species]]\nname = \"A\"\nmass = 1.0\ndiameter = 1.0\n[[species]]\nname = \"M\"\n\
    static = true\ndiameter = 1.0\n[[interaction]]\nspecies = [\"A\", \"M\"]\npotential = \"hard-sphere\"\n\
    [[particle]]\nspecies = \"A\"\nposition = [10, 10, 10]\n[[mesh]]\nspecies = \"M\"\nsurface = \"box\"\nlower = \
    [5.0, 5.0, 5.0]\nupper = [15.0, 15.0, 15.0]\nopen = [\"top\"]\n[[mesh]]\nspecies = \"M\"\nsurface = \"cone\"\n\
    base = [10, 10, 15]\naxis = [0, 0, 1]\nradii = [2, 4]\nlength = 3\n[run]\nuntil_time = 1.0\n";

const CHAINS: &str = "[space]\nsize = [10.0, 10.0, 10.0]\n[[species]]\nname = \"A\"\nmass = 1.0\ndiameter = 1.0\n\
    [[interaction]]\nspecies = [\"A\", \"A\"]\npotential = \"hard-sphere\"\n[[interaction]]\nname = \"link\"\n\
    potential = \"bond\"\nlambda = 1.2\n[[chain]]\nspecies = \"A\"\nlength = 5\ncount = 4\nbond = \"link\"\n\
    temperature = 1.0\n[[fill]]\nspecies = \"A\"\narrangement = \"random\"\ncount = 20\n[run]\nuntil_time = 1.0\n";

#[test]
fn the_scenes_that_are_mutated_are_valid() {
    for text in [GOOD, FLUID, MESHED, CHAINS] {
        Scene::from_toml(text, "scene.toml").unwrap_or_else(|error| panic!("{}", rendered(&error)));
    }
}

#[test]
fn more_interactions_than_16_bit_ids_are_rejected() {
    use carom::model::potential::Potential;
    let species = 363;
    let mut scene = carom::scene::SceneBuilder::new("many");
    for a in 0..species {
        scene = scene.species(SpeciesDraft::new(&format!("s{a}")).mass(1.0).diameter(1.0));
    }
    for a in 0..species {
        for b in a..species {
            let diameter = 1.0 + f64::from(a * species + b) * 1e-6;
            scene = scene.interaction(
                InteractionDraft::new(Potential::hard_sphere(diameter).unwrap())
                    .between(&format!("s{a}"), &format!("s{b}")),
            );
        }
    }
    let error = scene.space(carom::model::space::Space::periodic_cube(10.0)).build().unwrap_err().to_string();
    assert!(error.contains("65536"), "{error}");
}

//! The schema of scene files has the same keys, words, limits and defaults as the program.

#[path = "../bad_scenes/cases.rs"]
mod cases;
mod validator;

use std::collections::BTreeSet;
use std::process::Command;

use carom::model::Scene;
use carom::scene::{SceneError, SceneErrorKind};
use cases::cases;
use serde_json::{Value, json};
use validator::{mistakes, schema};

const EVERY_KEY: &str = include_str!("every_key.toml");

fn json_of(text: &str) -> Value {
    let table: toml::Table = text.parse().unwrap();
    serde_json::to_value(table).unwrap()
}

fn program(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_carom")).args(arguments).output().unwrap();
    assert!(output.status.success(), "{arguments:?}");
    String::from_utf8(output.stdout).unwrap()
}

/// A folder with the scene [`EVERY_KEY`] and its coordinate file.
struct Base(tempfile::TempDir);

impl Base {
    fn new() -> Self {
        let directory = tempfile::tempdir().unwrap();
        let coordinates = "1\nProperties=species:S:1:pos:R:3:velo:R:3\nA 20 5 5 0 0 0\n";
        std::fs::write(directory.path().join("start.xyz"), coordinates).unwrap();
        Self(directory)
    }

    fn with(&self, key: &str, value: &str) -> Result<Scene, SceneError> {
        Scene::from_toml_with(EVERY_KEY, self.0.path().join("scene.toml"), &[(key, value)])
    }
}

/// Calls `visit` for every property of a schema, with the path of the property and its value in the scene, if any.
fn walk(schema: &Value, value: Option<&Value>, path: &str, visit: &mut impl FnMut(&str, &Value, Option<&Value>)) {
    for (key, property) in schema["properties"].as_object().into_iter().flatten() {
        let value = value.and_then(|table| table.get(key));
        let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        visit(&path, property, value);
        walk(property, value, &path, visit);
    }
    for branch in schema["anyOf"].as_array().into_iter().flatten() {
        walk(branch, value, path, visit);
    }
    if schema["items"]["properties"].is_object() {
        let entries = value.and_then(Value::as_array).cloned().unwrap_or_default();
        if entries.is_empty() {
            walk(&schema["items"], None, &format!("{path}.0"), visit);
        }
        for (index, entry) in entries.iter().enumerate() {
            walk(&schema["items"], Some(entry), &format!("{path}.{index}"), visit);
        }
    }
}

#[test]
fn carom_schema_prints_the_schema_with_its_id_and_title() {
    let schema = schema();
    assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
    assert_eq!(schema["$id"], "urn:carom:scene");
    assert_eq!(schema["title"], "Carom scene");
    let printed = program(&["schema"]);
    assert!(printed.ends_with("}\n") && !printed.ends_with("\n\n"));
    assert_eq!(printed, program(&["schema"]));
    assert_eq!(serde_json::from_str::<Value>(&printed).unwrap(), schema);
}

/// Unicode classes need a flag in ECMA-262, and Python's `re` does not support them.
#[test]
fn patterns_use_no_unicode_classes_or_escapes() {
    let mut patterns = Vec::new();
    walk(&schema(), None, "", &mut |path, property, _| {
        if let Some(pattern) = property["pattern"].as_str() {
            assert!(!pattern.contains(r"\p") && !pattern.contains(r"\u"), "{path}: {pattern}");
            patterns.push(pattern.to_owned());
        }
    });
    assert!(patterns.len() > 5, "{patterns:?}");
    assert!(!program(&["schema"]).contains(r"\\p"));
}

#[test]
fn every_key_is_described() {
    walk(&schema(), None, "", &mut |path, property, _| {
        let description = property["description"].as_str().unwrap_or_else(|| panic!("{path} has no description"));
        assert!(description.ends_with('.') && !description.contains('\n'), "{path}: {description}");
    });
}

#[test]
fn shapes_are_described_for_their_own_table() {
    let mut left = vec![("fill.0.region.shape", "of the region"), ("mesh.0.surface", "of the static surface")];
    walk(&schema(), None, "", &mut |path, property, _| {
        let description = property["description"].as_str().unwrap_or_default();
        left.retain(|(place, expected)| path != *place || !description.contains(expected));
    });
    assert_eq!(left, [], "not found, or with another description");
}

#[test]
fn schema_accepts_scenes_of_configs_and_of_carom_new() {
    let schema = schema();
    let mut texts = vec![("every_key".to_owned(), EVERY_KEY.to_owned())];
    for entry in std::fs::read_dir("configs").unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        texts.push((path.display().to_string(), std::fs::read_to_string(path).unwrap()));
    }
    for kind in [
        "fluid",
        "well",
        "lennard-jones",
        "hopper",
        "pendulum",
        "polymer",
        "granular",
        "ball",
        "maxwell",
        "brownian",
        "cradle",
    ] {
        texts.push((format!("carom new {kind}"), program(&["new", kind])));
    }
    assert!(texts.len() >= 18);
    for (name, text) in texts {
        assert_eq!(mistakes(&schema, &json_of(&text)), [""; 0], "{name}");
    }
}

/// The schema must reject these scenes of `tests/bad_scenes`.
const REFUSED: [&str; 41] = [
    "barostat_with_negative_pressure",
    "bond_id_too_large",
    "bond_name_with_a_space",
    "fractional_count",
    "infinite_diameter",
    "key_of_another_potential",
    "lambda_of_one",
    "missing_key",
    "missing_run",
    "nan_mass",
    "negative_audit_limit",
    "negative_count",
    "negative_frame_interval",
    "negative_mass",
    "negative_size",
    "negative_temperature",
    "negative_temperature_of_one_wall",
    "negative_wall_restitution",
    "no_species",
    "region_name_like_a_formula",
    "restitution_above_one",
    "restitution_of_one_wall_above_one",
    "scene_name_with_a_slash",
    "species_name_like_a_formula",
    "species_name_too_long",
    "species_name_with_a_backslash",
    "species_name_with_a_quote",
    "species_name_with_an_escape_character",
    "unknown_arrangement",
    "unknown_boundary",
    "unknown_key",
    "unknown_key_at_the_top",
    "unknown_potential",
    "unknown_section",
    "unknown_side",
    "vector_too_short",
    "wrong_type",
    "zero_contact_time",
    "zero_count",
    "zero_diameter",
    "zero_events",
];

#[test]
fn schema_reports_one_mistake_per_bad_scene() {
    let schema = schema();
    let cases = cases();
    for name in REFUSED {
        let case = &cases[name];
        let found = mistakes(&schema, &json_of(&case.scene));
        assert_eq!(found.len(), 1, "{name}, `{}` in line {}: {found:?}", case.message, case.line);
    }
}

#[test]
fn reader_and_schema_have_the_same_keys() {
    let mut tables = vec![(String::new(), schema())];
    collect_tables(&schema(), &mut Vec::new(), &mut tables);
    assert!(tables.len() > 30, "{}", tables.len());
    for (header, table) in tables {
        let text = format!("{header}no_such_key = 1\n");
        let error = Scene::from_toml(text.as_str(), "scene.toml").unwrap_err();
        // The first error may be a missing key.
        let known = std::iter::once(&error).chain(error.others()).find_map(|error| match error.kind() {
            SceneErrorKind::UnknownKey { known, .. } => Some(known),
            _ => None,
        });
        let known = known.unwrap_or_else(|| panic!("{text}{error}"));
        let known: BTreeSet<&str> = known.iter().map(String::as_str).collect();
        let described: BTreeSet<&str> = table["properties"].as_object().unwrap().keys().map(String::as_str).collect();
        assert_eq!(known, described, "{header}");
        assert_eq!(table["additionalProperties"], false, "{header}");
    }
}

/// Collects the tables of a scene, each with its TOML headers.
fn collect_tables(schema: &Value, path: &mut Vec<(String, bool)>, tables: &mut Vec<(String, Value)>) {
    for (key, property) in schema["properties"].as_object().into_iter().flatten() {
        let choices = property["anyOf"].as_array().cloned().unwrap_or_else(|| vec![property.clone()]);
        for choice in choices {
            let is_list = choice["type"] == "array";
            let table = if is_list { &choice["items"] } else { &choice };
            if !table["properties"].is_object() {
                continue;
            }
            path.push((key.clone(), is_list));
            let mut header = String::new();
            for (depth, (_, is_list)) in path.iter().enumerate() {
                let keys: Vec<&str> = path[..=depth].iter().map(|(key, _)| key.as_str()).collect();
                let keys = keys.join(".");
                header += &if *is_list { format!("[[{keys}]]\n") } else { format!("[{keys}]\n") };
            }
            tables.push((header, table.clone()));
            collect_tables(table, path, tables);
            path.pop();
        }
    }
}

#[test]
fn reader_and_schema_accept_the_same_words() {
    let base = Base::new();
    let mut in_schema = BTreeSet::new();
    collect_words(&schema(), &mut in_schema);
    let mut in_reader = BTreeSet::new();
    for (key, value) in [
        ("space.x", "'?'"),
        ("space.z.upper", "'?'"),
        ("interaction.0.potential", "'?'"),
        ("fill.0.arrangement", "'?'"),
        ("fill.1.region.shape", "'?'"),
        ("mesh.0.surface", "'?'"),
        ("surface.0.shape", "'?'"),
        ("surface", "[{ shape = 'sphere', centre = [30.0, 36.0, 36.0], radius = 1.0, side = '?' }]"),
        ("mesh.0.open", "['?']"),
        ("surface.1.motion.0.kind", "'?'"),
        ("run.thermostat.kind", "'?'"),
        ("dynamics.tc_rule", "'?'"),
        ("run.equilibration", "'?'"),
        ("stage.0.thermostat.axes", "['?']"),
        ("measure.flow.0.axis", "'?'"),
        ("measure.flow.0.direction", "'?'"),
        ("output.formats", "['?']"),
        ("live.colour", "'?'"),
        ("live.slider.0.scale", "'?'"),
        ("species.0.diameter", "{ distribution = '?' }"),
        ("species.0.diameters", "'?'"),
        ("species", "[{ name = 'A', mass = 1.0, diameter = 1.0, diameters = 'individual', masses = '?' }]"),
        ("exchange", "{ temperatures = [1.0, 2.0], interval = 1.0, rate = 1.0, ensemble = '?' }"),
    ] {
        let error = base.with(key, value).unwrap_err();
        let SceneErrorKind::UnknownWord { known, .. } = error.kind() else { panic!("{key}: {error}") };
        assert!(in_schema.contains(known), "{key}: {known:?}");
        in_reader.insert(known.clone());
    }
    assert_eq!(in_schema, in_reader);
}

fn collect_words(schema: &Value, lists: &mut BTreeSet<Vec<String>>) {
    match schema {
        Value::Object(members) => {
            for (key, member) in members {
                match member {
                    Value::Array(words) if key == "enum" => {
                        lists.insert(words.iter().map(|word| word.as_str().unwrap().to_owned()).collect());
                    }
                    _ => collect_words(member, lists),
                }
            }
        }
        Value::Array(items) => items.iter().for_each(|item| collect_words(item, lists)),
        _ => {}
    }
}

#[test]
fn schema_defaults_are_those_of_the_reader() {
    let base = Base::new();
    let scene = base.with("name", "every_key").unwrap();
    let mut count = 0;
    let every_key = json_of(EVERY_KEY);
    walk(&schema(), Some(&every_key), "", &mut |path, property, value| {
        let parent = path.rsplit_once('.').map_or("", |(parent, _)| parent).replace('.', "/");
        let is_reachable = parent.is_empty() || every_key.pointer(&format!("/{parent}")).is_some_and(Value::is_object);
        let (Some(default), None, true) = (property.get("default"), value, is_reachable) else { return };
        match base.with(path, &default.to_string()) {
            Ok(with) => assert!(with == scene, "{path} = {default} makes another scene"),
            Err(error) => {
                let is_of_another_kind = matches!(error.kind(), SceneErrorKind::Misplaced { .. });
                assert!(is_of_another_kind, "{path} = {default}: {error}");
            }
        }
        count += 1;
    });
    assert!(count > 20, "only {count} defaults");
}

#[test]
fn schema_limits_are_those_of_the_reader() {
    let base = Base::new();
    let mut count = 0;
    walk(&schema(), Some(&json_of(EVERY_KEY)), "", &mut |path, property, value| {
        if value.is_none_or(|value| !value.is_number()) {
            return;
        }
        let is_whole = property["type"] == "integer";
        for (keyword, outside) in
            [("minimum", -1.0), ("maximum", 1.0), ("exclusiveMinimum", 0.0), ("exclusiveMaximum", 0.0)]
        {
            let Some(limit) = property[keyword].as_f64() else { continue };
            let text = |number: f64| if is_whole { format!("{number:.0}") } else { format!("{number:?}") };
            assert_eq!(mistakes(property, &json!(limit + outside)).len(), 1, "{path}");
            let error = base.with(path, &text(limit + outside)).unwrap_err();
            use SceneErrorKind as E;
            let is_about_it = matches!(
                error.kind(),
                E::Value { .. } | E::Syntax { .. } | E::Potential(_) | E::PackingFraction { .. }
            );
            assert!(is_about_it, "{path} = {}: {error}", limit + outside);
            // Equal spheres cannot reach the limit of a packing fraction.
            if outside != 0.0 && !path.ends_with("packing_fraction") {
                let accepted = base.with(path, &text(limit));
                assert!(accepted.is_ok(), "{path} = {limit}: {}", accepted.unwrap_err());
            }
            count += 1;
        }
    });
    assert!(count > 50, "only {count} limits");
}

#[test]
fn schema_rejects_numbers_outside_the_ranges_of_the_reader() {
    let base = Base::new();
    let mut count = 0;
    walk(&schema(), Some(&json_of(EVERY_KEY)), "", &mut |path, property, value| {
        // These limits depend on other keys.
        let is_relative = path.ends_with(".height") || path.starts_with("live.slider");
        if value.is_none_or(|value| !value.is_number()) || is_relative {
            return;
        }
        let is_whole = property["type"] == "integer";
        for number in [-1.0, 0.0, 0.5, 1.0, 2.0] {
            let text = if is_whole && number != 0.5 { format!("{number:.0}") } else { format!("{number:?}") };
            let Err(error) = base.with(path, &text) else { continue };
            let is_by_itself = matches!(error.kind(), SceneErrorKind::Value { .. } | SceneErrorKind::Syntax { .. });
            if is_by_itself {
                assert!(!mistakes(property, &json!(number)).is_empty(), "{path} = {number}: {error}");
                count += 1;
            }
        }
    });
    assert!(count > 100, "only {count} refusals");
}

use std::fs;
use std::path::Path;

use super::*;
use crate::analysis::instruments::{Curve, Measured, Number, Published, Series, Variable};
use crate::io::{Existing, Folder};
use crate::model::Scene;
use crate::run;

mod surfaces;
mod system;

const SCENE: &str = r#"
name = "scene"
seed = 3
[space]
size = [6.0, 6.0, 6.0]
[[species]]
name = "AB"
mass = 1.0
diameter = 1.0
[[interaction]]
species = ["AB", "AB"]
potential = "square-well"
lambda = 1.5
well_depth = 1.0
[[fill]]
species = "AB"
arrangement = "sc"
count = 27
temperature = 1.0
[run]
until_events = 500
[[output.count]]
name = "half"
lower = [0.0, 0.0, 0.0]
upper = [3.0, 6.0, 6.0]
"#;

const GROWN: &str = r#"
name = "grown"
[[species]]
name = "A"
mass = 1.0
diameter = 1.0
[[interaction]]
species = ["A", "A"]
potential = "hard-sphere"
[[fill]]
species = "A"
arrangement = "random"
count = 32
packing_fraction = 0.2
temperature = 1.0
[[stage]]
name = "compress"
grow = { rate = 0.2, packing_fraction = 0.4 }
[run]
until_events = 500
thermostat = { kind = "rescaling", temperature = 1.0, interval = 0.1 }
"#;

fn run_folder() -> tempfile::TempDir {
    folder_of(SCENE)
}

fn folder_of(text: &str) -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    let scene = Scene::from_toml(text, "scene.toml").unwrap();
    let mut folder = Folder::create(place.path(), &scene, Existing::Keep).unwrap();
    folder.keep_scene(text).unwrap();
    let finished = run::run(scene, &mut folder, &mut |_| std::ops::ControlFlow::Continue(())).unwrap();
    folder.complete(&finished, "").unwrap();
    place
}

const HOSTILE: &str = "</script><script>alert('\"&')</script>";

fn measured() -> Measured {
    let number = |mean, standard_error| Number {
        name: format!("number {mean:?}"),
        title: HOSTILE.to_owned(),
        unit: "length^2 / time".to_owned(),
        mean,
        standard_error,
        method: HOSTILE.to_owned(),
    };
    let variable = |name: &str, values: Vec<f64>| Variable { name: name.to_owned(), unit: HOSTILE.to_owned(), values };
    let series = |values: Vec<Option<f64>>| Series {
        name: HOSTILE.to_owned(),
        unit: "1".to_owned(),
        standard_errors: values.iter().map(|value| value.map(|value| 0.1 * value)).collect(),
        normalisation: None,
        values,
    };
    let curve = |variables: Vec<Variable>, series: Vec<Series>, is_logarithmic| Curve {
        name: HOSTILE.to_owned(),
        title: HOSTILE.to_owned(),
        method: HOSTILE.to_owned(),
        variables,
        series,
        is_logarithmic,
        published: vec![Published {
            label: HOSTILE.to_owned(),
            source: HOSTILE.to_owned(),
            x: vec![1.0, 2.0],
            y: vec![1e300, -1.0],
        }],
    };
    let xs = || variable("x", vec![0.0, 1.0, 2.0, 3.0]);
    let some = || series(vec![Some(1e-300), None, Some(-1.0), Some(5.0)]);
    let none = || series(vec![None; 4]);
    let ys = || variable("y", vec![1.0, 1.0, 2.0, 2.0]);
    let long = (0..500).map(f64::from).collect::<Vec<_>>();
    Measured {
        numbers: vec![number(Some(1.0), Some(0.25)), number(None, None), number(Some(2.0), None)],
        curves: vec![
            curve(vec![xs()], vec![some(), none()], [false, false]),
            curve(vec![xs()], vec![some()], [true, true]),
            curve(vec![xs()], vec![none()], [false, true]),
            curve(vec![variable("x", long.clone())], vec![series(long.into_iter().map(Some).collect())], [true, false]),
            curve(vec![xs(), ys()], vec![some(), none()], [false, true]),
            curve(vec![xs(), ys(), xs()], vec![some()], [false, false]),
        ],
    }
}

fn keep_measured(run: &Path) {
    fs::write(run.join("measurements.json"), serde_json::to_string(&measured()).unwrap()).unwrap();
}

/// Checks that XML elements are closed in order, attributes are quoted, and entities are known.
fn well_formed(xml: &str) -> Result<(), String> {
    let mut open: Vec<&str> = Vec::new();
    let mut rest = xml;
    while let Some(start) = rest.find('<') {
        characters(&rest[..start])?;
        let end = rest[start..].find('>').ok_or("an open tag")? + start;
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        if let Some(name) = tag.strip_prefix('/') {
            if open.pop() != Some(name) {
                return Err(format!("</{name}> closes nothing"));
            }
            continue;
        }
        let inner = tag.strip_suffix('/').unwrap_or(tag);
        let (name, attributes) = inner.split_once(' ').unwrap_or((inner, ""));
        let parts: Vec<&str> = attributes.split('"').collect();
        let is_sound = parts.len() % 2 == 1
            && parts.last().is_some_and(|last| last.is_empty())
            && parts.chunks_exact(2).all(|two| two[0].ends_with('='));
        if !is_sound || !name.chars().all(char::is_alphanumeric) {
            return Err(format!("<{tag}>"));
        }
        characters(attributes)?;
        if !tag.ends_with('/') {
            open.push(name);
        }
    }
    characters(rest)?;
    if open.is_empty() { Ok(()) } else { Err(format!("{open:?} are not closed")) }
}

fn characters(text: &str) -> Result<(), String> {
    let is_known = |part: &str| ["amp;", "lt;", "gt;", "quot;", "#39;"].iter().any(|entity| part.starts_with(entity));
    if text.contains('>') || !text.split('&').skip(1).all(is_known) {
        return Err(format!("text `{text}`"));
    }
    Ok(())
}

fn plots(html: &str) -> Vec<&str> {
    html.split("<svg class=\"plot\"").skip(1).map(|rest| rest.split("\n").next().unwrap()).collect()
}

#[test]
fn the_same_files_give_the_same_bytes() {
    let run = run_folder();
    keep_measured(run.path());
    let first = page(run.path()).unwrap();
    assert_eq!(first, page(run.path()).unwrap());
    assert_eq!(first.notes, [""; 0]);
    let out = run.path().join("report.html");
    write(&first, &out, Existing::Keep).unwrap();
    write(&first, &out, Existing::Keep).unwrap();
    let other = Page { html: String::new(), notes: Vec::new() };
    assert!(matches!(write(&other, &out, Existing::Keep), Err(ViewError::Exists(_))));
    assert_eq!(fs::read_to_string(out).unwrap(), first.html);
    assert!(matches!(write(&first, run.path(), Existing::Replace), Err(ViewError::Write { .. })));
}

#[test]
fn page_describes_the_scene_and_its_results() {
    let run = run_folder();
    let html = page(run.path()).unwrap().html;
    for expected in [
        "<h1>scene ",
        "seed 3",
        "27 AB",
        "hard core 1 with a square well of depth 1, range 1.5",
        "✓ Sound.",
        "energy ledger",
        "compressibility factor",
        "in half",
        "neighbours within a well",
        "arrangement = &quot;sc&quot;",
    ] {
        assert!(html.contains(expected), "{expected}");
    }
    assert!(!html.contains("Not everything is on this page"));
    for foreign in ["http://", "https://", "src=", "@import", "url("] {
        let others = html.replace("http://www.w3.org/2000/svg", "");
        assert!(!others.contains(foreign), "{foreign}");
    }
}

#[test]
fn page_shows_diameters_after_growth() {
    let run = folder_of(GROWN);
    let html = page(run.path()).unwrap().html;
    // Growth from a packing fraction of 0.2 to 0.4 multiplies diameters by the cube root of 2.
    for expected in ["of diameter 1.25992", "contact distance 1.25992", "packing fraction of 0.4"] {
        assert!(html.contains(expected), "{expected}");
    }
    assert!(!page(run_folder().path()).unwrap().html.contains("after growth"));
}

#[test]
fn the_page_tells_whether_the_run_was_in_equilibrium() {
    let run = run_folder();
    let path = run.path().join("summary.json");
    let mut summary: serde_json::Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
    let mut with = |equilibrated: serde_json::Value| {
        summary["equilibrated"] = equilibrated;
        fs::write(&path, summary.to_string()).unwrap();
        page(run.path()).unwrap().html
    };
    let html = with(serde_json::json!({ "verdict": "no", "reasons": ["pressure drifts by 1.1"] }));
    assert!(
        html.contains("✗ not equilibrated") && html.contains("Equilibrated: no.") && html.contains("drifts by 1.1")
    );
    assert!(html.contains("✓ Sound."), "the audit is another question");
    let html = with(serde_json::json!({ "verdict": "yes", "reasons": [] }));
    assert!(html.contains("✓ equilibrated") && html.contains("Equilibrated: yes."));
    // Earlier versions wrote no verdict.
    summary.as_object_mut().unwrap().remove("equilibrated");
    fs::write(&path, summary.to_string()).unwrap();
    assert!(page(run.path()).unwrap().html.contains("Equilibrated: unknown"));
}

#[test]
fn energies_that_are_plotted_add_up() {
    let run = folder_of(GROWN);
    let thermo = fs::read_to_string(run.path().join("thermo.csv")).unwrap();
    let mut lines = thermo.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let column = |name: &str| names.iter().position(|column| column.starts_with(name)).unwrap();
    let [kinetic, sum, supplied] = ["kinetic", "energy_and_dissipated", "supplied"].map(column);
    let mut rows = 0;
    for line in lines.filter(|line| line.ends_with(",measurement")) {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap_or(0.0)).collect();
        // Hard spheres have no potential energy. The bound allows for a thousand rounded terms.
        assert!((cells[kinetic] - cells[supplied] - cells[sum]).abs() < 1e-10, "{line}");
        assert!(cells[supplied] != 0.0);
        rows += 1;
    }
    assert!(rows > 2);
    let html = page(run.path()).unwrap().html;
    assert!(html.contains("kinetic + potential + dissipated - supplied") && html.contains("energy supplied"));
    let html = page(run_folder().path()).unwrap().html;
    assert!(html.contains("kinetic + potential + dissipated") && !html.contains("supplied<"));
}

#[test]
fn nothing_from_a_file_becomes_markup() {
    let run = run_folder();
    keep_measured(run.path());
    let summary = fs::read_to_string(run.path().join("summary.json")).unwrap();
    let hostile = serde_json::to_string(HOSTILE).unwrap();
    let summary = summary
        .replace("\"scene\": \"scene\"", &format!("\"scene\": {hostile}"))
        .replace("\"faults\": []", &format!("\"faults\": [{hostile}]"));
    fs::write(run.path().join("summary.json"), summary).unwrap();
    let trajectory = fs::read_to_string(run.path().join("trajectory.xyz")).unwrap().replace("AB", "</script>");
    fs::write(run.path().join("trajectory.xyz"), trajectory).unwrap();
    let scene = format!("{SCENE}# {HOSTILE}\n");
    fs::write(run.path().join("scene.toml"), scene).unwrap();
    let thermo =
        fs::read_to_string(run.path().join("thermo.csv")).unwrap().replace("in_half", &format!("in_{HOSTILE}"));
    fs::write(run.path().join("thermo.csv"), thermo).unwrap();
    let html = page(run.path()).unwrap().html;
    assert!(!html.contains(HOSTILE) && !html.contains("alert('"));
    assert!(html.matches("&lt;/script&gt;&lt;script&gt;alert(&#39;&quot;&amp;&#39;)").count() > 20);
    assert!(html.contains("\"name\":\"\\u003c/script\\u003e\""), "in the data of the player");
    assert!(html.contains("✗ Failed."));
    assert_eq!(html.matches("<script").count(), html.matches("</script>").count());
}

#[test]
fn plots_are_well_formed_and_finite() {
    let run = run_folder();
    keep_measured(run.path());
    let html = page(run.path()).unwrap().html;
    let plots = plots(&html);
    // Of the six functions, three are drawn as curves and one as a map. The other two have no data or three variables.
    // Five more plots show the energies, three columns of `thermo.csv`, and the region.
    assert_eq!(plots.len(), 4 + 5);
    for plot in plots {
        let svg = format!("<svg{plot}");
        well_formed(&svg).unwrap_or_else(|error| panic!("{error} in {svg}"));
        assert!(svg.contains("<text"), "letters are letters");
        for word in svg.split(|c: char| !c.is_alphanumeric()) {
            assert!(!["NaN", "inf", "Infinity"].contains(&word), "{svg}");
        }
    }
    assert!(
        well_formed("<a><b></a></b>").is_err() && well_formed("<a b=c/>").is_err() && well_formed("<a>&x</a>").is_err()
    );
}

#[test]
fn missing_estimates_are_shown_as_insufficient_data() {
    let run = run_folder();
    keep_measured(run.path());
    let html = page(run.path()).unwrap().html;
    assert!(html.contains("<em>insufficient data</em>"), "a number without a mean");
    assert!(html.contains("2 <small>error: insufficient data</small>"), "a mean without an error");
    assert!(html.contains("1.00 ± 0.25"));
    // One curve and one map have no data.
    assert_eq!(html.matches("<em>Insufficient data.</em>").count(), 2);
}

#[test]
fn folder_without_valid_summary_is_rejected() {
    let run = run_folder();
    assert!(matches!(page(&run.path().join("nowhere")), Err(ViewError::NotFolder(_))));
    assert!(matches!(page(&run.path().join("thermo.csv")), Err(ViewError::NotFolder(_))));
    for damage in ["", "{", "{\"version\": 1}", "[]"] {
        fs::write(run.path().join("summary.json"), damage).unwrap();
        let error = page(run.path()).unwrap_err();
        assert!(matches!(error, ViewError::Summary { .. }) && error.to_string().contains("summary.json"), "{error}");
    }
    fs::remove_file(run.path().join("summary.json")).unwrap();
    assert!(matches!(page(run.path()), Err(ViewError::Unreadable { .. })));
}

#[test]
fn missing_or_damaged_optional_files_give_one_note() {
    let run = run_folder();
    keep_measured(run.path());
    let sound = page(run.path()).unwrap();
    for file in ["thermo.csv", "trajectory.xyz", "scene.toml", "measurements.json"] {
        let path = run.path().join(file);
        let whole = fs::read(&path).unwrap();
        for damage in [&b""[..], b"{ nonsense", &[0xff, 0xfe, 0]] {
            fs::write(&path, damage).unwrap();
            let page = page(run.path()).unwrap();
            assert!(page.notes.len() == 1 && page.notes[0].starts_with(file), "{file}: {:?}", page.notes);
            assert!(page.html.contains("Not everything is on this page"));
        }
        fs::remove_file(&path).unwrap();
        let page_without = page(run.path()).unwrap();
        // A missing `measurements.json` is not noted, because only runs with instruments write this file.
        assert_eq!(page_without.notes.len(), usize::from(file != "measurements.json"), "{file}");
        assert_ne!(page_without, sound);
        fs::write(&path, whole).unwrap();
    }
    assert_eq!(page(run.path()).unwrap(), sound);
    let mut uneven = measured();
    uneven.curves[0].series[0].values.pop();
    fs::write(run.path().join("measurements.json"), serde_json::to_string(&uneven).unwrap()).unwrap();
    let notes = page(run.path()).unwrap().notes;
    assert!(notes.len() == 1 && notes[0].contains("same length"), "{notes:?}");
}

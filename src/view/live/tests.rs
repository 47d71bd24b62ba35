use super::*;
use crate::engine::Simulation;

fn scene(text: &str) -> Scene {
    Scene::from_toml(text, "live.toml").unwrap()
}

const TEXT: &str = r#"
description = "A *gas* of <b>discs</b>: [more](javascript:alert(1)), [docs](https://example.org)."

[space]
size = [10.0, 10.0, 0.0]
z = "flat"

[[species]]
name = "disc"
mass = 1.0
diameter = 1.0

[[interaction]]
species = ["disc", "disc"]
potential = "hard-sphere"

[[particle]]
species = "disc"
position = [2.0, 2.0, 0.0]

[run]
until_time = 1.0

[live]
speed = 3.0
colour = "speed"
view = [10.0, 20.0]

[[live.slider]]
key = "particle.0.position.0"
from = 1.0
to = 9.0
"#;

fn text() -> String {
    TEXT.to_owned()
}

/// `packed` is the compressed engine.
fn page_of(text: &str, packed: &[u8]) -> Page {
    let file = [format!("carom engine {}\n", env!("CAROM_FINGERPRINT")).as_bytes(), packed].concat();
    let source = Source { text: text.to_owned(), ..Source::default() };
    page(&scene(text), &source, Engine::of(&file).unwrap())
}

fn told(page: &Page) -> serde_json::Value {
    let json = page.html.split_once("id=\"scene\">").unwrap().1.split_once("</script>").unwrap().0;
    serde_json::from_str(json).unwrap()
}

#[test]
fn live_page_is_self_contained() {
    let text = text() + "# </script>\n";
    let page = page_of(&text, &b"packed".repeat(100));
    let (told, page) = (told(&page), page.html);
    assert_eq!(page.matches("</script>").count(), 4);
    for reference in ["src=", "http-equiv=\"refresh", "@import", "url("] {
        assert!(!page.contains(reference), "{reference}");
    }
    assert_eq!(told["text"], text);
    assert_eq!(told["live"]["speed"], 3.0);
    assert_eq!(told["live"]["colour"], "speed");
    assert_eq!(told["live"]["view"], json!([10.0, 20.0]));
    assert_eq!(told["live"]["sliders"][0]["key"], "particle.0.position.0");
    assert_eq!(told["live"]["sliders"][0]["scale"], "linear");
    let html = told["description"].as_str().unwrap();
    assert_eq!(
        html,
        "<p>A <em>gas</em> of &lt;b&gt;discs&lt;/b&gt;: <a href=\"#\">more</a>, <a href=\"https://example.org\">docs</a>.</p>\n"
    );
}

#[test]
fn all_scripts_of_the_page_are_in_it() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/view/live");
    let page = page_of(TEXT, b"").html;
    let scripts: serde_json::Value = serde_json::from_str(&scripts()).unwrap();
    let schema: serde_json::Value = serde_json::from_str(scripts["texts"]["schema"].as_str().unwrap()).unwrap();
    assert!(schema["properties"]["live"].is_object());
    let texts = scripts["texts"].as_object().unwrap().values().chain([&scripts["program"]]);
    let scripts: Vec<&str> = texts.map(|text| text.as_str().unwrap()).collect();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path
            .extension()
            .is_some_and(|extension| ["js", "css", "html", "vert", "frag"].iter().any(|it| extension == *it))
        {
            let text = std::fs::read_to_string(&path).unwrap();
            let is_there = page.contains(&text) || scripts.iter().any(|script| script.contains(&text));
            assert!(is_there, "{}", path.display());
        }
    }
}

#[test]
fn the_same_scene_gives_the_same_page() {
    let text = text();
    assert_eq!(page_of(&text, b"packed"), page_of(&text, b"packed"));
}

#[test]
fn invalid_live_settings_are_rejected_by_key() {
    let with = |from: &str, to: &str| {
        let changed = text().replace(from, to);
        assert_ne!(changed, text());
        Scene::from_toml(changed, "live.toml").unwrap_err().to_string()
    };
    assert!(with("speed = 3.0", "speed = 0.0").contains("live.speed"));
    assert!(with("\"speed\"", "\"sped\"").contains("sped"));
    assert!(with("to = 9.0", "to = 1.0").contains("live.slider"));
    assert!(with("from = 1.0", "from = -1.0\nscale = \"log\"").contains("live.slider"));
    assert!(with("[10.0, 20.0]", "[nan, 20.0]").contains("live.view"));
}

#[test]
fn page_contains_original_text_overrides_and_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let text = text().replace(
        "[[particle]]\nspecies = \"disc\"\nposition = [2.0, 2.0, 0.0]",
        "# Where they are.\n[[file]]\npath = \"at/start.xyz\"",
    );
    std::fs::create_dir(folder.path().join("at")).unwrap();
    std::fs::write(folder.path().join("at/start.xyz"), "1\nProperties=species:S:1:pos:R:3\ndisc 2 2 0\n").unwrap();
    std::fs::write(&path, &text).unwrap();
    let overrides = [("species.disc.mass", "2.0")];
    let source = Source::of_file(&path, &overrides).unwrap();
    let file = format!("carom engine {}\npacked", env!("CAROM_FINGERPRINT"));
    let told = told(&page(&Scene::from_file(&path).unwrap(), &source, Engine::of(file.as_bytes()).unwrap()));
    assert_eq!(told["text"], text);
    assert_eq!(told["changes"], json!({ "species.disc.mass": "2.0" }));
    assert_eq!(told["files"][0]["name"], "at/start.xyz");
    assert!(told["files"][0]["content"].as_str().unwrap().starts_with("H4sI"), "{}", told["files"][0]["content"]);
    assert_eq!(told["files"].as_array().unwrap().len(), 1);
    std::fs::remove_file(folder.path().join("at/start.xyz")).unwrap();
    let error = Source::of_file(&path, &overrides).unwrap_err().to_string();
    assert!(error.contains("start.xyz"), "{error}");
}

#[test]
fn predecessor_run_is_not_embedded_in_the_page() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, "start.from = \"run\"\nrun.until_time = 1.0\n").unwrap();
    std::fs::create_dir(folder.path().join("run")).unwrap();
    assert!(Source::of_file(&path, &[]).unwrap().files.is_empty());
}

#[test]
fn engine_file_needs_a_valid_fingerprint() {
    let file = format!("carom engine {}\npacked", env!("CAROM_FINGERPRINT"));
    let engine = Engine::of(file.as_bytes()).unwrap();
    assert!(engine.is_of_these_sources());
    assert_eq!(engine.packed, b"packed");
    assert!(!Engine::of(b"carom engine 0123456789abcdef\npacked").unwrap().is_of_these_sources());
    for bad in
        ["", "\0asm", "carom engine 0123", "carom engine 0123456789abcdef", "carom engine 0123456789abcdef packed"]
    {
        assert_eq!(Engine::of(bad.as_bytes()), None, "{bad}");
    }
}

#[test]
fn a_scene_without_a_description_has_its_first_comment() {
    let described = TEXT.lines().filter(|line| !line.starts_with("description")).collect::<Vec<_>>().join("\n");
    let page = page_of(&format!("# Two *discs*\n#and a\tthird.\n\n# Another.\n{}", described.trim_start()), b"");
    assert_eq!(told(&page)["description"], "<p>Two <em>discs</em>\nand a\tthird.</p>\n");
    assert_eq!(told(&page_of(&described, b""))["description"], "");
}

#[test]
fn scene_inside_a_closed_surface_is_contained() {
    let scene = |surface: &str| {
        let heavy = "[dynamics]\ngravity = [0.0, -1.0, 0.0]\n\n[[species]]";
        let text = text().replace("10.0, 0.0]\nz = \"flat\"", "10.0, 10.0]\nx = \"open\"\ny = \"open\"\nz = \"open\"");
        text.replacen("[[species]]", heavy, 1) + &format!("\n[[surface]]\nname = \"s\"\n{surface}\n")
    };
    let is_contained = |surface: &str| {
        let simulation = Simulation::without_plan(super::tests::scene(&scene(surface)));
        let head: serde_json::Value = serde_json::from_str(&Shown::of(&simulation).head).unwrap();
        head["isContained"].as_bool().unwrap()
    };
    let cylinder = |axis: &str, side: &str| {
        format!(
            "shape = \"cylinder\"\nbase = [3.0, 5.0, 0.0]\naxis = {axis}\nradius = 7.0\nside = \"{side}\"\nrestitution = 1.0"
        )
    };
    assert!(is_contained(&cylinder("[0.0, 0.0, 1.0]", "inside")));
    // Particles can leave an upright cylinder at its lower end.
    assert!(!is_contained(&cylinder("[0.0, 1.0, 0.0]", "inside")));
    assert!(!is_contained("shape = \"plane\"\npoint = [0.0, 0.0, 0.0]\nnormal = [0.0, 1.0, 0.0]\nrestitution = 1.0"));
    assert!(!is_contained(
        &cylinder("[0.0, 0.0, 1.0]", "outside").replace("7.0", "0.1").replace("3.0, 5.0", "9.0, 9.0")
    ));
    assert!(is_contained("shape = \"box\"\nlower = [-5.0, -5.0, -5.0]\nupper = [15.0, 15.0, 15.0]\nrestitution = 1.0"));
}

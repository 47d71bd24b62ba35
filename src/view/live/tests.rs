use super::*;

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

#[test]
fn a_page_carries_all_that_it_needs() {
    let text = text() + "# </script>\n";
    let module = b"\0asm of a test".repeat(100);
    let page = page(&scene(&text), &text, &module).html;
    assert_eq!(page.matches("</script>").count(), 3 + SHADERS.len() + LINES.len() + 1);
    for reference in ["src=", "http-equiv=\"refresh", "@import", "url("] {
        assert!(!page.contains(reference), "{reference}");
    }
    let json = page.split_once("id=\"scene\">").unwrap().1.split_once("</script>").unwrap().0;
    let told: serde_json::Value = serde_json::from_str(json).unwrap();
    assert_eq!(told["text"], text);
    assert_eq!(told["live"]["speed"], 3.0);
    assert_eq!(told["live"]["colour"], "speed");
    assert_eq!(told["live"]["view"], json!([10.0, 20.0]));
    assert_eq!(told["live"]["sliders"][0]["key"], "particle.0.position.0");
    assert_eq!(told["live"]["sliders"][0]["scale"], "linear");
    assert!(told["schema"]["properties"]["live"].is_object());
    let html = told["description"].as_str().unwrap();
    assert_eq!(
        html,
        "<p>A <em>gas</em> of &lt;b&gt;discs&lt;/b&gt;: <a href=\"#\">more</a>, <a href=\"https://example.org\">docs</a>.</p>\n"
    );
}

#[test]
fn all_scripts_of_the_page_are_in_it() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/view/live");
    let text = text();
    let page = page(&scene(&text), &text, b"").html;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path
            .extension()
            .is_some_and(|extension| ["js", "css", "html", "vert", "frag"].iter().any(|it| extension == *it))
        {
            assert!(page.contains(&std::fs::read_to_string(&path).unwrap()), "{}", path.display());
        }
    }
}

#[test]
fn the_same_scene_gives_the_same_page() {
    let text = text();
    assert_eq!(page(&scene(&text), &text, b"module"), page(&scene(&text), &text, b"module"));
}

#[test]
fn mistakes_in_a_page_are_told() {
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

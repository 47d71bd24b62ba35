use super::*;

#[test]
fn subtitle_summarises_the_system() {
    let subtitle = |text: &str| {
        let place = folder_of(text);
        let html = page(place.path()).unwrap().html;
        let start = html.find("<p class=\"subtitle\">").unwrap() + "<p class=\"subtitle\">".len();
        html[start..start + html[start..].find("</p>").unwrap()].to_owned()
    };
    // The volume fraction is `27 (pi / 6) / 216`.
    assert_eq!(subtitle(SCENE), "27 square-well spheres, φ = 0.06545");
    assert_eq!(subtitle(GROWN), "32 hard spheres, φ = 0.4");
}

#[test]
fn published_values_are_listed_and_constant_traces_not_drawn() {
    let hard = SCENE.replace("square-well\"\nlambda = 1.5\nwell_depth = 1.0", "hard-sphere\"");
    let html = page(folder_of(&hard).path()).unwrap().html;
    let published = crate::analysis::published::hard_spheres(27.0 * std::f64::consts::PI / 6.0 / 216.0);
    let digits = crate::base::text::digits(published);
    assert!(html.contains(&format!("{digits} <small>mKLM</small>")), "{digits}");
    assert!(html.contains("Phys. Chem. Chem. Phys. 21, 6886"));
    assert!(html.contains("aria-label=\"pressure against time\""));
    assert!(
        !html.contains("aria-label=\"temperature against time\"")
            && !html.contains("aria-label=\"energy against time\"")
    );
    let well = page(run_folder().path()).unwrap().html;
    assert!(well.contains("aria-label=\"temperature against time\"") && !well.contains("<small>mKLM</small>"));
}

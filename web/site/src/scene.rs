//! Pages of the scenes in `configs`.

use std::io;

use carom::Scene;
use carom::scene::SceneError;
use carom::view::live::{Source, first_comment};

use crate::layout::Page;
use crate::links::{escaped, relative};
use crate::markdown::{Targets, read};
use crate::{Site, gallery};

/// A scene of `configs`, and the content of its page.
pub struct ScenePage {
    /// The name of the scene file without the extension.
    pub name: String,
    pub title: String,
    /// Description of the scene, in HTML.
    pub about: String,
    /// First sentence of the description, as plain text.
    pub lead: String,
    pub text: String,
    pub scene: Scene,
    /// The scene and its files, as stored in the page.
    pub live: Source,
    pub has_picture: bool,
}

/// In a description, links stay unchanged, and the path of a scene becomes a link.
struct Plain;

impl Targets for Plain {
    fn link(&mut self, address: &str) -> String {
        address.to_owned()
    }

    fn code(&mut self, code: &str) -> Option<String> {
        Some(format!("{}.html", code.strip_prefix("configs/")?.strip_suffix(".toml")?))
    }
}

fn titled(name: &str) -> String {
    let words = name.replace('_', " ").replace(" 1d", " in one dimension").replace("lennard jones", "Lennard-Jones");
    let mut letters = words.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// Returns the first sentence of a text. A colon also ends a sentence.
fn sentence(text: &str) -> String {
    let line = text.split("\n\n").next().unwrap_or_default().replace(['\n', '`'], " ");
    let end = [". ", ": "].iter().filter_map(|mark| line.find(mark)).filter(|at| *at > 20).min().unwrap_or(line.len());
    format!("{}.", line[..end].trim().trim_end_matches('.'))
}

impl ScenePage {
    pub fn all(site: &Site) -> io::Result<Vec<Self>> {
        site.names("configs", "toml")?.iter().map(|file| Self::of(site, file)).collect()
    }

    fn of(site: &Site, file: &str) -> io::Result<Self> {
        let path = format!("configs/{file}");
        let text = site.read(&path)?;
        let wrong = |error: SceneError| io::Error::other(format!("{path}: {error}"));
        let scene = Scene::from_file(site.root.join(&path)).map_err(wrong)?;
        let live = Source::of_file(&site.root.join(&path), &[]).map_err(wrong)?;
        let name = file.trim_end_matches(".toml").to_owned();
        let source = scene.live().description.clone().unwrap_or_else(|| first_comment(&text));
        let about = read(&source, &mut Plain);
        let has_picture = crate::live::draw(site, &scene, &format!("scenes/{name}.png"))?;
        Ok(Self {
            title: titled(&name),
            about: about.body,
            lead: sentence(&source),
            name,
            text,
            scene,
            live,
            has_picture,
        })
    }

    pub fn address(&self) -> String {
        format!("scenes/{}.html", self.name)
    }

    pub fn picture(&self) -> String {
        format!("scenes/{}.png", self.name)
    }

    /// If the scene does not run in a browser, the page shows its picture and text.
    pub fn write(&self, site: &Site, scenes: &[Self]) -> io::Result<()> {
        let address = self.address();
        if let Some(page) = crate::live::scene_page(site, self, scenes) {
            return site.write(&address, page.as_bytes());
        }
        let picture = if self.has_picture {
            format!("<img class=\"site-picture\" src=\"{}.png\" alt=\"\">", self.name)
        } else {
            String::new()
        };
        let body = format!(
            "<h1>{}</h1>\n<div class=\"site-about\">{}</div>\n{picture}\n<p class=\"aside\">Run it with the program: \
             <code>carom run configs/{}.toml</code></p>\n<h2>The scene</h2>\n<pre class=\"site-source\"><code>{}</code></pre>\n\
             <h2>Other scenes</h2>\n{}",
            escaped(&self.title),
            self.about,
            self.name,
            escaped(&self.text),
            gallery::cards(&address, scenes.iter().filter(|scene| scene.name != self.name)),
        );
        site.write(
            &address,
            Page { address: &address, title: &self.title, about: &self.lead, aside: String::new(), body }
                .html()
                .as_bytes(),
        )
    }

    pub fn card(&self, from: &str) -> String {
        let picture = if self.has_picture {
            format!(
                "<img src=\"{}\" alt=\"\" loading=\"lazy\" width=\"480\" height=\"360\">",
                relative(from, &self.picture())
            )
        } else {
            String::new()
        };
        let link = relative(from, &self.address());
        format!(
            "<li class=\"site-card\"><a href=\"{link}\">{picture}<strong>{}</strong></a><p>{}</p></li>",
            escaped(&self.title),
            escaped(&self.lead)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn titles_and_first_sentences() {
        assert_eq!(titled("square_well_law"), "Square well law");
        assert_eq!(sentence("A heap in a box that\nis tilted: gravity turns. More"), "A heap in a box that is tilted.");
        assert_eq!(sentence("One."), "One.");
    }
}

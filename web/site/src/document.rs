//! Pages for the documents in `docs` and for the files that they link to.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::{fs, io};

use pulldown_cmark::HeadingLevel;

use crate::Site;
use crate::layout::Page;
use crate::links::{escaped, relative, resolve};
use crate::markdown::{Targets, Text, read};
use crate::scene::ScenePage;

/// Reading order. Other documents come last.
const ORDER: [&str; 16] = [
    "tutorial",
    "scene",
    "measuring",
    "driving",
    "studies",
    "exchange",
    "formats",
    "accuracy",
    "speed",
    "parallel",
    "python",
    "library",
    "architecture",
    "extending",
    "live",
    "glossary",
];

pub struct Library {
    documents: BTreeMap<String, Text>,
    /// Other files and folders that documents link to.
    others: BTreeSet<String>,
}

struct Linked<'a> {
    site: &'a Site,
    source: &'a str,
    scenes: &'a [ScenePage],
    /// Linked files of the repository, each with the linked heading, which may be empty.
    found: Vec<(String, String)>,
    broken: Vec<String>,
}

fn address_of(path: &str, is_folder: bool) -> String {
    let is_picture = [".png", ".svg", ".gif", ".csv"].iter().any(|ending| path.ends_with(ending));
    if let Some(name) = path.strip_prefix("configs/").and_then(|name| name.strip_suffix(".toml")) {
        format!("scenes/{name}.html")
    } else if let Some(name) = path.strip_suffix(".md") {
        format!("{name}.html")
    } else if is_folder {
        format!("files/{path}/index.html")
    } else if is_picture {
        path.to_owned()
    } else {
        format!("files/{path}.html")
    }
}

impl Targets for Linked<'_> {
    fn link(&mut self, address: &str) -> String {
        if address.contains("://") || address.starts_with("mailto:") {
            return address.to_owned();
        }
        let (path, heading) = address.split_once('#').unwrap_or((address, ""));
        if path.is_empty() {
            self.found.push((self.source.to_owned(), heading.to_owned()));
            return address.to_owned();
        }
        let Some(target) = resolve(self.source, path).filter(|target| self.site.root.join(target).exists()) else {
            self.broken.push(format!("{}: {address}", self.source));
            return address.to_owned();
        };
        let is_folder = self.site.root.join(&target).is_dir();
        let link = relative(&address_of(self.source, false), &address_of(&target, is_folder));
        self.found.push((target, heading.to_owned()));
        if heading.is_empty() { link } else { format!("{link}#{heading}") }
    }

    fn code(&mut self, code: &str) -> Option<String> {
        let name = code.strip_prefix("configs/")?.strip_suffix(".toml")?;
        self.scenes
            .iter()
            .any(|scene| scene.name == name)
            .then(|| relative(&address_of(self.source, false), &address_of(code, false)))
    }
}

impl Library {
    /// Reads the documents. A link to a missing file or heading is an error.
    pub fn of(site: &Site, scenes: &[ScenePage]) -> io::Result<Self> {
        let mut waiting: VecDeque<String> =
            site.names("docs", "md")?.into_iter().map(|name| format!("docs/{name}")).collect();
        let mut library = Self { documents: BTreeMap::new(), others: BTreeSet::new() };
        let (mut links, mut broken) = (Vec::new(), Vec::new());
        while let Some(source) = waiting.pop_front() {
            if library.documents.contains_key(&source) {
                continue;
            }
            let mut linked = Linked { site, source: &source, scenes, found: Vec::new(), broken: Vec::new() };
            let text = read(&site.read(&source)?, &mut linked);
            broken.append(&mut linked.broken);
            for (target, heading) in linked.found {
                if target.ends_with(".md") {
                    waiting.push_back(target.clone());
                } else if !(target.starts_with("configs/") && target.ends_with(".toml")) {
                    library.others.insert(target.clone());
                }
                links.push((source.clone(), target, heading));
            }
            library.documents.insert(source, text);
        }
        broken.extend(
            links
                .iter()
                .filter(|(_, target, heading)| !library.has(target, heading))
                .map(|(source, target, heading)| format!("{source}: {target}#{heading}")),
        );
        if broken.is_empty() {
            Ok(library)
        } else {
            Err(io::Error::other(format!("broken links: {}", broken.join(", "))))
        }
    }

    pub fn len(&self) -> usize {
        self.documents.len() + 1
    }

    fn has(&self, target: &str, heading: &str) -> bool {
        let is_there = |text: &Text| text.headings.iter().any(|there| there.anchor == heading);
        heading.is_empty() || self.documents.get(target).is_some_and(is_there)
    }

    pub fn write(&self, site: &Site) -> io::Result<()> {
        for (source, text) in &self.documents {
            let address = address_of(source, false);
            let aside = format!("{}{}", self.places(&address), contents(text));
            let body =
                format!("<article class=\"site-text\">\n<h1>{}</h1>\n{}</article>", escaped(&text.title), text.body);
            let page = Page { address: &address, title: &text.title, about: &lead(text), aside, body };
            site.write(&address, page.html().as_bytes())?;
        }
        self.write_index(site)?;
        for path in self.others.clone() {
            write_file(site, &path)?;
        }
        Ok(())
    }

    fn ordered(&self) -> Vec<(String, &Text)> {
        let place = |source: &str| {
            let name = source.trim_start_matches("docs/").trim_end_matches(".md");
            ORDER.iter().position(|known| *known == name).unwrap_or(ORDER.len())
        };
        let mut sources: Vec<&String> = self.documents.keys().filter(|source| source.starts_with("docs/")).collect();
        sources.sort_by_key(|source| place(source));
        sources.into_iter().map(|source| (address_of(source, false), &self.documents[source])).collect()
    }

    fn places(&self, address: &str) -> String {
        let links = self.ordered().into_iter().map(|(place, text)| {
            let here = if place == address { " aria-current=\"page\"" } else { "" };
            format!("<li><a href=\"{}\"{here}>{}</a></li>", relative(address, &place), escaped(&text.title))
        });
        format!(
            "<nav class=\"site-list\" aria-label=\"Documents\"><h2>Documents</h2><ul>{}</ul></nav>",
            links.collect::<String>()
        )
    }

    fn write_index(&self, site: &Site) -> io::Result<()> {
        let address = "docs/index.html";
        let items = self.ordered().into_iter().map(|(place, text)| {
            format!(
                "<li><a href=\"{}\">{}</a><p>{}</p></li>",
                relative(address, &place),
                escaped(&text.title),
                escaped(&lead(text))
            )
        });
        let body = format!("<h1>Documents</h1>\n<ul class=\"site-index\">{}</ul>", items.collect::<String>());
        let about = "The documentation of Carom: scenes, measurements, file formats, accuracy, speed and the library.";
        site.write(address, Page { address, title: "Documents", about, aside: String::new(), body }.html().as_bytes())
    }
}

fn contents(text: &Text) -> String {
    let items = text.headings.iter().filter(|heading| heading.level == HeadingLevel::H2);
    let items: String = items
        .map(|heading| format!("<li><a href=\"#{}\">{}</a></li>", heading.anchor, escaped(&heading.text)))
        .collect();
    if items.is_empty() {
        String::new()
    } else {
        format!(
            "<nav class=\"site-list site-contents\" aria-label=\"On this page\"><h2>On this page</h2><ul>{items}</ul></nav>"
        )
    }
}

/// Returns the first sentence of the first paragraph as plain text.
fn lead(text: &Text) -> String {
    let start = text.body.find("<p>").map_or(0, |at| at + 3);
    let paragraph = text.body[start..].split("</p>").next().unwrap_or_default();
    let mut plain = String::new();
    let mut is_markup = false;
    for letter in paragraph.chars() {
        match letter {
            '<' => is_markup = true,
            '>' => is_markup = false,
            letter if !is_markup => plain.push(letter),
            _ => {}
        }
    }
    let plain = plain
        .replace('\n', " ")
        .replace("&lt;", "<")
        .replace("&gt;", ">")
        .replace("&quot;", "\"")
        .replace("&amp;", "&");
    plain.split_once(". ").map_or(plain.clone(), |(first, _)| format!("{first}."))
}

/// Copies a picture, lists a folder, or makes a page of a text.
fn write_file(site: &Site, path: &str) -> io::Result<()> {
    let place = site.root.join(path);
    let address = address_of(path, place.is_dir());
    if place.is_dir() {
        let mut names: Vec<String> = fs::read_dir(&place)?
            .filter_map(|entry| {
                entry
                    .ok()
                    .filter(|entry| entry.path().is_file())
                    .map(|entry| entry.file_name().to_string_lossy().into_owned())
            })
            .collect();
        names.sort();
        let mut items = String::new();
        for name in names {
            let file = format!("{path}/{name}");
            write_file(site, &file)?;
            items.push_str(&format!(
                "<li><a href=\"{}\">{}</a></li>",
                relative(&address, &address_of(&file, false)),
                escaped(&name)
            ));
        }
        let body = format!("<h1>{}</h1>\n<ul>{items}</ul>", escaped(path));
        return site.write(
            &address,
            Page { address: &address, title: path, about: path, aside: String::new(), body }.html().as_bytes(),
        );
    }
    if address == path {
        return site.copy(path, path);
    }
    let text = site.read(path)?;
    let body = format!("<h1>{}</h1>\n<pre class=\"site-source\"><code>{}</code></pre>", escaped(path), escaped(&text));
    site.write(
        &address,
        Page { address: &address, title: path, about: path, aside: String::new(), body }.html().as_bytes(),
    )
}

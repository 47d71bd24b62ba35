//! The layout of all pages.

use crate::links::{escaped, relative};

/// Addresses and names of the pages in the navigation bar.
const PLACES: [(&str, &str); 4] = [
    ("index.html", "Carom"),
    ("scenes/index.html", "Scenes"),
    ("editor.html", "Editor"),
    ("docs/index.html", "Documents"),
];

/// Content security policy: no scripts, and nothing from other sites.
const POLICY: &str = "default-src 'none'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; frame-src 'self'";

/// A page without the common layout.
pub struct Page<'a> {
    /// Address relative to the root of the site.
    pub address: &'a str,
    pub title: &'a str,
    /// Description of the page in one sentence.
    pub about: &'a str,
    /// Content beside the text on wide windows, in HTML. May be empty.
    pub aside: String,
    /// Main content, in HTML.
    pub body: String,
}

impl Page<'_> {
    pub fn html(&self) -> String {
        let style = relative(self.address, "site.css");
        let title = if self.address == "index.html" {
            escaped(self.title)
        } else {
            format!("{} · Carom", escaped(self.title))
        };
        let aside = if self.aside.is_empty() {
            String::new()
        } else {
            format!("<aside class=\"site-aside\">{}</aside>\n", self.aside)
        };
        let class = if self.aside.is_empty() { "site-plain" } else { "site-columns" };
        format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n<title>{title}</title>\n\
             <meta name=\"description\" content=\"{}\">\n<link rel=\"stylesheet\" href=\"{style}\">\n</head>\n\
             <body class=\"site\">\n{}\n<div class=\"{class}\">\n{aside}<main>\n{}\n</main>\n</div>\n{}\n</body>\n</html>\n",
            escaped(self.about),
            navigation(self.address),
            self.body,
            end(),
        )
    }
}

pub fn navigation(address: &str) -> String {
    let folder = address.split_once('/').map_or("", |(folder, _)| folder);
    let links = PLACES.iter().enumerate().map(|(index, (place, name))| {
        let is_here = *place == address || (!folder.is_empty() && place.starts_with(&format!("{folder}/")));
        let here = if is_here { " aria-current=\"page\"" } else { "" };
        let class = if index == 0 { " class=\"site-name\"" } else { "" };
        format!("<a href=\"{}\"{class}{here}>{name}</a>", relative(address, place))
    });
    format!("<header class=\"site-head\"><div>{}</div></header>", links.collect::<Vec<_>>().join("\n"))
}

fn end() -> String {
    "<footer class=\"site-end\"><p>Carom: event-driven particle dynamics. MIT or Apache-2.0.</p></footer>".to_owned()
}

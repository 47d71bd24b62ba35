//! Converts Markdown to HTML, with anchors for headings, links between pages of the site, and scrolling tables.

use std::collections::HashMap;

use pulldown_cmark::{CowStr, Event, HeadingLevel, Options, Parser, Tag, TagEnd, html};

use crate::links::{anchor, escaped};

pub struct Heading {
    pub level: HeadingLevel,
    pub anchor: String,
    pub text: String,
}

pub struct Text {
    /// Text of the first heading, if it has level 1. The body does not contain this heading.
    pub title: String,
    pub headings: Vec<Heading>,
    pub body: String,
}

/// Maps links and inline code to addresses.
pub trait Targets {
    /// Address of a link or picture.
    fn link(&mut self, address: &str) -> String;

    /// Returns the address for inline code, such as the path of a scene. `None` means no link.
    fn code(&mut self, code: &str) -> Option<String>;
}

/// Converts Markdown to HTML. HTML in the source is shown as text.
pub fn read(source: &str, targets: &mut dyn Targets) -> Text {
    let options = Options::ENABLE_TABLES | Options::ENABLE_STRIKETHROUGH | Options::ENABLE_FOOTNOTES;
    let mut events: Vec<Event> = Parser::new_ext(source, options).collect();
    let headings = name_headings(&mut events);
    let mut title = String::new();
    if let [first, ..] = &headings[..]
        && first.level == HeadingLevel::H1
    {
        title.clone_from(&first.text);
        let end = events.iter().position(|event| matches!(event, Event::End(TagEnd::Heading(_))));
        let start = events.iter().position(|event| matches!(event, Event::Start(Tag::Heading { .. })));
        if let (Some(start), Some(end)) = (start, end) {
            events.drain(start..=end);
        }
    }
    let is_in_link = links_around(&events);
    let events = events.into_iter().zip(is_in_link).map(|(event, is_in_link)| shown(event, is_in_link, targets));
    let mut body = String::new();
    html::push_html(&mut body, events.flat_map(boxed));
    Text { title, headings, body }
}

/// Returns whether each event is inside a link or a heading. Inline code does not become a link there.
fn links_around(events: &[Event]) -> Vec<bool> {
    let mut depth = 0_usize;
    let mut within = Vec::with_capacity(events.len());
    for event in events {
        match event {
            Event::Start(Tag::Link { .. } | Tag::Heading { .. }) => depth += 1,
            Event::End(TagEnd::Link | TagEnd::Heading(_)) => depth = depth.saturating_sub(1),
            _ => {}
        }
        within.push(depth > 0);
    }
    within
}

fn name_headings(events: &mut [Event]) -> Vec<Heading> {
    let mut headings: Vec<Heading> = Vec::new();
    let mut seen: HashMap<String, usize> = HashMap::new();
    let mut start = None;
    let mut text = String::new();
    for place in 0..events.len() {
        match &events[place] {
            Event::Start(Tag::Heading { .. }) => {
                start = Some(place);
                text.clear();
            }
            Event::Text(words) | Event::Code(words) if start.is_some() => text.push_str(words),
            Event::End(TagEnd::Heading(level)) => {
                let name = anchor(&text);
                let times = seen.entry(name.clone()).and_modify(|times| *times += 1).or_insert(0);
                let anchor = if *times == 0 { name } else { format!("{name}-{times}") };
                headings.push(Heading { level: *level, anchor: anchor.clone(), text: text.clone() });
                if let Some(Event::Start(Tag::Heading { id, .. })) = start.take().map(|start| &mut events[start]) {
                    *id = Some(CowStr::from(anchor));
                }
            }
            _ => {}
        }
    }
    headings
}

fn shown<'a>(event: Event<'a>, is_in_link: bool, targets: &mut dyn Targets) -> Event<'a> {
    match event {
        Event::Start(Tag::Link { link_type, dest_url, title, id }) => {
            let dest_url = CowStr::from(targets.link(&dest_url));
            Event::Start(Tag::Link { link_type, dest_url, title, id })
        }
        Event::Start(Tag::Image { link_type, dest_url, title, id }) => {
            let dest_url = CowStr::from(targets.link(&dest_url));
            Event::Start(Tag::Image { link_type, dest_url, title, id })
        }
        Event::Code(code) if !is_in_link => match targets.code(&code) {
            Some(address) => {
                let link = format!("<a href=\"{}\"><code>{}</code></a>", escaped(&address), escaped(&code));
                Event::InlineHtml(CowStr::from(link))
            }
            None => Event::Code(code),
        },
        Event::Html(markup) | Event::InlineHtml(markup) => Event::Text(markup),
        event => event,
    }
}

/// Puts tables into scrolling boxes.
fn boxed(event: Event) -> Vec<Event> {
    match event {
        Event::Start(Tag::Table(_)) => vec![Event::Html(CowStr::from("<div class=\"wide\" tabindex=\"0\">")), event],
        Event::End(TagEnd::Table) => vec![event, Event::Html(CowStr::from("</div>\n"))],
        event => vec![event],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Nowhere;

    impl Targets for Nowhere {
        fn link(&mut self, address: &str) -> String {
            address.replace(".md", ".html")
        }

        fn code(&mut self, code: &str) -> Option<String> {
            (code == "configs/a.toml").then(|| "a.html".to_owned())
        }
    }

    #[test]
    fn headings_links_and_code() {
        let text = read("# A `b`\n\n## C\n[d](e.md#f) `configs/a.toml` `x`\n\n## C\n", &mut Nowhere);
        assert_eq!(text.title, "A b");
        assert!(!text.body.contains("<h1"), "{}", text.body);
        assert!(text.body.contains("<h2 id=\"c\">") && text.body.contains("<h2 id=\"c-1\">"), "{}", text.body);
        assert!(text.body.contains("<a href=\"e.html#f\">d</a>"), "{}", text.body);
        assert!(
            text.body.contains("<a href=\"a.html\"><code>configs/a.toml</code></a> <code>x</code>"),
            "{}",
            text.body
        );
    }

    #[test]
    fn markup_is_shown_as_text() {
        let text = read("a <script>b</script>\n\n<div onclick=\"c\">\n", &mut Nowhere);
        assert!(!text.body.contains("<script") && !text.body.contains("<div"), "{}", text.body);
    }

    #[test]
    fn tables_scroll() {
        let text = read("| a | b |\n|---|--:|\n| 1 | 2 |\n", &mut Nowhere);
        assert!(text.body.contains("<div class=\"wide\" tabindex=\"0\"><table>"), "{}", text.body);
        assert!(text.body.contains("<td style=\"text-align: right\">2</td>"), "{}", text.body);
        assert!(text.body.contains("</table>\n</div>"), "{}", text.body);
    }
}

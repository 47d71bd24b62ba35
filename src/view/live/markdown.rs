use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd, html};

/// URL schemes of permitted links.
const SCHEMES: [&str; 3] = ["https://", "http://", "mailto:"];

/// Converts Markdown with tables to HTML. HTML in the text is shown as text. Links without a permitted scheme lose
/// their address, and images are replaced by their alternative text.
pub(super) fn html(text: &str) -> String {
    let events = Parser::new_ext(text, Options::ENABLE_TABLES).filter_map(|event| match event {
        Event::Html(markup) | Event::InlineHtml(markup) => Some(Event::Text(markup)),
        Event::Start(Tag::Image { .. }) | Event::End(TagEnd::Image) => None,
        Event::Start(Tag::Link { link_type, dest_url, title, id }) => {
            let is_known = SCHEMES.iter().any(|scheme| dest_url.starts_with(scheme)) || dest_url.starts_with('#');
            let dest_url = if is_known { dest_url } else { "#".into() };
            Some(Event::Start(Tag::Link { link_type, dest_url, title, id }))
        }
        event => Some(event),
    });
    let mut written = String::new();
    html::push_html(&mut written, events);
    written
}

//! Relative links, so that the site works in any folder of any host, and from disk.

/// Returns the path of a file relative to the folder of another file.
pub fn relative(from: &str, to: &str) -> String {
    let mut steps: Vec<&str> = from.split('/').collect();
    steps.pop();
    let mut rest = to;
    let mut start = 0;
    while let Some((first, behind)) = rest.split_once('/')
        && steps.get(start) == Some(&first)
    {
        rest = behind;
        start += 1;
    }
    format!("{}{rest}", "../".repeat(steps.len() - start))
}

/// Resolves a link in the file `from` to a path from the root of the repository. Returns `None` for a path outside.
pub fn resolve(from: &str, target: &str) -> Option<String> {
    let mut steps: Vec<&str> = from.split('/').collect();
    steps.pop();
    for step in target.split('/') {
        match step {
            "" | "." => {}
            ".." => {
                steps.pop()?;
            }
            step => steps.push(step),
        }
    }
    Some(steps.join("/"))
}

/// Returns the anchor of a heading: lower-case letters, digits and underscores, with hyphens for spaces.
pub fn anchor(heading: &str) -> String {
    let letters = heading.trim().chars().filter_map(|letter| match letter {
        ' ' => Some('-'),
        '-' | '_' => Some(letter),
        letter if letter.is_alphanumeric() => Some(letter),
        _ => None,
    });
    letters.flat_map(char::to_lowercase).collect()
}

/// Escapes text for HTML elements and attributes.
pub fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            letter => escaped.push(letter),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_from_page_to_page() {
        assert_eq!(relative("index.html", "site.css"), "site.css");
        assert_eq!(relative("docs/scene.html", "site.css"), "../site.css");
        assert_eq!(relative("docs/scene.html", "docs/speed.html"), "speed.html");
        assert_eq!(relative("benches/results/a.html", "docs/b.html"), "../../docs/b.html");
        assert_eq!(relative("a/b/c.html", "a/d.html"), "../d.html");
    }

    #[test]
    fn paths_in_files() {
        assert_eq!(resolve("docs/scene.md", "speed.md").as_deref(), Some("docs/speed.md"));
        assert_eq!(resolve("docs/scene.md", "../configs/a.toml").as_deref(), Some("configs/a.toml"));
        assert_eq!(resolve("README.md", "../a"), None);
    }

    #[test]
    fn headings_have_the_anchors_that_links_expect() {
        assert_eq!(anchor("The TC model"), "the-tc-model");
        assert_eq!(anchor("`[[surface.motion]]`"), "surfacemotion");
        assert_eq!(anchor("measure.diffusion, measure.transport"), "measurediffusion-measuretransport");
        assert_eq!(anchor("[stage.thermostat], [run.thermostat]"), "stagethermostat-runthermostat");
    }

    #[test]
    fn text_is_no_markup() {
        assert_eq!(escaped("<a href='x'>&\"</a>"), "&lt;a href=&#39;x&#39;&gt;&amp;&quot;&lt;/a&gt;");
    }
}

use std::fmt::Display;

/// Escapes text for the content or the quoted attributes of a page, and replaces control characters.
pub(in crate::view) fn escape(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            '\n' | '\t' => safe.push(c),
            '\r' => {}
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => safe.push('\u{fffd}'),
            c => safe.push(c),
        }
    }
    safe
}

/// Returns a table cell. `content` must be escaped. On a narrow page, the cell shows the title of the column.
pub(super) fn cell(element: &str, class: &str, head: &str, content: &str) -> String {
    let scope = if element == "th" { " scope=\"row\"" } else { "" };
    let class = if class.is_empty() { String::new() } else { format!(" class=\"{class}\"") };
    let head = if content.is_empty() { String::new() } else { format!(" data-head=\"{}\"", escape(head)) };
    format!("<{element}{scope}{class}{head}>{content}</{element}>")
}

/// Largest number of columns of a printed table. Longer rows are printed as lists.
const MOST_PRINTED: usize = 6;

/// Returns a table. `heads` are the class and the title of each column. Titles and rows must be escaped.
pub(super) fn table<'c, N: Display>(
    class: &str,
    caption: &str,
    heads: impl IntoIterator<Item = (&'c str, N)>,
    rows: &str,
) -> String {
    let head = |(class, name): (&str, N)| match class {
        "" => format!("<th scope=\"col\">{name}</th>"),
        _ => format!("<th scope=\"col\" class=\"{class}\">{name}</th>"),
    };
    let heads: Vec<String> = heads.into_iter().map(head).collect();
    let many = if heads.len() > MOST_PRINTED { " many" } else { "" };
    let heads = heads.concat();
    format!(
        "<div class=\"wide\" role=\"region\" tabindex=\"0\" aria-label=\"{0}\"><table class=\"{class}{many}\">\n<caption>{0}</caption>\n<thead><tr>{heads}</tr></thead>\n<tbody>\n{rows}</tbody>\n\
         </table></div>\n",
        escape(caption)
    )
}

/// `body` must be escaped.
pub(in crate::view) fn document(title: &str, policy: &str, style: &str, body: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{policy}\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>{} - Carom</title>\n<style>\n{style}</style>\n</head>\n\
         <body>\n{body}</body>\n</html>\n",
        escape(title),
    )
}

pub(in crate::view) fn escape_json(json: &str) -> String {
    json.replace('<', "\\u003c").replace('>', "\\u003e").replace('&', "\\u0026").replace('\'', "\\u0027")
}

/// Raises exponents in a unit: `energy / length^3` becomes `energy / length³`. The result is not escaped.
pub(super) fn unit(unit: &str) -> String {
    let mut text = String::with_capacity(unit.len());
    let mut is_raised = false;
    for c in unit.chars() {
        is_raised = c == '^' || (is_raised && raised(c).is_some());
        match raised(c) {
            Some(raised) if is_raised => text.push(raised),
            _ if c == '^' => {}
            _ => text.push(c),
        }
    }
    text
}

const GREEK: [(&str, char); 14] = [
    ("alpha", 'α'),
    ("beta", 'β'),
    ("chi", 'χ'),
    ("delta", 'δ'),
    ("eps", 'ε'),
    ("eta", 'η'),
    ("gamma", 'γ'),
    ("lambda", 'λ'),
    ("mu", 'μ'),
    ("phi", 'φ'),
    ("pi", 'π'),
    ("psi", 'ψ'),
    ("rho", 'ρ'),
    ("sigma", 'σ'),
];

/// Replaces plain text by symbols: `<v^2> / (rho T)` becomes `⟨v²⟩ / (ρ T)`. The result is not escaped.
pub(super) fn symbols(text: &str) -> String {
    let mut symbols = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let word = &rest[..rest.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(rest.len())];
        let before = symbols.chars().next_back().unwrap_or(' ');
        let after = rest[c.len_utf8()..].chars().next().unwrap_or(' ');
        match c {
            _ if !word.is_empty() => match GREEK.iter().find(|(name, _)| *name == word) {
                Some((_, letter)) => symbols.push(*letter),
                None => symbols.push_str(word),
            },
            // If a space follows `<` or precedes `>`, or if `=` follows, the text is a comparison and not an average.
            '<' if !after.is_whitespace() && after != '=' => symbols.push('⟨'),
            '>' if !before.is_whitespace() && after != '=' => symbols.push('⟩'),
            c => symbols.push(c),
        }
        rest = &rest[if word.is_empty() { c.len_utf8() } else { word.len() }..];
    }
    unit(&symbols)
}

/// Returns a unit in brackets, or nothing for a pure number. The result is not escaped.
pub(super) fn brackets(of: &str) -> String {
    if of.is_empty() || of == "1" { String::new() } else { format!(" [{}]", unit(of)) }
}

/// Returns a quantity with its unit in brackets, unless the name contains the unit. The result is not escaped.
pub(super) fn quantity(name: &str, unit: &str) -> String {
    let is_told = name.split(|c: char| !c.is_alphanumeric()).any(|word| word.eq_ignore_ascii_case(unit));
    if is_told { symbols(name) } else { format!("{}{}", symbols(name), brackets(unit)) }
}

fn raised(c: char) -> Option<char> {
    Some(match c {
        '0' => '⁰',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4' => '⁴',
        '5' => '⁵',
        '6' => '⁶',
        '7' => '⁷',
        '8' => '⁸',
        '9' => '⁹',
        '-' => '⁻',
        'D' => 'ᴰ',
        _ => return None,
    })
}

pub(super) fn power_of_ten(exponent: i32) -> String {
    unit(&format!("10^{exponent}"))
}

/// Formats a number: `1.2e-5` becomes `1.2×10⁻⁵`. Words are unchanged.
pub(super) fn number(text: &str) -> String {
    let parts = text.split_once('e').and_then(|(digits, exponent)| Some((digits, exponent.parse::<i32>().ok()?)));
    match parts {
        Some((digits, exponent)) => format!("{}×{}", digits.replace('-', "−"), power_of_ten(exponent)),
        None if text.parse::<f64>().is_ok() => text.replace('-', "−"),
        None => text.to_owned(),
    }
}

pub(super) fn numbers(text: &str) -> String {
    let shown = |word: &str| {
        let (start, end) =
            (word.len() - word.trim_start_matches('(').len(), word.trim_end_matches([',', ';', ')']).len());
        match word.get(start..end) {
            Some(own) if own.parse::<f64>().is_ok() => format!("{}{}{}", &word[..start], number(own), &word[end..]),
            _ => word.to_owned(),
        }
    };
    text.split(' ').map(shown).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn special_characters_are_escaped() {
        assert_eq!(
            escape("</script><b a='1'>&\"\u{0}\r\n"),
            "&lt;/script&gt;&lt;b a=&#39;1&#39;&gt;&amp;&quot;\u{fffd}\n"
        );
        assert_eq!(escape_json("\"</script>&'\""), "\"\\u003c/script\\u003e\\u0026\\u0027\"");
    }

    #[test]
    fn symbols_are_typeset_consistently() {
        assert_eq!(symbols("Z = p / (rho T), <v(0).v(t)>"), "Z = p / (ρ T), ⟨v(0).v(t)⟩");
        assert_eq!(symbols("<(dG_p - <dG_p>)^2> / (2 V T)"), "⟨(dG_p - ⟨dG_p⟩)²⟩ / (2 V T)");
        assert_eq!(symbols("a < b, c > d, phi4 and psi_6"), "a < b, c > d, phi4 and ψ_6");
    }

    #[test]
    fn exponents_are_superscripts() {
        assert_eq!(unit("energy / length^D"), "energy / lengthᴰ");
        assert_eq!(unit("length^-2 * Density2"), "length⁻² * Density2");
        assert_eq!(brackets("1"), "");
        assert_eq!(quantity("time", "time"), "time");
        assert_eq!(quantity("Potential energy per particle", "energy"), "Potential energy per particle");
        assert_eq!(quantity("temperature", "energy"), "temperature [energy]");
        assert_eq!(quantity("rho", "1 / length^3"), "ρ [1 / length³]");
        assert_eq!(quantity("acceptance", "1"), "acceptance");
        assert_eq!(brackets("length^2 / time"), " [length² / time]");
        assert_eq!(number("-1.2e-5"), "−1.2×10⁻⁵");
        assert_eq!(number("-12"), "−12");
        assert_eq!(number("round-off"), "round-off");
        assert_eq!(number("none"), "none");
        assert_eq!(numbers("mass 2e-5, at (-1, 0) for type2"), "mass 2×10⁻⁵, at (−1, 0) for type2");
    }
}

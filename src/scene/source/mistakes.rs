//! Collects all invalid keys and values of a scene file, in the order of the file.

use std::ops::Range;

use serde::Deserialize;
use serde_spanned::Spanned;
use toml::de::{DeTable, DeValue, Deserializer};

use super::Source;
use crate::scene::diagnostic::SceneError;
use crate::scene::file::SceneFile;

/// Maximum number of errors that are reported at a time.
const MOST: usize = 10;

impl Source {
    /// Collects all errors. Each invalid key or value is removed, and the rest is parsed again. A table or array that
    /// becomes incomplete by a removal is not an error.
    pub(super) fn mistakes(&self, first: &toml::de::Error) -> SceneError {
        let mut errors = vec![(first.span().unwrap_or(0..0), self.refused(first))];
        if let Ok(mut tree) = self.tree() {
            let mut damaged = Vec::new();
            let mut last = first.clone();
            while errors.len() < MOST {
                let Some(parent) = last.span().and_then(|range| remove(&mut tree, &range)) else { break };
                damaged.push(parent);
                let Err(next) = SceneFile::deserialize(Deserializer::from(tree.clone())) else { break };
                let range = next.span().unwrap_or(0..0);
                let is_incomplete =
                    |message: &str| message.starts_with("missing field") || message.starts_with("invalid length");
                let follows = is_incomplete(next.message()) && damaged.contains(&range);
                if !follows {
                    errors.push((range, self.refused(&next)));
                }
                last = next;
            }
        }
        // Overrides have positions beyond the end of the file, so errors in overrides come last.
        errors.sort_by_key(|(range, _)| range.start);
        let mut errors = errors.into_iter().map(|(_, error)| error);
        match errors.next() {
            Some(error) => error.with_others(errors.collect()),
            None => self.refused(first),
        }
    }
}

/// Removes the key or value at a range of bytes. Returns the range of the table or array that contained it.
fn remove(tree: &mut Spanned<DeTable<'_>>, range: &Range<usize>) -> Option<Range<usize>> {
    let whole = tree.span();
    remove_from_table(tree.get_mut(), &whole, range)
}

fn remove_from_table(table: &mut DeTable<'_>, own: &Range<usize>, range: &Range<usize>) -> Option<Range<usize>> {
    for (_, value) in table.iter_mut() {
        if let Some(parent) = remove_inside(value, range) {
            return Some(parent);
        }
    }
    let found = table.iter().find(|(key, value)| key.span() == *range || value.span() == *range);
    let key = found.map(|(key, _)| key.get_ref().clone().into_owned())?;
    table.remove(key.as_str());
    Some(own.clone())
}

fn remove_inside(value: &mut Spanned<DeValue<'_>>, range: &Range<usize>) -> Option<Range<usize>> {
    let own = value.span();
    match value.get_mut() {
        DeValue::Table(table) => remove_from_table(table, &own, range),
        DeValue::Array(array) => {
            for element in array.iter_mut() {
                if let Some(parent) = remove_inside(element, range) {
                    return Some(parent);
                }
            }
            if !array.iter().any(|element| element.span() == *range) {
                return None;
            }
            *array = array.iter().filter(|element| element.span() != *range).cloned().collect();
            Some(own)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::model::Scene;

    fn mistakes(text: &str, overrides: &[(&str, &str)]) -> Vec<(usize, String)> {
        let error = Scene::from_toml_with(text, Path::new("scene.toml"), overrides).unwrap_err();
        let all = std::iter::once(&error).chain(error.others());
        all.map(|error| (error.line().unwrap(), error.to_string())).collect()
    }

    const TEXT: &str =
        "seed = -1\nname = \"a\"\n\n[[species]]\nname = \"A\"\nmas = 1.0\ndiameter = \"x\"\n\n[run]\nuntil_tim = 10\n";

    #[test]
    fn all_mistakes_are_reported_in_file_order() {
        let found = mistakes(TEXT, &[]);
        let lines: Vec<usize> = found.iter().map(|(line, _)| *line).collect();
        assert_eq!(lines, [1, 6, 7, 10], "{found:?}");
        assert!(found[1].1.contains("unknown key `mas`") && found[3].1.contains("until_tim"), "{found:?}");
    }

    #[test]
    fn mistakes_in_overrides_come_last() {
        let found = mistakes(TEXT, &[("audit.limit", "1")]);
        assert_eq!(found.len(), 5);
        assert!(found[4].1.contains("unknown key `limit`"), "{found:?}");
    }

    #[test]
    fn one_mistake_is_one_error() {
        assert_eq!(
            mistakes(&TEXT.replace("seed = -1", "seed = 1").replace("mas ", "mass ").replace("\"x\"", "1.0"), &[])
                .len(),
            1
        );
        // Removing the invalid value leaves an incomplete table or list.
        assert_eq!(mistakes("[[bond]]\nparticles = [0, -1]\ninteraction = \"a\"\n", &[]).len(), 1);
        assert_eq!(mistakes("[[measure.flow]]\nname = 3\naxis = \"x\"\nat = 1.0\n", &[]).len(), 1);
    }

    #[test]
    fn many_mistakes_are_cut_short() {
        let text: String = (0..30).map(|k| format!("key{k} = 1\n")).collect();
        assert_eq!(mistakes(&text, &[]).len(), super::MOST);
    }
}

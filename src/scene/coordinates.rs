//! Coordinates from a file: the extended XYZ format, which every viewer of particles reads and writes.
//!
//! A frame is a line with the number of particles, a line that names the columns
//! (`Properties=species:S:1:pos:R:3:velo:R:3`), and a line per particle. Without `Properties` the columns are species,
//! x, y and z.

use std::path::Path;

use crate::Vector;
use crate::scene::diagnostic::SceneErrorKind;
use crate::scene::draft::Listed;

/// Which columns hold what, from 0.
struct Columns {
    species: usize,
    position: usize,
    velocity: Option<usize>,
}

/// The particles of one frame, the first being 0.
pub(crate) fn read(path: &Path, frame: u64) -> Result<Vec<Listed>, SceneErrorKind> {
    let unreadable = |source| SceneErrorKind::Unreadable { path: path.to_owned(), source };
    let bytes = std::fs::read(path).map_err(unreadable)?;
    let wrong = |line: usize, problem: String| SceneErrorKind::Coordinates { path: path.to_owned(), line, problem };
    let text = std::str::from_utf8(&bytes).map_err(|error| {
        let line = 1 + bytes[..error.valid_up_to()].iter().filter(|&&byte| byte == b'\n').count();
        wrong(line, "not UTF-8 text".to_owned())
    })?;
    parse(text, frame).map_err(|(line, problem)| wrong(line, problem))
}

/// The particles, or the line and what is wrong with it.
fn parse(text: &str, frame: u64) -> Result<Vec<Listed>, (usize, String)> {
    let mut lines = text.lines().enumerate().map(|(index, line)| (index + 1, line));
    for current in 0.. {
        let Some((number, line)) = lines.find(|(_, line)| !line.trim().is_empty()) else {
            let frames = if current == 1 { "1 frame".to_owned() } else { format!("{current} frames") };
            return Err((text.lines().count().max(1), format!("the file ends after {frames}, expected frame {frame}")));
        };
        let count: usize = line
            .trim()
            .parse()
            .map_err(|_| (number, format!("`{}` is not the number of particles", shortened(line.trim()))))?;
        let (number, comment) =
            lines.next().ok_or_else(|| (number, "the file ends before the line of columns".into()))?;
        if current < frame {
            if count > 0 {
                lines.nth(count - 1);
            }
            continue;
        }
        let columns = columns(comment).map_err(|problem| (number, problem))?;
        let mut particles = Vec::new();
        for read in 0..count {
            let (number, line) =
                lines.next().ok_or_else(|| (number, format!("the file ends after {read} of {count} particles")))?;
            particles.push(particle(line, &columns).map_err(|problem| (number, problem))?);
        }
        return Ok(particles);
    }
    Err((1, "too many frames".to_owned()))
}

fn columns(comment: &str) -> Result<Columns, String> {
    let Some(start) = comment.find("Properties=") else {
        return Ok(Columns { species: 0, position: 1, velocity: None });
    };
    let list = comment[start + "Properties=".len()..].split_whitespace().next().unwrap_or_default();
    let words: Vec<&str> = list.trim_matches('"').split(':').collect();
    let (mut species, mut position, mut velocity, mut column) = (None, None, None, 0_usize);
    for triple in words.chunks(3) {
        let [name, _, width] = triple else {
            return Err(format!("`Properties={}` is not a list of name:type:columns", shortened(list)));
        };
        let width: usize = width.parse().map_err(|_| format!("`{}` is not a number of columns", shortened(width)))?;
        match (*name, width) {
            // The trajectories of this program call it type, after the convention of other readers.
            ("species" | "type", 1) => species = Some(column),
            ("pos", 3) => position = Some(column),
            ("velo" | "vel", 3) => velocity = Some(column),
            _ => {}
        }
        column = column.saturating_add(width);
    }
    match (species, position) {
        (Some(species), Some(position)) => Ok(Columns { species, position, velocity }),
        (None, _) => Err("Properties has no species:S:1".to_owned()),
        (_, None) => Err("Properties has no pos:R:3".to_owned()),
    }
}

fn particle(line: &str, columns: &Columns) -> Result<Listed, String> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let word = |column: usize| {
        words.get(column).copied().ok_or_else(|| format!("{} columns, expected at least {}", words.len(), column + 1))
    };
    let vector = |first: usize| {
        let mut vector = Vector::zeros();
        for k in 0..3 {
            let word = word(first.saturating_add(k))?;
            let value = word.parse::<f64>().ok().filter(|value| value.is_finite());
            vector[k] = value.ok_or_else(|| format!("`{}` is not a finite number", shortened(word)))?;
        }
        Ok::<_, String>(vector)
    };
    Ok(Listed {
        species: word(columns.species)?.to_owned(),
        position: vector(columns.position)?,
        velocity: columns.velocity.map_or(Ok(Vector::zeros()), vector)?,
    })
}

/// The beginning of a word, so that a wrong file does not fill the screen.
fn shortened(word: &str) -> String {
    const MOST: usize = 40;
    if word.chars().count() <= MOST {
        word.to_owned()
    } else {
        word.chars().take(MOST).chain(['.', '.', '.']).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_found_by_name() {
        let text = "2\nLattice=\"1 0 0 0 1 0 0 0 1\" Properties=id:I:1:species:S:1:velo:R:3:pos:R:3 Time=0\n\
                    0 A 1 2 3 4 5 6\n1 B 0 0 0 7 8 9\n";
        let particles = parse(text, 0).unwrap();
        assert_eq!(particles[0].species, "A");
        assert_eq!(particles[0].position, Vector::new(4.0, 5.0, 6.0));
        assert_eq!(particles[0].velocity, Vector::new(1.0, 2.0, 3.0));
        assert_eq!(particles[1].position, Vector::new(7.0, 8.0, 9.0));
    }

    #[test]
    fn a_plain_file_has_species_and_coordinates_and_frames_are_counted() {
        let text = "1\n\nA 1 2 3\n1\n\nA 4 5 6\n";
        assert_eq!(parse(text, 1).unwrap()[0].position, Vector::new(4.0, 5.0, 6.0));
        assert_eq!(parse(text, 2).unwrap_err().0, 6);
    }

    #[test]
    fn wrong_files_name_the_line() {
        assert_eq!(parse("", 0).unwrap_err().0, 1);
        assert_eq!(parse("x\n\n", 0).unwrap_err(), (1, "`x` is not the number of particles".to_owned()));
        assert_eq!(parse("2\n\nA 1 2 3\n", 0).unwrap_err().1, "the file ends after 1 of 2 particles");
        assert_eq!(parse("1\n\nA 1 2\n", 0).unwrap_err(), (3, "3 columns, expected at least 4".to_owned()));
        assert_eq!(parse("1\n\nA 1 nan 3\n", 0).unwrap_err().1, "`nan` is not a finite number");
        assert!(parse("1\nProperties=pos:R:3\n1 2 3\n", 0).unwrap_err().1.contains("species"));
        assert!(parse("99999999999999999\n\nA 1 2 3\n", 0).is_err(), "the announced number is not allocated");
    }
}

//! Text STL: solids made of facets, each with one loop of three vertices. Lines may be broken between any two words.

use super::error::{MeshFileProblem, Place};
use super::words::{Word, Words};
use crate::Vector;
use crate::model::triangle_mesh::{MOST_TRIANGLES, TriangleMesh, Welder};

/// Reads a text STL file with one or more solids. Names of solids may have any encoding.
pub(super) fn read(content: &[u8]) -> Result<TriangleMesh, MeshFileProblem> {
    let mut words = Words::of(content);
    let mut welder = Welder::default();
    let mut is_inside = false;
    loop {
        let expected = if is_inside { "`facet` or `endsolid`" } else { "`solid` or the end of the file" };
        match words.next() {
            None if is_inside => return Err(MeshFileProblem::Truncated { line: words.line(), expected }),
            None if welder.len() == 0 => return Err(MeshFileProblem::NoTriangle { expected: "`facet`" }),
            None => return Ok(welder.finish()),
            Some(word) if !is_inside && word.is("solid") => {
                skip_name(&mut words);
                is_inside = true;
            }
            Some(word) if is_inside && is_end(&word, &mut words, "solid") => is_inside = skip_name(&mut words),
            Some(word) if is_inside && word.is("facet") => {
                if welder.len() == MOST_TRIANGLES {
                    return Err(MeshFileProblem::TooManyTriangles { place: Place::Line(word.line) });
                }
                welder.push(&facet(&mut words)?);
            }
            Some(word) => return Err(word.unexpected(expected)),
        }
    }
}

/// Skips the name of a solid, up to a facet or the end of the line. Returns whether a facet follows on the line.
fn skip_name(words: &mut Words<'_>) -> bool {
    let mut ahead = words.clone();
    while let Some(word) = ahead.next_on_line() {
        if word.is("facet") && ahead.clone().next_on_line().is_some_and(|word| word.is("normal")) {
            return true;
        }
        *words = ahead.clone();
    }
    words.skip_line();
    false
}

fn is_end(word: &Word<'_>, words: &mut Words<'_>, part: &str) -> bool {
    let is_part = |text: &[u8]| text.eq_ignore_ascii_case(part.as_bytes());
    if let Some((end, rest)) = word.text.split_at_checked(3)
        && end.eq_ignore_ascii_case(b"end")
    {
        let mut ahead = words.clone();
        if rest.is_empty() && ahead.next().is_some_and(|word| is_part(word.text)) {
            *words = ahead;
            return true;
        }
        return is_part(rest);
    }
    false
}

fn facet(words: &mut Words<'_>) -> Result<[Vector; 3], MeshFileProblem> {
    keyword(words, "normal", "`normal`")?;
    for _ in 0..3 {
        // The normal is not parsed. In many files, the normal of a facet of zero area is NaN.
        next(words, "a component of the normal")?;
    }
    keyword(words, "outer", "`outer` after the three components of the normal")?;
    keyword(words, "loop", "`loop`")?;
    let mut corners = [Vector::zeros(); 3];
    for corner in &mut corners {
        keyword(words, "vertex", "`vertex`, because a facet has three vertices")?;
        for coordinate in corner.iter_mut() {
            *coordinate = next(words, "a coordinate")?.coordinate()?;
        }
    }
    end(words, "loop", "`endloop` after three vertices with three coordinates each")?;
    end(words, "facet", "`endfacet`")?;
    Ok(corners)
}

fn next<'a>(words: &mut Words<'a>, expected: &'static str) -> Result<Word<'a>, MeshFileProblem> {
    words.next().ok_or(MeshFileProblem::Truncated { line: words.line(), expected })
}

fn keyword(words: &mut Words<'_>, keyword: &str, expected: &'static str) -> Result<(), MeshFileProblem> {
    let word = next(words, expected)?;
    if word.is(keyword) { Ok(()) } else { Err(word.unexpected(expected)) }
}

fn end(words: &mut Words<'_>, part: &str, expected: &'static str) -> Result<(), MeshFileProblem> {
    let word = next(words, expected)?;
    if is_end(&word, words, part) { Ok(()) } else { Err(word.unexpected(expected)) }
}

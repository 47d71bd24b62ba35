//! Text STL: solids of facets of one loop of three vertices.

use super::error::{MeshFileProblem, Place};
use super::words::{Word, Words};
use crate::Vector;
use crate::model::triangle_mesh::{MOST_TRIANGLES, TriangleMesh, Welder};

/// Reads a whole file, which may hold several solids; their names are passed over, in whichever encoding they are.
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
            Some(word) if word.is(if is_inside { "endsolid" } else { "solid" }) => {
                is_inside = !is_inside;
                words.skip_line();
            }
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

/// Reads what follows `facet`.
fn facet(words: &mut Words<'_>) -> Result<[Vector; 3], MeshFileProblem> {
    keyword(words, "normal", "`normal`")?;
    for _ in 0..3 {
        // Not a number in many files, where the area is zero.
        next(words, "a component of the normal")?;
    }
    keyword(words, "outer", "`outer` behind three components of the normal")?;
    keyword(words, "loop", "`loop`")?;
    let mut corners = [Vector::zeros(); 3];
    for corner in &mut corners {
        keyword(words, "vertex", "`vertex`, of which a facet has three")?;
        for coordinate in corner.iter_mut() {
            *coordinate = next(words, "a coordinate")?.coordinate()?;
        }
    }
    keyword(words, "endloop", "`endloop` behind three vertices of three coordinates")?;
    keyword(words, "endfacet", "`endfacet`")?;
    Ok(corners)
}

/// The next word.
fn next<'a>(words: &mut Words<'a>, expected: &'static str) -> Result<Word<'a>, MeshFileProblem> {
    words.next().ok_or(MeshFileProblem::Truncated { line: words.line(), expected })
}

/// Passes over a keyword.
fn keyword(words: &mut Words<'_>, keyword: &str, expected: &'static str) -> Result<(), MeshFileProblem> {
    let word = next(words, expected)?;
    if word.is(keyword) { Ok(()) } else { Err(word.unexpected(expected)) }
}

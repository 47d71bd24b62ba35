//! Wavefront OBJ: positions `v`, and faces `f` that refer to them. Everything else is ignored.
//!
//! Faces of more than three corners are cut into triangles, see [`super::polygon`]. A truncated file may look complete.

use super::error::{MeshFileProblem, Place};
use super::polygon::triangulate;
use super::words::{Word, Words};
use crate::Vector;
use crate::model::triangle_mesh::{MOST_TRIANGLES, TriangleMesh, Welder};

/// Vertices and faces read so far. Faces may come before their vertices, so vertex numbers are checked at the end.
#[derive(Debug, Default)]
struct Faces {
    positions: Vec<Vector>,
    triangles: Vec<[u32; 3]>,
    polygons: Vec<Polygon>,
    /// Largest vertex number in a face, counted from 1, and the line number of the face.
    farthest: (u32, usize),
}

/// A face with more than three corners. At first, the face is divided into a fan of triangles around its first corner.
#[derive(Debug)]
struct Polygon {
    line: usize,
    /// Index of the first triangle of the fan.
    first: usize,
    corners: usize,
}

pub(super) fn read(content: &[u8]) -> Result<TriangleMesh, MeshFileProblem> {
    let mut words = Words::of(content);
    let mut faces = Faces::default();
    loop {
        match words.next_on_line() {
            Some(word) if word.text == b"v" => faces.positions.push(position(&mut words)?),
            Some(word) if word.text == b"f" => faces.read(word.line, &mut words)?,
            _ => {}
        }
        if !words.skip_line() {
            return faces.finish();
        }
    }
}

/// Reads a position. A weight or a colour after the position is ignored.
fn position(words: &mut Words<'_>) -> Result<Vector, MeshFileProblem> {
    let mut position = Vector::zeros();
    for coordinate in position.iter_mut() {
        let word = words.next_on_line().unwrap_or(Word { text: b"end of line", line: words.line() });
        *coordinate = word.coordinate()?;
    }
    Ok(position)
}

impl Faces {
    fn read(&mut self, line: usize, words: &mut Words<'_>) -> Result<(), MeshFileProblem> {
        let (mut first, mut last, mut corners) = (0, 0, 0);
        while let Some(word) = words.next_on_line() {
            let corner = self.corner(&word)?;
            corners += 1;
            if corners == 1 {
                first = corner;
            }
            if corners > 2 {
                if self.triangles.len() == MOST_TRIANGLES {
                    return Err(MeshFileProblem::TooManyTriangles { place: Place::Line(line) });
                }
                self.triangles.push([first, last, corner]);
            }
            last = corner;
        }
        if corners > 3 {
            self.polygons.push(Polygon { line, first: self.triangles.len() - (corners - 2), corners });
        }
        if corners < 3 { Err(MeshFileProblem::Corners { line, found: corners }) } else { Ok(()) }
    }

    /// Returns the index of a vertex. A corner of a face is written as `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn corner(&mut self, word: &Word<'_>) -> Result<u32, MeshFileProblem> {
        let text = word.text.split(|byte| *byte == b'/').next().unwrap_or_default();
        let text = std::str::from_utf8(text).ok();
        let Some(found) = text.and_then(|text| text.parse::<i64>().ok()) else {
            return Err(word.unexpected("the number of a vertex, such as 7, -1 or 7/2/3"));
        };
        let vertices = self.positions.len();
        let last = i64::try_from(vertices).unwrap_or(i64::MAX);
        let number = if found < 0 { found.saturating_add(last).saturating_add(1) } else { found };
        match u32::try_from(number) {
            Ok(number @ 1..) => {
                if number > self.farthest.0 {
                    self.farthest = (number, word.line);
                }
                Ok(number - 1)
            }
            _ => Err(MeshFileProblem::Index { line: word.line, found, vertices }),
        }
    }

    fn finish(mut self) -> Result<TriangleMesh, MeshFileProblem> {
        let (farthest, line) = self.farthest;
        let vertices = self.positions.len();
        if farthest as usize > vertices {
            return Err(MeshFileProblem::Index { line, found: i64::from(farthest), vertices });
        }
        if self.triangles.is_empty() {
            return Err(MeshFileProblem::NoTriangle { expected: "face `f`" });
        }
        self.cut_polygons()?;
        let mesh = TriangleMesh { vertices: self.positions, triangles: self.triangles };
        let mut welder = Welder::default();
        mesh.all_corners().for_each(|corners| welder.push(&corners));
        Ok(welder.finish())
    }

    /// Replaces each fan that is not a valid triangulation of its face.
    fn cut_polygons(&mut self) -> Result<(), MeshFileProblem> {
        for &Polygon { line, first, corners } in &self.polygons {
            let Some(fan) = self.triangles.get_mut(first..first + corners - 2) else { continue };
            let begin = fan.first().map(|&[a, b, _]| [a, b]).unwrap_or_default();
            let numbers: Vec<u32> = begin.into_iter().chain(fan.iter().map(|triangle| triangle[2])).collect();
            let at = |number: &u32| self.positions.get(*number as usize).copied().unwrap_or_default();
            let polygon: Vec<Vector> = numbers.iter().map(at).collect();
            let cut = triangulate(&polygon).map_err(|problem| MeshFileProblem::Polygon { line, corners, problem })?;
            for (triangle, corners) in fan.iter_mut().zip(cut.into_iter().flatten()) {
                *triangle = corners.map(|corner| numbers.get(corner).copied().unwrap_or_default());
            }
        }
        Ok(())
    }
}

//! Writes VTK XML PolyData. A description in XML is followed by binary arrays.

use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::Path;

use crate::Vector;
use crate::io::convert::draft;

#[derive(Debug, Default)]
pub(super) struct PolyData {
    fields: String,
    points: String,
    point_data: String,
    vertices: String,
    lines: String,
    polygons: String,
    point_count: usize,
    vertex_count: usize,
    line_count: usize,
    polygon_count: usize,
    appended: Vec<u8>,
}

impl PolyData {
    /// Adds numbers that describe the whole frame.
    pub fn field(&mut self, name: &str, components: usize, numbers: impl IntoIterator<Item = f64>) {
        let bytes: Vec<u8> = numbers.into_iter().flat_map(f64::to_le_bytes).collect();
        let tuples = bytes.len() / (8 * components.max(1));
        self.fields += &append(&mut self.appended, "Float64", name, components, Some(tuples), &bytes);
    }

    pub fn byte_field(&mut self, name: &str, bytes: [u8; 3]) {
        self.fields += &append(&mut self.appended, "UInt8", name, 1, Some(3), &bytes);
    }

    /// Adds words that describe the whole frame, as character codes with a zero after each word.
    pub fn words<'a>(&mut self, name: &str, words: impl Iterator<Item = &'a str>) {
        let mut count = 0;
        let mut codes = String::new();
        for word in words {
            count += 1;
            for byte in word.bytes().chain([0]) {
                let _ = write!(codes, "{byte} ");
            }
        }
        self.fields += &format!(
            "<Array type=\"String\" Name=\"{name}\" NumberOfTuples=\"{count}\" format=\"ascii\">{}</Array>\n",
            codes.trim_end()
        );
    }

    pub fn points<'a>(&mut self, points: impl Iterator<Item = &'a Vector>) {
        let bytes = vector_bytes(points);
        self.point_count = bytes.len() / 24;
        self.points = append(&mut self.appended, "Float64", "Points", 3, None, &bytes);
    }

    /// Viewers do not draw points without vertices.
    pub fn vertices(&mut self) {
        let cells: Vec<[u32; 1]> = (0..).take(self.point_count).map(|point| [point]).collect();
        self.vertex_count = cells.len();
        self.vertices = self.cells(&cells);
    }

    pub fn lines(&mut self, ends: &[[u32; 2]]) {
        self.line_count = ends.len();
        self.lines = self.cells(ends);
    }

    pub fn triangles(&mut self, corners: &[[u32; 3]]) {
        self.polygon_count = corners.len();
        self.polygons = self.cells(corners);
    }

    /// `kind` is the VTK type of the numbers. `bytes` are little-endian.
    pub fn point_array(&mut self, name: &str, kind: &str, components: usize, bytes: impl Iterator<Item = u8>) {
        self.point_data += &append(&mut self.appended, kind, name, components, None, &bytes.collect::<Vec<u8>>());
    }

    fn cells<const N: usize>(&mut self, cells: &[[u32; N]]) -> String {
        let points = cells.iter().flatten().flat_map(|&point| i64::from(point).to_le_bytes());
        let ends = (1..=cells.len()).flat_map(|cell| ((cell * N) as i64).to_le_bytes());
        let points = append(&mut self.appended, "Int64", "connectivity", 1, None, &points.collect::<Vec<u8>>());
        points + &append(&mut self.appended, "Int64", "offsets", 1, None, &ends.collect::<Vec<u8>>())
    }

    pub fn write(&self, path: &Path) -> io::Result<()> {
        let mut file = draft(path)?;
        write!(
            file,
            "<?xml version=\"1.0\"?>\n\
            <VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
            <PolyData>\n<FieldData>\n{}</FieldData>\n\
            <Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"{}\" NumberOfStrips=\"0\" NumberOfPolys=\"{}\">\n\
            <PointData>\n{}</PointData>\n<Points>\n{}</Points>\n<Verts>\n{}</Verts>\n<Lines>\n{}</Lines>\n<Polys>\n{}</Polys>\n</Piece>\n\
            </PolyData>\n<AppendedData encoding=\"raw\">\n_",
            self.fields,
            self.point_count,
            self.vertex_count,
            self.line_count,
            self.polygon_count,
            self.point_data,
            self.points,
            self.vertices,
            self.lines,
            self.polygons
        )?;
        file.write_all(&self.appended)?;
        file.write_all(b"\n</AppendedData>\n</VTKFile>\n")?;
        // Syncing each frame's file to disk would take longer than all other work.
        file.flush()
    }
}

fn vector_bytes<'a>(vectors: impl Iterator<Item = &'a Vector>) -> Vec<u8> {
    vectors.flat_map(|vector| vector.iter()).flat_map(|x| x.to_le_bytes()).collect()
}

/// Appends an array and returns its XML element. The element of a field contains the number of tuples.
fn append(
    appended: &mut Vec<u8>,
    kind: &str,
    name: &str,
    components: usize,
    tuples: Option<usize>,
    bytes: &[u8],
) -> String {
    let offset = appended.len();
    appended.extend_from_slice(&(bytes.len() as u64).to_le_bytes());
    appended.extend_from_slice(bytes);
    let tuples = tuples.map_or_else(String::new, |tuples| format!(" NumberOfTuples=\"{tuples}\""));
    format!(
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\"{tuples} format=\"appended\" \
        offset=\"{offset}\"/>\n"
    )
}

//! A trajectory as a table with a line for each particle and frame, for spreadsheets, pandas and R.
//!
//! The columns are `frame` (index in the trajectory, from 0), `time`, `id`, `species`, `x`, `y`, `z`, `vx`, `vy`, `vz`
//! and `radius`. If the first frame has image numbers, the columns `ix`, `iy` and `iz` follow. The last columns are the
//! scalars of the first frame. Cells of missing values are empty. Numbers have the fewest digits that restore the exact
//! value. Species names with commas or quotes are quoted (RFC 4180). An apostrophe is added before a name that a
//! spreadsheet would read as a formula.

use std::io::Write;

use super::convert::{Draft, FrameError, Moment, Writer, finish};
use super::number::Cell;
use super::table::text_cell;
use crate::analysis::instruments::Scalar;
use crate::trajectory::Frame;

const HEADER: &str = "frame,time,id,species,x,y,z,vx,vy,vz,radius";

#[derive(Debug)]
pub(super) struct Table {
    file: Draft,
    /// Whether the first frame has images, and the names of its scalars. `None` before the first frame.
    columns: Option<(bool, Vec<String>)>,
}

impl Table {
    pub fn new(file: Draft) -> Self {
        Self { file, columns: None }
    }

    fn header(&mut self, first: &Frame) -> Result<(bool, Vec<String>), FrameError> {
        let has_images = !first.images.is_empty();
        write!(self.file, "{HEADER}{}", if has_images { ",ix,iy,iz" } else { "" })?;
        for scalar in &first.scalars {
            write!(self.file, ",{}", scalar.name)?;
        }
        self.file.write_all(b"\n")?;
        Ok((has_images, first.scalars.iter().map(|scalar| scalar.name.clone()).collect()))
    }
}

impl Writer for Table {
    fn write(&mut self, moment: &Moment) -> Result<(), FrameError> {
        let Moment { index, frame, has_velocities } = *moment;
        let (has_images, scalars) = match self.columns.take() {
            Some(columns) => columns,
            None => self.header(frame)?,
        };
        let columns: Vec<Option<&Scalar>> =
            scalars.iter().map(|name| frame.scalars.iter().find(|scalar| scalar.name == *name)).collect();
        let names: Vec<String> = frame.species.iter().map(|species| text_cell(&species.name)).collect();
        let time = Cell(Some(frame.time));
        for (place, particle) in frame.particles.iter().enumerate() {
            let name = names.get(particle.species.0 as usize).map_or("", String::as_str);
            write!(self.file, "{index},{time},{},{name}", particle.id.0)?;
            for &x in &particle.position {
                write!(self.file, ",{}", Cell(Some(x)))?;
            }
            for &v in &particle.velocity {
                write!(self.file, ",{}", Cell(has_velocities.then_some(v)))?;
            }
            write!(self.file, ",{}", Cell(Some(particle.radius)))?;
            if has_images {
                match frame.images.get(place) {
                    Some([x, y, z]) => write!(self.file, ",{x},{y},{z}")?,
                    None => self.file.write_all(b",,,")?,
                }
            }
            for column in &columns {
                write!(self.file, ",{}", Cell(column.map(|scalar| scalar.values[place])))?;
            }
            self.file.write_all(b"\n")?;
        }
        self.columns = Some((has_images, scalars));
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), FrameError> {
        Ok(finish(self.file)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::convert::tests::{chain, converted};
    use crate::model::Format;

    #[test]
    fn csv_has_one_line_per_particle_and_frame() {
        let mut frame = chain();
        frame.species[1].name = "a,b".into();
        frame.particles.truncate(2);
        frame.bonds.clear();
        let text = String::from_utf8(converted(&[frame], Format::Csv)).unwrap();
        let expected = "frame,time,id,species,x,y,z,vx,vy,vz,radius\n\
            0,0.25,0,bead,-1.5,0.1,2,1,0.30000000000000004,-2e-9,0.5\n\
            0,0.25,1,\"a,b\",-0.5,0.1,2,0,0,0,0.75\n";
        assert_eq!(text, expected);
        assert_eq!([text_cell("ab"), text_cell("a\"b")], ["ab", "\"a\"\"b\""]);
        assert_eq!([text_cell("=1+cmd"), text_cell("-1,x"), text_cell("1-x")], ["'=1+cmd", "\"'-1,x\"", "1-x"]);
    }

    #[test]
    fn velocities_that_are_not_known_are_empty() {
        let folder = tempfile::tempdir().unwrap();
        let (source, target) = (folder.path().join("a.xyz"), folder.path().join("a.csv"));
        std::fs::write(&source, "1\n\nO 1 2 3\n").unwrap();
        crate::io::convert::convert(&source, Format::Csv, &target, &Default::default()).unwrap();
        let text = std::fs::read_to_string(target).unwrap();
        assert_eq!(text.lines().nth(1), Some("0,0,0,O,1,2,3,,,,0.5"));
    }
}

//! A trajectory as a text dump of LAMMPS (`dump custom` with `dump_modify units yes time yes`).
//!
//! ```text
//! ITEM: UNITS
//! lj
//! ITEM: TIME
//! 0.5
//! ITEM: TIMESTEP
//! 1
//! ITEM: NUMBER OF ATOMS
//! 1
//! ITEM: BOX BOUNDS pp pp ff
//! 0 5
//! 0 5
//! -0.5 0.5
//! ITEM: ATOMS id type element x y z vx vy vz ix iy iz radius
//! 0 1 ball 0.5 0.5 0 1 0 0 -2 0 0 0.5
//! ```
//!
//! `TIMESTEP` is the index of the frame, from 0. `TIME` is the simulated time. Ids count from 0. Types count from 1 in
//! the order of the species, and `element` is the name of the species. `ix iy iz` are the periods travelled, and the
//! unwrapped position is `x + ix Lx + iy xy`, `y + iy Ly`, `z + iz Lz`. Velocities and images are left out if the
//! source has none. Sides are `p` (periodic) or `f` (all others). The edge along a flat axis is the largest diameter.
//! Further columns are the scalars of the particles. Numbers have the fewest digits that restore the exact value.
//!
//! A sheared box with a displaced image along y has the bounds of its parallelepiped and the tilt factor `xy`, which is
//! the displacement: `ITEM: BOX BOUNDS xy xz yz pp pp pp`. Positions do not change.
//!
//! ASE accepts only chemical symbols as names, and MDAnalysis (2.11) rejects dumps with `TIME`. Use extended XYZ for
//! these programs, or GSD for MDAnalysis.

use std::io::Write;

use super::convert::{Draft, FrameError, Moment, Writer, finish};
use super::number::Cell;

#[derive(Debug)]
pub(super) struct Dump {
    file: Draft,
    has_units: bool,
}

impl Dump {
    pub fn new(file: Draft) -> Self {
        Self { file, has_units: false }
    }

    fn header(&mut self, moment: &Moment) -> Result<(), FrameError> {
        let Moment { index, frame, has_velocities } = *moment;
        let file = &mut self.file;
        if !self.has_units {
            file.write_all(b"ITEM: UNITS\nlj\n")?;
            self.has_units = true;
        }
        write!(file, "ITEM: TIME\n{}\nITEM: TIMESTEP\n{index}\n", Cell(Some(frame.time)))?;
        let tilt = frame.displacement;
        let is_tilted = tilt != 0.0;
        let tilts = if is_tilted { " xy xz yz" } else { "" };
        write!(file, "ITEM: NUMBER OF ATOMS\n{}\nITEM: BOX BOUNDS{tilts}", frame.particles.len())?;
        for is_periodic in frame.periodic {
            file.write_all(if is_periodic { b" pp" } else { b" ff" })?;
        }
        let (mut lower, mut upper) = frame.thickened();
        // The bounds in a LAMMPS dump include all corners of the tilted box.
        lower.x += tilt.min(0.0);
        upper.x += tilt.max(0.0);
        for ((lower, upper), tilt) in lower.iter().zip(&upper).zip([tilt, 0.0, 0.0]) {
            write!(file, "\n{} {}", Cell(Some(*lower)), Cell(Some(*upper)))?;
            if is_tilted {
                write!(file, " {}", Cell(Some(tilt)))?;
            }
        }
        let velocities = if has_velocities { " vx vy vz" } else { "" };
        let images = if frame.images.is_empty() { "" } else { " ix iy iz" };
        write!(file, "\nITEM: ATOMS id type element x y z{velocities}{images} radius")?;
        for scalar in &frame.scalars {
            write!(file, " {}", scalar.name)?;
        }
        file.write_all(b"\n")?;
        Ok(())
    }
}

impl Writer for Dump {
    fn write(&mut self, moment: &Moment) -> Result<(), FrameError> {
        self.header(moment)?;
        let Moment { frame, has_velocities, .. } = *moment;
        for (index, particle) in frame.particles.iter().enumerate() {
            let name = frame.species.get(particle.species.0 as usize).map_or("", |species| species.name.as_str());
            write!(self.file, "{} {} {name}", particle.id.0, u64::from(particle.species.0) + 1)?;
            let velocity = if has_velocities { particle.velocity.as_slice() } else { &[] };
            let scalars = frame.scalars.iter().map(|scalar| &scalar.values[index]);
            for &number in particle.position.iter().chain(velocity) {
                write!(self.file, " {}", Cell(Some(number)))?;
            }
            for image in frame.images.get(index).into_iter().flatten() {
                write!(self.file, " {image}")?;
            }
            for &number in [&particle.radius].into_iter().chain(scalars) {
                write!(self.file, " {}", Cell(Some(number)))?;
            }
            self.file.write_all(b"\n")?;
        }
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), FrameError> {
        Ok(finish(self.file)?)
    }
}

#[cfg(test)]
mod tests {
    use crate::Vector;
    use crate::io::convert::tests::{chain, converted};
    use crate::model::Format;
    use crate::trajectory::Frame;

    #[test]
    fn written_lammps_frame_is_exact() {
        let mut frame = chain();
        frame.particles.truncate(2);
        frame.bonds.clear();
        let text = String::from_utf8(converted(&[frame.clone(), frame], Format::Lammps)).unwrap();
        let one = |index| {
            format!(
                "ITEM: TIME\n0.25\nITEM: TIMESTEP\n{index}\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp ff pp\n-2 2\n-1 5\n\
                0 10\nITEM: ATOMS id type element x y z vx vy vz radius\n\
                0 1 bead -1.5 0.1 2 1 0.30000000000000004 -2e-9 0.5\n1 2 bob -0.5 0.1 2 0 0 0 0.75\n"
            )
        };
        assert_eq!(text, format!("ITEM: UNITS\nlj\n{}{}", one(0), one(1)));
    }

    #[test]
    fn a_sheared_box_has_the_bounds_of_its_corners_and_its_tilt() {
        for (displacement, line) in [(1.5, "-2 3.5 1.5"), (-1.5, "-3.5 2 -1.5")] {
            let mut frame = Frame { displacement, ..chain() };
            frame.periodic[1] = true;
            let text = String::from_utf8(converted(&[frame], Format::Lammps)).unwrap();
            let expected = format!("BOX BOUNDS xy xz yz pp pp pp\n{line}\n-1 5 0\n0 10 0\nITEM: ATOMS");
            assert!(text.contains(&expected), "{text}");
        }
    }

    #[test]
    fn a_flat_axis_is_as_thick_as_the_largest_particle() {
        let mut frame = chain();
        frame.size = Vector::new(4.0, 6.0, 0.0);
        frame.lower.z = 2.0;
        frame.periodic[2] = false;
        let text = String::from_utf8(converted(&[frame], Format::Lammps)).unwrap();
        assert!(text.contains("BOX BOUNDS pp ff ff\n-2 2\n-1 5\n1.25 2.75\n"), "{text}");
    }
}

mod particle;

pub(crate) use particle::Beside;

use std::io::{BufRead, Read};

use self::particle::{SpeciesTable, Words};
use super::comment::{Columns, Comment};
use super::error::LONGEST;
use super::{LONGEST_LINE, ReadError};
use crate::Vector;
use crate::analysis::instruments::Scalar;
use crate::base::text::shorten;
use crate::trajectory::Frame;
use crate::trajectory::frame::FrameParticle;

/// Maximum number of particles for which memory is reserved in advance. The count in a damaged file may be huge.
const TRUSTED_COUNT: usize = 1 << 16;

/// The part of a frame before its particles.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Preamble {
    pub count: usize,
    pub time: f64,
    /// Lower corner and edges of the box, if the file contains them `[length]`.
    pub region: Option<(Vector, Vector)>,
}

/// Iterator over the frames of a trajectory in extended XYZ. It ends after the first error.
///
/// Missing data get default values. Times and velocities are zero, radii are 1/2, and ids count the lines from 0. The
/// box just contains the particles and is not periodic. [`Frame::images`] is empty. An unknown column of real numbers
/// is kept as a scalar if all its numbers are finite.
#[derive(Debug)]
pub struct FrameReader<R> {
    input: R,
    line: usize,
    text: Vec<u8>,
    frame_line: usize,
    columns: Columns,
    has_box: bool,
    is_finished: bool,
    beside: Beside,
}

impl<R: BufRead> FrameReader<R> {
    /// Creates a reader. The input must start at the beginning of a frame.
    pub fn new(input: R) -> Self {
        Self::behind(input, 0)
    }

    /// Creates a reader for an input whose first `lines` lines have been removed.
    pub(crate) fn behind(input: R, lines: usize) -> Self {
        Self {
            input,
            line: lines,
            text: Vec::new(),
            frame_line: 0,
            columns: Columns::default(),
            has_box: false,
            is_finished: false,
            beside: Beside::default(),
        }
    }

    /// Whether the last frame contained velocities.
    #[must_use]
    pub fn has_velocities(&self) -> bool {
        self.columns.velocity.is_some()
    }

    /// Whether the last frame contained the species of its particles.
    #[must_use]
    pub fn has_species(&self) -> bool {
        self.columns.species.is_some()
    }

    /// Whether the last frame contained the radii of its particles.
    #[must_use]
    pub fn has_radii(&self) -> bool {
        self.columns.radius.is_some()
    }

    /// Whether the last frame contained its box.
    #[must_use]
    pub fn has_box(&self) -> bool {
        self.has_box
    }

    pub(crate) fn beside(&mut self) -> Beside {
        std::mem::take(&mut self.beside)
    }

    /// The first line of the last frame, counted from 1.
    #[must_use]
    pub fn frame_line(&self) -> usize {
        self.frame_line
    }

    /// Skips the next frame without parsing its numbers. Returns false if there is no further frame.
    ///
    /// # Errors
    /// Any error of reading a frame, except errors in the lines of particles.
    pub fn skip_frame(&mut self) -> Result<bool, ReadError> {
        let Some(count) = self.next_count()? else { return Ok(false) };
        let first = self.line;
        for found in 0..=count {
            if self.next_line()?.is_none() {
                return Err(ReadError::Truncated { line: first, expected: count, found: found.saturating_sub(1) });
            }
        }
        Ok(true)
    }

    pub(crate) fn place(&mut self) -> (usize, &mut R) {
        (self.line, &mut self.input)
    }

    /// Reads the beginning of the next frame and skips the particles. Returns `None` if there is no further frame.
    pub(crate) fn next_preamble(&mut self) -> Result<Option<Preamble>, ReadError> {
        let Some((count, comment)) = self.begin_frame()? else { return Ok(None) };
        let first = self.frame_line;
        let truncated = |found| ReadError::Truncated { line: first, expected: count, found };
        for found in 0..count {
            if self.next_line()?.is_none() {
                return Err(truncated(found));
            }
        }
        if count > 0 && self.text.last() != Some(&b'\n') {
            let mut table = SpeciesTable::new(Vec::new());
            let text = std::str::from_utf8(&self.text).unwrap_or_default().trim_end_matches('\r');
            let is_whole = Words::of(text, self.line, &comment.columns).is_ok_and(|words| {
                words.particle(0, &comment.columns, &mut table).is_ok() && words.image(&comment.columns).is_ok()
            });
            if !is_whole {
                return Err(truncated(count - 1));
            }
        }
        let Frame { time, lower, size, .. } = comment.frame;
        Ok(Some(Preamble { count, time, region: comment.has_box.then_some((lower, size)) }))
    }

    fn next_line(&mut self) -> Result<Option<&str>, ReadError> {
        self.text.clear();
        self.line += 1;
        let line = self.line;
        let mut input = self.input.by_ref().take(LONGEST_LINE);
        let length = input.read_until(b'\n', &mut self.text).map_err(|source| ReadError::Io { line, source })?;
        if length as u64 == LONGEST_LINE && self.text.last() != Some(&b'\n') {
            return Err(ReadError::LineTooLong { line });
        }
        let text = std::str::from_utf8(&self.text).map_err(|_| ReadError::NotText { line })?;
        // Some programs write a byte order mark at the beginning of a file.
        let text = text.strip_prefix('\u{feff}').filter(|_| line == 1).unwrap_or(text);
        Ok(if length == 0 { None } else { Some(text.trim_end_matches(['\n', '\r'])) })
    }

    fn next_count(&mut self) -> Result<Option<usize>, ReadError> {
        loop {
            match self.next_line()?.map(str::trim) {
                None => return Ok(None),
                Some("") => {}
                Some(text) => match text.parse::<u32>() {
                    // Ids are `u32`, which limits the count.
                    Ok(count) => return Ok(Some(count as usize)),
                    Err(_) => {
                        let found = shorten(text, LONGEST);
                        let problem =
                            format!("expected the number of particles of a frame, 0 to 4294967295, found `{found}`");
                        return Err(ReadError::Malformed { line: self.line, problem });
                    }
                },
            }
        }
    }

    fn begin_frame(&mut self) -> Result<Option<(usize, Comment)>, ReadError> {
        let Some(count) = self.next_count()? else { return Ok(None) };
        let first = self.line;
        self.frame_line = first;
        let comment = self.next_line()?.map(|text| Comment::parse(text, first + 1));
        let is_whole = self.text.last() == Some(&b'\n') || count == 0;
        let Some(comment) = comment.filter(|_| is_whole) else {
            return Err(ReadError::Truncated { line: first, expected: count, found: 0 });
        };
        Ok(Some((count, comment?)))
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, ReadError> {
        let Some((count, mut comment)) = self.begin_frame()? else { return Ok(None) };
        let first = self.frame_line;
        let truncated = |found| ReadError::Truncated { line: first, expected: count, found };
        let mut table = SpeciesTable::new(std::mem::take(&mut comment.frame.species));
        let mut particles = Vec::with_capacity(count.min(TRUSTED_COUNT));
        let mut images = Vec::new();
        let mut beside = Beside { unused: comment.columns.unused.clone(), ..Beside::default() };
        let scalars = comment.columns.scalars.iter();
        let mut scalars: Vec<_> = scalars.map(|(name, _)| Scalar { name: name.clone(), values: Vec::new() }).collect();
        for (index, id) in (0..count).zip(0..) {
            let Some(text) = self.next_line()? else { return Err(truncated(index)) };
            if index == 0 && comment.columns.may_be_species.len() > 1 {
                let words: Vec<&str> = text.split_whitespace().collect();
                let names_one = |at: &&usize| words.get(**at).is_some_and(|word| table.has(word));
                let known = comment.columns.may_be_species.iter().find(names_one).copied();
                comment.columns.species = known.or(comment.columns.species);
            }
            let read = Words::of(text, first + 2 + index, &comment.columns).and_then(|words| {
                particles.push(words.particle(id, &comment.columns, &mut table)?);
                images.extend(words.image(&comment.columns)?);
                words.scalars(&comment.columns, &mut scalars);
                beside.read(&words, &comment.columns)
            });
            match read {
                Ok(()) => {}
                // The file may end within a line.
                Err(_) if self.text.last() != Some(&b'\n') => return Err(truncated(index)),
                Err(error) => return Err(error),
            }
        }
        self.beside = beside;
        scalars.retain(|scalar| scalar.values.len() == count);
        self.columns = comment.columns;
        self.has_box = comment.has_box;
        let mut frame = Frame { species: table.species, particles, images, scalars, ..comment.frame };
        if !self.has_box {
            (frame.lower, frame.size) = bounds(&frame.particles);
        }
        Ok(Some(frame))
    }
}

impl<R: BufRead> Iterator for FrameReader<R> {
    type Item = Result<Frame, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.is_finished {
            return None;
        }
        let frame = self.next_frame().transpose();
        self.is_finished = !matches!(frame, Some(Ok(_)));
        frame
    }
}

pub(crate) fn bounds(particles: &[FrameParticle]) -> (Vector, Vector) {
    let mut corners: Option<(Vector, Vector)> = None;
    for particle in particles {
        let (lower, upper) =
            (particle.position.add_scalar(-particle.radius), particle.position.add_scalar(particle.radius));
        corners = Some(corners.map_or((lower, upper), |(l, u)| (l.inf(&lower), u.sup(&upper))));
    }
    corners.map_or((Vector::zeros(), Vector::zeros()), |(lower, upper)| (lower, upper - lower))
}

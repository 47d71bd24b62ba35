//! Per-particle arrays, indexed by the particle's place in memory.
//!
//! These arrays are called columns. The macro `columns` lists all of them.

mod part;
pub(super) mod records;

use super::array::Array;
use super::images::travelled::Travelled;
use super::marks::Marks;
use super::neighbours::Neighbours;
use super::neighbours::cells::NO_PARTICLE;
use super::pairs::contacts::ContactTimes;
use super::pairs::states::{CapturedPairs, PairState};
use super::parts::Engine;
use super::prediction::{FIRST_ABSENT, Prediction, absent};
use super::sources::rest::{Sleepers, Watched};
use super::sources::surface::SurfaceRandom;
use super::state::Body;
use crate::Vector;
use rayon::prelude::*;
use records::Record;

/// A new order of particles, in which particles may be left out.
pub(super) struct Order {
    pub old: Vec<u32>,
    /// New number of each old particle; [`NO_PARTICLE`] for particles that are left out.
    pub new: Vec<u32>,
    /// Number of additional particles to reserve memory for. Arrays that are reallocated lose their large pages.
    pub room: usize,
}

impl Order {
    /// Creates the order in which new particle `i` is old particle `old[i]`. `count` is the number of old particles.
    pub fn of(old: Vec<u32>, count: usize) -> Self {
        let mut new = vec![NO_PARTICLE; count];
        for (&old, number) in old.iter().zip(0..) {
            new[old as usize] = number;
        }
        Self { old, new, room: 0 }
    }

    /// Returns the permuted values of a column that is empty in scenes without the feature.
    pub fn permuted_if_any<T: Copy>(&self, values: &[T]) -> Array<T> {
        if values.is_empty() { Array::new() } else { self.permuted(values) }
    }

    pub fn permuted<T: Copy>(&self, values: &[T]) -> Array<T> {
        let mut permuted = Vec::with_capacity(self.old.len() + self.room);
        permuted.extend(self.old.iter().map(|&old| values[old as usize]));
        permuted.into()
    }
}

/// How a part of the system numbers its particles.
pub(super) struct PartNumbers<'a> {
    /// For each particle of the whole system, its number in the part, or [`NO_PARTICLE`].
    pub here: &'a [u32],
    /// The particles of the part whose values are copied.
    pub owned: &'a Marks,
    /// For each particle of the part, its number in the whole system.
    pub whole: &'a (dyn Fn(u32) -> Option<u32> + Sync),
}

impl PartNumbers<'_> {
    /// The numbers in the part and in the whole system of all particles whose values are copied.
    fn all(&self) -> impl Iterator<Item = (u32, u32)> {
        (0..)
            .zip(self.here)
            .filter(|&(_, here)| *here != NO_PARTICLE && self.owned.has(*here))
            .map(|(whole, here)| (*here, whole))
    }
}

pub(super) trait Column: Sized {
    /// Whether contacts change the column. Windows on several threads then store complete records, which is slower. Only
    /// motions, predictions and captured pairs are stored separately.
    const CHANGES_IN_CONTACTS: bool;

    /// True if the column is not part of the state of a particle, but needed to find its next event.
    const IS_PLAN: bool = false;

    /// Whether contacts change data in this column that a rollback of motions, predictions and captured pairs does not
    /// restore.
    fn is_more_than_motion(&self) -> bool {
        Self::CHANGES_IN_CONTACTS
    }

    /// Returns the column in a new order, with new particle numbers in its entries.
    fn permuted(&self, order: &Order) -> Self;

    /// Shifts times to an epoch that is later by `shift`.
    fn shift(&mut self, _shift: f64) {}

    fn copy(&self, particle: u32, record: &mut Record);

    fn push(&mut self, record: &Record);

    fn set(&mut self, particle: u32, record: &Record);

    /// Copies the values of some particles from the column of a part.
    fn take_over(&mut self, part: &Self, numbers: &PartNumbers<'_>);

    /// Prepares a bitwise copy of the column for another thread, which uses the memory of the original. See
    /// [`Array::become_alias`] for what the threads may do.
    fn share_memory(&mut self);

    /// Checks the length of a column that was read from a file. It must be `count`, or 0 if the engine may do without
    /// the column.
    fn fits(&self, count: usize) -> bool;
}

/// Copies some values of a column from a part, on all threads of the current pool. Columns without values stay empty.
pub(super) fn take_values<T: Copy + Send + Sync>(column: &mut [T], part: &[T], numbers: &PartNumbers<'_>) {
    /// Number of values that a thread copies at a time.
    const SOME: usize = 16_384;
    let (here, owned) = (numbers.here, numbers.owned);
    column.par_chunks_mut(SOME).zip(here.par_chunks(SOME)).for_each(|(values, here)| {
        for (value, &here) in values.iter_mut().zip(here) {
            if here != NO_PARTICLE && owned.has(here) {
                *value = part[here as usize];
            }
        }
    });
}

impl Column for Array<Body> {
    const CHANGES_IN_CONTACTS: bool = true;

    fn is_more_than_motion(&self) -> bool {
        false
    }

    fn permuted(&self, order: &Order) -> Self {
        order.permuted(self)
    }

    fn shift(&mut self, shift: f64) {
        self.iter_mut().for_each(|body| body.time -= shift);
    }

    fn copy(&self, particle: u32, record: &mut Record) {
        record.body = self[particle as usize];
    }

    fn push(&mut self, record: &Record) {
        self.push(record.body);
    }

    fn set(&mut self, particle: u32, record: &Record) {
        self[particle as usize] = record.body;
    }

    fn take_over(&mut self, part: &Self, numbers: &PartNumbers<'_>) {
        take_values(self, part, numbers);
    }

    fn share_memory(&mut self) {
        self.become_alias();
    }

    fn fits(&self, count: usize) -> bool {
        self.len() == count
    }
}

impl Column for Array<u16> {
    const CHANGES_IN_CONTACTS: bool = false;

    /// The column is empty in an engine without an interaction table.
    fn permuted(&self, order: &Order) -> Self {
        order.permuted_if_any(self)
    }

    fn copy(&self, particle: u32, record: &mut Record) {
        record.row = self.get(particle as usize).copied();
    }

    fn push(&mut self, record: &Record) {
        record.row.into_iter().for_each(|row| self.push(row));
    }

    /// Does nothing, because rows never change while the system runs in domains.
    fn set(&mut self, _: u32, _: &Record) {}

    /// Does nothing, because rows never change while the system runs in domains.
    fn take_over(&mut self, _: &Self, _: &PartNumbers<'_>) {}

    fn share_memory(&mut self) {
        self.become_alias();
    }

    fn fits(&self, count: usize) -> bool {
        self.is_empty() || self.len() == count
    }
}

/// The spins; empty if the scene has none.
impl Column for Array<Vector> {
    const CHANGES_IN_CONTACTS: bool = true;

    fn is_more_than_motion(&self) -> bool {
        !self.is_empty()
    }

    fn permuted(&self, order: &Order) -> Self {
        order.permuted_if_any(self)
    }

    fn copy(&self, particle: u32, record: &mut Record) {
        record.spin = self.get(particle as usize).copied();
    }

    fn push(&mut self, record: &Record) {
        record.spin.into_iter().for_each(|spin| self.push(spin));
    }

    fn set(&mut self, particle: u32, record: &Record) {
        if let Some(spin) = record.spin {
            self[particle as usize] = spin;
        }
    }

    fn take_over(&mut self, part: &Self, numbers: &PartNumbers<'_>) {
        take_values(self, part, numbers);
    }

    fn share_memory(&mut self) {
        self.become_alias();
    }

    fn fits(&self, count: usize) -> bool {
        self.is_empty() || self.len() == count
    }
}

impl Column for Travelled {
    const CHANGES_IN_CONTACTS: bool = false;

    fn permuted(&self, order: &Order) -> Self {
        match self {
            Self::Near(images) => Self::Near(order.permuted(images)),
            Self::Far(images) => Self::Far(order.permuted(images)),
        }
    }

    fn copy(&self, particle: u32, record: &mut Record) {
        record.images = Some(self.of(particle));
    }

    fn push(&mut self, record: &Record) {
        self.push(record.images.unwrap_or_default());
    }

    fn set(&mut self, particle: u32, record: &Record) {
        if let Some(images) = record.images {
            self.put(particle, images);
        }
    }

    fn take_over(&mut self, part: &Self, numbers: &PartNumbers<'_>) {
        match (&mut *self, part) {
            (Self::Near(images), Self::Near(part)) => take_values(images, part, numbers),
            _ => numbers.all().for_each(|(here, whole)| self.put(whole, part.of(here))),
        }
    }

    fn share_memory(&mut self) {
        self.become_alias();
    }

    fn fits(&self, count: usize) -> bool {
        self.len() == count
    }
}

impl Column for Array<Prediction> {
    const IS_PLAN: bool = true;
    const CHANGES_IN_CONTACTS: bool = true;

    fn is_more_than_motion(&self) -> bool {
        false
    }

    fn permuted(&self, order: &Order) -> Self {
        let mut permuted = order.permuted(self);
        permuted.iter_mut().for_each(|prediction| prediction.renumber(&order.new));
        permuted
    }

    fn shift(&mut self, shift: f64) {
        for prediction in self {
            prediction.contact_time -= shift;
            prediction.transition_time -= shift;
        }
    }

    fn copy(&self, particle: u32, record: &mut Record) {
        record.prediction = Some(self[particle as usize]);
    }

    /// Adds an empty prediction. It is set later, when all particles have numbers.
    fn push(&mut self, _: &Record) {
        self.push(Prediction::NONE);
    }

    fn set(&mut self, particle: u32, record: &Record) {
        if let Some(prediction) = record.prediction {
            self[particle as usize] = prediction;
        }
    }

    /// Partners that the part does not hold remain absent.
    fn take_over(&mut self, part: &Self, numbers: &PartNumbers<'_>) {
        for (here, whole) in numbers.all() {
            let mut prediction = part[here as usize];
            if prediction.partner < FIRST_ABSENT {
                prediction.partner = (numbers.whole)(prediction.partner).unwrap_or(absent(prediction.partner));
            }
            self[whole as usize] = prediction;
        }
    }

    fn share_memory(&mut self) {
        self.become_alias();
    }

    fn fits(&self, count: usize) -> bool {
        self.len() == count
    }
}

impl Column for ContactTimes {
    const CHANGES_IN_CONTACTS: bool = true;

    fn permuted(&self, order: &Order) -> Self {
        Self { last: order.permuted(&self.last), ..*self }
    }

    fn shift(&mut self, shift: f64) {
        self.last.iter_mut().for_each(|last| *last -= shift);
    }

    fn copy(&self, particle: u32, record: &mut Record) {
        record.last_contact = Some(self.last[particle as usize]);
    }

    fn push(&mut self, record: &Record) {
        self.last.push(record.last_contact.unwrap_or(f64::NEG_INFINITY));
    }

    fn set(&mut self, particle: u32, record: &Record) {
        if let Some(last) = record.last_contact {
            self.last[particle as usize] = last;
        }
    }

    fn take_over(&mut self, part: &Self, numbers: &PartNumbers<'_>) {
        take_values(&mut self.last, &part.last, numbers);
    }

    fn share_memory(&mut self) {
        self.last.become_alias();
    }

    fn fits(&self, count: usize) -> bool {
        self.last.len() == count
    }
}

impl Column for SurfaceRandom {
    const CHANGES_IN_CONTACTS: bool = true;

    fn permuted(&self, order: &Order) -> Self {
        Self { contacts: order.permuted(&self.contacts), stream: self.stream.clone() }
    }

    fn copy(&self, particle: u32, record: &mut Record) {
        record.surface_contacts = Some(self.contacts[particle as usize]);
    }

    fn push(&mut self, record: &Record) {
        self.contacts.push(record.surface_contacts.unwrap_or(0));
    }

    fn set(&mut self, particle: u32, record: &Record) {
        if let Some(contacts) = record.surface_contacts {
            self.contacts[particle as usize] = contacts;
        }
    }

    fn take_over(&mut self, part: &Self, numbers: &PartNumbers<'_>) {
        take_values(&mut self.contacts, &part.contacts, numbers);
    }

    fn share_memory(&mut self) {
        self.contacts.become_alias();
    }

    fn fits(&self, count: usize) -> bool {
        self.contacts.len() == count
    }
}

impl Column for Box<Sleepers> {
    /// Contacts with moving surfaces change it. That does no harm: systems with sleeping particles run on one thread, so
    /// that nothing is undone.
    const CHANGES_IN_CONTACTS: bool = false;

    fn permuted(&self, order: &Order) -> Self {
        Self::new(self.with(order.permuted(&self.watched).into()))
    }

    fn copy(&self, particle: u32, record: &mut Record) {
        record.watched = Some(self.watched[particle as usize]);
    }

    fn push(&mut self, record: &Record) {
        self.watched.push(record.watched.unwrap_or_else(|| Watched::from(&record.body)));
    }

    fn set(&mut self, particle: u32, record: &Record) {
        if let Some(watched) = record.watched {
            self.watched[particle as usize] = watched;
        }
    }

    fn take_over(&mut self, part: &Self, numbers: &PartNumbers<'_>) {
        take_values(&mut self.watched, &part.watched, numbers);
    }

    /// Does nothing. Systems with sleeping particles run on one thread.
    fn share_memory(&mut self) {}

    fn fits(&self, count: usize) -> bool {
        self.watched.len() == count
    }
}

impl Column for CapturedPairs {
    const CHANGES_IN_CONTACTS: bool = true;

    fn is_more_than_motion(&self) -> bool {
        false
    }

    /// Without pairs that can be captured, the lists are empty.
    fn permuted(&self, order: &Order) -> Self {
        if self.is_empty() {
            return Self::new(0);
        }
        let mut states = Self::new(order.old.len());
        for (&old, particle) in order.old.iter().zip(0..) {
            for captured in self.of(old) {
                let partner = order.new[captured.partner as usize];
                if partner != NO_PARTICLE {
                    states.set(particle, PairState { partner, ..*captured });
                }
            }
        }
        states
    }

    fn copy(&self, particle: u32, record: &mut Record) {
        record.captured = (!self.is_empty()).then(|| self.of(particle).to_vec());
    }

    /// Adds an empty list. The pairs are set later, when all particles have numbers.
    fn push(&mut self, record: &Record) {
        if record.captured.is_some() {
            self.push_empty();
        }
    }

    fn set(&mut self, particle: u32, record: &Record) {
        if let Some(captured) = &record.captured {
            self.replace(particle, captured);
        }
    }

    fn take_over(&mut self, part: &Self, numbers: &PartNumbers<'_>) {
        if self.is_empty() {
            return;
        }
        let mut captured = Vec::new();
        for (here, whole) in numbers.all() {
            let in_whole = |pair: &PairState| Some(PairState { partner: (numbers.whole)(pair.partner)?, ..*pair });
            captured.clear();
            captured.extend(part.of(here).iter().filter_map(in_whole));
            self.replace(whole, &captured);
        }
    }

    fn share_memory(&mut self) {
        self.become_alias();
    }

    fn fits(&self, count: usize) -> bool {
        self.is_empty() || self.len() == count
    }
}

impl Column for Neighbours {
    const IS_PLAN: bool = true;
    const CHANGES_IN_CONTACTS: bool = false;

    fn permuted(&self, order: &Order) -> Self {
        match self {
            Self::Cells(cells) => Self::Cells(cells.permuted(order)),
            Self::Lists(verlet) => Self::Lists(verlet.permuted(order)),
        }
    }

    fn copy(&self, particle: u32, record: &mut Record) {
        record.place = Some(self.place(particle));
    }

    fn push(&mut self, record: &Record) {
        self.push(&record.body.position, record.place, record.row.unwrap_or(0));
    }

    /// Writes the cell or list centre. The neighbour list is filled later, when all particles are in place.
    fn set(&mut self, particle: u32, record: &Record) {
        if let Some(place) = record.place {
            self.relocate(particle, place);
        }
    }

    /// Copies cells or list centres. The lists are left out.
    fn take_over(&mut self, part: &Self, numbers: &PartNumbers<'_>) {
        numbers.all().for_each(|(here, whole)| self.relocate(whole, part.place(here)));
    }

    /// Does nothing. [`Neighbours::share`] does it, because the other thread also needs room for new lists.
    fn share_memory(&mut self) {}

    /// Always true. `unsound_index` checks the neighbour search, because that needs the table rows.
    fn fits(&self, _: usize) -> bool {
        true
    }
}

/// Evaluates an expression once for each column of an engine, or of several engines.
macro_rules! columns {
    ($($engine:expr, $some:ident, $column:ident: $($mutable:ident)?),+ => $body:expr) => {{
        $(let $column = &$($mutable)? $engine.state.bodies;)+
        $body;
        $(let $column = &$($mutable)? $engine.state.rows;)+
        $body;
        $(let $column = &$($mutable)? $engine.state.images;)+
        $body;
        $(let $column = &$($mutable)? $engine.state.spins;)+
        $body;
        $(let $column = &$($mutable)? $engine.state.sizes;)+
        $body;
        $(let $column = &$($mutable)? $engine.schedule.predictions;)+
        $body;
        $(let $column = &$($mutable)? $engine.neighbours;)+
        $body;
        $(let $column = &$($mutable)? $engine.pairs.states;)+
        $body;
        if let ($(Some($column),)+) = ($($engine.pairs.contact_times.$some(),)+) {
            $body;
        }
        if let ($(Some($column),)+) = ($($engine.sources.surface_random.$some(),)+) {
            $body;
        }
        if let ($(Some($column),)+) = ($($engine.sources.sleepers.$some(),)+) {
            $body;
        }
    }};
}

fn take_if<C: Column>(is_plan: bool, column: &mut C, part: &C, numbers: &PartNumbers<'_>) {
    if C::IS_PLAN == is_plan {
        column.take_over(part, numbers);
    }
}

#[inline(always)]
fn copy_if_it_changes<C: Column>(column: &C, particle: u32, record: &mut Record) {
    if C::CHANGES_IN_CONTACTS {
        column.copy(particle, record);
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Returns the record of a particle. Other particles are given by their numbers in memory.
    #[inline]
    pub(super) fn record(&self, particle: u32) -> Record {
        let mut record = Record::new(0, Vector::zeros(), Vector::zeros(), 0.0);
        record.number = particle;
        columns!(self, as_ref, column: => column.copy(particle, &mut record));
        record
    }

    /// Returns true if contacts change nothing but motions, predictions and captured pairs.
    pub(super) fn changes_motions_and_pairs_only(&self) -> bool {
        let mut is_more = false;
        columns!(self, as_ref, column: => is_more |= column.is_more_than_motion());
        !is_more
    }

    #[inline(always)]
    pub(super) fn record_before_contact(&self, particle: u32) -> Record {
        let mut record = Record::new(0, Vector::zeros(), Vector::zeros(), 0.0);
        record.number = particle;
        columns!(self, as_ref, column: => copy_if_it_changes(column, particle, &mut record));
        record
    }

    /// Writes the record of a particle, except its neighbour list and its row.
    #[inline]
    pub(super) fn write_record(&mut self, particle: u32, record: &Record) {
        columns!(self, as_mut, column: mut => Column::set(column, particle, record));
    }

    /// Copies the state of some particles from an engine with a part of the system; with `is_plan`, the predictions and
    /// places instead. The lists of neighbours are left out.
    pub(super) fn take_over(&mut self, part: &Self, numbers: &PartNumbers<'_>, is_plan: bool) {
        columns!(self, as_mut, column: mut, part, as_ref, other: => take_if(is_plan, column, other, numbers));
    }

    pub(super) fn push_record(&mut self, record: &Record) {
        columns!(self, as_mut, column: mut => Column::push(column, record));
    }

    pub(super) fn permute(&mut self, order: &Order) {
        columns!(self, as_mut, column: mut => *column = column.permuted(order));
        self.state.numbers.iter_mut().for_each(|number| *number = order.new[*number as usize]);
        self.state.numbers.retain(|number| *number != NO_PARTICLE);
    }

    pub(super) fn shift_columns(&mut self, shift: f64) {
        columns!(self, as_mut, column: mut => Column::shift(column, shift));
    }

    /// Prepares a bitwise copy of an engine for another thread. The copy uses the columns of the original. See
    /// [`Array::become_alias`] for what the threads may do.
    pub(super) fn share_columns(&mut self) {
        columns!(self, as_mut, column: mut => column.share_memory());
    }

    /// Checks that all columns of an engine from a file have the right length.
    pub(super) fn columns_fit(&self) -> bool {
        let count = self.state.bodies.len();
        let mut fit = true;
        columns!(self, as_ref, column: => fit &= column.fits(count));
        fit
    }
}

#[cfg(test)]
pub(super) mod tests;

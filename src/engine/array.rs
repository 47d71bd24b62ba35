//! Arrays whose elements several threads can access at the same time.
//!
//! A [`Vec`] lends either one mutable slice or several immutable ones. This is too strict for particles on several
//! threads: each thread changes some elements and reads others, and which ones follows from the positions of particles.
//! An [`Array`] therefore accesses one element at a time, through a raw pointer. A copy of the handle
//! gives another thread access to the same elements, see [`Array::become_alias`].

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::mem::ManuallyDrop;
use std::ops::{Deref, DerefMut, Index, IndexMut, Range};
use std::ptr::NonNull;

/// A growable array, or an alias of one.
///
/// As long as an array has aliases, it must not be resized, and no two threads may access the same element unless both
/// only read it. Slices of the whole array must not be used meanwhile; [`Self::some`] returns a slice of some elements.
pub struct Array<T> {
    first: NonNull<T>,
    length: usize,
    /// Number of elements for which there is memory; `None` for an alias, which does not own the memory.
    capacity: Option<usize>,
}

// SAFETY: like a `Vec`, an array owns its elements. Who creates an alias promises to avoid simultaneous access.
unsafe impl<T: Send> Send for Array<T> {}
// SAFETY: as above.
unsafe impl<T: Sync> Sync for Array<T> {}

impl<T> Array<T> {
    #[must_use]
    pub fn new() -> Self {
        Self::from(Vec::new())
    }

    /// Turns a bitwise copy of an array into an alias, which does not own the memory.
    ///
    /// While the alias exists, the array must not be resized, dropped or used as a slice. No two threads may access the
    /// same element at the same time, unless both only read it. Called for an array that is not a copy, this function
    /// leaks the memory.
    pub fn become_alias(&mut self) {
        self.capacity = None;
    }

    #[inline]
    #[must_use]
    pub fn len(&self) -> usize {
        self.length
    }

    #[inline]
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// Address of the first element, for prefetching.
    #[inline]
    #[must_use]
    pub fn as_ptr(&self) -> *const T {
        self.first.as_ptr()
    }

    #[inline(always)]
    #[must_use]
    pub fn get(&self, at: usize) -> Option<&T> {
        if at >= self.length {
            return None;
        }
        // SAFETY: the element exists, as just checked, and no thread changes it meanwhile.
        Some(unsafe { &*self.first.as_ptr().add(at) })
    }

    #[inline(always)]
    #[must_use]
    pub fn get_mut(&mut self, at: usize) -> Option<&mut T> {
        if at >= self.length {
            return None;
        }
        // SAFETY: the element exists, as just checked, and no other thread accesses it meanwhile.
        Some(unsafe { &mut *self.first.as_ptr().add(at) })
    }

    /// Returns some successive elements.
    ///
    /// # Panics
    /// If the range extends beyond the array.
    #[inline]
    #[must_use]
    #[track_caller]
    pub fn some(&self, range: Range<usize>) -> &[T] {
        if range.start > range.end || range.end > self.length {
            no_elements(range, self.length);
        }
        // SAFETY: the elements exist, as just checked, and no thread changes them meanwhile.
        unsafe { std::slice::from_raw_parts(self.first.as_ptr().add(range.start), range.len()) }
    }

    /// Like [`Self::some`], for changing the elements.
    #[inline]
    #[must_use]
    #[track_caller]
    pub fn some_mut(&mut self, range: Range<usize>) -> &mut [T] {
        if range.start > range.end || range.end > self.length {
            no_elements(range, self.length);
        }
        // SAFETY: as above; no other thread accesses the elements meanwhile.
        unsafe { std::slice::from_raw_parts_mut(self.first.as_ptr().add(range.start), range.len()) }
    }

    /// Changes the array as a vector, for example its length.
    ///
    /// # Panics
    /// If the array is an alias.
    pub fn change<R>(&mut self, change: impl FnOnce(&mut Vec<T>) -> R) -> R {
        let mut vector = self.take_vector();
        let result = change(&mut vector);
        *self = Self::from(vector);
        result
    }

    pub fn push(&mut self, element: T) {
        self.change(|vector| vector.push(element));
    }

    pub fn reserve(&mut self, additional: usize) {
        self.change(|vector| vector.reserve(additional));
    }

    pub fn capacity(&self) -> usize {
        self.capacity.unwrap_or(self.length)
    }

    /// Moves the memory into a vector, and leaves an empty array.
    #[cfg_attr(not(test), expect(clippy::expect_used, reason = "only the array itself is resized"))]
    fn take_vector(&mut self) -> Vec<T> {
        let capacity = self.capacity.expect("an alias cannot be resized");
        let taken = ManuallyDrop::new(std::mem::replace(self, Self::from(Vec::new())));
        // SAFETY: the parts are those of the vector from which the array was made.
        unsafe { Vec::from_raw_parts(taken.first.as_ptr(), taken.length, capacity) }
    }
}

#[cold]
#[inline(never)]
#[track_caller]
#[cfg_attr(not(test), expect(clippy::panic, reason = "as for a slice"))]
fn no_element(at: usize, length: usize) -> ! {
    panic!("element {at} of {length}")
}

#[cold]
#[inline(never)]
#[track_caller]
#[cfg_attr(not(test), expect(clippy::panic, reason = "as for a slice"))]
fn no_elements(range: Range<usize>, length: usize) -> ! {
    panic!("elements {range:?} of {length}")
}

impl<T> From<Vec<T>> for Array<T> {
    fn from(vector: Vec<T>) -> Self {
        let mut vector = ManuallyDrop::new(vector);
        let first = NonNull::new(vector.as_mut_ptr()).unwrap_or(NonNull::dangling());
        Self { first, length: vector.len(), capacity: Some(vector.capacity()) }
    }
}

impl<T> From<Array<T>> for Vec<T> {
    fn from(mut array: Array<T>) -> Self {
        array.take_vector()
    }
}

impl<T> FromIterator<T> for Array<T> {
    fn from_iter<I: IntoIterator<Item = T>>(elements: I) -> Self {
        Self::from(elements.into_iter().collect::<Vec<T>>())
    }
}

impl<T> Default for Array<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T> Drop for Array<T> {
    fn drop(&mut self) {
        if let Some(capacity) = self.capacity {
            // SAFETY: the parts are those of the vector from which the array was made.
            drop(unsafe { Vec::from_raw_parts(self.first.as_ptr(), self.length, capacity) });
        }
    }
}

impl<T: Clone> Clone for Array<T> {
    fn clone(&self) -> Self {
        Self::from(self.to_vec())
    }
}

impl<T: fmt::Debug> fmt::Debug for Array<T> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt(formatter)
    }
}

impl<T: Serialize> Serialize for Array<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        (**self).serialize(serializer)
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Array<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Vec::deserialize(deserializer).map(Self::from)
    }
}

impl<T> Index<usize> for Array<T> {
    type Output = T;

    #[inline(always)]
    #[track_caller]
    fn index(&self, at: usize) -> &T {
        let Some(element) = self.get(at) else { no_element(at, self.length) };
        element
    }
}

impl<T> IndexMut<usize> for Array<T> {
    #[inline(always)]
    #[track_caller]
    fn index_mut(&mut self, at: usize) -> &mut T {
        if at >= self.length {
            no_element(at, self.length);
        }
        // SAFETY: the element exists, as just checked, and no other thread accesses it meanwhile.
        unsafe { &mut *self.first.as_ptr().add(at) }
    }
}

/// Only for arrays without aliases.
impl<T> Deref for Array<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        self.some(0..self.length)
    }
}

/// Only for arrays without aliases.
impl<T> DerefMut for Array<T> {
    #[inline]
    fn deref_mut(&mut self) -> &mut [T] {
        self.some_mut(0..self.length)
    }
}

impl<'a, T> IntoIterator for &'a Array<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<'a, T> IntoIterator for &'a mut Array<T> {
    type Item = &'a mut T;
    type IntoIter = std::slice::IterMut<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter_mut()
    }
}

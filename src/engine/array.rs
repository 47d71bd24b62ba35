//! Arrays whose elements several threads can access at the same time.
//!
//! A [`Vec`] lends either one mutable slice or several immutable ones. This is too strict for particles on several
//! threads: each thread changes some elements and reads others, and which ones follows from the positions of particles.
//! An [`Array`] therefore accesses one element at a time, through a raw pointer. An *alias* is a second
//! handle to the same elements, for another thread. See [`Array::become_alias`].

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

// SAFETY: an array owns its elements, like a `Vec`. Code that creates an alias ensures that threads use different elements.
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
        // SAFETY: all three values come from the vector that `From<Vec<T>>` took apart.
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
        if self.capacity.is_some() {
            drop(self.take_vector());
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
        let length = self.length;
        let Some(element) = self.get_mut(at) else { no_element(at, length) };
        element
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a second handle to the elements of an array.
    fn alias(array: &Array<String>) -> Array<String> {
        let mut copy = Array { first: array.first, length: array.length, capacity: array.capacity };
        copy.become_alias();
        copy
    }

    #[test]
    fn arrays_behave_like_vectors() {
        let mut array: Array<String> = ["a", "b"].map(str::to_owned).into_iter().collect();
        array.push("c".to_owned());
        array[1] = "d".to_owned();
        assert_eq!((array.len(), &array[1], array.get(3)), (3, &"d".to_owned(), None));
        assert_eq!(array.some(1..3), ["d", "c"]);
        let copy = array.clone();
        array.change(|vector| vector.truncate(1));
        assert_eq!(
            (array.to_vec(), copy.to_vec()),
            (vec!["a".to_owned()], ["a", "d", "c"].map(str::to_owned).to_vec())
        );
        let bytes = postcard::to_stdvec(&copy).unwrap();
        assert_eq!(bytes, postcard::to_stdvec(&Vec::from(copy.clone())).unwrap());
        assert_eq!(postcard::from_bytes::<Array<String>>(&bytes).unwrap().to_vec(), copy.to_vec());
        assert!(Array::<u32>::new().is_empty());
    }

    #[test]
    fn an_alias_changes_the_elements_of_its_array() {
        let array: Array<String> = (0..100).map(|number| number.to_string()).collect();
        std::thread::scope(|scope| {
            for part in 0..2 {
                let mut alias = alias(&array);
                scope.spawn(move || (0..50).for_each(|at| alias[2 * at + part].push('!')));
            }
        });
        assert!((0..100).all(|number| array[number] == format!("{number}!")));
    }

    #[test]
    #[should_panic(expected = "an alias cannot be resized")]
    fn an_alias_cannot_grow() {
        let array = Array::from(vec!["a".to_owned()]);
        alias(&array).push("b".to_owned());
    }

    #[test]
    #[should_panic(expected = "element 1 of 1")]
    fn elements_beyond_the_end_cannot_be_used() {
        let mut array = Array::from(vec![1]);
        array[1] = 2;
    }

    #[test]
    #[should_panic(expected = "elements 0..2 of 1")]
    fn slices_beyond_the_end_cannot_be_used() {
        let _ = Array::from(vec![1]).some(0..2);
    }
}

//! Long arrays in huge pages. A map of 2048² pixels is 8192 pages of 4 KiB; handing out each of them at its first touch
//! takes a system longer than the solver takes for the map.

use std::fmt;
use std::marker::PhantomData;
use std::ops::{Deref, DerefMut};

use memmap2::MmapMut;
use zerocopy::{FromBytes, Immutable, IntoBytes};

/// Numbers that one thread takes at a time.
pub(crate) const RUN: usize = 1 << 14;

/// Bytes from which an array has pages of its own: a huge page.
const OWN_PAGES: usize = 1 << 21;

/// What an array holds: numbers that any bytes stand for.
pub trait Number: FromBytes + IntoBytes + Immutable + Default + Copy {}

impl<T: FromBytes + IntoBytes + Immutable + Default + Copy> Number for T {}

/// Numbers in one piece of memory, zero to begin with; a slice in all other respects.
pub struct Array<T>(Memory<T>);

enum Memory<T> {
    Pages(MmapMut, PhantomData<T>),
    Heap(Vec<T>),
}

impl<T: Number> Array<T> {
    /// `length` zeros.
    pub fn zeros(length: usize) -> Self {
        let bytes = length * size_of::<T>();
        let pages = if bytes < OWN_PAGES { None } else { pages(bytes) };
        Self(match pages {
            Some(pages) => Memory::Pages(pages, PhantomData),
            None => Memory::Heap(vec![T::default(); length]),
        })
    }
}

/// Zeroed memory, in huge pages where the system has them; `None` where it gives no pages.
fn pages(bytes: usize) -> Option<MmapMut> {
    let pages = MmapMut::map_anon(bytes).ok()?;
    #[cfg(target_os = "linux")]
    // A kernel without huge pages refuses, and small ones serve.
    let _ = pages.advise(memmap2::Advice::HugePage);
    Some(pages)
}

const WHOLE: &str = "pages are aligned for every number, and were asked for as many bytes as the numbers have";

impl<T: Number> Deref for Array<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        match &self.0 {
            Memory::Pages(pages, _) => <[T]>::ref_from_bytes(pages).map_err(|_| ()).expect(WHOLE),
            Memory::Heap(numbers) => numbers,
        }
    }
}

impl<T: Number> DerefMut for Array<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        match &mut self.0 {
            Memory::Pages(pages, _) => <[T]>::mut_from_bytes(pages).map_err(|_| ()).expect(WHOLE),
            Memory::Heap(numbers) => numbers,
        }
    }
}

impl<T: Number> From<Vec<T>> for Array<T> {
    fn from(numbers: Vec<T>) -> Self {
        Self(Memory::Heap(numbers))
    }
}

impl<T: Number> Clone for Array<T> {
    fn clone(&self) -> Self {
        let mut copy = Self::zeros(self.len());
        copy.copy_from_slice(self);
        copy
    }
}

impl<T: Number + PartialEq> PartialEq for Array<T> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl<T: Number + fmt::Debug> fmt::Debug for Array<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_and_long_arrays_are_slices_of_zeros_that_can_be_changed() {
        for length in [0, 1, 1000, OWN_PAGES / 8, OWN_PAGES / 8 + 3] {
            let mut numbers = Array::<f64>::zeros(length);
            assert_eq!(matches!(numbers.0, Memory::Pages(..)), 8 * length >= OWN_PAGES);
            assert!(numbers.len() == length && numbers.iter().all(|number| *number == 0.0));
            for (k, number) in numbers.iter_mut().enumerate() {
                *number = k as f64;
            }
            let copy = numbers.clone();
            assert_eq!(copy, numbers);
            if let Some(last) = numbers.last_mut() {
                *last = -1.0;
                assert_ne!(copy, numbers);
                assert_eq!(copy.last(), Some(&(length as f64 - 1.0)));
            }
        }
    }
}

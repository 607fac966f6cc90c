//! numpy arrays that look into the memory of their owner.

use numpy::ndarray::ArrayView;
use numpy::{Element, Ix1, Ix2, PyArray, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::PyClass;
use pyo3::prelude::*;

/// `numbers` of a frozen `owner` as an array that nobody can write; it keeps its owner alive.
#[expect(
    unsafe_code,
    reason = "the owner is frozen, so its numbers neither move nor change while the array lives"
)]
pub(crate) fn view<'py, T: Element, C: PyClass<Frozen = pyo3::pyclass::boolean_struct::True> + Sync>(
    owner: &Bound<'py, C>,
    numbers: impl FnOnce(&C) -> &[T],
) -> Bound<'py, PyArray<T, Ix1>> {
    let numbers = ArrayView::from(numbers(owner.get()));
    // SAFETY: `owner` is the container of the numbers and outlives the array, which holds a reference to it.
    let array = unsafe { PyArray::borrow_from_array(&numbers, owner.clone().into_any()) };
    array.readwrite().make_nonwriteable();
    array
}

/// As [`view`], in rows of `columns`.
pub(crate) fn rows<'py, T: Element, C: PyClass<Frozen = pyo3::pyclass::boolean_struct::True> + Sync>(
    owner: &Bound<'py, C>,
    columns: usize,
    numbers: impl FnOnce(&C) -> &[T],
) -> PyResult<Bound<'py, PyArray<T, Ix2>>> {
    let flat = view(owner, numbers);
    let count = flat.len() / columns.max(1);
    flat.reshape([count, columns])
}

//! Two hands computed the same effects: `isolux-darkroom` LED by LED, `isolux-model` by the formulas of the catalogue.
//! The tests of this package hold one against the other.

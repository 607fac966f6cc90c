//! C-γ grid and intensity distribution.

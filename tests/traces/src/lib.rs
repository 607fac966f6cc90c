//! Recorded sessions of every driver; the tests play them back.

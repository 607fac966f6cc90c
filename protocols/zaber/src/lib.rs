//! The Zaber ASCII protocol as a sans-IO codec.

//! The house rules, proved over cargo metadata.

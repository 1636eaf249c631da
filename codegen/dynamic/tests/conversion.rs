//! Tests of conversions between packages.

mod corpus;
mod hints;
mod memory;
mod properties;
mod rules;
mod steps;
mod support;

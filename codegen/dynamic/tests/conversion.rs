//! Tests of conversions between packages.

mod corpus;
mod hints;
mod memory;
mod properties;
mod reference;
mod rules;
mod steps;
mod support;

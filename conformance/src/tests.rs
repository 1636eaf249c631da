//! Tests of internals; the tests of the program are in `tests/`.

mod outcomes;

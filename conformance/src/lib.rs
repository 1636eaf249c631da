//! The place of the conformance suite: it will judge logs, captures, codecs and live servers by the
//! definitions that `uavspec-codegen` reads. Nothing is here yet.

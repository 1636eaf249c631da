//! The conformance suite: it judges logs, captures, codecs and live servers by the definitions that
//! `uavspec-codegen` reads. So far it reads logs.

pub mod source;

//! The tests of xtask in one program; each file is a module.

mod api;
mod baseline;
mod breaking;
mod cli;
mod clocks;
mod compile;
mod conversions;
mod dependencies;
mod files;
mod lint;
mod modules;
mod outputs;
mod packages;
mod sbom;
mod support;
mod translate;
mod untrusted;

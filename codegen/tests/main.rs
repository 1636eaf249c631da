//! The tests of the generator in one program; each file is a module.

mod configuration;
mod emitters;
mod names;
mod releases;
mod ros_packages;

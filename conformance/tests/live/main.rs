//! Tests of the transports with third-party peers. They require the feature `live` and Python.

mod application;
mod dds;
mod foxglove;
mod probe;
mod python;
mod roles;
mod rosbridge;
mod self_test;
mod zenoh;

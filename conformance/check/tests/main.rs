//! Tests of the public items of the crate, one module per file.

mod application;
mod body_schemas;
mod changing;
mod check;
mod convert;
mod corruption;
mod events;
mod examples;
mod ext;
mod flockwave;
mod json;
mod mcap;
mod px4_json;
mod releases;
mod reports;
mod rosbag;
mod topics;
mod trials;
mod unread;

//! The Rust types that typify makes of the bundles: what deserialises is taken.

use serde::de::DeserializeOwned;
use uavspec_interop_protocol::{Failure, serve, version};

type Judge = fn(&str) -> Result<(), String>;

#[allow(warnings)] // it is not ours to mend
mod generated {
    use super::{Failure, Judge, judge};
    include!(concat!(env!("OUT_DIR"), "/types.rs"));
}

fn main() -> Result<(), Failure> {
    serve(&version("typify"), |_| {
        Ok(|address: &str| {
            let (document, definition) = address.split_once("#/$defs/").unwrap_or((address, ""));
            let file = document.rsplit('/').next().unwrap_or(document);
            generated::judge_of(file.trim_end_matches(".bundle.schema.json"), definition)
        })
    })
}

fn judge<T: DeserializeOwned>(text: &str) -> Result<(), String> {
    serde_json::from_str::<T>(text).map(|_| ()).map_err(|error| error.to_string())
}

//! Adapter for typify. An instance is valid if it can be deserialized into the Rust types generated from the bundles.

use serde::de::DeserializeOwned;
use uavspec_interop_protocol::{Failure, serve, version};

type Check = fn(&str) -> Result<(), String>;

#[allow(warnings)] // generated code
mod generated {
    use super::{Check, Failure, check};
    include!(concat!(env!("OUT_DIR"), "/types.rs"));
}

fn main() -> Result<(), Failure> {
    serve(&version("typify"), |_| {
        Ok(|address: &str| {
            let (document, definition) = address.split_once("#/$defs/").unwrap_or((address, ""));
            let file = document.rsplit('/').next().unwrap_or(document);
            generated::check_of(file.trim_end_matches(".bundle.schema.json"), definition)
        })
    })
}

fn check<T: DeserializeOwned>(text: &str) -> Result<(), String> {
    serde_json::from_str::<T>(text).map(|_| ()).map_err(|error| error.to_string())
}

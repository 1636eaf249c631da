//! Adapter for the crate jsonschema, with draft 2020-12.

use jsonschema::{Registry, Resource};
use serde_json::json;
use uavspec_interop_protocol::{Failure, serve, version};

fn main() -> Result<(), Failure> {
    serve(&version("jsonschema"), |documents| {
        let resources = documents.into_iter().map(|(address, text)| (address, Resource::from_contents(text)));
        let registry = Registry::new().extend(resources)?.prepare()?;
        Ok(move |address: &str| {
            let reference =
                json!({ "$schema": "https://json-schema.org/draft/2020-12/schema", "$ref": address });
            let validator = jsonschema::options().with_registry(&registry).build(&reference)?;
            Ok(move |text: &str| {
                let instance = serde_json::from_str(text).map_err(|error| error.to_string())?;
                validator.validate(&instance).map_err(|error| error.to_string())
            })
        })
    })
}

//! Adapter for the crate boon, with draft 2020-12.

use boon::{Compiler, Draft, Schemas};
use uavspec_interop_protocol::{Failure, serve, version};

fn main() -> Result<(), Failure> {
    serve(&version("boon"), |documents| {
        let mut compiler = Compiler::new();
        compiler.set_default_draft(Draft::V2020_12);
        for (address, document) in documents {
            compiler.add_resource(&address, document)?;
        }
        Ok(move |address: &str| {
            let mut schemas = Schemas::new();
            let index = compiler.compile(address, &mut schemas)?;
            Ok(move |text: &str| {
                let instance = serde_json::from_str(text).map_err(|error| error.to_string())?;
                schemas.validate(&instance, index).map_err(|error| error.to_string())
            })
        })
    })
}

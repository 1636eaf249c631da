//! Integration tests of the runtime. Each file is a module of this program, so the tests are linked only once.

mod fixed_size;
#[cfg(feature = "serde")]
mod formats;
#[cfg(feature = "json")]
mod json_type;
mod open;
mod variable_size;

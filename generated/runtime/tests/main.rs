//! The tests of the runtime, in one program; each file is a module.

mod fixed_size;
mod variable_size;

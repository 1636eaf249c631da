//! Integration tests of the runtime. Each file is a module of this program, so the tests link once.

mod fixed_size;
mod variable_size;

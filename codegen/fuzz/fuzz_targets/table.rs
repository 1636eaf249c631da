//! Reads pages with tables. The first byte selects the format of the page.
#![no_main]

use libfuzzer_sys::fuzz_target;
use uavspec_codegen::schema::Form;
use uavspec_codegen_fuzz::check;

fuzz_target!(|data: &[u8]| {
    let Some((first, data)) = data.split_first() else { return };
    check(Form::Table, ["md", "adoc", "txt"][usize::from(first % 3)], data);
});

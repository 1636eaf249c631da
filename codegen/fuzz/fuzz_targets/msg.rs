//! Reads `.msg`, `.srv` and `.action` files in both dialects. The first byte selects the kind of file.
#![no_main]

use libfuzzer_sys::fuzz_target;
use uavspec_codegen::msg::Dialect;
use uavspec_codegen::schema::Form;
use uavspec_codegen_fuzz::check;

fuzz_target!(|data: &[u8]| {
    let Some((first, data)) = data.split_first() else { return };
    let extension = ["msg", "srv", "action"][usize::from(first % 3)];
    for dialect in [Dialect::Px4, Dialect::Ros2] {
        check(Form::Msg(dialect), extension, data);
    }
});

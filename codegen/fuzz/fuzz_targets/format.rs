//! Formats an arbitrary definition or page. The meaning must stay the same, and a second run must change nothing. The
//! first byte selects the kind of file.
#![no_main]

use libfuzzer_sys::fuzz_target;
use uavspec_codegen::msg::Dialect;
use uavspec_codegen::schema::Form;
use uavspec_codegen_fuzz::check_layout;

fuzz_target!(|data: &[u8]| {
    let Some((first, data)) = data.split_first() else { return };
    let (form, path) = match first % 9 {
        0 => (Form::Msg(Dialect::Px4), "A.msg"),
        1 => (Form::Msg(Dialect::Px4), "A.srv"),
        2 => (Form::Msg(Dialect::Px4), "A.action"),
        3 => (Form::Msg(Dialect::Ros2), "A.msg"),
        4 => (Form::Msg(Dialect::Ros2), "A.srv"),
        5 => (Form::Msg(Dialect::Ros2), "A.action"),
        6 => (Form::Table, "A.md"),
        7 => (Form::Table, "A.adoc"),
        _ => (Form::Table, "A.txt"),
    };
    check_layout(form, path, data);
});

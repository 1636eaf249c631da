//! Enums and flags. The types are written like generated code.

#[derive(Clone, Copy, Default, PartialEq)]
struct Narrow(i8);

uavspec_runtime::open! { Narrow: i8 flags; 1 "LOW"; 2 "MIDDLE"; -128 "HIGH"; }

#[derive(Clone, Copy, Default, PartialEq)]
struct Wide(i64);

uavspec_runtime::open! { Wide: i64 flags; 1 "LOW"; -0x8000_0000_0000_0000 "HIGH"; }

#[test]
fn names_the_top_flag_of_a_signed_number() {
    assert!(Narrow(-126).names().eq(["MIDDLE", "HIGH"]));
    assert!(Narrow(127).names().eq(["LOW", "MIDDLE"]));
    assert!(Wide(i64::MIN).names().eq(["HIGH"]));
    assert_eq!(format!("{:?}", Narrow(-123)), "Narrow(LOW | HIGH | 0x4)");
}

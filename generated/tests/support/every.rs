//! Messages of variable size, with fields of every type and constraint.

use uavspec_runtime::record;

#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Mode(pub(crate) i8);

uavspec_runtime::open! {
    Mode: i8;
    3 "ON";
    -1 "OFF";
    5 "RUN";
    3 "ALSO_ON";
}

#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Bits(pub(crate) i16);

uavspec_runtime::open! {
    Bits: i16 flags;
    0 "NONE";
    0x2 "LOW";
    0x40 "HIGH";
    -32768 "TOP";
}

#[derive(Clone, Default, PartialEq)]
pub(crate) struct Inner {
    pub(crate) number: i64,
    pub(crate) names: Vec<String>,
}

record! {
    Inner[2];
    0 number = int64("number", 0).within(&number().from(int(-5)).or(&[int(i64::MAX as i128)]));
    1 names = string("names", 0).at_most(4).bounded(2);
}

#[derive(Clone, PartialEq, Default)]
pub(crate) struct Every {
    pub(crate) yes: bool,
    pub(crate) bytes: Vec<u8>,
    pub(crate) any: Vec<u16>,
    pub(crate) single: f32,
    pub(crate) double: f64,
    pub(crate) share: [f32; 3],
    pub(crate) far: f64,
    pub(crate) mode: Mode,
    pub(crate) modes: [Mode; 2],
    pub(crate) bits: Bits,
    pub(crate) text: uavspec_runtime::Text<6>,
    pub(crate) wide: String,
    pub(crate) inner: Inner,
    pub(crate) inners: Vec<Inner>,
    pub(crate) count: u8,
    pub(crate) long: u64,
    pub(crate) letter: u8,
}

record! {
    Every[17];
    0 yes = bool("yes", 0);
    1 bytes = byte("bytes", 0).bounded(3);
    2 any = uint16("any", 0).sequence();
    3 single = float32("single", 0).within(&number().not_nan());
    4 double = float64("double", 0);
    5 share = float32("share", 0).array(3).within(&number().from(int(0)).to(float(0.1_f32 as f64)).or(&[int(-1)]).not_nan());
    6 far = float64("far", 0).within(&number().from(float(1e10)).to(float(1e10 + 1.0)));
    7 mode = int8("mode", 0).within(&number().values::<Mode>());
    8 modes = int8("modes", 0).array(2).within(&number().to(int(4)).or(&[int(9)]).values::<Mode>());
    9 bits = int16("bits", 0).within(&number().flags::<Bits>());
    10 text = text("text", 0).array(6);
    11 wide = wstring("wide", 0).at_most(5);
    12 inner = message::<Inner>("inner", 0);
    13 inners = message::<Inner>("inners", 0).bounded(3);
    14 count = uint8("count", 0).within(&number().counting(3));
    15 long = uint64("long", 0);
    16 letter = char("letter", 0);
}

/// A message without constraints.
#[derive(Clone, PartialEq, Default)]
pub(crate) struct Free {
    pub(crate) a: i32,
    pub(crate) b: bool,
}

record! {
    Free[2];
    0 a = int32("a", 0);
    1 b = bool("b", 4);
}

macro_rules! message {
    ($($type:ident)*) => {$(
        impl uavspec_runtime::Message for $type {
            const DEFINITION: uavspec_runtime::Definition =
                uavspec_runtime::Definition::new("test", stringify!($type));
        }
    )*};
}

message!(Inner Every Free);

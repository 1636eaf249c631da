//! Code shared by the fuzz targets: message selection, and variable-size messages.

use uavspec_runtime::{Definition, Message};

/// Calls a generic function for the message type that the first byte selects, and passes the remaining bytes.
#[macro_export]
macro_rules! dispatch {
    ($data:expr, $check:ident; $($type:ty),* $(,)?) => {
        if let Some((first, data)) = $data.split_first() {
            let checks: &[fn(&[u8])] = &[$($check::<$type>),*];
            checks[usize::from(*first) % checks.len()](data);
        }
    };
}

macro_rules! sample {
    ($type:ident { $($field:ident: $field_type:ty),* }) => {
        /// A variable-size message, written like generated code.
        #[derive(Clone, Debug, Default, PartialEq)]
        #[allow(missing_docs)]
        pub struct $type {
            $(pub $field: $field_type,)*
        }

        impl Message for $type {
            const DEFINITION: Definition = Definition::new("samples", stringify!($type));
        }
    };
}

sample!(Sample {
    flag: bool,
    name: String,
    wide: String,
    numbers: Vec<f64>,
    few: Vec<u16>,
    points: Vec<Point>,
    pair: [Point; 2],
    empties: Vec<Empty>,
    names: Vec<String>
});

sample!(Point { tag: u8, label: String, x: u64 });

sample!(Empty {});

uavspec_runtime::record! {
    Sample[9];
    0 flag = bool("flag", 0);
    1 name = string("name", 0).at_most(5);
    2 wide = wstring("wide", 0);
    3 numbers = float64("numbers", 0).sequence();
    4 few = uint16("few", 0).bounded(3);
    5 points = message::<Point>("points", 0).sequence();
    6 pair = message::<Point>("pair", 0).array(2);
    7 empties = message::<Empty>("empties", 0).sequence();
    8 names = string("names", 0).at_most(4).bounded(2);
}

uavspec_runtime::record! {
    Point[3];
    0 tag = uint8("tag", 0);
    1 label = string("label", 0);
    2 x = uint64("x", 0);
}

uavspec_runtime::record! {
    Empty[0];
}

//! Messages of fixed size, in memory and in CDR, written here as the generator writes them.

use uavspec_runtime::Message;
use uavspec_runtime::cdr::{ByteOrder, HEADER};

macro_rules! sample {
    ($type:ident, $cdr:literal { $($field:ident: $field_type:ty),* }) => {
        #[derive(Clone, Debug, Default, PartialEq)]
        struct $type {
            $($field: $field_type,)*
        }

        impl Message for $type {
            const PACKAGE: &'static str = "samples";
            const NAME: &'static str = stringify!($type);
            const HASH: u32 = 0;
            const TYPE_HASH: &'static str = "";
            const CDR_SIZE: Option<usize> = Some($cdr);
        }
    };
}

sample!(Empty, 5 {});

sample!(Hollow, 6 { e: Empty, x: u8 });

sample!(Hollows, 12 { few: [Empty; 3], x: u16, last: Hollow });

uavspec_runtime::record! {
    Empty;
}

uavspec_runtime::record! {
    Hollow;
    0 e: Empty = message::<Empty>("e", 0);
    1 x: u8 = uint8("x", 0);
}

uavspec_runtime::record! {
    Hollows;
    0 few: [Empty; 3] = message::<Empty>("few", 0).array(3);
    1 x: u16 = uint16("x", 0);
    2 last: Hollow = message::<Hollow>("last", 0);
}

const ORDERS: [ByteOrder; 2] = [ByteOrder::LittleEndian, ByteOrder::BigEndian];

/// The error of a payload of zeros that ends after each number of bytes, from the header on.
fn cuts<T: Message + std::fmt::Debug>() -> Vec<String> {
    let size = T::CDR_SIZE.expect("a fixed size");
    let cut = |order: ByteOrder, end: usize| {
        let payload = T::default().to_cdr(order).expect("a payload");
        assert_eq!(payload.len(), size);
        T::from_cdr(&payload[..end]).expect_err("too short").to_string()
    };
    let told = ORDERS.map(|order| (HEADER..size).map(|end| cut(order, end)).collect::<Vec<_>>());
    assert_eq!(told[0], told[1]);
    let [told, _] = told;
    told
}

#[test]
fn messages_without_fields_count_where_a_payload_ends_too_soon() {
    assert_eq!(cuts::<Empty>(), ["Empty at byte 4: expected 1 more bytes, found 0"]);
    assert_eq!(
        cuts::<Hollow>(),
        ["e at byte 4: expected 1 more bytes, found 0", "x at byte 5: expected 1 more bytes, found 0"]
    );
    assert_eq!(
        cuts::<Hollows>(),
        [
            "few[0] at byte 4: expected 1 more bytes, found 0",
            "few[1] at byte 5: expected 1 more bytes, found 0",
            "few[2] at byte 6: expected 1 more bytes, found 0",
            "x at byte 7: expected 2 more bytes, found 0",
            "x at byte 8: expected 2 more bytes, found 0",
            "x at byte 8: expected 2 more bytes, found 1",
            "last.e at byte 10: expected 1 more bytes, found 0",
            "last.x at byte 11: expected 1 more bytes, found 0",
        ]
    );
}

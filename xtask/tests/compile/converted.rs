//! Tests that generated conversions convert as their definitions and hints require.

use conversions::{new, old, ros_new, ros_old, ros_shared};

fn glider() -> old::Glider {
    old::Glider {
        count: 4,
        parts: core::array::from_fn(|at| old::Part { id: at as u8, code: -1 }),
        part: old::Part { id: 9, code: i64::MIN },
        grown: [1, 2, 3],
        cut: core::array::from_fn(|at| at as u8),
        wide: [0.5, f32::INFINITY],
        narrow: 1000,
        neutral: -1,
        rounded: 0.1,
        short: "abcd".parse().unwrap(),
        long: "aäöü".parse().unwrap(),
        many: [7; 40],
        is_valid: true,
        dropped: 1,
        ..Default::default()
    }
}

#[test]
fn values_are_converted() {
    let new = new::Glider::from(&glider());
    assert_eq!(new.count, 3);
    assert_eq!(new.parts[2], new::Part { code: -1, id: 2, is_new: false });
    assert_eq!(new.part, new::Part { code: i64::MIN, id: 9, is_new: false });
    assert_eq!(new.grown, [1, 2, 3, 9, 9]);
    assert_eq!(new.cut, [0, 1]);
    assert_eq!(new.wide, [0.5, f64::INFINITY]);
    assert_eq!((new.narrow, new.neutral, new.rounded), (127, 3, 0.1_f32));
    assert_eq!((new.short.as_str(), new.long.as_str()), (Ok("abcd"), Ok("aä")));
    assert_eq!((new.many[39], new.many[40]), (7, 0));
    assert_eq!(new.added, [0; 40]);
    assert!(new.unknown.iter().all(|value| value.is_nan()));
}

/// A count is limited to the length of the array that was cut, even if its type is narrower.
#[test]
fn counts_of_cut_arrays_are_limited() {
    for (count, nearest, neutral) in [(1, 1, 1), (2, 2, 2), (4, 2, 2), (300, 2, 0)] {
        let old = old::Glider { num_marks: count, num_seats: count, ..glider() };
        let new = new::Glider::from(&old);
        assert_eq!((new.num_marks, new.num_seats), (nearest, neutral), "{count}");
    }
}

/// A special value, such as an unknown count, is not limited to the length of the array that was cut.
#[test]
fn special_values_of_counts_are_not_limited() {
    let counts = |count, [num_knots, num_turns]: [u8; 2], num_ropes| {
        let old = old::Glider { count, num_knots, num_ropes, num_turns: u32::from(num_turns), ..glider() };
        let new = new::Glider::from(&old);
        (new.count, new.num_knots, new.num_ropes, new.num_turns)
    };
    assert_eq!(counts(63, [255, 255], 65535), (63, 255, 0, 255));
    assert_eq!(counts(62, [254, 254], 65534), (3, 2, 2, 2));
}

#[test]
fn named_values_of_counts_are_not_limited() {
    for (count, expected) in [(2, 2), (4, 2), (255, 254)] {
        let old = old::Glider { num_legs: old::glider::Leg(count), ..glider() };
        assert_eq!(new::Glider::from(&old).num_legs.0, expected, "{count}");
    }
}

#[test]
fn constants_are_converted_by_name() {
    for (mode, faults, new_mode, new_faults) in [(0, 0, 0, 0), (1, 1, 2, 2), (2, 2, 1, 1), (9, 0x83, 9, 0x83)]
    {
        let old = old::Glider {
            mode: old::glider::Mode(mode),
            wide_mode: old::glider::Mode(mode),
            faults: old::glider::Fault(faults),
            ..glider()
        };
        let new = new::Glider::from(&old);
        assert_eq!((new.mode.0, new.faults.0, new.wide_mode.0), (new_mode, new_faults, i32::from(new_mode)));
    }
}

#[test]
fn hints_compute_values() {
    let cases = [(1, false, 5, 0), (1, true, 5, 27), (0, false, 200, 0), (0, false, 4, 29)];
    for (mode, is_valid, limit, expected) in cases {
        let old = old::Glider { mode: old::glider::Mode(mode), is_valid, limit, share: 3.0, ..glider() };
        let new = new::Glider::from(&old);
        assert_eq!(new.limit, expected, "{mode} {is_valid} {limit}");
        assert_eq!(new.share, 1.5 + f32::from(limit));
        assert_eq!(new.is_valid, is_valid);
        let large = if is_valid { (u64::MAX, i32::MIN, -4_294_967_296.0) } else { (0, -1, 1.0) };
        assert_eq!((new.mask, new.offset, new.large), large);
    }
}

#[test]
fn messages_of_ros_and_services_are_converted() {
    let from = ros_old::Box {
        header: ros_shared::Header { name: "frame".to_owned() },
        data: vec![1, 2, 3],
        names: vec!["äöü".to_owned(), "a".to_owned()],
        few: vec![4],
        parts: vec![ros_old::Part { id: 1 }],
        text: "unchanged".to_owned(),
        level: vec![5],
    };
    let to = ros_new::Box::from(&from);
    assert_eq!(to.header, from.header);
    assert_eq!((to.data, to.names), (vec![1, 2], vec!["äö".to_owned(), "a".to_owned()]));
    assert_eq!((to.few, to.parts[0].id, to.text), ([4, 8], 1_u16, from.text));
    assert_eq!((to.level, to.speed), (vec![5], 2.5));
    let request = ros_new::srv::TowRequest::from(&ros_old::srv::TowRequest { height: 3 });
    assert_eq!(request.height, 3_u16);
}

#[test]
fn random_messages_convert_like_the_reference() {
    let cases: serde_json::Value = serde_json::from_str(include_str!("cases.json")).unwrap();
    let compare = |direction: &str, name: &str, convert: fn(&serde_json::Value) -> serde_json::Value| {
        let pairs = cases[direction][name].as_array().unwrap();
        assert!(pairs.len() > 100, "{direction} {name}");
        for pair in pairs {
            assert_eq!(convert(&pair[0]), pair[1], "{direction} {name}: {}", pair[0]);
        }
    };
    compare("forward", "Glider", convert::<old::Glider, new::Glider>);
    compare("forward", "Part", convert::<old::Part, new::Part>);
    compare("backward", "Part", convert::<new::Part, old::Part>);
}

/// Converts a message in JSON.
fn convert<Old, New>(message: &serde_json::Value) -> serde_json::Value
where
    Old: serde::de::DeserializeOwned,
    New: serde::Serialize + for<'m> From<&'m Old>,
{
    let message: Old = serde_json::from_value(message.clone()).unwrap();
    serde_json::to_value(New::from(&message)).unwrap()
}

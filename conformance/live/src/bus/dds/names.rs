//! Names and type hashes of ROS in DDS.

use uavspec_model::limits::MAX_NAME;

/// The ROS name of a topic: `/fmu/out/x` for `rt/fmu/out/x`. Topics that aren't ROS topics keep their name.
pub(crate) fn topic_to_ros(name: &str) -> &str {
    name.strip_prefix("rt").filter(|rest| rest.starts_with('/')).unwrap_or(name)
}

/// The DDS name of a topic: `rt/fmu/out/x` for `/fmu/out/x`.
pub(crate) fn topic_to_dds(name: &str) -> String {
    if name.starts_with('/') { format!("rt{name}") } else { name.to_owned() }
}

/// The type hash in the user data of an endpoint: `typehash=RIHS01_…;`.
pub(crate) fn type_hash(user_data: &[u8]) -> Option<&str> {
    const KEY: &[u8] = b"typehash=";
    let start = user_data.windows(KEY.len()).position(|window| window == KEY)? + KEY.len();
    let value = user_data.get(start..)?.split(|byte| matches!(byte, b';' | 0)).next()?;
    let text = std::str::from_utf8(value).ok()?;
    (text.starts_with("RIHS") && text.len() <= MAX_NAME).then_some(text)
}

/// The name of a node, from the name of its participant. `rmw` names participants after their enclave, which is `/` if
/// there is none.
pub(crate) fn node(name: &str) -> Option<&str> {
    Some(name).filter(|name| !name.trim_matches('/').is_empty() && name.len() <= MAX_NAME)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ros_names_are_converted_in_both_directions() {
        for (dds, ros) in [("rt/fmu/out/x", "/fmu/out/x"), ("rtx/y", "rtx/y"), ("ros_info", "ros_info")] {
            assert_eq!(topic_to_ros(dds), ros);
            assert_eq!(topic_to_dds(ros), dds);
        }
    }

    #[test]
    fn finds_the_type_hash() {
        let data = b"\x12\0\0\0a=b;typehash=RIHS01_00ff;x=y;";
        assert_eq!(type_hash(data), Some("RIHS01_00ff"));
        assert_eq!(type_hash(b"typehash=RIHS01_00ff"), Some("RIHS01_00ff"));
        for data in [b"typehash=\xff;".as_slice(), b"typehash=", b"RIHS01_00ff"] {
            assert_eq!(type_hash(data), None);
        }
    }

    #[test]
    fn participants_without_an_enclave_have_no_name() {
        assert_eq!(node("/"), None);
        assert_eq!(node("/ground_station"), Some("/ground_station"));
        assert_eq!(node(&"x".repeat(MAX_NAME + 1)), None);
    }
}

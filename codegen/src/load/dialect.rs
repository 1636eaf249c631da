//! Detects the dialect of definitions that no configuration file describes.

use std::fs;
use std::path::PathBuf;

use uavspec_schema::msg::Dialect;
use uavspec_schema::name::is_identifier;

use super::files::ros_package_of;

/// Types that only ROS 2 has.
const ROS_TYPES: [&str; 5] = ["string", "wstring", "byte", "time", "duration"];

/// The dialect of files, and the name of their package. Messages with a timestamp are PX4 messages. Files with types
/// that only ROS 2 has, and files in the folder of a ROS package, are ROS 2 interfaces. All other files are PX4
/// messages.
pub fn detected(files: &[PathBuf]) -> (Dialect, String) {
    let (mut num_px4, mut num_ros) = (0, 0);
    for file in files {
        let Ok(text) = fs::read_to_string(file) else { continue };
        let mut types = text.lines().map(declaration);
        num_px4 += usize::from(types.clone().any(|words| words == ("uint64", "timestamp")));
        num_ros += usize::from(types.any(|(ty, _)| is_only_in_ros(ty)));
    }
    let packages = files.iter().filter_map(|file| ros_package_of(file)).map(|(name, _)| name);
    let package = packages.clone().find(|name| is_identifier(name));
    let is_ros = num_ros > num_px4 || num_px4 == 0 && package.is_some();
    match package {
        Some(package) if is_ros => (Dialect::Ros2, package),
        _ if is_ros => (Dialect::Ros2, Dialect::Ros2.name().to_owned()),
        _ => (Dialect::Px4, Dialect::Px4.name().to_owned()),
    }
}

/// The first two words of a line, without its comment.
fn declaration(line: &str) -> (&str, &str) {
    let mut words = line.split('#').next().unwrap_or_default().split_whitespace();
    (words.next().unwrap_or_default(), words.next().unwrap_or_default())
}

fn is_only_in_ros(ty: &str) -> bool {
    let element = ty.split(['[', '<']).next().unwrap_or(ty);
    ROS_TYPES.contains(&element) || element.contains('/') || ty.ends_with("[]") || ty.contains("<=")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(files: &[(&str, &str)]) -> (Dialect, String) {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |(name, text): &(&str, &str)| {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            fs::write(&path, text).expect("a file");
            path
        };
        detected(&files.iter().map(write).collect::<Vec<_>>())
    }

    #[test]
    fn messages_with_a_timestamp_are_those_of_px4() {
        let px4 = (Dialect::Px4, "px4".to_owned());
        let status = "uint64 timestamp # [us] string a\nuint8[4] a\n";
        assert_eq!(of(&[("Status.msg", status)]), px4);
        assert_eq!(of(&[("px4_msgs/msg/Status.msg", status), ("px4_msgs/msg/Mark.msg", "bool a\n")]), px4);
        assert_eq!(of(&[("Mark.msg", "bool a\n")]), px4);
        assert_eq!(of(&[]), px4);
        // A mistake doesn't change the dialect.
        assert_eq!(of(&[("Status.msg", status), ("Odd.msg", "uint64 timestamp\nstring a\n")]), px4);
    }

    #[test]
    fn files_in_ros_packages_are_ros_2_interfaces() {
        let ros = |name: &str| (Dialect::Ros2, name.to_owned());
        assert_eq!(of(&[("sky_msgs/msg/Mark.msg", "float64 x\n")]), ros("sky_msgs"));
        for text in ["string<=3 a\n", "sky_msgs/Mark[2] a\n", "uint8[] a\n", "uint8[<=3] a\n", "time at\n"] {
            assert_eq!(of(&[("Mark.msg", text)]), ros("ros2"), "{text}");
        }
    }
}

//! Conversion of definition names to the case conventions of target languages. The emitter for each language handles
//! that language's keywords.

use std::collections::HashMap;

use uavspec_schema::ErrorCode;
use uavspec_schema::name::words;

/// The names already used in a module, type or struct, each with the last number that was appended to it.
#[derive(Default)]
pub struct Scope(HashMap<String, usize>);

impl Scope {
    /// Returns `name`; appends `_` and a number if it is already used.
    pub fn unique(&mut self, name: &str) -> String {
        self.numbered(name, "_")
    }

    /// Like [`Self::unique`], but for type names: appends the number without `_`.
    pub(crate) fn unique_type(&mut self, name: &str) -> String {
        self.numbered(name, "")
    }

    /// Returns the first unused type name in `names`. If all of them are already used, appends a number to the last
    /// name.
    pub(crate) fn first_free_type(&mut self, names: &[String]) -> String {
        let free = names.iter().find(|name| !self.0.contains_key(*name));
        let name = free.or(names.last()).cloned().unwrap_or_default();
        self.unique_type(&name)
    }

    fn numbered(&mut self, name: &str, separator: &str) -> String {
        let mut candidate = name.to_owned();
        while self.0.contains_key(&candidate) {
            let last = self.0.entry(name.to_owned()).or_insert(1);
            *last += 1;
            candidate = format!("{name}{separator}{last}");
        }
        self.0.insert(candidate.clone(), 1);
        candidate
    }
}

/// Converts a message name to a type name: removes `_` and capitalizes each part.
pub(crate) fn type_name(name: &str) -> String {
    name.split('_')
        .filter_map(|part| {
            let (first, rest) = part.split_at_checked(1)?;
            Some(first.to_ascii_uppercase() + rest)
        })
        .collect()
}

/// Converts a name in any case to `PascalCase`, such as `HealthComponentIndex`.
pub(crate) fn pascal_case(name: &str) -> String {
    words(name)
        .into_iter()
        .map(|word| {
            let (first, rest) = word.split_at(1);
            first.to_ascii_uppercase() + &rest.to_ascii_lowercase()
        })
        .collect()
}

/// Converts a name in any case to `snake_case`, such as `health_component_index`.
pub(crate) fn snake_case(name: &str) -> String {
    words(name).into_iter().map(str::to_ascii_lowercase).collect::<Vec<_>>().join("_")
}

/// Converts a name in any case to `UPPER_CASE`, such as `HEALTH_COMPONENT_INDEX`.
pub(crate) fn upper_case(name: &str) -> String {
    words(name).into_iter().map(str::to_ascii_uppercase).collect::<Vec<_>>().join("_")
}

/// Names the constant of each code after its abbreviation. If several codes share an abbreviation, the severity is
/// appended. If these codes also share the severity, the code is appended instead.
pub(crate) fn error_code_names(codes: &[&ErrorCode]) -> Vec<String> {
    let plain = |code: &ErrorCode| match &code.abbreviation {
        Some(abbreviation) if !upper_case(abbreviation).is_empty() => upper_case(abbreviation),
        _ => format!("CODE_{}", code.code),
    };
    let severity = |code: &ErrorCode| code.severity().name().to_uppercase();
    let names: Vec<String> = codes.iter().map(|code| plain(code)).collect();
    // The number of codes with each name, and the number of codes with each name and severity.
    let (mut with_name, mut with_both) = (HashMap::new(), HashMap::new());
    for (code, name) in codes.iter().zip(&names) {
        *with_name.entry(name).or_insert(0) += 1;
        *with_both.entry((name, code.severity())).or_insert(0) += 1;
    }
    let mut scope = Scope::default();
    codes
        .iter()
        .zip(&names)
        .map(|(code, name)| match (with_name[name], with_both[&(name, code.severity())]) {
            (1, _) => scope.unique(name),
            (_, 1) => scope.unique(&format!("{name}_{}", severity(code))),
            _ => scope.unique(&format!("{name}_{}", code.code)),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn converts_names_between_cases() {
        for (name, snake, pascal) in [
            ("ArmingCheckReply", "arming_check_reply", "ArmingCheckReply"),
            ("HEALTH_COMPONENT_INDEX", "health_component_index", "HealthComponentIndex"),
            ("Ekf2Timestamps", "ekf2_timestamps", "Ekf2Timestamps"),
            ("UInt8MultiArray", "u_int8_multi_array", "UInt8MultiArray"),
            ("GPSData", "gps_data", "GpsData"),
            ("Pose2D", "pose2d", "Pose2d"),
            ("Pose2DStamped", "pose2d_stamped", "Pose2dStamped"),
            ("I2C", "i2c", "I2c"),
            ("I2cBus", "i2c_bus", "I2cBus"),
            ("RC1IN", "rc1in", "Rc1in"),
            ("FIX_TYPE_3D", "fix_type_3d", "FixType3d"),
            ("SOURCE_PX4IO_PPM", "source_px4io_ppm", "SourcePx4ioPpm"),
            ("COMM T/O", "comm_t_o", "CommTO"),
            ("vehicle_status", "vehicle_status", "VehicleStatus"),
        ] {
            assert_eq!((snake_case(name).as_str(), pascal_case(name).as_str()), (snake, pascal));
            assert_eq!(upper_case(name), snake.to_uppercase());
        }
    }

    #[test]
    fn derives_type_names_from_message_names() {
        for (name, expected) in
            [("ColorRGBA", "ColorRGBA"), ("vehicle_status", "VehicleStatus"), ("Go_Request", "GoRequest")]
        {
            assert_eq!(type_name(name), expected);
        }
    }

    #[test]
    fn equal_names_are_numbered_in_linear_time() {
        let allocated = |count: usize| {
            let mut scope = Scope::default();
            allocation_counter::measure(|| (0..count).for_each(|_| drop(scope.unique("wind")))).bytes_total
        };
        let [once, twice] = [1_000, 2_000].map(allocated);
        assert!(10 * twice < 25 * once, "{once} and {twice} bytes");
    }

    #[test]
    fn numbers_duplicate_names() {
        let mut scope = Scope::default();
        let names: Vec<String> = ["a", "a", "a_2", "a"].into_iter().map(|name| scope.unique(name)).collect();
        assert_eq!(names, ["a", "a_2", "a_2_2", "a_3"]);
    }
}

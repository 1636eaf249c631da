//! Conversion of definition names to the case conventions of target languages. The emitter for each language handles
//! that language's keywords.

use std::collections::HashSet;

use crate::name::words;
use crate::schema::ErrorCode;

/// The names already used in a module, type or struct.
#[derive(Default)]
pub(crate) struct Scope(HashSet<String>);

impl Scope {
    /// Returns `name`; appends `_` and a number if it is already used.
    pub(crate) fn unique(&mut self, name: &str) -> String {
        self.numbered(name, "_")
    }

    /// Like [`Self::unique`], but for type names: appends the number without `_`.
    pub(crate) fn unique_type(&mut self, name: &str) -> String {
        self.numbered(name, "")
    }

    /// Returns the first unused type name in `names`. If all of them are already used, appends a number to the last
    /// name.
    #[cfg(feature = "rust")]
    pub(crate) fn first_free_type(&mut self, names: &[String]) -> String {
        let free = names.iter().find(|name| !self.0.contains(*name));
        let name = free.or(names.last()).cloned().unwrap_or_default();
        self.unique_type(&name)
    }

    fn numbered(&mut self, name: &str, separator: &str) -> String {
        let mut candidate = name.to_owned();
        let mut number = 2;
        while !self.0.insert(candidate.clone()) {
            candidate = format!("{name}{separator}{number}");
            number += 1;
        }
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
    let mut scope = Scope::default();
    codes
        .iter()
        .map(|code| {
            let name = plain(code);
            let is_shared = |with_severity: bool| {
                let same = |other: &&&ErrorCode| {
                    plain(other) == name && (!with_severity || severity(other) == severity(code))
                };
                codes.iter().filter(same).count() > 1
            };
            let name = match (is_shared(false), is_shared(true)) {
                (false, _) => name,
                (true, false) => format!("{name}_{}", severity(code)),
                (true, true) => format!("{name}_{}", code.code),
            };
            scope.unique(&name)
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
    fn numbers_duplicate_names() {
        let mut scope = Scope::default();
        let names: Vec<String> = ["a", "a", "a_2", "a"].into_iter().map(|name| scope.unique(name)).collect();
        assert_eq!(names, ["a", "a_2", "a_2_2", "a_3"]);
    }
}

//! The steps between message versions for which PX4 has hand-written translations.
//!
//! The definitions contain only the relevant fields, with descriptions written for this project. Each test needs only
//! the published hints.

use serde_json::{Value, json};
use uavspec_dynamic::conversion::Hints;

use super::support::{Converted, Definitions, PX4_HINTS, convert};

/// Converts with the published hints, and checks that no other hint is needed.
fn step(old: Definitions<'_>, new: Definitions<'_>) -> Converted {
    let found = convert(old, new, PX4_HINTS);
    assert_eq!(found.problems(), "");
    found
}

/// Like [`step`], for a step that the definitions alone decide.
fn plain_step(name: &str, old: &str, new: &str) -> Converted {
    let found = convert(&[(name, old)], &[(name, new)], "");
    assert_eq!(found.problems(), "");
    assert_eq!(step(&[(name, old)], &[(name, new)]).conversions.mistakes, []);
    found
}

#[track_caller]
fn has(message: &Value, fields: Value) {
    let Value::Object(fields) = fields else { panic!("an object") };
    for (name, value) in fields {
        assert_eq!(message[&name], value, "{name}");
    }
}

/// Checks a field that only the new message has.
#[track_caller]
fn adds(name: &str, field: &str, value: &Value) {
    let found = plain_step(
        name,
        "uint32 MESSAGE_VERSION = 0\nuint64 timestamp\n",
        &format!("uint32 MESSAGE_VERSION = 1\nuint64 timestamp\n{field}\n"),
    );
    let field = field.split_whitespace().nth(1).expect("a name").to_owned();
    has(&found.converted(found.forward(name), r#"{"timestamp": 7}"#), json!({"timestamp": 7, field: value}));
    has(&found.converted(found.backward(name), r#"{"timestamp": 7}"#), json!({"timestamp": 7}));
}

#[test]
fn actuator_servos_0_to_1() {
    let text = |count| {
        format!(
            "uint64 timestamp\nuint8 NUM_CONTROLS = {count}\nfloat32[{count}] control  # range: [-1, 1]. NaN maps to disarmed\n"
        )
    };
    let found = plain_step("ActuatorServos", &text(8), &text(15));
    let old = found.message(found.forward("ActuatorServos").from, r#"{"control": [1, 2, 3, 4, 5, 6, 7, 8]}"#);
    let new = found.run(found.forward("ActuatorServos"), &old);
    assert_eq!(
        new["control"],
        json!([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, null, null, null, null, null, null, null])
    );
    assert_eq!(found.run(found.backward("ActuatorServos"), &new), old);
    assert_eq!(found.backward("ActuatorServos").losses[0].text, "`control` is truncated to 8 elements");
}

#[test]
fn airspeed_validated_0_to_1() {
    let found = step(
        &[(
            "AirspeedValidated",
            "float32 calibrated_ground_minus_wind_m_s\nfloat32 true_ground_minus_wind_m_s\nbool airspeed_sensor_measurement_valid\nint8 selected_airspeed_index\n",
        )],
        &[(
            "AirspeedValidated",
            "int8 airspeed_source  # [@enum SOURCE]\nint8 SOURCE_DISABLED = -1\nint8 SOURCE_GROUND_MINUS_WIND = 0\nint8 SOURCE_SENSOR_1 = 1\nint8 SOURCE_SENSOR_2 = 2\nint8 SOURCE_SENSOR_3 = 3\nint8 SOURCE_SYNTHETIC = 4\nfloat32 calibrated_ground_minus_wind_m_s  # [m/s] [@invalid NaN]\nfloat32 calibraded_airspeed_synth_m_s  # [m/s] [@invalid NaN]\n",
        )],
    );
    let new = found.converted(
        found.forward("AirspeedValidated"),
        r#"{"calibrated_ground_minus_wind_m_s": 2.5, "selected_airspeed_index": 2}"#,
    );
    has(
        &new,
        json!({"airspeed_source": 2, "calibrated_ground_minus_wind_m_s": 2.5, "calibraded_airspeed_synth_m_s": null}),
    );
    for (source, is_valid) in [(-1, false), (0, false), (1, true), (3, true), (4, false)] {
        let fields = format!(r#"{{"airspeed_source": {source}, "calibrated_ground_minus_wind_m_s": 2.5}}"#);
        let old = found.converted(found.backward("AirspeedValidated"), &fields);
        has(
            &old,
            json!({"selected_airspeed_index": source, "airspeed_sensor_measurement_valid": is_valid, "true_ground_minus_wind_m_s": 2.5}),
        );
    }
}

const EVENT: &str =
    "uint64 timestamp\nuint32 id\nuint16 event_sequence\nuint8[25] arguments\nuint8 log_levels\n";

#[test]
fn arming_check_reply_0_to_1_keeps_all_events() {
    let reply = |added: &str| {
        format!(
            "uint8 request_id\nuint8 num_events  # [@count events]\nEvent[5] events\nbool mode_req_local_position_relaxed\n{added}"
        )
    };
    let found = step(
        &[("ArmingCheckReply", &reply("")), ("Event", EVENT)],
        &[("ArmingCheckReply", &reply("bool mode_req_global_position_relaxed\n")), ("Event", EVENT)],
    );
    let event = |id: u32| json!({"timestamp": 0, "id": id, "event_sequence": 0, "arguments": vec![0; 25], "log_levels": 0});
    let events: Vec<Value> = (1..=5).map(event).collect();
    let fields = json!({"num_events": 5, "events": events, "mode_req_local_position_relaxed": true});
    let new = found.converted(found.forward("ArmingCheckReply"), &fields.to_string());
    has(&new, fields.clone());
    has(&new, json!({"mode_req_global_position_relaxed": false}));
    has(&found.run(found.backward("ArmingCheckReply"), &new), fields);
}

#[test]
fn arming_check_request_0_to_1() {
    let found = step(
        &[("ArmingCheckRequest", "uint8 request_id\n")],
        &[("ArmingCheckRequest", "uint8 request_id\nuint32 valid_registrations_mask\n")],
    );
    let new = found.converted(found.forward("ArmingCheckRequest"), r#"{"request_id": 3}"#);
    has(&new, json!({"request_id": 3, "valid_registrations_mask": u32::MAX}));
    has(
        &found.converted(found.backward("ArmingCheckRequest"), r#"{"request_id": 3}"#),
        json!({"request_id": 3}),
    );
}

#[test]
fn aux_global_position_becomes_a_message_of_its_own() {
    let found = step(
        &[(
            "VehicleGlobalPosition",
            "float64 lat\nfloat64 lon\nfloat32 alt\nfloat32 alt_ellipsoid\nbool lat_lon_valid\nbool alt_valid\nfloat32 eph\n# TOPICS vehicle_global_position aux_global_position\n",
        )],
        &[(
            "AuxGlobalPosition",
            "uint8 id\nuint8 source  # [@enum SOURCE]\nuint8 SOURCE_UNKNOWN = 0\nuint8 SOURCE_GNSS = 1\nuint8 SOURCE_VISION = 2\nfloat64 lat\nfloat64 lon\nfloat32 alt  # [m] [@invalid NaN]\nfloat32 eph  # [m] [@invalid NaN]\n# TOPICS aux_global_position\n",
        )],
    );
    let forward = found.find(true, "VehicleGlobalPosition", "AuxGlobalPosition");
    let new =
        found.converted(forward, r#"{"lat": 1.5, "lon": 2.5, "alt": 30, "alt_valid": true, "eph": 0.5}"#);
    has(&new, json!({"lat": 1.5, "lon": 2.5, "alt": 30.0, "eph": 0.5, "id": 1, "source": 2}));
    has(&found.converted(forward, r#"{"alt": 30, "alt_valid": false}"#), json!({"alt": null}));
    let backward = found.find(false, "AuxGlobalPosition", "VehicleGlobalPosition");
    let old = found.converted(backward, r#"{"alt": 30}"#);
    has(&old, json!({"alt": 30.0, "alt_valid": true, "lat_lon_valid": true, "alt_ellipsoid": 0.0}));
    has(&found.converted(backward, r#"{"alt": null}"#), json!({"alt": 0.0, "alt_valid": false}));
}

#[test]
fn battery_status_0_to_1() {
    let found = plain_step("BatteryStatus", "uint16 capacity\nuint16 serial_number\n", "uint16 capacity\n");
    has(
        &found.converted(found.forward("BatteryStatus"), r#"{"capacity": 9, "serial_number": 4}"#),
        json!({"capacity": 9}),
    );
    has(
        &found.converted(found.backward("BatteryStatus"), r#"{"capacity": 9}"#),
        json!({"capacity": 9, "serial_number": 0}),
    );
    assert_eq!(found.forward("BatteryStatus").losses[0].text, "`serial_number` is dropped");
}

#[test]
fn battery_status_1_to_2() {
    let constants = "uint8 WARNING_NONE = 0\nuint8 WARNING_LOW = 1\n";
    let old = format!(
        "uint32 MESSAGE_VERSION = 1\nuint8 warning  # [@enum WARNING]\n{constants}uint8 WARNING_UNHEALTHY = 6\nuint8 WARNING_CHARGING = 7\n"
    );
    let new = format!(
        "uint32 MESSAGE_VERSION = 2\nuint8 warning  # [@enum WARNING]\n{constants}uint8 flags  # [@enum FLAG]\nuint8 FLAG_CHARGING = 1\nuint8 FLAG_FULL = 2\n"
    );
    let found = step(&[("BatteryStatus", &old)], &[("BatteryStatus", &new)]);
    for (warning, converted, flags) in [(0, 0, 0), (1, 1, 0), (6, 0, 0), (7, 0, 1)] {
        let new = found.converted(found.forward("BatteryStatus"), &json!({"warning": warning}).to_string());
        has(&new, json!({"warning": converted, "flags": flags}));
    }
    for (warning, flags, converted) in [(0, 0, 0), (0, 1, 7), (0, 3, 7), (0, 2, 0), (1, 1, 1)] {
        let fields = json!({"warning": warning, "flags": flags}).to_string();
        has(&found.converted(found.backward("BatteryStatus"), &fields), json!({"warning": converted}));
    }
}

#[test]
fn config_overrides_0_to_1() {
    adds("ConfigOverrides", "bool disable_auto_set_home", &json!(false));
}

#[test]
fn event_0_to_1() {
    let moved = "uint64 timestamp\nuint16 event_sequence\nuint8 log_levels\nuint32 id\nuint8[25] arguments\n";
    let found = plain_step("Event", EVENT, moved);
    let fields =
        json!({"timestamp": 1, "id": 2, "event_sequence": 3, "log_levels": 4, "arguments": vec![5; 25]});
    for conversion in [found.forward("Event"), found.backward("Event")] {
        assert_eq!(found.converted(conversion, &fields.to_string()), fields);
        assert_eq!(conversion.losses, []);
    }
}

#[test]
fn home_position_0_to_1() {
    adds("HomePosition", "float32 roll", &json!(0.0));
    adds("HomePosition", "float32 pitch", &json!(0.0));
}

#[test]
fn register_ext_component_0_to_1() {
    adds("RegisterExtComponentReply", "bool not_user_selectable", &json!(false));
    adds("RegisterExtComponentRequest", "bool not_user_selectable", &json!(false));
}

#[test]
fn vehicle_attitude_setpoint_0_to_1() {
    let found = plain_step(
        "VehicleAttitudeSetpoint",
        "float32 yaw_sp_move_rate\nbool reset_integral\nbool fw_control_yaw_wheel\n",
        "float32 yaw_sp_move_rate\n",
    );
    let old = found.converted(found.backward("VehicleAttitudeSetpoint"), r#"{"yaw_sp_move_rate": 0.5}"#);
    has(&old, json!({"yaw_sp_move_rate": 0.5, "reset_integral": false, "fw_control_yaw_wheel": false}));
    assert_eq!(found.forward("VehicleAttitudeSetpoint").losses.len(), 2);
}

#[test]
fn vehicle_command_0_to_1_inverts_the_safety_switch() {
    let command = "uint16 VEHICLE_CMD_DO_SET_SAFETY_SWITCH_STATE = 5300\nfloat32 param1\nuint32 command\n";
    let old = format!("uint32 MESSAGE_VERSION = 0\n{command}uint8 SAFETY_OFF = 0\nuint8 SAFETY_ON = 1\n");
    let new =
        format!("uint32 MESSAGE_VERSION = 1\n{command}uint8 SAFETY_SAFE = 0\nuint8 SAFETY_DANGEROUS = 1\n");
    let found = step(&[("VehicleCommand", &old)], &[("VehicleCommand", &new)]);
    for conversion in [found.forward("VehicleCommand"), found.backward("VehicleCommand")] {
        for (command, before, after) in [(5300, 0.0, 1.0), (5300, 1.0, 0.0), (16, 0.0, 0.0), (16, 2.5, 2.5)] {
            let fields = json!({"command": command, "param1": before});
            has(
                &found.converted(conversion, &fields.to_string()),
                json!({"command": command, "param1": after}),
            );
        }
    }
}

#[test]
fn vehicle_local_position_0_to_1() {
    let found = step(
        &[("VehicleLocalPosition", "float32 hagl_min\nfloat32 hagl_max\n")],
        &[("VehicleLocalPosition", "float32 hagl_min\nfloat32 hagl_max_z\nfloat32 hagl_max_xy\n")],
    );
    let new = found.converted(found.forward("VehicleLocalPosition"), r#"{"hagl_max": 5}"#);
    has(&new, json!({"hagl_max_z": 5.0, "hagl_max_xy": 5.0}));
    let old =
        found.converted(found.backward("VehicleLocalPosition"), r#"{"hagl_max_z": 5, "hagl_max_xy": 6}"#);
    has(&old, json!({"hagl_max": 5.0}));
}

#[test]
fn vehicle_odometry_0_to_1() {
    adds("VehicleOdometry", "float32 acceleration  # [m/s^2] [@invalid NaN]", &Value::Null);
}

#[test]
fn vehicle_status_0_to_4() {
    adds("VehicleStatus", "bool accepts_offboard_setpoints", &json!(false));
    for removed in
        ["bool avoidance_system_required\nbool avoidance_system_valid\n", "uint16 failure_detector_status\n"]
    {
        let found = plain_step("VehicleStatus", &format!("uint8 nav_state\n{removed}"), "uint8 nav_state\n");
        let old = found.converted(found.backward("VehicleStatus"), r#"{"nav_state": 4}"#);
        assert_eq!(old, found.message(found.backward("VehicleStatus").to, r#"{"nav_state": 4}"#));
    }
}

#[test]
fn six_steps_require_hints() {
    let names = [
        "ArmingCheckRequest",
        "AirspeedValidated",
        "VehicleLocalPosition",
        "BatteryStatus",
        "VehicleCommand",
        "AuxGlobalPosition",
    ];
    for name in names {
        assert!(PX4_HINTS.contains(&format!("essage = \"{name}\"")), "{name}");
    }
    assert_eq!(Hints::default().mistakes, []);
}

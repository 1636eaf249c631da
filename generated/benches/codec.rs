//! Benchmarks of the codecs, compared with a plain copy of the bytes and with other crates.
//!
//! Run with `cargo bench --package uavspec-types --bench codec`. Prints nanoseconds and ratios, and never fails.

use std::hint::black_box;
use std::time::Instant;

use byteorder::LittleEndian;
use serde::Serialize;
use serde::de::DeserializeOwned;
use uavspec_runtime::cdr::ByteOrder;
use uavspec_runtime::{Message, UorbMessage};
use uavspec_types::px4::{ArmingCheckReply, BatteryStatus, Event, FailsafeFlags};

/// Samples of each function. The functions take turns, so a slow moment of the machine affects all of them.
const SAMPLES: usize = 41;
/// Minimum duration of one sample, in nanoseconds.
const SAMPLE_NS: u128 = 500_000;

type Function<'f> = Box<dyn FnMut() + 'f>;

/// Functions to compare. The first one is the baseline.
struct Comparison<'f> {
    title: &'f str,
    functions: Vec<(&'f str, Function<'f>)>,
}

impl<'f> Comparison<'f> {
    fn new(title: &'f str) -> Self {
        Self { title, functions: Vec::new() }
    }

    fn with<T>(mut self, name: &'f str, mut function: impl FnMut() -> T + 'f) -> Self {
        self.functions.push((
            name,
            Box::new(move || {
                black_box(&function());
            }),
        ));
        self
    }

    fn run(mut self) {
        println!("{}", self.title);
        let mut rounds: Vec<u32> = Vec::new();
        for (_, function) in &mut self.functions {
            let mut count = 1_u32;
            while time(function, count) < SAMPLE_NS {
                count *= 2;
            }
            rounds.push(count);
        }
        let mut samples: Vec<Vec<f64>> = vec![Vec::new(); self.functions.len()];
        for _ in 0..SAMPLES {
            for (index, (_, function)) in self.functions.iter_mut().enumerate() {
                let elapsed = time(function, rounds[index]);
                #[allow(clippy::cast_precision_loss)] // far below 2^52
                samples[index].push(elapsed as f64 / f64::from(rounds[index]));
            }
        }
        let mut base = None;
        for ((name, _), mut samples) in self.functions.iter().zip(samples) {
            samples.sort_by(f64::total_cmp);
            let median = samples[SAMPLES / 2];
            let base = *base.get_or_insert(median);
            println!("  {name:<44} {median:>9.1} ns  {:>7.2}x", median / base);
        }
    }
}

fn time(function: &mut dyn FnMut(), count: u32) -> u128 {
    let started = Instant::now();
    for _ in 0..count {
        function();
    }
    started.elapsed().as_nanos()
}

fn main() {
    uorb(&flags(), "FailsafeFlags");
    uorb(&reply(), "ArmingCheckReply");
    uorb(&battery(), "BatteryStatus");
    view();
    cdr::<FailsafeFlags, derived::FailsafeFlags>(&flags(), "FailsafeFlags");
    cdr::<ArmingCheckReply, derived::ArmingCheckReply>(&reply(), "ArmingCheckReply");
    json::<FailsafeFlags, derived::FailsafeFlags>(&flags(), "FailsafeFlags");
    json::<ArmingCheckReply, derived::ArmingCheckReply>(&reply(), "ArmingCheckReply");
}

fn flags() -> FailsafeFlags {
    FailsafeFlags {
        timestamp: 1_234_567_890,
        mode_req_attitude: 0x00ff_00ff,
        gcs_connection_lost: true,
        battery_warning: 2.into(),
        ..FailsafeFlags::default()
    }
}

fn reply() -> ArmingCheckReply {
    let mut reply = ArmingCheckReply {
        timestamp: 1_234_567_890,
        request_id: 7,
        num_events: 2,
        can_arm_and_run: true,
        ..ArmingCheckReply::default()
    };
    for (event, id) in reply.events.iter_mut().zip([0x0100_0001, 0x0100_0002]) {
        *event =
            Event { timestamp: 1_234_567_000, id, arguments: [9; 25], log_levels: 0x33, event_sequence: 17 };
    }
    reply
}

fn battery() -> BatteryStatus {
    BatteryStatus {
        timestamp: 1_234_567_890,
        voltage_v: 15.9,
        voltage_cell_v: [3.9; 14],
        ..Default::default()
    }
}

fn uorb<T: UorbMessage>(message: &T, name: &str) {
    let bytes = message.to_uorb();
    let payload = bytes.as_ref();
    Comparison::new(&format!("uORB, {name}, {} bytes", T::SIZE))
        .with("copy of the bytes", || {
            let mut copy = T::ZEROS;
            copy.as_mut().copy_from_slice(black_box(payload));
            copy
        })
        .with("decode", || T::from_uorb(black_box(payload)))
        .with("decode, strict", || T::from_uorb_strict(black_box(payload)))
        .with("encode", || black_box(message).to_uorb())
        .run();
}

fn view() {
    let bytes = flags().to_uorb();
    Comparison::new("uORB, three fields of FailsafeFlags")
        .with("copy of the bytes", || {
            let mut copy = FailsafeFlags::ZEROS;
            copy.copy_from_slice(black_box(&bytes));
            copy
        })
        .with("view", || {
            let view = FailsafeFlags::view(black_box(&bytes)).ok()?;
            Some((view.timestamp(), view.gcs_connection_lost(), view.battery_warning()))
        })
        .run();
}

fn cdr<T: Message, D: Serialize + DeserializeOwned>(message: &T, name: &str) {
    let bytes = message.to_cdr(ByteOrder::LittleEndian).expect("it fits");
    let big = message.to_cdr(ByteOrder::BigEndian).expect("it fits");
    let derived: D = cdr::deserialize(&bytes).expect("the same type");
    assert_eq!(cdr::serialize::<_, _, cdr::CdrLe>(&derived, cdr::Infinite).expect("it fits"), bytes);
    let (same, _) = cdr_encoding::from_bytes::<D, LittleEndian>(&bytes[4..]).expect("the same type");
    assert_eq!(cdr_encoding::to_vec::<_, LittleEndian>(&same).expect("it fits"), &bytes[4..]);
    Comparison::new(&format!("CDR, decode {name}, {} bytes", bytes.len()))
        .with("this crate", || T::from_cdr(black_box(&bytes)))
        .with("this crate, big endian", || T::from_cdr(black_box(&big)))
        .with("cdr", || cdr::deserialize::<D>(black_box(&bytes)))
        .with("cdr-encoding", || cdr_encoding::from_bytes::<D, LittleEndian>(black_box(&bytes[4..])))
        .run();
    let mut buffer = bytes.clone();
    Comparison::new(&format!("CDR, encode {name}, {} bytes", bytes.len()))
        .with("this crate", || black_box(message).to_cdr(ByteOrder::LittleEndian))
        .with("this crate, to a buffer", || {
            black_box(message).encode_cdr(ByteOrder::LittleEndian, black_box(&mut buffer))
        })
        .with("this crate, big endian", || black_box(message).to_cdr(ByteOrder::BigEndian))
        .with("cdr", || cdr::serialize::<_, _, cdr::CdrLe>(black_box(&derived), cdr::Infinite))
        .with("cdr-encoding", || cdr_encoding::to_vec::<_, LittleEndian>(black_box(&derived)))
        .run();
}

fn json<T: Message + Serialize + DeserializeOwned, D: Serialize + DeserializeOwned>(message: &T, name: &str) {
    let text = serde_json::to_string(message).expect("finite numbers");
    let derived: D = serde_json::from_str(&text).expect("the same fields");
    assert_eq!(serde_json::to_string(&derived).expect("finite numbers"), text);
    Comparison::new(&format!("JSON, read {name}, {} bytes", text.len()))
        .with("serde's derive", || serde_json::from_str::<D>(black_box(&text)))
        .with("this crate", || serde_json::from_str::<T>(black_box(&text)))
        .run();
    Comparison::new(&format!("JSON, write {name}, {} bytes", text.len()))
        .with("serde's derive", || serde_json::to_string(black_box(&derived)))
        .with("this crate", || serde_json::to_string(black_box(message)))
        .run();
}

/// The messages as handwritten structs with serde's derives.
#[allow(clippy::struct_excessive_bools, clippy::struct_field_names)]
mod derived {
    use serde::{Deserialize, Serialize};

    #[derive(Serialize, Deserialize)]
    pub(crate) struct FailsafeFlags {
        timestamp: u64,
        mode_req_angular_velocity: u32,
        mode_req_attitude: u32,
        mode_req_local_alt: u32,
        mode_req_local_position: u32,
        mode_req_local_position_relaxed: u32,
        mode_req_global_position: u32,
        mode_req_mission: u32,
        mode_req_offboard_signal: u32,
        mode_req_home_position: u32,
        mode_req_wind_and_flight_time_compliance: u32,
        mode_req_prevent_arming: u32,
        mode_req_manual_control: u32,
        mode_req_other: u32,
        angular_velocity_invalid: bool,
        attitude_invalid: bool,
        local_altitude_invalid: bool,
        local_position_invalid: bool,
        local_position_invalid_relaxed: bool,
        local_velocity_invalid: bool,
        global_position_invalid: bool,
        auto_mission_missing: bool,
        offboard_control_signal_lost: bool,
        home_position_invalid: bool,
        manual_control_signal_lost: bool,
        gcs_connection_lost: bool,
        battery_warning: u8,
        battery_low_remaining_time: bool,
        battery_unhealthy: bool,
        geofence_breached: bool,
        mission_failure: bool,
        vtol_fixed_wing_system_failure: bool,
        wind_limit_exceeded: bool,
        flight_time_limit_exceeded: bool,
        local_position_accuracy_low: bool,
        fd_critical_failure: bool,
        fd_esc_arming_failure: bool,
        fd_imbalanced_prop: bool,
        fd_motor_failure: bool,
    }

    #[derive(Serialize, Deserialize)]
    pub(crate) struct ArmingCheckReply {
        timestamp: u64,
        request_id: u8,
        registration_id: u8,
        health_component_index: u8,
        health_component_is_present: bool,
        health_component_warning: bool,
        health_component_error: bool,
        can_arm_and_run: bool,
        num_events: u8,
        events: [Event; 5],
        mode_req_angular_velocity: bool,
        mode_req_attitude: bool,
        mode_req_local_alt: bool,
        mode_req_local_position: bool,
        mode_req_local_position_relaxed: bool,
        mode_req_global_position: bool,
        mode_req_global_position_relaxed: bool,
        mode_req_mission: bool,
        mode_req_home_position: bool,
        mode_req_prevent_arming: bool,
        mode_req_manual_control: bool,
    }

    #[derive(Serialize, Deserialize)]
    pub(crate) struct Event {
        timestamp: u64,
        id: u32,
        event_sequence: u16,
        arguments: [u8; 25],
        log_levels: u8,
    }
}

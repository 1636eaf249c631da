//! Logs a few values to standard output, in the binary format that a device uses.

use std::io::Write as _;

use uavspec_types::flockwave::ErrorCode;
use uavspec_types::px4::battery_status::{BatteryFault, BatteryWarning};
use uavspec_types::px4::{BatteryStatus, Event, RegisterExtComponentReply, UnregisterExtComponent};
use uavspec_runtime::{Severity, Text};

#[defmt::global_logger]
struct Logger;

// The program has a single thread.
unsafe impl defmt::Logger for Logger {
    fn acquire() {}

    unsafe fn flush() {}

    unsafe fn release() {}

    unsafe fn write(bytes: &[u8]) {
        std::io::stdout().write_all(bytes).expect("standard output is writable");
    }
}

defmt::timestamp!("");

/// An error code whose abbreviation contains braces.
struct Braced(u32);

uavspec_runtime::error_code! { Braced; 7 "{x}"; }

fn main() {
    defmt::println!("{}", Event { id: 7, arguments: [1; 25], ..Event::default() });
    let reply = RegisterExtComponentReply {
        name: "Land".parse().expect("it fits"),
        success: true,
        mode_id: -3,
        ..RegisterExtComponentReply::default()
    };
    defmt::println!("{}", reply);
    let bytes = UnregisterExtComponent { name: Text([0xff; 25]), ..UnregisterExtComponent::default() };
    defmt::println!("{}", bytes);
    let battery = BatteryStatus {
        warning: BatteryWarning::CRITICAL,
        faults: BatteryFault::SPIKES | BatteryFault(0x8000),
        temperature: f32::NAN,
        ..BatteryStatus::default()
    };
    defmt::println!("{} {} {}", battery.warning, battery.faults, BatteryWarning(200));
    defmt::println!("{}", battery);
    defmt::println!("{} {} {}", ErrorCode::LOWBAT_FATAL, ErrorCode(0x1_0042), Severity::Fatal);
    defmt::println!("{} {}", Braced(7), Braced(8));
}

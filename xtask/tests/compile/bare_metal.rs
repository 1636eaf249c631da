//! Firmware without an allocator. The crate is a static library and links only `core`. Therefore, the crate would not
//! build if the code required an allocator.

#![no_std]
#![forbid(unsafe_code)]

use uavspec_types::px4::{FailsafeFlags, FailsafeFlagsView};
use uavspec_runtime::cdr::ByteOrder;
use uavspec_runtime::{Message, UorbMessage};

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}

/// Converts a uORB payload to CDR. Returns the number of bytes, or 0 if the payload is invalid or not urgent.
pub extern "C" fn forward(payload: &[u8; FailsafeFlags::SIZE], out: &mut [u8; 89]) -> usize {
    let Ok(view) = FailsafeFlags::view(payload) else { return 0 };
    if !is_urgent(view) {
        return 0;
    }
    let Ok(flags) = FailsafeFlags::from_uorb_strict(payload) else { return 0 };
    let mut violations = 0;
    flags.validate_with(&mut |_| violations += 1);
    if violations > 0 || !flags.contains_failure() {
        return 0;
    }
    flags.encode_cdr(ByteOrder::LittleEndian, out).unwrap_or(0)
}

fn is_urgent(view: FailsafeFlagsView<'_>) -> bool {
    view.timestamp() > 0 && (view.fd_motor_failure() || view.battery_unhealthy())
}

//! A flight controller that takes part in arming checks. It is a ROS 2 node that uses hiroz, which implements names,
//! type hashes and CDR independently of uavspec.
//!
//! ```text
//! uavspec-hiroz-peer ROUTER    publishes ArmingCheckRequest, and prints each RegisterExtComponentRequest
//! ```
//!
//! ROUTER is the address of a Zenoh router, such as `tcp/127.0.0.1:7447`.

use std::num::NonZeroUsize;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use hiroz::context::ZContextBuilder;
use hiroz::msg::{SerdeCdrSerdes, ZMessage};
use hiroz::qos::{QosDurability, QosHistory, QosProfile, QosReliability};
use hiroz::{Builder, MessageTypeInfo};
use serde::{Deserialize, Serialize};

/// The period of requests.
const PERIOD: Duration = Duration::from_millis(50);

#[derive(Debug, Clone, Default, Serialize, Deserialize, MessageTypeInfo)]
#[ros_msg(type_name = "px4_msgs/msg/ArmingCheckRequest")]
struct ArmingCheckRequest {
    timestamp: u64,
    request_id: u8,
    valid_registrations_mask: u32,
}

#[derive(Debug, Clone, Default, Serialize, Deserialize, MessageTypeInfo)]
#[ros_msg(type_name = "px4_msgs/msg/RegisterExtComponentRequest")]
struct RegisterExtComponentRequest {
    timestamp: u64,
    request_id: u64,
    name: [u8; 25],
    px4_ros2_api_version: u16,
    register_arming_check: bool,
    register_mode: bool,
    register_mode_executor: bool,
    enable_replace_internal_mode: bool,
    replace_internal_mode: u8,
    activate_mode_immediately: bool,
}

impl ZMessage for ArmingCheckRequest {
    type Serdes = SerdeCdrSerdes<Self>;
}

impl ZMessage for RegisterExtComponentRequest {
    type Serdes = SerdeCdrSerdes<Self>;
}

fn main() -> hiroz::Result<()> {
    let router = std::env::args().nth(1).ok_or("expected the address of a router")?;
    let context = ZContextBuilder::default().with_domain_id(0).with_router_endpoint(router)?.build()?;
    let node = context.create_node("hiroz_px4").without_parameters().build()?;
    let qos = QosProfile {
        reliability: QosReliability::BestEffort,
        durability: QosDurability::TransientLocal,
        history: QosHistory::KeepLast(NonZeroUsize::MIN),
        ..QosProfile::default()
    };
    let output =
        node.create_pub::<ArmingCheckRequest>("/fmu/out/arming_check_request_v1").with_qos(qos).build()?;
    let input = node
        .create_sub::<RegisterExtComponentRequest>("/fmu/in/register_ext_component_request")
        .with_qos(qos)
        .build()?;
    for number in (0..=u8::MAX).cycle() {
        let request =
            ArmingCheckRequest { timestamp: microseconds(), request_id: number, valid_registrations_mask: 1 };
        output.publish(&request)?;
        if let Ok(received) = input.recv_timeout(PERIOD) {
            print(&received);
        }
    }
    Ok(())
}

/// The time in µs since 1970. uavspec only requires it to increase.
fn microseconds() -> u64 {
    let time = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(time.as_micros()).unwrap_or(u64::MAX)
}

/// Prints the fields that a component chooses.
fn print(request: &RegisterExtComponentRequest) {
    let name = String::from_utf8_lossy(&request.name);
    println!(
        "{} api {} check {}",
        name.trim_end_matches('\0'),
        request.px4_ros2_api_version,
        request.register_arming_check
    );
}

//! The targets of commands that connect to a server or a vehicle.

use std::str::FromStr;

use uavspec_flockwave::transport::endpoint::Endpoint;
use uavspec_live::bus::Address;

/// A Flockwave server or a PX4 vehicle.
#[derive(Clone, Debug)]
pub(super) enum Target {
    /// A Flockwave server.
    Server(Endpoint),
    /// A bus with a PX4 vehicle.
    Vehicle(Address),
}

impl FromStr for Target {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if Address::is_meant(text) {
            return text.parse().map(Self::Vehicle);
        }
        text.parse().map(Self::Server)
    }
}

//! The limits on the amount of data that this crate reads and stores. They bound the time and the memory that hostile
//! input can use.

// Buses.

/// The maximum number of endpoints that a bus reports.
pub(crate) const MAX_ENDPOINTS: usize = 10_000;

/// The maximum number of distinct problems of each kind that are reported for a bus.
pub(crate) const MAX_PROBLEMS: usize = 256;

/// The maximum size of all schemas from a Foxglove server, in bytes.
pub(crate) const MAX_SCHEMAS: usize = 64 << 20;

/// The maximum size of a message over a WebSocket, in bytes. The records of a recording have at most 64 MiB.
pub(crate) const MAX_MESSAGE: usize = 60 << 20;

// Vehicles and their recordings.

/// The maximum number of channels of a vehicle.
pub(crate) const MAX_CHANNELS: usize = 10_000;

/// The maximum size of a recording, in bytes.
pub(crate) const MAX_RECORDING: u64 = 8 << 30;

// Displays.

/// The maximum number of UAVs. The largest fleets flown so far are about half as large.
pub(crate) const MAX_UAVS: usize = 10_000;

/// The maximum number of error codes of a UAV.
pub(crate) const MAX_CODES: usize = 64;

/// The maximum number of values in each other list of a UAV.
pub(crate) const MAX_VALUES: usize = 16;

/// The maximum number of unknown fields of a UAV.
pub(crate) const MAX_OTHERS: usize = 8;

/// The maximum number of batteries. PX4 supports four.
pub(crate) const MAX_BATTERIES: usize = 16;

/// The maximum number of components. PX4 supports far fewer components.
pub(crate) const MAX_COMPONENTS: usize = 64;

//! A small PX4 log that conforms to the definitions of all releases.

/// The magic bytes of a log, and the version of the format.
const MAGIC: [u8; 8] = *b"ULog\x01\x12\x35\x01";

/// The number of records.
const RECORDS: u8 = 10;

/// Creates a log with one topic, `cpuload`.
pub(super) fn cpuload() -> Vec<u8> {
    let mut log = [&MAGIC[..], &time(0)].concat();
    message(&mut log, b'F', &[b"cpuload:uint64_t timestamp;float load;float ram_usage;"]);
    // The instance and the id of the topic precede its name.
    message(&mut log, b'A', &[&[0, 0, 0], b"cpuload"]);
    for index in 0..RECORDS {
        let [load, ram_usage] = [0.25f32, 0.5].map(f32::to_le_bytes);
        message(&mut log, b'D', &[&[0, 0], &time(index), &load, &ram_usage]);
    }
    log
}

/// A time in microseconds: one second for each record.
fn time(index: u8) -> [u8; 8] {
    (u64::from(index) * 1_000_000).to_le_bytes()
}

/// Appends a message: the size, the type and the payload.
fn message(log: &mut Vec<u8>, kind: u8, parts: &[&[u8]]) {
    let payload = parts.concat();
    // All payloads are shorter than 100 bytes.
    let size = u16::try_from(payload.len()).unwrap_or(u16::MAX);
    log.extend(size.to_le_bytes());
    log.push(kind);
    log.extend(payload);
}

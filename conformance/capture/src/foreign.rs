//! Identifies files that aren't captures by their first bytes, and says what to do with them.

/// The number of bytes that are needed to identify a file.
pub const START: usize = 512;

/// The magic bytes of files, each with its offset and a description.
const MAGICS: [(usize, &[u8], &str); 31] = [
    (0, b"PK\x03\x04", ZIP),
    (0, b"PK\x05\x06", ZIP),
    (0, b"7z\xbc\xaf\x27\x1c", "a 7z archive: unpack it first, for example with `7z x`"),
    (0, b"Rar!\x1a\x07", "a RAR archive: unpack it first, for example with `unrar x`"),
    (0, b"\xfd7zXZ\0", "xz data: decompress it first, for example with `xz -d`"),
    (0, b"BZh", "bzip2 data: decompress it first, for example with `bzip2 -d`"),
    (0, b"\x04\x22\x4d\x18", "lz4 data: decompress it first, for example with `lz4 -d`"),
    (0, b"\x1f\x9d", "compressed data (.Z): decompress it first, for example with `gzip -d`"),
    (257, b"ustar", "a tar archive: unpack it first, for example with `tar -xf`"),
    (0, b"\xff\xfe\0\0", UTF_32),
    (0, b"\0\0\xfe\xff", UTF_32),
    (0, b"\xff\xfe", UTF_16),
    (0, b"\xfe\xff", UTF_16),
    (
        0,
        b"version https://git-lfs.github.com/spec/",
        "a Git LFS pointer in place of the file: run `git lfs pull`",
    ),
    (0, b"/annex/objects/", "a git-annex pointer in place of the file: run `git annex get`"),
    // An ArduPilot log starts with the format of its format messages. PX4's old logger uses the same file format.
    (0, b"\xa3\x95\x80\x80", ARDUPILOT),
    (0, b"FMT, ", ARDUPILOT),
    (0, b"FMT,128", ARDUPILOT),
    (
        0,
        b"\xa3\x95\x80",
        "a log from PX4's old logger (.px4log): PX4 1.4 and later write ULog; set the parameter SYS_LOGGER to 1 \
         in older ones",
    ),
    (
        0,
        b"#ROSBAG V1",
        "a bag from an old ROS 1 version: convert it first, with `rosbag fix` and `rosbags-convert`",
    ),
    (0, b"\xd4\xc3\xb2\xa1", PCAP),
    (0, b"\xa1\xb2\xc3\xd4", PCAP),
    (0, b"\x4d\x3c\xb2\xa1", PCAP),
    (0, b"\xa1\xb2\x3c\x4d", PCAP),
    (0, b"\x0a\x0d\x0d\x0a", PCAP),
    (16, b"BUILD", DJI),
    (242, b"DJI_LOG_V", DJI),
    (0, b"H Product:Blackbox", "a Betaflight or INAV log (Blackbox): only logs of PX4 are supported"),
    (0, b"\x89HDF\r\n", "an HDF5 file: check the log or bag that it was made from"),
    (0, b"PAR1", "a Parquet file: check the log or bag that it was made from"),
    (0, b"%PDF-", "a PDF file, not a capture"),
];

const ZIP: &str = "a ZIP archive: unpack it first, for example with `unzip`";

const UTF_16: &str = "UTF-16 text: convert it to UTF-8 first, for example with `iconv -f UTF-16 -t UTF-8`; PowerShell \
                      writes UTF-8 with `Out-File -Encoding utf8`";

const UTF_32: &str = "UTF-32 text: convert it to UTF-8 first, for example with `iconv -f UTF-32 -t UTF-8`";

const ARDUPILOT: &str = "an ArduPilot DataFlash log: only logs of PX4 (ULog) are supported";

const PCAP: &str = "a network capture (pcap): record the topics as a bag, for example with `ros2 bag record` or `uavspec \
                    probe`";

const DJI: &str = "a DJI flight log: only logs of PX4 (ULog) are supported";

const TLOG: &str = "a MAVLink telemetry log (.tlog): check the log that the flight controller wrote (.ulg)";

const MAVLINK: &str = "MAVLink messages: check the log that the flight controller wrote (.ulg)";

const WEB_PAGE: &str = "a web page: the download may have required a login; download the file again";

/// The first bytes of `MAVLink` packets, in versions 1 and 2.
const MAVLINK_PACKETS: [u8; 2] = [0xfe, 0xfd];

/// The plausible times of telemetry logs, in µs since 1970: from 2000 to 2100.
const TIMES: std::ops::Range<u64> = 946_684_800_000_000..4_102_444_800_000_000;

/// Describes a file with these first bytes, and says what to do. `None` if its kind is unknown.
pub fn describe(start: &[u8]) -> Option<&'static str> {
    let has = |at: usize, magic: &[u8]| start.get(at..).is_some_and(|rest| rest.starts_with(magic));
    let known = MAGICS.iter().find(|(at, magic, _)| has(*at, magic)).map(|(_, _, text)| *text);
    known.or_else(|| is_web_page(start).then_some(WEB_PAGE)).or_else(|| mavlink(start))
}

fn is_web_page(start: &[u8]) -> bool {
    let text = start.trim_ascii_start();
    ["<!doctype html", "<html"]
        .iter()
        .any(|tag| text.get(..tag.len()).is_some_and(|found| found.eq_ignore_ascii_case(tag.as_bytes())))
}

/// Describes `MAVLink` packets. In telemetry logs, the time in µs precedes each packet.
fn mavlink(start: &[u8]) -> Option<&'static str> {
    let is_packet = |at: usize| {
        // The payload must not be empty.
        let packet = start.get(at..at + 6)?;
        (MAVLINK_PACKETS.contains(&packet[0]) && packet[1] > 0).then_some(())
    };
    let time = start.first_chunk().map(|bytes| u64::from_be_bytes(*bytes))?;
    if TIMES.contains(&time) && is_packet(8).is_some() {
        return Some(TLOG);
    }
    // Without times, two packets in a row show that the first byte isn't a coincidence.
    let overhead = match start[..3] {
        [0xfe, ..] => 8,
        // Signed packets are longer.
        [0xfd, _, flags] if flags & 1 == 0 => 12,
        [0xfd, ..] => 25,
        _ => return None,
    };
    is_packet(0)?;
    is_packet(usize::from(start[1]) + overhead)?;
    Some(MAVLINK)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_files_of_other_programs() {
        let time = 1_700_000_000_000_000_u64.to_be_bytes();
        let packet = [&[0xfd, 9, 0, 0, 0, 1, 1, 0, 0, 0][..], &[0; 11]].concat();
        let mut tar = b"log.ulg".to_vec();
        tar.resize(257, 0);
        tar.extend(b"ustar\x0000");
        let mut dji = vec![0x55; 16];
        dji.extend(b"BUILD 2015-08-28");
        for (start, expected) in [
            (&b"PK\x03\x04\x14\0\0\0"[..], "a ZIP archive: unpack it first"),
            (b"\xfd7zXZ\0\0\x04", "xz data: decompress it first"),
            (b"BZh91AY&SY", "bzip2 data"),
            (b"\x04\x22\x4d\x18\x64\x40\xa7", "lz4 data"),
            (&tar, "a tar archive"),
            (b"\xff\xfe{\0\"\0", "UTF-16 text: convert it to UTF-8 first"),
            (b"\xfe\xff\0{\0\"", "UTF-16 text"),
            (b"\xff\xfe\0\0{\0\0\0", "UTF-32 text"),
            (b"version https://git-lfs.github.com/spec/v1\noid sha256:00", "a Git LFS pointer"),
            (b"/annex/objects/MD5E-s1--0.ulg", "a git-annex pointer"),
            (b"\xa3\x95\x80\x80\x59FMT\0BBnNZ", "an ArduPilot DataFlash log"),
            (b"FMT, 128, 89, FMT, BBnNZ, Type,Length", "an ArduPilot DataFlash log"),
            (b"\xa3\x95\x80\x81\x0bTIME", "a log from PX4's old logger"),
            (&[&time[..], &packet].concat(), "a MAVLink telemetry log"),
            (&packet.repeat(2), "MAVLink messages"),
            (b"#ROSBAG V1.2\n", "a bag from an old ROS 1 version"),
            (b"\xd4\xc3\xb2\xa1\x02\0\x04\0", "a network capture"),
            (b"\x0a\x0d\x0d\x0a\x1c\0\0\0", "a network capture"),
            (&dji, "a DJI flight log"),
            (b"H Product:Blackbox flight data recorder", "a Betaflight or INAV log"),
            (b"\n<!DOCTYPE HTML>", "a web page"),
        ] {
            let found = describe(start).unwrap_or("nothing");
            assert!(found.starts_with(expected), "{}: {found}", start.escape_ascii());
        }
        for other in [
            &b""[..],
            b"P",
            b"\xfd",
            b"\xfd\xfd\xfd\xfd\xfd\xfd\xfd\xfd",
            b"version 1",
            b"\0\0\0\0\0\0\0\0\xfe",
        ] {
            assert_eq!(describe(other), None, "{}", other.escape_ascii());
        }
    }
}

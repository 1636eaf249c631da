//! Tests that the logs of a run share what is compiled, and not more.

use uavspec_check::check_bytes;
use uavspec_rules::definitions::Library;
use uavspec_test_support::{Writer, extent};

use super::violated;

/// A log with these formats, and with a message for each format whose size is given.
fn log(formats: &[(&str, usize)]) -> Vec<u8> {
    let mut log = Writer::with_flags();
    for (format, _) in formats {
        log.format(format);
    }
    for (id, (format, size)) in (0..).zip(formats).filter(|(_, (_, size))| *size > 0) {
        log.subscribe(id, 0, format.split(':').next().unwrap_or_default());
        log.data(id, &vec![2; *size]);
    }
    log.bytes
}

/// Compares the results of logs that are checked with the same library, several times, with those of each log alone.
fn check_together(logs: &[Vec<u8>]) {
    let check = |bytes: &[u8], library: &Library| {
        let checked = check_bytes(bytes, library).expect("bytes can be read");
        let result = checked.result;
        (
            violated(&result),
            format!("{:?}", result.summary),
            format!("{:?}", result.coverage),
            result.corruption,
        )
    };
    let alone: Vec<_> = logs.iter().map(|bytes| check(bytes, &Library::built_in())).collect();
    let shared = Library::built_in();
    for _ in 0..2 {
        for (bytes, alone) in logs.iter().zip(&alone) {
            assert_eq!(*alone, check(bytes, &shared));
        }
    }
}

#[test]
fn logs_with_equal_or_other_formats_have_the_results_that_they_have_alone() {
    let (kite, other) = ("kite:uint64_t timestamp;bool up;", "kite:uint64_t timestamp;uint8_t up;");
    let gust = "gust:uint64_t timestamp;bool[3] strong;";
    check_together(&[
        log(&[(kite, 9)]),
        log(&[(other, 9)]),
        log(&[(kite, 9), (gust, 11)]),
        log(&[(gust, 11), (kite, 9)]),
        log(&[(kite, 0), (gust, 11)]),
        log(&[("gust:uint64_t timestamp;unknown u;", 11), (kite, 9)]),
    ]);
}

#[test]
fn logs_with_large_plans_have_the_results_that_they_have_alone() {
    // Each of these topics has as many checked values as a plan may have.
    let mut large = vec![("small:bool flag;".to_owned(), 0)];
    large.extend((0..extent(8, 3)).map(|number| (format!("large_{number}:small[5000] all;"), 5_000)));
    let borrowed: Vec<(&str, usize)> = large.iter().map(|(format, size)| (format.as_str(), *size)).collect();
    check_together(&[log(&borrowed), log(&[("kite:uint64_t timestamp;bool up;", 9)])]);
}

//! Reads the folder of a bag: the files that its `metadata.yaml` lists, one after the other.

use std::collections::{BTreeMap, HashMap};
use std::io::{self, Read};
use std::path::Path;

use uavspec_capture::input::{self, FileState};
use uavspec_capture::rosbag::metadata::{self, FILE_NAME, Metadata};
use uavspec_model::text::shown;
use uavspec_model::{Extent, Location};
use uavspec_rules::definitions::{Clues, Shared};

use super::mcap::McapFile;
use super::sqlite::{self, SQLITE};
use super::{BagContent, BagFile, BagSummary, Channels, MCAP, clues};
use crate::limits::MAX_FILES;
use crate::release::MAX_AHEAD;
use crate::{CaptureResult, CheckRun, Reading, Source, Summary, read_start};

/// Reads the declarations in the files of a bag's folder.
pub(crate) fn clues(folder: &Path, shared: &Shared) -> Clues {
    let Ok(Some(metadata)) = Metadata::read(folder) else { return Clues::default() };
    let distribution = Some(metadata.distribution).filter(|name| !name.is_empty());
    let mut clues = Clues { distribution, ..Clues::default() };
    for file in metadata.files.iter().take(MAX_FILES) {
        // The check reports a file that can't be read.
        clues::merge(&mut clues, file_clues(&folder.join(file), shared).unwrap_or_default());
    }
    clues
}

/// The bytes of a bag's file.
struct FileBytes<'p, R> {
    start: Vec<u8>,
    /// All bytes, decompressed, including the start.
    whole: R,
    /// The file that contains these bytes, if there is one.
    file: Option<&'p Path>,
}

fn open<'p>(path: &'p Path, reading: Reading<'_>) -> io::Result<FileBytes<'p, impl Read + use<>>> {
    let file = input::up_to_end(metadata::open(path)?)?;
    let (mut input, is_plain) = input::decompressed(reading(Box::new(file)))?;
    let start = read_start(&mut input)?;
    let whole = io::Cursor::new(start.clone()).chain(input);
    Ok(FileBytes { start, whole, file: is_plain.then_some(path) })
}

/// Reads the declarations in a file of a bag, which may be compressed.
fn file_clues(path: &Path, shared: &Shared) -> io::Result<Clues> {
    let FileBytes { start, mut whole, file } = open(path, &|file| file)?;
    let whole = &mut whole;
    if (MCAP.detect)(&start) {
        return Ok(clues::mcap(&mut Source { bytes: &mut whole.take(MAX_AHEAD), file, copy: None }, shared));
    }
    if !(SQLITE.detect)(&start) {
        return Ok(Clues::default());
    }
    if file.is_some() {
        return Ok(clues::sqlite(&mut Source { bytes: whole, file, copy: None }, shared));
    }
    let (copy, _) = sqlite::copy(whole);
    let file = copy.as_ref().map(sqlite::CopiedFile::path);
    Ok(clues::sqlite(&mut Source { bytes: whole, file, copy: copy.as_ref() }, shared))
}

/// Checks the readable parts of a bag's files. Fails if `metadata.yaml` can't be read.
pub(crate) fn check_folder(
    folder: &Path,
    run: CheckRun<'_>,
    reading: Reading<'_>,
) -> io::Result<CaptureResult> {
    let Some(metadata) = Metadata::read(folder)? else {
        return Ok(CaptureResult::unknown(format!("its {FILE_NAME} isn't the metadata of a rosbag2 bag")));
    };
    let mut bag = Channels::new(run);
    let mut summary = BagSummary {
        storage: metadata.storage,
        distribution: metadata.distribution,
        num_files: metadata.files.len() as u64,
        ..BagSummary::default()
    };
    let is_single = metadata.files.len() == 1;
    let mut bytes = 0;
    for problem in &metadata.problems {
        bag.corruption(FILE_NAME, Location::Byte(0), problem, Extent::WithGaps);
    }
    for file in &metadata.files {
        let before = bag.run.records;
        let part = BagFile { name: if is_single { "" } else { file }, encodings: Some(&metadata.encodings) };
        let path = folder.join(file);
        let state = FileState::of(&path);
        match check_file(&path, part, &mut bag, &mut summary, reading) {
            Ok(read) => bytes += read,
            Err(error) => {
                let text = format!("{file}, which {FILE_NAME} lists, can't be opened: {error}");
                bag.corruption("", Location::Byte(0), &text, Extent::WithGaps);
            }
        }
        if let Some(change) = state.and_then(|state| state.change(&path)) {
            bag.run.cut_short(&format!("{file}: {change}"));
        }
        let (stated, found) = (metadata.file_counts.get(file), bag.run.records - before);
        if !bag.has_gaps() {
            compare(&mut bag, stated.copied(), found, &format!(" in {}", shown(file)));
        }
    }
    let found = bag.run.records;
    if !bag.has_gaps() {
        compare_topics(&mut bag, &metadata.topic_counts);
        compare(&mut bag, metadata.message_count, found, "");
    }
    Ok(bag.finish(bytes, |BagContent { channels, dialects, releases, .. }| {
        Summary::Bag(BagSummary { channels, dialects, releases, ..summary })
    }))
}

/// Compares the number of messages with the number in the metadata. Does nothing if parts of the bag can't be read,
/// because the numbers then differ anyway.
fn compare(bag: &mut Channels<'_>, stated: Option<u64>, found: u64, of: &str) {
    if let Some(stated) = stated.filter(|stated| *stated != found) {
        let text = format!("{FILE_NAME} counts {stated} messages{of}, but there are {found}");
        bag.corruption("", Location::Message(bag.run.records), &text, Extent::WithGaps);
    }
}

/// Compares each topic's number of messages with the number in the metadata.
fn compare_topics(bag: &mut Channels<'_>, stated: &BTreeMap<String, u64>) {
    let mut found: HashMap<&str, u64> = HashMap::new();
    for open in &bag.open {
        *found.entry(&open.identity.topic).or_default() += open.tally.records;
    }
    let pair = |(topic, stated): (&String, &u64)| {
        let topic = topic.escape_debug().to_string();
        let found = found.get(topic.as_str()).copied().unwrap_or_default();
        (found != *stated).then_some((topic, *stated, found))
    };
    let different: Vec<(String, u64, u64)> = stated.iter().filter_map(pair).collect();
    for (topic, stated, found) in different {
        compare(bag, Some(stated), found, &format!(" of {}", shown(&topic)));
    }
}

/// Checks the readable part of a file. Returns the number of bytes read. Fails if the file can't be opened.
fn check_file(
    path: &Path,
    file: BagFile<'_>,
    bag: &mut Channels<'_>,
    summary: &mut BagSummary,
    reading: Reading<'_>,
) -> io::Result<u64> {
    let FileBytes { start, mut whole, file: own } = open(path, reading)?;
    let whole = &mut whole;
    if (MCAP.detect)(&start) {
        return Ok(McapFile::named(file.name).read(bag, whole));
    }
    if !(SQLITE.detect)(&start) {
        bag.corruption(file.name, Location::Byte(0), "neither a SQLite nor an MCAP file", Extent::WithGaps);
        return Ok(0);
    }
    let mut source = Source { bytes: whole, file: own, copy: None };
    let (read, distribution) = sqlite::read_source(&mut source, bag, file);
    if summary.distribution.is_empty() {
        summary.distribution = distribution;
    }
    Ok(read)
}

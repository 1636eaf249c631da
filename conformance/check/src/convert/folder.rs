//! Converts the folder of a bag: the files that its `metadata.yaml` lists, one after the other.

use std::ffi::OsStr;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::Path;

use uavspec_capture::rosbag::metadata::FILE_NAME;
use uavspec_capture::rosbag::{BagContent, FileContent};

use super::bag::{Source, Target, Unpacked};
use super::plan::Converters;
use super::report::{Problems, TopicReport, merged};
use super::{ConversionReport, Error, Format, Output, Plan, Settings, bag, distribution};
use crate::{Opened, OpenedFolder, Reading};

/// The conversion of a folder.
struct Conversion<'c> {
    plan: &'c Plan,
    settings: Settings,
    opened: &'c OpenedFolder,
    converters: Converters<'c>,
    topics: Vec<TopicReport>,
    problems: Problems,
    /// The format of the files in the bag and in the output.
    formats: Option<(Format, Format)>,
}

/// Converts the folder of a bag: to one file with the content of all files, or to a folder, with a file for each file of the
/// bag. `name` is the start of the names of new files. `reading` wraps each file before it is read.
pub fn convert_folder(
    (folder, opened): (&Path, &OpenedFolder),
    plan: &Plan,
    settings: Settings,
    reading: Reading<'_>,
    (name, output): (&str, Output<'_>),
) -> Result<ConversionReport, Error> {
    if settings.format == Some(Format::Log) {
        let reason = "a folder can't be converted to ULog: convert each of its files";
        return Err(Error::Input(reason.to_owned()));
    }
    let mut problems = Problems::default();
    opened.metadata.problems.iter().for_each(|problem| problems.add(format!("{FILE_NAME}: {problem}")));
    let mut conversion = Conversion {
        plan,
        settings,
        opened,
        converters: Converters::default(),
        topics: Vec::new(),
        problems,
        formats: None,
    };
    let named = if opened.metadata.storage == "mcap" { Format::Mcap } else { Format::Sqlite };
    match output {
        Output::Stream(_) | Output::Sqlite(_) => {
            let format = if matches!(output, Output::Stream(_)) { Format::Mcap } else { Format::Sqlite };
            let mut target = Target::new(output, distribution(plan, false));
            conversion.files(folder, reading, Some(format), &mut |conversion, opened, _, found| {
                conversion.file(opened, &mut target, found)
            })?;
            plan.check_hints(&conversion.converters, &mut conversion.problems)?;
            target.finish(&mut conversion.problems)?;
            conversion.formats.get_or_insert((named, format));
        }
        Output::Folder(to) => {
            let (mut files, mut stated) = (Vec::new(), None);
            conversion.files(folder, reading, None, &mut |conversion, opened, format, found| {
                let extension = if format == Format::Mcap { "mcap" } else { "db3" };
                let name = format!("{name}_{}.{extension}", files.len());
                let path = to.join(&name);
                let mut file = BufWriter::new(File::create(&path)?);
                let output = match format {
                    Format::Mcap => Output::Stream(&mut file),
                    _ => Output::Sqlite(&path),
                };
                let mut target = Target::new(output, distribution(plan, false));
                conversion.file(opened, &mut target, found)?;
                stated = Some(target.distribution()).filter(|name| !name.is_empty()).or(stated.take());
                let content = target.finish(found)?;
                file.flush()?;
                files.push(FileContent { name, ..content });
                Ok(())
            })?;
            plan.check_hints(&conversion.converters, &mut conversion.problems)?;
            let (_, format) = *conversion.formats.get_or_insert((named, named));
            let storage = if format == Format::Mcap { "mcap" } else { "sqlite3" };
            let distribution = &stated.unwrap_or_default();
            BagContent { storage, distribution, files: &files }.write(to)?;
        }
    }
    let Conversion { topics, problems, formats, .. } = conversion;
    let formats = formats.unwrap_or((named, named));
    Ok(ConversionReport::new(folder, plan, formats, merged(topics), problems))
}

/// Converts a file that was opened to a format, and adds the problems.
type Convert<'w, 'c> =
    &'w mut dyn FnMut(&mut Conversion<'c>, Opened<'_>, Format, &mut Problems) -> Result<(), Error>;

impl<'c> Conversion<'c> {
    /// Opens all files, and passes them to `convert`. `to` is the format of the output; `None` is the format of the first
    /// file.
    fn files(
        &mut self,
        folder: &Path,
        reading: Reading<'_>,
        to: Option<Format>,
        convert: Convert<'_, 'c>,
    ) -> Result<(), Error> {
        for file in &self.opened.metadata.files {
            let path = folder.join(file);
            let opened = self.opened.open(&path, reading).map_err(|error| error.to_string());
            let opened = opened.and_then(|opened| opened).and_then(|opened| match Format::of(&opened) {
                Ok(format @ (Format::Mcap | Format::Sqlite)) => Ok((opened, format)),
                _ => Err("neither a SQLite nor an MCAP file".to_owned()),
            });
            let (opened, format) = match opened {
                Ok(opened) => opened,
                Err(problem) => {
                    self.problems.add(format!("{file}: {problem}"));
                    continue;
                }
            };
            let (_, to) = *self.formats.get_or_insert((format, to.unwrap_or(format)));
            let state = opened.state;
            let mut found = Problems::default();
            convert(self, opened, to, &mut found)?;
            if let Some(change) = state.and_then(|state| state.change(&path)) {
                found.add(change);
            }
            self.problems.merge(found.of_file(file));
        }
        Ok(())
    }

    /// Converts a file.
    fn file(
        &mut self,
        opened: Opened<'_>,
        target: &mut Target<'_>,
        problems: &mut Problems,
    ) -> Result<(), Error> {
        let Opened { bytes, database, .. } = opened;
        let metadata = &self.opened.metadata;
        target.take_distribution(metadata.distribution.clone());
        let source = Source {
            bytes,
            database: database.as_ref(),
            shared: &self.plan.source().shared,
            encodings: Some(&metadata.encodings),
        };
        let unpacked = if metadata.has_compressed_messages { Unpacked::All } else { Unpacked::Cdr };
        let settings = (self.plan, self.settings, unpacked);
        self.topics.extend(bag::convert(source, settings, target, &mut self.converters, problems)?);
        Ok(())
    }
}

/// The start of the names of the files in a folder: the name of the folder.
pub fn file_names(folder: &Path) -> String {
    folder.file_name().and_then(OsStr::to_str).unwrap_or("bag").to_owned()
}

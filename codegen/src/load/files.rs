//! Finds and reads the files of a plan.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};

use globset::{GlobBuilder, GlobSetBuilder};
use uavspec_dynamic::conversion::Request;
use uavspec_lint::release::{ReleaseText, Releases, age};
use uavspec_schema::diagnostic::Diagnostic;
use uavspec_schema::failure::Failure;
use uavspec_schema::msg::ast::{Element, Item};
use uavspec_schema::msg::{self, Dialect, Kind};
use uavspec_schema::name::package_problem;
use uavspec_schema::path::normalise;
use uavspec_schema::read::PackageInput;
use uavspec_schema::source::{SourceId, SourceMap, Span};
use uavspec_schema::{Form, event, terminal};
use walkdir::WalkDir;

use super::built_in::{self, BuiltIn};
use super::config::{Inputs, Plan, PlannedPackage};
use super::folder::{is_skipped, manifest_name};
use super::located::failure_at;

/// Extensions of pages with tables.
const PAGE_EXTENSIONS: [&str; 5] = ["md", "markdown", "adoc", "asciidoc", "txt"];

/// The maximum number of bytes that are read from a file. A file that is too long for a definition, but within this
/// limit, doesn't prevent reading other files.
const MAX_FILE: u64 = 16 << 20;

/// The files of a plan, as sources.
pub struct Loaded {
    /// The texts.
    pub sources: SourceMap,
    /// The packages, with the files of each.
    pub packages: Vec<PackageInput>,
    /// Diagnostics of sources that can't be read.
    pub diagnostics: Vec<Diagnostic>,
    /// All files that were read.
    pub(crate) files: Vec<PathBuf>,
    /// The file of each source except the configuration file.
    pub paths: BTreeMap<SourceId, PathBuf>,
    /// Translation catalogues, if requested.
    pub catalogues: Vec<SourceId>,
    /// The conversions that the plan requests. Their hints are read if catalogues are requested.
    pub(crate) conversions: Vec<Request>,
    /// The releases of each package, if requested.
    pub(crate) releases: Releases,
    /// The names of built-in packages that definitions refer to.
    pub(crate) built_in: Vec<String>,
    /// The configuration file, to which findings may point.
    pub config: Option<Span>,
}

impl Loaded {
    /// Replaces the texts of some sources. Each diagnostic gets the location in the new texts.
    pub fn set_texts(&mut self, texts: &BTreeMap<SourceId, String>) {
        self.sources = self.sources.with_texts(texts);
        // Excludes the configuration file.
        let has_path = |error: &Diagnostic| self.paths.contains_key(&self.sources.source_of(error.span));
        self.diagnostics = self.sources.errors().filter(has_path).collect();
    }

    /// The packages that some of the sources refer to, but that were not loaded.
    pub fn missing_packages(&self, is_selected: impl Fn(SourceId) -> bool) -> BTreeSet<String> {
        let mut missing = BTreeSet::new();
        for package in &self.packages {
            let sources = package.sources.iter().copied().filter(|id| is_selected(*id)).collect();
            let input = PackageInput::new(&package.name, package.form, sources);
            missing.append(&mut referenced_packages(&self.sources, &input));
        }
        missing.retain(|name| self.packages.iter().all(|package| package.name != *name));
        missing
    }
}

impl Loaded {
    /// The files that were read, and the configuration file of the plan.
    pub(crate) fn inputs<'i>(&'i self, plan: &'i Plan) -> impl Iterator<Item = &'i Path> {
        let config = plan.config.iter().map(|(path, _)| Path::new(path));
        self.files.iter().map(PathBuf::as_path).chain(config)
    }

    /// The sources with paths relative to the current folder, as CI systems expect them, instead of the plan's root.
    pub(crate) fn sources_from_here(&self) -> SourceMap {
        let relative = self.paths.iter().filter(|(_, path)| path.is_relative());
        self.sources.with_paths(relative.map(|(id, path)| (*id, shown(path, Path::new("")))))
    }
}

/// Reads all sources of `plan`, and the referenced ROS 2 packages in neighbouring folders.
pub fn load(plan: &Plan) -> Result<Loaded, Failure> {
    load_into(plan, SourceMap::default())
}

/// Reads all sources of `plan` into `sources`.
pub fn load_into(plan: &Plan, sources: SourceMap) -> Result<Loaded, Failure> {
    let mut loader = loader(plan, sources)?;
    loader.ros_dependencies()?;
    Ok(loader.loaded)
}

/// Reads all sources of `plan`, the translation catalogues, the releases of the packages, and the hints for conversions.
pub fn load_with_catalogues(plan: &Plan) -> Result<Loaded, Failure> {
    let mut loader = loader(plan, SourceMap::default())?;
    loader.releases()?;
    loader.ros_dependencies()?;
    loader.catalogues()?;
    loader.conversions()?;
    Ok(loader.loaded)
}

/// Reads only the sources that `plan` lists, without referenced packages.
pub fn load_named(plan: &Plan) -> Result<Loaded, Failure> {
    Ok(loader(plan, SourceMap::default())?.loaded)
}

fn loader(plan: &Plan, sources: SourceMap) -> Result<Loader<'_>, Failure> {
    let mut loader = Loader {
        plan,
        loaded: Loaded {
            sources,
            packages: Vec::new(),
            diagnostics: Vec::new(),
            files: Vec::new(),
            paths: BTreeMap::new(),
            catalogues: Vec::new(),
            conversions: Vec::new(),
            releases: Releases::new(),
            built_in: Vec::new(),
            config: None,
        },
        folders: BTreeMap::new(),
    };
    let config = match &plan.config {
        Some((path, text)) => loader.loaded.sources.add(path.clone(), text.clone().into_bytes()).ok(),
        None => None,
    };
    loader.loaded.config = config.map(|config| loader.loaded.sources.span(config));
    for package in &plan.packages {
        let files = files_of(package)?;
        let select = package.select.as_ref().map(|names| {
            let place = loader.loaded.config.unwrap_or_default();
            names.iter().map(|(name, range)| (name.clone(), place.part(range.clone()))).collect::<Vec<_>>()
        });
        loader.package(package, select.as_deref(), files)?;
    }
    Ok(loader)
}

struct Loader<'p> {
    plan: &'p Plan,
    loaded: Loaded,
    /// The folder of each ROS 2 package, by the name of the package. The folder contains the folder `msg`.
    folders: BTreeMap<String, PathBuf>,
}

impl Loader<'_> {
    fn package(
        &mut self,
        package: &PlannedPackage,
        select: Option<&[(String, Span)]>,
        files: Vec<PathBuf>,
    ) -> Result<(), Failure> {
        let input = |name: String, sources| PackageInput {
            name,
            form: package.form,
            ros_package: package.ros_package.clone(),
            origin: package.origin.clone(),
            revision: package.revision.clone(),
            select: select.map(<[_]>::to_vec),
            sources,
        };
        for (name, files) in self.by_package(package, files) {
            self.check_name(package, &name)?;
            let sources = self.read_all(&files)?;
            self.loaded.packages.push(input(name, sources));
        }
        Ok(())
    }

    /// Checks that a package can have this name, which becomes the name of folders and modules.
    fn check_name(&self, package: &PlannedPackage, name: &str) -> Result<(), Failure> {
        let packages = &self.loaded.packages;
        let other = packages.iter().find(|other| other.name.eq_ignore_ascii_case(name));
        let clash = other.map(|other| {
            let message = if other.name == name {
                format!("two packages are named `{name}`")
            } else {
                format!("the package names `{}` and `{name}` differ in case only", other.name)
            };
            (message, "choose a different name for one of them".to_owned())
        });
        let Some((message, hint)) = package_problem(name).or(clash) else { return Ok(()) };
        let failure = match (&self.plan.config, &package.name_range) {
            (Some((path, text)), Some(range)) => failure_at(path, text, range.clone(), &message),
            _ => Failure::new(message),
        };
        Err(failure.with_hint(hint))
    }

    /// Groups files by ROS package. ROS stores a package's files in `package/msg`. If the inputs span several package
    /// folders, each folder is a package; otherwise all files belong to the configured package.
    fn by_package(&mut self, package: &PlannedPackage, files: Vec<PathBuf>) -> Vec<(String, Vec<PathBuf>)> {
        if package.form != Form::Msg(Dialect::Ros2) {
            return vec![(package.name.clone(), files)];
        }
        let mut by_name: BTreeMap<Option<String>, Vec<PathBuf>> = BTreeMap::new();
        for file in files {
            by_name.entry(ros_package_of(&file).map(|(name, _)| name)).or_default().push(file);
        }
        let is_single = by_name.len() == 1;
        by_name
            .into_iter()
            .map(|(name, files)| {
                let name = if is_single {
                    package.name.clone()
                } else {
                    name.unwrap_or_else(|| package.name.clone())
                };
                if let Some((_, folder)) = files.first().and_then(|file| ros_package_of(file)) {
                    self.folders.insert(name.clone(), folder);
                }
                (name, files)
            })
            .collect()
    }

    fn read_all(&mut self, files: &[PathBuf]) -> Result<Vec<SourceId>, Failure> {
        let mut sources = Vec::with_capacity(files.len());
        for path in files {
            let bytes = match self.plan.open.get(path) {
                Some(text) => text.clone().into_bytes(),
                None => read(path).map_err(|error| unreadable(path, &error))?,
            };
            self.loaded.files.push(path.clone());
            let text = text_of(bytes).map_err(|error| unreadable(path, &error))?;
            match self.loaded.sources.add(self.shown(path), text) {
                Ok(id) => {
                    self.loaded.paths.insert(id, path.clone());
                    sources.push(id);
                }
                Err(diagnostic) => {
                    let id = self.loaded.sources.source_of(diagnostic.span);
                    self.loaded.paths.insert(id, path.clone());
                    self.loaded.diagnostics.push(diagnostic);
                }
            }
        }
        Ok(sources)
    }

    /// Reads the catalogues, if any exist.
    fn catalogues(&mut self) -> Result<(), Failure> {
        let (folder, patterns) = &self.plan.catalogues;
        let mut files = Vec::new();
        for pattern in patterns {
            files.append(&mut matching(folder, pattern, is_catalogue)?);
        }
        files.sort();
        files.dedup();
        self.loaded.catalogues = self.read_all(&files)?;
        Ok(())
    }

    /// Reads the hints of conversions. A file that several conversions share is read once.
    fn conversions(&mut self) -> Result<(), Failure> {
        let plan = self.plan;
        let mut read: BTreeMap<&Path, Option<SourceId>> = BTreeMap::new();
        for path in plan.conversions.iter().filter_map(|conversion| conversion.hints.as_deref()) {
            if !read.contains_key(path) {
                let found = self.read_all(&[path.to_path_buf()])?;
                read.insert(path, found.first().copied());
            }
        }
        let requests = plan.conversions.iter().map(|conversion| Request {
            from: conversion.from.clone(),
            to: conversion.to.clone(),
            hints: conversion.hints.as_deref().and_then(|path| *read.get(path)?),
        });
        self.loaded.conversions = requests.collect();
        Ok(())
    }

    /// Reads the releases of the packages.
    fn releases(&mut self) -> Result<(), Failure> {
        for package in &self.plan.packages {
            let Some(folder) = &package.releases else { continue };
            let (mut files, mut releases) = (releases_in(folder)?, Vec::new());
            for path in &files {
                let text = fs::read_to_string(path).map_err(|error| unreadable(path, &error))?;
                releases.push(ReleaseText { name: release_name(path), text });
            }
            self.loaded.files.append(&mut files);
            self.loaded.releases.insert(package.name.clone(), releases);
        }
        Ok(())
    }

    /// A path as displayed in diagnostics and output.
    fn shown(&self, path: &Path) -> String {
        let path = shown(path, &self.plan.root);
        self.plan.revision.as_ref().map_or_else(|| path.clone(), |revision| format!("{revision}:{path}"))
    }

    /// Reads referenced packages from neighbouring folders, until no more are found, and adds built-in packages. Only
    /// the referenced messages of these packages appear in the output.
    fn ros_dependencies(&mut self) -> Result<(), Failure> {
        self.neighbours()?;
        let loaded = &self.loaded;
        let of_package = |package| referenced_packages(&loaded.sources, package);
        let referenced: BTreeSet<String> = loaded.packages.iter().flat_map(of_package).collect();
        let known: BTreeSet<String> =
            loaded.packages.iter().map(|package| package.name.to_ascii_lowercase()).collect();
        let plan = self.plan;
        let is_ros = |package: &PlannedPackage| package.form == Form::Msg(Dialect::Ros2);
        let is_all = plan.built_in == BuiltIn::All && plan.packages.iter().any(is_ros);
        if referenced.is_subset(&known) && !is_all {
            return Ok(());
        }
        let mut packages = built_in::ros_packages(plan.built_in, &mut self.loaded.sources);
        packages.retain(|package| !known.contains(&package.name));
        let is_used = |name: &&String| is_all || referenced.contains(*name);
        let names = packages.iter().map(|package| &package.name).filter(is_used);
        self.loaded.built_in = names.cloned().collect();
        if !self.loaded.built_in.is_empty() {
            self.loaded.packages.append(&mut packages);
        }
        Ok(())
    }

    fn neighbours(&mut self) -> Result<(), Failure> {
        let mut tried: BTreeSet<String> =
            self.loaded.packages.iter().map(|package| package.name.clone()).collect();
        let mut from = 0;
        while from < self.loaded.packages.len() {
            let package = &self.loaded.packages[from];
            let missing: Vec<String> = referenced_packages(&self.loaded.sources, package)
                .into_iter()
                .filter(|name| !tried.contains(name))
                .collect();
            let parent =
                self.folders.get(&package.name).and_then(|folder| folder.parent()).map(Path::to_path_buf);
            from += 1;
            let Some(parent) = parent else { continue };
            for name in missing {
                let folder = parent.join(&name);
                let messages = folder.join(Kind::Message.name());
                if !messages.is_dir() {
                    continue;
                }
                let sources = self.read_all(&files_below(&messages, Form::Msg(Dialect::Ros2))?)?;
                self.folders.insert(name.clone(), folder);
                tried.insert(name.clone());
                let dependency = PackageInput::new(name, Form::Msg(Dialect::Ros2), sources);
                self.loaded.packages.push(PackageInput { select: Some(Vec::new()), ..dependency });
            }
        }
        Ok(())
    }
}

/// The packages that the definitions of a ROS 2 package refer to.
fn referenced_packages(sources: &SourceMap, package: &PackageInput) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    if package.form != Form::Msg(Dialect::Ros2) {
        return found;
    }
    for id in &package.sources {
        let Some(kind) = Kind::of(sources.path(*id)) else { continue };
        let (definition, _) = msg::parse(sources, *id, kind, Dialect::Ros2);
        for line in definition.parts.iter().flat_map(|part| &part.lines) {
            let Some(Item::Field(field)) = line.item.as_deref() else { continue };
            match field.ty.element {
                Element::Message { package: Some(package), .. } => {
                    found.insert(package.to_owned());
                }
                Element::Message { package: None, name: "Header" } => {
                    found.insert("std_msgs".to_owned());
                }
                Element::Message { package: None, name: "time" | "duration" } => {
                    found.insert("builtin_interfaces".to_owned());
                }
                Element::Message { .. } | Element::Scalar(_) | Element::String { .. } => {}
            }
        }
    }
    found
}

/// Name and folder of the ROS package that contains `file`, if the file's folder is `msg`, `srv` or `action`.
pub(super) fn ros_package_of(file: &Path) -> Option<(String, PathBuf)> {
    let kind_folder = file.parent()?;
    if !matches!(kind_folder.file_name()?.to_str()?, "msg" | "srv" | "action") {
        return None;
    }
    let folder = kind_folder.parent()?;
    // Make the path absolute, because a relative path such as `msg/A.msg` may have no further parent.
    let absolute = std::path::absolute(folder).ok()?;
    let name = manifest_name(&absolute);
    Some((name.or_else(|| Some(absolute.file_name()?.to_str()?.to_owned()))?, absolute))
}

fn files_of(package: &PlannedPackage) -> Result<Vec<PathBuf>, Failure> {
    let mut files = match &package.inputs {
        Inputs::Paths(paths) => {
            let mut files = Vec::new();
            for path in paths {
                files.append(&mut files_at(path, package.form)?);
            }
            files
        }
        Inputs::Patterns { folder, patterns } => files_matching(folder, patterns, package)?,
        Inputs::Files(files) => files.clone(),
    };
    files.sort();
    files.dedup();
    Ok(without_generated(files))
}

/// Removes messages that ROS 2 generates from services and actions: installed packages contain `Reel_Request.msg` next to
/// `Reel.srv`.
fn without_generated(files: Vec<PathBuf>) -> Vec<PathBuf> {
    let known: BTreeSet<&PathBuf> = files.iter().collect();
    let is_generated = |path: &PathBuf| {
        let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
        [Kind::Service, Kind::Action].into_iter().any(|kind| {
            let mut stems = kind.part_suffixes().iter().filter_map(|suffix| stem.strip_suffix(suffix));
            stems.any(|stem| known.contains(&path.with_file_name(format!("{stem}.{}", kind.name()))))
        })
    };
    let generated: Vec<bool> = files.iter().map(is_generated).collect();
    files.into_iter().zip(generated).filter(|(_, is_generated)| !is_generated).map(|(path, _)| path).collect()
}

/// The `.msg`, `.srv` and `.action` files at a path.
pub(super) fn definitions_at(path: &Path) -> Result<Vec<PathBuf>, Failure> {
    files_at(path, Form::Msg(Dialect::Px4))
}

/// The file at `path`, or all definitions below it if `path` is a folder.
fn files_at(path: &Path, form: Form) -> Result<Vec<PathBuf>, Failure> {
    let metadata = fs::metadata(path).map_err(|error| unreadable(path, &error))?;
    if metadata.is_dir() {
        let files = files_below(path, form)?;
        if files.is_empty() {
            return Err(Failure::new(format!("no definitions in {}", terminal::path(path)))
                .with_hint(expected_files(form)));
        }
        return Ok(files);
    }
    if !is_definition(path, form) {
        return Err(Failure::new(format!("{} is not a definition of this dialect", terminal::path(path)))
            .with_hint(expected_files(form)));
    }
    Ok(vec![path.to_path_buf()])
}

fn expected_files(form: Form) -> String {
    match form {
        Form::Msg(dialect) => {
            format!("definitions of the {dialect} dialect are .msg, .srv and .action files")
        }
        Form::Table => format!("pages with tables have the extension .{}", PAGE_EXTENSIONS.join(", .")),
        Form::Events => "event metadata has the extension .json or .json.xz".to_owned(),
    }
}

/// True if a file of this name may be a definition of this form.
pub fn is_definition(path: &Path, form: Form) -> bool {
    let Some(extension) = path.extension().and_then(|extension| extension.to_str()) else { return false };
    match form {
        Form::Msg(_) => Kind::of(&format!(".{extension}")).is_some(),
        Form::Table => PAGE_EXTENSIONS.contains(&extension),
        Form::Events => extension == "json" || is_compressed(path),
    }
}

/// Reads a file, unless it is much too long for a definition.
fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(MAX_FILE + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MAX_FILE {
        return Err(io::Error::other(format!(
            "longer than {MAX_FILE} bytes; check that this file is a definition"
        )));
    }
    Ok(bytes)
}

/// The text of a file, which may be compressed.
fn text_of(bytes: Vec<u8>) -> io::Result<Vec<u8>> {
    if event::is_compressed(&bytes) { event::decompress(&bytes) } else { Ok(bytes) }
}

/// True for event metadata as PX4's build writes it.
fn is_compressed(path: &Path) -> bool {
    path.to_string_lossy().ends_with(".json.xz")
}

fn is_catalogue(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "po")
}

fn files_below(folder: &Path, form: Form) -> Result<Vec<PathBuf>, Failure> {
    search(folder, |path| is_definition(path, form))
}

/// The releases in a folder, from the oldest to the newest: one `.msg` file for each release.
fn releases_in(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let entries = fs::read_dir(folder).map_err(|error| unreadable(folder, &error))?;
    let paths = entries.map(|entry| entry.map(|entry| entry.path()));
    let paths: Vec<PathBuf> = paths.collect::<Result<_, _>>().map_err(|error| unreadable(folder, &error))?;
    let is_release = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "msg");
    let mut files: Vec<PathBuf> = paths.into_iter().filter(is_release).collect();
    if files.is_empty() {
        return Err(Failure::new(format!("no releases in {}", terminal::path(folder))).with_hint(
            "a release is a file such as 1.16.msg, which contains all definitions of the release",
        ));
    }
    files.sort_by_cached_key(|path| age(&release_name(path)));
    Ok(files)
}

/// The name of a release: the name of its file without the extension.
fn release_name(path: &Path) -> String {
    path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default()
}

fn search(folder: &Path, is_match: impl Fn(&Path) -> bool) -> Result<Vec<PathBuf>, Failure> {
    let mut files = Vec::new();
    let entries = WalkDir::new(folder).follow_links(true).sort_by_file_name().into_iter();
    for entry in entries.filter_entry(|entry| entry.depth() == 0 || !is_skipped(entry)) {
        let entry = entry.map_err(|error| Failure::new(error.to_string()))?;
        if entry.file_type().is_file() && is_match(entry.path()) {
            files.push(entry.into_path());
        }
    }
    Ok(files)
}

fn files_matching(
    folder: &Path,
    patterns: &[String],
    package: &PlannedPackage,
) -> Result<Vec<PathBuf>, Failure> {
    let mut files = Vec::new();
    for pattern in patterns {
        let mut matching = matching(folder, pattern, |path| is_definition(path, package.form))?;
        if matching.is_empty() {
            let message = format!(
                "package {}: `{pattern}` matches no file in {}",
                package.name,
                terminal::path(or_current(folder))
            );
            return Err(Failure::new(message).with_hint(expected_files(package.form)));
        }
        files.append(&mut matching);
    }
    if files.is_empty() {
        let message = format!("package {} has an empty `include`", package.name);
        return Err(Failure::new(message).with_hint("add a pattern such as \"msg/**/*.msg\""));
    }
    Ok(files)
}

/// The files in a folder that match a pattern.
fn matching(folder: &Path, pattern: &str, is_match: impl Fn(&Path) -> bool) -> Result<Vec<PathBuf>, Failure> {
    let (base, rest) = literal_base(pattern);
    let bad = |error: globset::Error| Failure::new(format!("invalid pattern `{pattern}`: {}", error.kind()));
    let glob = GlobBuilder::new(&rest).literal_separator(true).build().map_err(bad)?;
    let set = GlobSetBuilder::new().add(glob).build().map_err(bad)?;
    let base = normalise(&folder.join(base));
    if base.is_file() && rest.is_empty() {
        return Ok(vec![base]);
    }
    let searched = or_current(&base);
    if !searched.is_dir() {
        return Ok(Vec::new());
    }
    let files = search(searched, is_match)?;
    let paths = files.iter().filter_map(|file| file.strip_prefix(searched).ok());
    Ok(paths.filter(|path| set.is_match(path)).map(|path| base.join(path)).collect())
}

/// The path of a folder, with `.` instead of an empty path.
fn or_current(folder: &Path) -> &Path {
    if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
}

/// Splits a pattern before its first component with a wildcard. The part before the split is the folder to search.
pub fn literal_base(pattern: &str) -> (String, String) {
    let parts: Vec<&str> = pattern.split('/').collect();
    let literal = parts.iter().take_while(|part| !part.contains(['*', '?', '[', '{'])).count();
    (parts[..literal].join("/"), parts[literal..].join("/"))
}

fn unreadable(path: &Path, error: &std::io::Error) -> Failure {
    let failure = Failure::new(format!("{}: {error}", terminal::path(path)));
    match error.kind() {
        ErrorKind::NotFound => failure.with_hint("check the path, which is relative to the current folder"),
        _ => failure,
    }
}

/// A path as displayed in diagnostics and output: relative to the root, with `/` on every system.
fn shown(path: &Path, root: &Path) -> String {
    let path = path.strip_prefix(root).unwrap_or(path);
    let parts: Vec<_> = path.components().map(|part| part.as_os_str().to_string_lossy()).collect();
    terminal::shown(&parts.join("/").replace("//", "/"))
}

//! Takes the pictures of the README: screenshots of pages in `xtask/site`, in both colour schemes.

use std::env;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use clap::Args;
use sha2::{Digest as _, Sha256};

use crate::command::{found, output};
use crate::paths::repository;

/// Arguments of `pictures`.
#[derive(Args)]
pub(crate) struct Arguments {
    /// Only check that the pictures show the current pages; requires no browser
    #[arg(long)]
    check: bool,
}

/// The pages, each with the size of the pictures in CSS pixels.
const PAGES: [(&str, &str); 2] = [("flight", "960,1180"), ("report", "960,900")];

/// The colour schemes, each with its number in Chromium.
const SCHEMES: [(&str, u8); 2] = [("dark", 0), ("light", 1)];

/// The folder of the pages.
const SITE: &str = "xtask/site";

/// The hash of the page in each picture. Different browsers draw a page differently, so pictures can't be compared.
const HASHES: &str = "xtask/site/pictures/pages.txt";

/// Takes the pictures. With `--check`, returns false if the pictures show old pages.
pub(crate) fn run(arguments: &Arguments) -> Result<bool, String> {
    let root = repository();
    let hashes = hashes(root)?;
    if arguments.check {
        let is_current = fs::read_to_string(root.join(HASHES)).is_ok_and(|known| known == hashes);
        if !is_current {
            eprintln!("the pictures of the README show old pages: run `cargo xtask pictures`");
        }
        return Ok(is_current);
    }
    let browser = browser()?;
    // Create the folder, because Chromium doesn't.
    let folder = root.join(SITE).join("pictures");
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    for (page, size) in PAGES {
        for (scheme, number) in SCHEMES {
            let picture = format!("{SITE}/pictures/{page}-{scheme}.png");
            take(
                &browser,
                &root.join(SITE).join(format!("{page}.html")),
                &root.join(&picture),
                size,
                number,
            )?;
            println!("{picture}");
        }
    }
    fs::write(root.join(HASHES), hashes).map_err(|error| format!("{HASHES}: {error}"))?;
    Ok(true)
}

/// A line for each page: its hash and its name.
fn hashes(root: &Path) -> Result<String, String> {
    let mut lines = String::new();
    for (page, _) in PAGES {
        let path = root.join(SITE).join(format!("{page}.html"));
        let text = fs::read(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        let hash = data_encoding::HEXLOWER.encode(&Sha256::digest(text));
        // Writing to a string can't fail.
        let _ = writeln!(lines, "{hash}  {page}.html");
    }
    Ok(lines)
}

fn browser() -> Result<String, String> {
    let known = ["chromium-headless-shell", "chromium", "google-chrome"];
    let named = env::var("UAVSPEC_CHROMIUM").ok();
    let browser = named.or_else(|| known.into_iter().find(|name| found(name)).map(str::to_owned));
    browser.ok_or_else(|| "no Chromium: install it, or set UAVSPEC_CHROMIUM to its path".to_owned())
}

fn take(browser: &str, page: &Path, picture: &Path, size: &str, scheme: u8) -> Result<(), String> {
    // The page is our own, so it needs no sandbox, which containers often lack.
    let mut command = Command::new(browser);
    command.args(["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--no-first-run"]);
    command.args(["--disable-background-networking", "--force-device-scale-factor=1.5"]);
    command.arg(format!("--blink-settings=preferredColorScheme={scheme}"));
    command.arg(format!("--window-size={size}"));
    command.arg(format!("--screenshot={}", picture.display()));
    command.arg(format!("file://{}", page.display()));
    output(&mut command).map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pictures_show_the_current_pages() {
        assert_eq!(run(&Arguments { check: true }), Ok(true));
        let folder = repository().join(SITE).join("pictures");
        for (page, _) in PAGES {
            for (scheme, _) in SCHEMES {
                let picture = fs::read(folder.join(format!("{page}-{scheme}.png"))).expect("a picture");
                assert!(picture.starts_with(b"\x89PNG") && picture.len() < 400_000, "{page} {scheme}");
            }
        }
    }
}

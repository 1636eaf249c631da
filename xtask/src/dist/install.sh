#!/bin/sh
# Installs uavspec from the archives of `cargo xtask dist`, without root privileges.
set -eu

usage() {
  cat <<'END'
Install uavspec with its man pages and completions

Usage: sh install.sh [--from FOLDER] [--prefix FOLDER]

  --from FOLDER    folder with the archives and SHA256SUMS, a path or an
                   https:// URL [default: $UAVSPEC_RELEASE]
  --prefix FOLDER  folder to install to [default: $HOME/.local]
  --help           print this text

Example: sh install.sh --from target/dist --prefix ~/tools

Requires tar, sha256sum or shasum, and for a URL, curl or GNU wget.
Exit status: 0 for success, 1 for an error.
END
}

fail() {
  printf 'error: %s\n' "$1" >&2
  [ $# -lt 2 ] || printf '  help: %s\n' "$2" >&2
  exit 1
}

has() { command -v "$1" >/dev/null 2>&1; }

# The target of the program for this machine, as in the names of the archives.
machine() {
  case "$(uname -s) $(uname -m)" in
    'Linux x86_64') echo x86_64-unknown-linux-musl ;;
    'Linux aarch64' | 'Linux arm64') echo aarch64-unknown-linux-musl ;;
    'Darwin x86_64') echo x86_64-apple-darwin ;;
    'Darwin arm64') echo aarch64-apple-darwin ;;
    *) fail "this script doesn't support $(uname -s) on $(uname -m)" 'build uavspec from its source, as its README describes' ;;
  esac
}

# Copies a file of the release. Without certificates, as with wget of BusyBox, anyone on the way could change both the archive
# and its checksum.
fetch() {
  case $release in
    https://*)
      if has curl; then
        curl --fail --silent --show-error --location --proto =https --retry 3 --output "$1" "$release/$1"
      elif wget --version 2>/dev/null | grep -q GNU; then
        wget --no-verbose --tries=3 --output-document="$1" "$release/$1"
      else
        fail 'neither curl nor GNU wget is installed' 'install curl, or download the files and use --from FOLDER'
      fi
      ;;
    *) cp "$release/$1" "$1" ;;
  esac || fail "cannot read $release/$1" 'check the folder or URL of --from'
}

checksum() {
  if has sha256sum; then sha256sum; else shasum -a 256; fi <"$1" | cut -d ' ' -f 1
}

# The shell runs nothing of a script that was downloaded in part, because the call is in the last line.
main() {
  release=${UAVSPEC_RELEASE-} prefix=${HOME:+$HOME/.local}
  while [ $# -gt 0 ]; do
    case $1 in
      --help | -h) usage && exit ;;
      --from | --prefix) [ "${2:-}" ] || fail "$1 requires a value" ;;
      *) fail "unknown argument: $1" 'run this script with --help' ;;
    esac
    if [ "$1" = --from ]; then release=$2; else prefix=$2; fi
    shift 2
  done
  release=${release#file://}
  case $release in
    '') fail 'the address of the release is unknown' 'set it with --from, for example --from target/dist' ;;
    https://* | /*) ;;
    *://*) fail "$release: expected a path or an https:// URL" ;;
    *) release=$PWD/$release ;;
  esac
  case $prefix in
    '') fail 'HOME is not set' 'choose a folder with --prefix' ;;
    /*) ;;
    *) prefix=$PWD/$prefix ;;
  esac
  target=$(machine)
  has tar || fail 'tar is not installed'
  has sha256sum || has shasum || fail 'neither sha256sum nor shasum is installed'

  # The temporary folder is in the prefix, so that files are moved and never copied: each is complete or absent.
  stage=$prefix/.uavspec.$$
  { mkdir -p "$prefix" && mkdir "$stage"; } || fail "cannot write to $prefix" 'choose another folder with --prefix'
  trap 'rm -rf "$stage"' EXIT
  trap 'exit 130' HUP INT TERM
  cd "$stage"

  fetch SHA256SUMS
  entry=$(sed -n "\\|^[0-9a-f]\{64\}  uavspec-[^ /]*-$target\.tar\.gz\$|{p;q;}" SHA256SUMS)
  [ "$entry" ] || fail "$release/SHA256SUMS lists no archive for $target"
  archive=${entry##* }
  echo "Reading $release/$archive"
  fetch "$archive"
  found=$(checksum "$archive")
  [ "$found" = "${entry%% *}" ] || fail "$archive: expected SHA-256 ${entry%% *}, found $found" \
    'the file is incomplete or was changed: try again'
  tar -xzf "$archive" || fail "cannot unpack $archive"
  cd "${archive%.tar.gz}"
  version=$(./uavspec --version) || fail 'the program does not run on this machine'

  share=$prefix/share
  for folder in "$prefix/bin" "$share/man/man1" "$share/bash-completion/completions" \
    "$share/fish/vendor_completions.d" "$share/zsh/site-functions" "$share/doc/uavspec"; do
    { mkdir -p "$folder" && [ -w "$folder" ]; } || fail "cannot write to $folder" 'choose another folder with --prefix'
  done
  mv -f man/man1/* "$share/man/man1"
  mv -f completions/uavspec.bash "$share/bash-completion/completions/uavspec"
  mv -f completions/uavspec.fish "$share/fish/vendor_completions.d"
  mv -f completions/_uavspec "$share/zsh/site-functions"
  mv -f LICENSE-* ./*-LICENSES.* "$share/doc/uavspec"
  mv -f uavspec "$prefix/bin"

  echo "Installed $version:"
  echo "  program                         $prefix/bin/uavspec"
  echo "  man pages                       $share/man/man1"
  echo "  completions (bash, fish, zsh)   $share"
  echo "  licences                        $share/doc/uavspec"
  if [ "$(command -v uavspec)" != "$prefix/bin/uavspec" ]; then
    printf 'Put the program first in PATH, in the profile of your shell:\n'
    printf "  export PATH=\"%s:\$PATH\"\n" "$prefix/bin"
  fi
  case ${SHELL-} in
    */zsh) printf 'Add the completions to ~/.zshrc, before compinit:\n  fpath+=("%s")\n' "$share/zsh/site-functions" ;;
  esac
}

main "$@"

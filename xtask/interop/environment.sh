#!/bin/sh
# Installs what an adapter requires, and runs it:
#
#   environment.sh install ENVIRONMENT ADAPTER
#   environment.sh run ENVIRONMENT ADAPTER JOBS FOLDER
#
# `install` requires no root: it writes to target/interop/ENVIRONMENT. If the adapter can't run, it prints the reason to
# standard output and fails. If `NO_INSTALL` is set, it installs and compiles nothing.
set -eu
action=$1 environment=$2 adapter=$3
shift 3
source=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$source/../../target/interop/$environment"
cd "$source/../../target/interop/$environment"
target=$PWD

fail() {
  echo "$1"
  exit 1
}

# Runs an installation command, unless it has succeeded for the current content of a lock file. A copy of this file, the
# mark, is in what the command installs.
once() {
  lock=$1 mark=$2
  shift 2
  if cmp -s "$lock" "$mark"; then return; fi
  if [ -n "${NO_INSTALL:-}" ]; then fail "the packages for $lock are not installed"; fi
  echo "interop: installing packages for $lock" >&2
  "$@" >log.txt 2>&1 || { cat log.txt >&2; fail "$1 failed"; }
  cp "$lock" "$mark"
}

install_python() {
  python3 -m venv --clear venv &&
    venv/bin/python -m pip install --quiet --disable-pip-version-check --requirement "$source/python/requirements.txt"
}

case $action-$environment in
  install-node)
    node --version >/dev/null || fail 'requires Node 20 or later'
    npm --version >/dev/null || fail 'requires npm'
    # Node looks for packages next to the adapters.
    (cd "$source/node" && cp -R .npmrc ./*.js* generators validators "$target")
    once package-lock.json node_modules/installed npm ci --no-audit --no-fund --ignore-scripts --omit=optional
    ;;
  run-node) exec node "$adapter" "$@" ;;
  install-python) once "$source/python/requirements.txt" venv/installed install_python ;;
  run-python)
    # Adapters have the same names as the packages that they import, so their folder must not be searched first.
    export PYTHONPATH="$source/python" PYTHONSAFEPATH=1 PYTHONDONTWRITEBYTECODE=1
    exec venv/bin/python "$source/python/$adapter" "$@"
    ;;
  install-rust)
    if [ -z "${NO_INSTALL:-}" ]; then
      echo "interop: compiling $adapter" >&2
      "${CARGO:-cargo}" build --quiet --locked --package "$adapter" --manifest-path "$source/rust/Cargo.toml" --target-dir . ||
        fail "$adapter doesn't compile"
    fi
    [ -x "debug/$adapter" ] || fail 'not compiled'
    ;;
  run-rust) exec "debug/$adapter" "$@" ;;
  install-cpp)
    g++ -fsyntax-only -x c++ -include valijson/schema.hpp -include nlohmann/json.hpp /dev/null 2>/dev/null ||
      fail 'requires g++, libvalijson-dev and nlohmann-json3-dev'
    version=$(dpkg-query --show --showformat '${Version}' libvalijson-dev || echo unknown)
    once "$source/cpp/$adapter" "$adapter" g++ -O1 -std=c++17 -DVALIJSON_USE_EXCEPTIONS=1 \
      "-DVALIJSON_VERSION=\"$version\"" -o "$adapter.out" "$source/cpp/$adapter"
    ;;
  run-cpp) exec "./$adapter.out" "$@" ;;
  install-perl) perl -MJSON::Validator -e 1 2>/dev/null || fail 'requires libjson-validator-perl' ;;
  run-perl) exec perl "$source/perl/$adapter" "$@" ;;
  *) fail "unknown environment: $environment" ;;
esac

#!/usr/bin/env bash
# Installs what the build needs and builds a Debian package for the release that it runs on.
#   make_deb.sh [FOLDER]      FOLDER: of the package; default: the current one
# MLIC_BUILD: build directory of its own (default: build-deb in the repository).
set -euo pipefail
. "$(dirname "$0")/environment.sh"

folder=$(realpath -m -- "${1:-.}")
build=${MLIC_BUILD:-$repository/build-deb}
"$repository/scripts/install_dependencies.sh"
build_mlic -DBUILD_TESTING=OFF -DCATKIN_BUILD_BINARY_PACKAGE=ON -DCMAKE_INSTALL_PREFIX=/usr
cmake -E chdir "$build" cpack
rm -rf "$build/_CPack_Packages"  # with its second calibrate.launch below the repository roslaunch would start neither
mkdir -p "$folder"
cp "$build"/*.deb "$folder"

#!/usr/bin/env bash
# Installs what MLIC needs to build, run and be tested, from Debian's own packages (12; also 11 and 13).
#   install_dependencies.sh [--dry-run] [--with-learned]
# --dry-run prints what would be done. --with-learned adds what runs learned matchers (docs/learned_matcher.md).
# Does nothing, and says nothing, when all is there. Uses sudo when not root.
set -euo pipefail
export LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive

dry_run=false
with_learned=false
for argument in "$@"; do
  case "$argument" in
    --dry-run) dry_run=true ;;
    --with-learned) with_learned=true ;;
    *) sed -n '2,5p' "$0" >&2; exit 1 ;;
  esac
done

command -v apt-get >/dev/null || {
  echo "install_dependencies.sh: no apt-get here; MLIC installs on Debian 11 to 13, elsewhere install the packages listed in $0" >&2
  exit 1
}

required=(
  # toolchain
  g++ cmake ninja-build git ca-certificates
  # ROS 1: build (the .msg files are in ros-*-msgs)
  catkin libroscpp-dev librosbag-dev libtf2-dev libtf2-ros-dev libtf2-msgs-dev libcv-bridge-dev libpcl-conversions-dev
  ros-message-generation ros-message-runtime ros-std-msgs ros-geometry-msgs ros-sensor-msgs ros-nav-msgs
  ros-visualization-msgs ros-tf2-msgs ros-actionlib-msgs
  libstd-msgs-dev libstd-srvs-dev libgeometry-msgs-dev libsensor-msgs-dev libnav-msgs-dev libvisualization-msgs-dev
  # ROS 1: run (tf2-tools holds static_transform_publisher) and test
  python3-roslaunch python3-rosbag rosbash tf2-tools liburdfdom-tools librostest-dev python3-rostest
  python3-rospy python3-std-msgs python3-std-srvs python3-geometry-msgs python3-sensor-msgs python3-nav-msgs
  python3-visualization-msgs python3-tf2-msgs python3-yaml
  # mathematics, files, command line
  libeigen3-dev libceres-dev libopenblas-dev libtbb-dev libboost-dev libyaml-cpp-dev libcli11-dev libspdlog-dev
  libxml2-dev robin-map-dev libembree-dev
  # images, point clouds, structure from motion
  libopencv-dev libpcl-dev colmap libsqlite3-dev
  # tests
  libgtest-dev
)
# Each is left out with a line of explanation where a suite lacks it.
declare -A optional=(
  [ccache]="repeated builds take longer"
  [catkin-lint]="the check of package.xml by catkin_lint is skipped"
  [catkin-tools]="no 'catkin build'; catkin_make and plain cmake work"
  [clang-format-14]="the formatting check is skipped"
  [clang-tidy]="continuous integration skips clang-tidy"
  [libbenchmark-dev]="no benchmarks"
  [dpkg-dev]="no scripts/make_deb.sh"
  [file]="no scripts/make_deb.sh"
  [libopengv-dev]="no comparison with OpenGV among the benchmarks"
  [libjs-three]="reports draw the rig from above and from the side instead of turnable"
  [rviz]="no RViz: calibrate.launch works with rviz:=false only"
  [librviz-dev]="RViz shows no panel with stage, verdict and convergence"
  [xdotool]="no scripts/record_rviz.sh"
  [xvfb]="no scripts/screenshot.sh"
  [imagemagick]="no scripts/screenshot.sh"
  [libgl1-mesa-dri]="no software OpenGL, so no scripts/screenshot.sh"
)
# The Qt that RViz is built with.
case "$(. /etc/os-release && echo "${VERSION_ID:-}")" in
  11 | 12) qt=qtbase5-dev ;;
  *) qt=qt6-base-dev ;;
esac
optional[$qt]="RViz shows no panel with stage, verdict and convergence"

installed() { [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null)" = installed ]; }
# Asked once for all: in a container, where apt keeps no cache of its lists, each call reads them anew.
declare -A candidates=()
ask_apt() {
  local package
  candidates=()
  while read -r package; do candidates[$package]=yes; done < <(
    apt-cache policy libc6-dev "${required[@]}" "${!optional[@]}" 2>/dev/null |
      awk '/^[^ ]/ {name = substr($1, 1, length($1) - 1)} $1 == "Candidate:" && $2 != "(none)" {print name}')
}
available() { [ -n "${candidates[$1]:-}" ]; }
# CLI11 is a few headers: a copy in /usr/local is as good as the package.
have() {
  installed "$1" || { [ "$1" = libcli11-dev ] && [ -f /usr/local/include/CLI/CLI.hpp ]; }
}

# ONNX Runtime is a package since Debian 13; 12 has libtorch, and that of 11 is too old.
if $with_learned; then
  case "$(. /etc/os-release && echo "${VERSION_ID:-}")" in
    11) echo "install_dependencies.sh: neither ONNX Runtime nor a new libtorch is in this suite: no learned matcher" ;;
    12) required+=(libtorch-dev) ;;
    *) required+=(libonnxruntime-dev) ;;
  esac
fi

ask_apt
# Optional packages that this suite lacks are no reason to ask the network again at every call.
lists_known=false
if available libc6-dev; then lists_known=true; fi
missing=()
for package in "${required[@]}" "${!optional[@]}"; do
  if have "$package"; then continue; fi
  if $lists_known && [ -n "${optional[$package]:-}" ] && ! available "$package"; then
    echo "install_dependencies.sh: $package is not in this suite: ${optional[$package]}"
  else
    missing+=("$package")
  fi
done
if [ ${#missing[@]} -eq 0 ]; then exit 0; fi

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || { echo "install_dependencies.sh: neither root nor sudo: run it as root to install: ${missing[*]}" >&2; exit 1; }
  as_root=(sudo)
fi
run() {
  if $dry_run; then echo "would run: $*"; else "$@"; fi
}

# A dry run asks the lists that are there; on a system without any it takes the names as they stand.
if $dry_run; then
  echo "would run: ${as_root[*]+sudo }apt-get update"
elif ! "${as_root[@]}" apt-get update -q; then
  echo "install_dependencies.sh: apt-get update failed (see above): is the network there?" >&2
  exit 1
else
  lists_known=true
  ask_apt
fi

to_install=()
from_elsewhere=()
for package in "${missing[@]}"; do
  if ! $lists_known || available "$package"; then
    to_install+=("$package")
  elif [ "$package" = libcli11-dev ]; then
    from_elsewhere+=("$package")
  elif [ -n "${optional[$package]:-}" ]; then
    echo "install_dependencies.sh: $package is not in this suite: ${optional[$package]}"
  else
    echo "install_dependencies.sh: no package $package in this machine's apt sources; MLIC needs Debian 11, 12 or 13 (main)" >&2
    exit 1
  fi
done

# Debian 11 lacks CLI11. Its package of Debian 12 is headers without dependencies, fetched through apt (signed).
install_from_bookworm() {
  local package=$1 folder apt mirror
  mirror=$(apt-cache policy | grep -oE 'https?://[^ ]+/debian/? ' | head -1 | tr -d ' ')
  folder=$(mktemp -d)
  mkdir -p "$folder/lists/partial" "$folder/archives/partial"
  echo "deb ${mirror:-http://deb.debian.org/debian} bookworm main" >"$folder/sources.list"
  apt=(apt-get -q -o Dir::Etc::SourceList="$folder/sources.list" -o Dir::Etc::SourceParts=/dev/null
       -o Dir::State::Lists="$folder/lists" -o Dir::Cache::Archives="$folder/archives"
       -o Dir::Cache::pkgcache= -o Dir::Cache::srcpkgcache= -o APT::Sandbox::User=root)
  chmod -R a+rX "$folder"
  "${as_root[@]}" "${apt[@]}" update
  (cd "$folder" && "${as_root[@]}" "${apt[@]}" download "$package")
  "${as_root[@]}" dpkg -i "$folder"/"$package"_*.deb
  "${as_root[@]}" rm -rf "$folder"
}

if [ ${#to_install[@]} -gt 0 ]; then
  run "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "${to_install[@]}"
fi
for package in ${from_elsewhere[@]+"${from_elsewhere[@]}"}; do
  if $dry_run; then
    echo "would take: $package (headers only) from Debian 12, this suite has none"
  else
    echo "install_dependencies.sh: $package is not in this suite: taking the headers from Debian 12"
    install_from_bookworm "$package"
  fi
done
$dry_run || echo "install_dependencies.sh: done"

# Sourced by the scripts beside it: where things are, and an environment in which Debian's ROS works.
# MLIC_BUILD: build directory (default: build in the repository). MLIC_JOBS: parallel compile jobs.

repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=${MLIC_BUILD:-$repository/build}

# Debian's ROS needs Debian's Python: a pyenv or conda python3 first in PATH has none of its modules.
export PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin
unset PYTHONPATH PYTHONHOME LD_LIBRARY_PATH
export LC_ALL=C.UTF-8
# Without it the log of a node is lost when it is killed and its output is not a terminal.
export ROSCONSOLE_STDOUT_LINE_BUFFERED=1
export ROS_HOSTNAME=localhost
export OMP_WAIT_POLICY=PASSIVE

# As many jobs as there are cores, but at most one for each 1.5 GB of free memory.
compile_jobs() {
  local by_memory cores
  cores=$(nproc)
  by_memory=$(awk '/^MemAvailable/ {print int($2 / 1572864)}' /proc/meminfo)
  if [ "${by_memory:-1}" -lt 1 ]; then by_memory=1; fi
  if [ "$by_memory" -lt "$cores" ]; then echo "$by_memory"; else echo "$cores"; fi
}

# Configures (Release, Ninja) in $build; arguments go to cmake. A new build directory compiles several source files of a
# library in one call: the whole takes half the time, as headers and the templates of Eigen are compiled once for all of
# them. An existing one stays as it was configured.
configure_mlic() {
  local unity=()
  if [ ! -f "$build/CMakeCache.txt" ]; then unity=(-DCMAKE_UNITY_BUILD=ON); fi
  cmake -S "$repository" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release "${unity[@]}" "$@"
}

# Builds these targets; without one, all programs.
compile_mlic() {
  local jobs=${MLIC_JOBS:-$(compile_jobs)}
  echo "== building in $build with $jobs jobs"
  ninja -C "$build" -j "$jobs" "$@"
}

# Configures as the arguments to cmake say, and builds all programs; also the tests where they are configured.
build_mlic() {
  configure_mlic "$@" || return
  local targets=(all)
  if ninja -C "$build" -t targets all 2>/dev/null | grep -q '^tests: phony'; then targets+=(tests); fi
  compile_mlic "${targets[@]}"
}

# Makes roslaunch, rosrun and rospack see the build. The file of catkin reads unset variables.
source_workspace() {
  set +u
  # shellcheck disable=SC1091
  . "$build/devel/setup.bash"
  set -u
}

# roslaunch and rostest cannot start a master on a machine whose own name does not resolve (bare containers).
require_host_name() {
  if ! getent hosts "$(hostname)" >/dev/null; then
    echo "warning: the name of this machine, $(hostname), does not resolve, so roslaunch will not start;" \
      "put '127.0.0.1 localhost $(hostname)' into /etc/hosts" >&2
  fi
}

# Ends the script where one of these programs is missing.
require_programs() {
  local program
  for program in "$@"; do
    command -v "$program" >/dev/null ||
      { echo "$(basename "$0"): no $program: run scripts/install_dependencies.sh" >&2; exit 1; }
  done
}

# A screen of 1600 x 1000 that nobody sees, drawn in software, for what is started after it. Its files are in
# $virtual_display.
start_virtual_display() {
  virtual_display=$(mktemp -d)
  # Xvfb finds a free display by itself and writes its number.
  Xvfb -displayfd 3 -screen 0 1600x1000x24 +extension GLX 3>"$virtual_display/number" >"$virtual_display/log" 2>&1 &
  virtual_display_process=$!
  for _ in $(seq 100); do [ -s "$virtual_display/number" ] && break; sleep 0.1; done
  [ -s "$virtual_display/number" ] ||
    { cat "$virtual_display/log" >&2; echo "$(basename "$0"): Xvfb did not start" >&2; exit 1; }
  mkdir -m 700 "$virtual_display/runtime"
  DISPLAY=:$(cat "$virtual_display/number")
  export DISPLAY LIBGL_ALWAYS_SOFTWARE=1 XDG_RUNTIME_DIR=$virtual_display/runtime QT_X11_NO_MITSHM=1
}

stop_virtual_display() {
  kill "$virtual_display_process" 2>/dev/null || true
  wait "$virtual_display_process" 2>/dev/null || true
  rm -rf "$virtual_display"
}

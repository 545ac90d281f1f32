#pragma once

#include <malloc.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <type_traits>

namespace mlic {

// Wall and user CPU seconds since it was made, and the most memory above what was resident then, of this
// process.
class Usage {
 public:
  Usage() {
    malloc_trim(0);
    std::ofstream("/proc/self/clear_refs") << "5";  // the peak starts anew (man 5 proc)
    begin_ = std::chrono::steady_clock::now();
    const rusage now = Now();
    user_ = User(now);
    resident_ = static_cast<double>(now.ru_maxrss);
  }
  double Wall() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }
  double User() const { return User(Now()) - user_; }
  double PeakMegabytes() const { return (static_cast<double>(Now().ru_maxrss) - resident_) / 1024.0; }

 private:
  static rusage Now() {
    rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return usage;
  }
  static double User(const rusage& usage) {
    return static_cast<double>(usage.ru_utime.tv_sec) + 1e-6 * static_cast<double>(usage.ru_utime.tv_usec);
  }
  std::chrono::steady_clock::time_point begin_;
  double user_, resident_;
};

// What `run` returns in a process of its own, which shares what the caller has made; nothing if it failed.
template <typename Run>
auto InOwnProcess(const Run& run) -> std::optional<decltype(run())> {
  using Result = decltype(run());
  static_assert(std::is_trivially_copyable_v<Result>);
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("cannot make a pipe");
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("cannot start a process");
  if (child == 0) {
    int status = 1;
    try {
      const Result result = run();
      status = write(ends[1], &result, sizeof(result)) == static_cast<ssize_t>(sizeof(result)) ? 0 : 1;
    } catch (const std::exception& error) {
      std::fprintf(stderr, "joint_solver_benchmark: %s\n", error.what());
    }
    _exit(status);
  }
  close(ends[1]);
  Result result;
  const bool read_all = read(ends[0], &result, sizeof(result)) == static_cast<ssize_t>(sizeof(result));
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (!read_all || !WIFEXITED(status) || WEXITSTATUS(status) != 0) return std::nullopt;
  return result;
}

}  // namespace mlic

#include "mlic_core/camera/colmap/colmap_process.h"

#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <thread>

#include "mlic_core/common/error.h"

namespace mlic {
namespace {

constexpr int kNotFound = 127;                 // from: standard, POSIX shells
constexpr int kNotRun = 126;                   // from: standard, POSIX shells
constexpr std::chrono::milliseconds kPoll(5);  // from: structural
constexpr int kPollsBetweenCalls = 100;        // from: structural

// One of the processors that this process may use; the next one at each call.
cpu_set_t NextProcessor() {
  static std::atomic<int> turn{0};
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  if (sched_getaffinity(0, sizeof(allowed), &allowed) != 0 || CPU_COUNT(&allowed) == 0) return allowed;
  int skip = turn++ % CPU_COUNT(&allowed);
  cpu_set_t one;
  CPU_ZERO(&one);
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (CPU_ISSET(cpu, &allowed) && skip-- == 0) {
      CPU_SET(cpu, &one);
      break;
    }
  }
  return one;
}

// In the child: only calls that are safe between fork and exec in a program of several threads.
[[noreturn]] void Execute(char* const* arguments, int log, const cpu_set_t& processor, pid_t parent) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(kNotRun);
  sched_setaffinity(0, sizeof(processor), &processor);
  dup2(log, STDOUT_FILENO);
  dup2(log, STDERR_FILENO);
  execvp(arguments[0], arguments);
  _exit(errno == ENOENT ? kNotFound : kNotRun);
}

std::string LastLine(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line, last;
  while (std::getline(file, line)) {
    if (line.find_first_not_of(" \t\r") != std::string::npos) last = line;
  }
  return last;
}

// waitpid with these flags. Throws where the system does not tell how the child ended: where SIGCHLD is
// ignored, as some supervisors hand it down, it is not kept.
bool HasEnded(pid_t child, const std::string& program, int flags, int* status) {
  pid_t ended = 0;
  do {
    ended = waitpid(child, status, flags);
  } while (ended < 0 && errno == EINTR);
  if (ended >= 0) return ended == child;
  throw InputError(program + ": how it ended cannot be learned (waitpid: " + std::strerror(errno) +
                   "); start this program where the signal SIGCHLD is not ignored");
}

}  // namespace

ProcessEnd RunProcess(const std::vector<std::string>& command, const std::filesystem::path& log_file,
                      const CancellationToken& cancellation, const std::function<void()>& meanwhile) {
  cancellation.ThrowIfCancelled();
  const int log = open(log_file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (log < 0)
    throw InputError(log_file.string() + ": cannot be written; free space or choose another place");
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const cpu_set_t processor = NextProcessor();
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child == 0) Execute(arguments.data(), log, processor, parent);
  close(log);
  if (child < 0) throw InternalError("no further process can be started");
  int status = 0;
  for (int poll = 1; !HasEnded(child, command.front(), WNOHANG, &status); ++poll) {
    if (cancellation.IsCancelled()) {
      kill(child, SIGKILL);
      HasEnded(child, command.front(), 0, &status);
      throw Cancelled();
    }
    std::this_thread::sleep_for(kPoll);
    if (meanwhile && poll % kPollsBetweenCalls == 0) meanwhile();
  }
  ProcessEnd end;
  end.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  end.found = end.status != kNotFound;
  end.last_line = LastLine(log_file);
  return end;
}

}  // namespace mlic

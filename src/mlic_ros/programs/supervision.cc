#include "mlic_ros/programs/supervision.h"

#include <poll.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "mlic_ros/programs/program.h"

namespace mlic {
namespace {

// roslaunch asks its nodes to end within a poll of its processes; this is far more.
constexpr timespec kMostForRoslaunch{10, 0};

volatile pid_t child = 0;
volatile std::sig_atomic_t was_signalled = 0;

extern "C" void HandOn(int signal) {
  was_signalled = 1;
  if (child > 0) kill(child, signal);
}

sigset_t EndSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  return signals;
}

[[noreturn]] void RunChild(const std::function<int()>& work, pid_t supervisor, const sigset_t& mask) {
  // Its own group: what roslaunch sends to the node's group comes once, from the supervisor.
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != supervisor) _exit(kFailure);
  sigprocmask(SIG_SETMASK, &mask, nullptr);
  std::exit(work());
}

// A process that outlives this one and roslaunch, and writes the text once roslaunch is gone.
void WriteAfter(pid_t roslaunch, const std::string& text) {
  if (fork() != 0) return;
  setsid();  // not of the group that roslaunch ends
  pollfd end{static_cast<int>(syscall(SYS_pidfd_open, roslaunch, 0)), POLLIN, 0};
  if (end.fd >= 0 && poll(&end, 1, -1) == 1) {
    const ssize_t written = write(STDERR_FILENO, text.data(), text.size());
    _exit(written < 0 ? kFailure : kTrusted);
  }
  _exit(kFailure);
}

}  // namespace

int Supervise(const std::function<int()>& work, const std::function<int(int)>& on_death) {
  const sigset_t signals = EndSignals();
  sigset_t before;
  sigprocmask(SIG_BLOCK, &signals, &before);  // until the child is known, to whom they go
  const pid_t supervisor = getpid();
  child = fork();
  if (child == 0) RunChild(work, supervisor, before);
  if (child < 0) return on_death(0);
  struct sigaction action {};
  action.sa_handler = HandOn;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  sigprocmask(SIG_SETMASK, &before, nullptr);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  child = 0;
  return WIFEXITED(status) ? WEXITSTATUS(status) : on_death(WTERMSIG(status));
}

void EndLaunch(const std::string& last_words) {
  WriteAfter(getppid(), last_words);
  const sigset_t signals = EndSignals();
  sigprocmask(SIG_BLOCK, &signals, nullptr);
  if (was_signalled != 0) return;
  kill(getppid(), SIGINT);
  sigtimedwait(&signals, nullptr, &kMostForRoslaunch);
}

void EndLaunchWith(int status, const std::string& last_line) {
  const char* path = std::getenv("MLIC_STATUS_FILE");
  if (path != nullptr) std::ofstream(path) << status << "\n" << last_line << "\n";
  std::fflush(nullptr);  // before what roslaunch says
  EndLaunch(last_line + "\n");
}

}  // namespace mlic

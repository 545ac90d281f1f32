#include "mlic_ros/programs/rviz_window.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>

namespace mlic {
namespace {

// Whether the X server of this machine, ":N", answers. RViz would die of one that does not.
bool LocalServerAnswers(const std::string& display) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string number = display.substr(1, display.find('.') - 1);
  std::snprintf(address.sun_path, sizeof(address.sun_path), "/tmp/.X11-unix/X%s", number.c_str());
  const int descriptor = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const bool answers = connect(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
  close(descriptor);
  return answers;
}

std::string DisplayProblem() {
  const char* display = std::getenv("DISPLAY");
  if (display == nullptr || *display == '\0') return "there is no display (DISPLAY is not set)";
  if (*display == ':' && !LocalServerAnswers(display))
    return "the display " + std::string(display) + " does not answer";
  return "";
}

// The child of fork, of a process with threads: nothing but system calls until exec.
[[noreturn]] void BecomeRviz(const char* config, const char* log) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  const int output = open(log, O_WRONLY | O_CREAT | O_TRUNC, 0666);
  if (output >= 0) {
    dup2(output, STDOUT_FILENO);
    dup2(output, STDERR_FILENO);
  }
  // Else closing it would ask whether to write the view of this map into the package's configuration.
  execlp("rviz", "rviz", "-d", config, "__name:=mlic_rviz", "_asks_to_save:=false",
         static_cast<char*>(nullptr));
  constexpr char kMissing[] = "there is no program rviz in PATH: install it\n";
  if (write(STDERR_FILENO, kMissing, sizeof(kMissing) - 1) < 0) _exit(126);
  _exit(127);
}

}  // namespace

RvizWindow::RvizWindow(const std::string& config, const std::string& log) : problem_(DisplayProblem()) {
  if (!problem_.empty()) return;
  const pid_t process = fork();
  if (process == 0) BecomeRviz(config.c_str(), log.c_str());
  if (process < 0) {
    problem_ = "it cannot be started";
  } else {
    process_ = process;
  }
}

RvizWindow::~RvizWindow() {
  if (!IsOpen()) return;
  kill(*process_, SIGTERM);
  waitpid(*process_, nullptr, 0);
}

bool RvizWindow::IsOpen() {
  if (process_ && waitpid(*process_, nullptr, WNOHANG) != 0) process_.reset();
  return process_.has_value();
}

}  // namespace mlic

#include "mlic_ros/programs/drive_runs.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cctype>
#include <csignal>
#include <map>

#include "mlic_core/common/error.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

constexpr int kPoll = 50;  // ms between looks at processes and at the token; from: structural

// Starts the program, in a process group of its own: Ctrl-C goes to it through us, once.
pid_t Start(const std::vector<std::string>& command, const fs::path& log) {
  std::vector<char*> arguments;
  for (const std::string& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  const pid_t process = fork();
  if (process < 0) throw InputError(command.front() + ": cannot be started, there are too many processes");
  if (process > 0) return process;
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  const int output = open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (output >= 0) {
    dup2(output, STDOUT_FILENO);
    dup2(output, STDERR_FILENO);
  }
  execvp(arguments.front(), arguments.data());
  constexpr char kMissing[] = "cannot be started\n";
  const ssize_t written = write(STDERR_FILENO, kMissing, sizeof(kMissing) - 1);
  _exit(written < 0 ? 126 : 127);  // as a shell says it
}

// The process's status once it has ended: that of its exit, or 128 and its signal as a shell says it.
int StatusOf(int wait_status) {
  return WIFEXITED(wait_status) ? WEXITSTATUS(wait_status) : 128 + WTERMSIG(wait_status);
}

// Waits until the process has ended; meanwhile calls look again and again.
void WaitFor(pid_t process, const std::function<void()>& look) {
  while (waitpid(process, nullptr, WNOHANG) == 0) {
    look();
    poll(nullptr, 0, kPoll);
  }
  look();
}

fs::path StatusFile(const DriveRun& run) { return run.log.string() + ".status"; }

std::string ArrayJob(int threads, const std::vector<DriveRun>& runs) {
  std::string script =
      "#!/bin/bash\n"
      "#SBATCH --job-name=mlic_fleet\n"
      "#SBATCH --mem=16G\n"  // what the largest rig needs
      "#SBATCH --array=0-" +
      std::to_string(runs.size() - 1) + "\n";
  if (threads > 0) script += "#SBATCH --cpus-per-task=" + std::to_string(threads) + "\n";
  script +=
      "run() {  # LOG COMMAND ...\n"
      "  local log=$1\n"
      "  shift\n"
      "  \"$@\" --threads \"${SLURM_CPUS_ON_NODE:-1}\" >\"$log\" 2>&1\n"
      "  echo $? >\"$log.new\"\n"
      "  mv \"$log.new\" \"$log.status\"\n"
      "}\n"
      "case $SLURM_ARRAY_TASK_ID in\n";
  for (std::size_t i = 0; i < runs.size(); ++i) {
    script += std::to_string(i) + ") run " + ShellQuoted(runs[i].log.string());
    for (const std::string& argument : runs[i].command) script += " " + ShellQuoted(argument);
    script += " ;;\n";
  }
  return script + "esac\n";
}

// What sbatch --parsable printed: NUMBER or NUMBER;CLUSTER. Empty where it printed no number.
std::string JobNumber(const fs::path& output) {
  const std::string text = ReadFile(output);
  std::string number;
  for (const char c : text) {
    if (std::isdigit(static_cast<unsigned char>(c)) == 0) break;
    number += c;
  }
  return number;
}

}  // namespace

void RunHere(std::size_t at_once, const CancellationToken& cancellation,
             const std::function<void(std::size_t)>& on_end, std::vector<DriveRun>* runs) {
  std::map<pid_t, std::size_t> running;
  std::size_t next = 0;
  bool interrupted = false;
  while (next < runs->size() || !running.empty()) {
    if (cancellation.IsCancelled() && !interrupted) {
      interrupted = true;
      next = runs->size();
      for (const auto& [process, index] : running) kill(process, SIGINT);
    }
    while (next < runs->size() && running.size() < at_once) {
      running[Start((*runs)[next].command, (*runs)[next].log)] = next;
      ++next;
    }
    int status = 0;
    const pid_t ended = waitpid(-1, &status, WNOHANG);
    if (ended <= 0) {
      poll(nullptr, 0, kPoll);
      continue;
    }
    const std::size_t index = running.at(ended);
    running.erase(ended);
    (*runs)[index].status = StatusOf(status);
    if (!interrupted) on_end(index);
  }
  cancellation.ThrowIfCancelled();
}

void RunOnSlurm(const fs::path& directory, int threads, const CancellationToken& cancellation,
                const std::function<void(std::size_t)>& on_end, std::vector<DriveRun>* runs) {
  const fs::path script = directory / "slurm.sh", answer = directory / "slurm_job.txt";
  WriteFileAtomically(script, ArrayJob(threads, *runs));
  for (const DriveRun& run : *runs) fs::remove(StatusFile(run));
  const pid_t process = Start({"sbatch", "--parsable", "--wait", "--output",
                               (directory / "logs" / "slurm_%a.txt").string(), script.string()},
                              answer);
  bool interrupted = false;
  WaitFor(process, [&] {
    for (std::size_t i = 0; i < runs->size(); ++i) {
      DriveRun& run = (*runs)[i];
      if (run.status >= 0 || !fs::exists(StatusFile(run))) continue;
      run.status = std::stoi(ReadFile(StatusFile(run)));
      on_end(i);
    }
    if (!cancellation.IsCancelled() || interrupted) return;
    interrupted = true;
    const std::string job = JobNumber(answer);
    if (!job.empty()) WaitFor(Start({"scancel", job}, directory / "logs" / "scancel.txt"), [] {});
    kill(process, SIGINT);
  });
  cancellation.ThrowIfCancelled();
  if (JobNumber(answer).empty()) {
    const std::string said = ReadFile(answer);
    throw InputError("sbatch " + script.string() + ": " + said.substr(0, said.find('\n')) +
                     "; expected a job's number; without --slurm the drives are calibrated here");
  }
  for (std::size_t i = 0; i < runs->size(); ++i) {
    if ((*runs)[i].status < 0) on_end(i);
  }
}

}  // namespace mlic

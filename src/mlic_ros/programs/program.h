#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace mlic {

// Exit statuses that every program shares; README lists them.
enum ExitStatus {
  kTrusted = 0,
  kBadInput = 1,
  kRefused = 2,
  kFailure = 3,
  kPartial = 4,  // some sensors of the rig, or pairs of them
  kInterrupted = 130,
};

// How a program ended, and the line that says why where it failed; empty otherwise.
struct ProgramEnd {
  int status = kTrusted;
  std::string line;
};

// Runs the body and turns exceptions into exit statuses, each with a line that begins with the program's
// name.
ProgramEnd EndOfProgram(const std::string& name, const std::function<int()>& body,
                        const std::function<std::string()>& failure_hint = {});

// Runs the body and turns exceptions into exit statuses, each with one line on stderr that begins with the
// program's name. failure_hint completes the line of an internal failure, such as where the log is.
int RunProgram(const std::string& name, const std::function<int()>& body,
               const std::function<std::string()>& failure_hint = {});

struct StatusMeaning {
  int status;
  std::string meaning;
};

// Of this build of MLIC: 1.2.3.
std::string Version();

// From the root on, without . and .. in it.
std::string AbsolutePath(const std::filesystem::path& path);

// Gives the program its --help and --version. statuses: those that are its own; bad input and internal
// failures every program has. example: a call of it, from `rosrun` on.
void Describe(CLI::App& app, std::vector<StatusMeaning> statuses, const std::string& example);

// Parses the arguments. Returns true to go on; otherwise status is what to exit with (help and version: 0,
// wrong usage: 1). What roslaunch adds (__name:=..., __log:=...) is left out.
bool ParseArguments(CLI::App& app, int argc, char** argv, int& status);

}  // namespace mlic

#include "mlic_ros/programs/program.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <exception>
#include <iostream>
#include <new>
#include <vector>

#include "mlic_core/common/error.h"
#include "mlic_ros/programs/help_text.h"

namespace mlic {

ProgramEnd EndOfProgram(const std::string& name, const std::function<int()>& body,
                        const std::function<std::string()>& failure_hint) {
  const auto fail = [&](const std::string& what) -> ProgramEnd {
    return {kFailure, name + ": internal failure: " + what + (failure_hint ? failure_hint() : "")};
  };
  try {
    return {body(), ""};
  } catch (const InputError& error) {
    return {kBadInput, name + ": " + error.what()};
  } catch (const Cancelled&) {
    return {kInterrupted, name + ": interrupted"};
  } catch (const std::bad_alloc&) {
    return fail("out of memory; use --duration for a shorter part");
  } catch (const std::exception& error) {
    return fail(error.what());
  }
}

int RunProgram(const std::string& name, const std::function<int()>& body,
               const std::function<std::string()>& failure_hint) {
  const ProgramEnd end = EndOfProgram(name, body, failure_hint);
  if (!end.line.empty()) std::fprintf(stderr, "%s\n", end.line.c_str());
  return end.status;
}

std::string Version() { return MLIC_VERSION; }

std::string AbsolutePath(const std::filesystem::path& path) {
  return std::filesystem::absolute(path).lexically_normal().string();
}

void Describe(CLI::App& app, std::vector<StatusMeaning> statuses, const std::string& example) {
  app.formatter_fn(
      [](const CLI::App* described, const std::string&, CLI::AppFormatMode) { return HelpText(*described); });
  app.set_help_flag("-h,--help", "print this and exit");
  app.add_flag_callback(
      "--version",
      [&app] {
        std::cout << app.get_name() << " (MLIC) " << Version() << "\n";
        throw CLI::Success();  // beside what else is required
      },
      "print the version and exit");
  statuses.push_back({kBadInput, "bad input or usage; one line on stderr says what to do"});
  statuses.push_back({kFailure, "an internal failure"});
  std::sort(statuses.begin(), statuses.end(),
            [](const StatusMeaning& a, const StatusMeaning& b) { return a.status < b.status; });
  std::string footer = "\nExit status:\n";
  for (const auto& [status, meaning] : statuses) {
    const std::string number = std::to_string(status);
    footer += "  " + number + std::string(5 - number.size(), ' ') + meaning + "\n";
  }
  app.footer(footer + "\nExample:\n  " + example + "\n");
}

bool ParseArguments(CLI::App& app, int argc, char** argv, int& status) {
  std::vector<const char*> arguments;
  for (int i = 0; i < argc; ++i) {
    if (std::strncmp(argv[i], "__", 2) != 0) arguments.push_back(argv[i]);
  }
  try {
    app.parse(static_cast<int>(arguments.size()), arguments.data());
    return true;
  } catch (const CLI::CallForHelp& help) {
    status = app.exit(help);
  } catch (const CLI::Success&) {
    status = kTrusted;
  } catch (const CLI::ParseError& error) {
    std::cerr << app.get_name() << ": " << error.what() << "; --help lists the options\n";
    status = kBadInput;
  }
  return false;
}

}  // namespace mlic

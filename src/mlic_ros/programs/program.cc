#include "mlic_ros/programs/program.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <iostream>
#include <new>

#include "mlic_core/common/error.h"
#include "mlic_ros/programs/help_text.h"

namespace mlic {

int RunProgram(const std::string& name, const std::function<int()>& body,
               const std::function<std::string()>& failure_hint) {
  const auto fail = [&](const std::string& what) {
    std::fprintf(stderr, "%s: internal failure: %s%s\n", name.c_str(), what.c_str(),
                 failure_hint ? failure_hint().c_str() : "");
    return kFailure;
  };
  try {
    return body();
  } catch (const InputError& error) {
    std::fprintf(stderr, "%s: %s\n", name.c_str(), error.what());
    return kBadInput;
  } catch (const Cancelled&) {
    std::fprintf(stderr, "%s: interrupted\n", name.c_str());
    return kInterrupted;
  } catch (const std::bad_alloc&) {
    return fail("out of memory; use --duration for a shorter part");
  } catch (const std::exception& error) {
    return fail(error.what());
  }
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
  try {
    app.parse(argc, argv);
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

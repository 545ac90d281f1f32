#include "mlic_ros/programs/program.h"

#include <cstdio>
#include <exception>
#include <iostream>
#include <new>

#include "mlic_core/common/error.h"

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

bool ParseArguments(CLI::App& app, int argc, char** argv, int& status) {
  try {
    app.parse(argc, argv);
    return true;
  } catch (const CLI::CallForHelp& help) {
    status = app.exit(help);
  } catch (const CLI::ParseError& error) {
    std::cerr << app.get_name() << ": " << error.what() << "; --help lists the options\n";
    status = kBadInput;
  }
  return false;
}

}  // namespace mlic

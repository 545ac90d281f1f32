#include "mlic_ros/programs/program.h"

#include <cstdio>
#include <cstring>
#include <exception>
#include <iostream>
#include <new>
#include <vector>

#include "mlic_core/common/error.h"

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
  } catch (const CLI::ParseError& error) {
    std::cerr << app.get_name() << ": " << error.what() << "; --help lists the options\n";
    status = kBadInput;
  }
  return false;
}

}  // namespace mlic

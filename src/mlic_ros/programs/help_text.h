#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace mlic {

// What --help prints: usage, what the program does, its arguments with their defaults, and the footer. Not
// CLI11's own, which differs between its versions: cmake/command_line_files.py makes man pages and completion
// of it. There an argument begins in the third column of a line, and its description in the seventh.
std::string HelpText(const CLI::App& app);

}  // namespace mlic

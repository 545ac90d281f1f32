#pragma once

#include <filesystem>
#include <string>

namespace mlic {

// Writes a whole file under a temporary name beside it and renames it, so that nobody ever finds half of it.
// Creates the directory. InputError when that is not possible (no permission, disk full).
void WriteFileAtomically(const std::filesystem::path& path, const std::string& content);

// The whole file, byte by byte; InputError when it cannot be read.
std::string ReadFile(const std::filesystem::path& path);

// A number with enough digits: "%.*f" without the sign of a negative zero.
std::string FixedNumber(double value, int decimals);

// "%.*g" without the sign of a negative zero; "1.0e-05" for 1e-05, which readers of YAML 1.1, PyYAML among
// them, take for text.
std::string ShortNumber(double value, int significant_digits);

// The text as one word of a shell: as it is where no character means anything there, else in single quotes.
std::string ShellQuoted(const std::string& text);

}  // namespace mlic

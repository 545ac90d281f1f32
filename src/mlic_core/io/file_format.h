#pragma once

#include <string>

#include "mlic_core/io/yaml_reader.h"

namespace mlic {

// What a file says under `format`, KIND/VERSION. A version changes when a program that knows the one before
// would misunderstand the file; keys that may be ignored are added without. A program reads the versions up
// to its own, whatever MLIC wrote them.
struct FileFormat {
  const char* kind;
  int version;  // that is written, and the newest that is read

  std::string Text() const { return kind + ("/" + std::to_string(version)); }
};

constexpr FileFormat kResultFormat{"mlic_calibration", 1};  // from: definition
constexpr FileFormat kRigFormat{"mlic_rig", 1};             // from: definition

// The version that the file says, from 1 on; 1 where it says none. InputError where it is of another kind of
// file, or of a newer MLIC.
int ReadFormatVersion(const YamlReader& root, const FileFormat& format);

}  // namespace mlic

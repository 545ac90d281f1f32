#pragma once

#include <string>

namespace mlic {

struct ExportedFile {
  std::string name;  // within the directory of a format that has several
  std::string text;
};

}  // namespace mlic

#include "mlic_core/io/text_file.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <sstream>

#include "mlic_core/common/error.h"

namespace mlic {

void WriteFileAtomically(const std::filesystem::path& path, const std::string& content) {
  std::error_code error;
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), error);
  // The process id keeps two programs that write into one directory apart.
  std::filesystem::path temporary = path;
  temporary += ".tmp" + std::to_string(getpid());
  {
    std::ofstream stream(temporary, std::ios::binary | std::ios::trunc);
    stream.write(content.data(), static_cast<std::streamsize>(content.size()));
    stream.close();
    if (!stream) {
      std::filesystem::remove(temporary, error);
      throw InputError(path.string() + ": cannot be written; check the permissions and the free space there");
    }
  }
  std::filesystem::rename(temporary, path, error);
  if (error) {
    const std::string reason = error.message();
    std::filesystem::remove(temporary, error);
    throw InputError(path.string() + ": cannot be written: " + reason);
  }
}

std::string ReadFile(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::error_code ignored;
  if (!stream || std::filesystem::is_directory(path, ignored)) {
    throw InputError(path.string() + ": cannot be read; give the path of an existing file");
  }
  std::ostringstream content;
  content << stream.rdbuf();
  return content.str();
}

std::string FixedNumber(double value, int decimals) {
  char text[400];
  std::snprintf(text, sizeof(text), "%.*f", decimals, value);
  // "-0.000" would differ from "0.000" for no reason that a reader could see.
  bool zero = true;
  for (const char* c = text; *c != '\0'; ++c) zero = zero && (*c == '-' || *c == '0' || *c == '.');
  return zero && text[0] == '-' ? text + 1 : text;
}

std::string ShortNumber(double value, int significant_digits) {
  char text[64];
  std::snprintf(text, sizeof(text), "%.*g", significant_digits, value == 0.0 ? 0.0 : value);
  std::string number = text;
  const std::size_t exponent = number.find('e');
  if (exponent != std::string::npos && number.find('.') == std::string::npos) number.insert(exponent, ".0");
  return number;
}

std::string ShellQuoted(const std::string& text) {
  const bool plain = !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || std::strchr("_/.-+:,@%", c) != nullptr;
  });
  if (plain) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

}  // namespace mlic

#include "mlic_core/io/file_format.h"

#include <charconv>

namespace mlic {

int ReadFormatVersion(const YamlReader& root, const FileFormat& format) {
  if (!root.Has("format")) return 1;
  const YamlReader place = root.Get("format");
  const std::string text = place.String();
  const std::size_t slash = text.find('/');
  const std::string kind = text.substr(0, slash);
  for (const FileFormat& other : {kResultFormat, kRigFormat}) {
    if (kind == other.kind && kind != format.kind) {
      place.Fail("'" + text + "' is another kind of file; expected " + format.Text());
    }
  }
  int version = 0;
  const char* const end = text.data() + text.size();
  if (slash != std::string::npos) std::from_chars(text.data() + slash + 1, end, version);
  if (kind != format.kind || kind + "/" + std::to_string(version) != text || version < 1) {
    place.Fail("'" + text + "' is not known; expected " + format.Text());
  }
  if (version > format.version) {
    place.Fail("'" + text + "' was written by a newer MLIC than this one, which reads up to " +
               format.Text() + "; update MLIC");
  }
  return version;
}

}  // namespace mlic

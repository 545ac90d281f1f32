#include "support/source_directory.h"

namespace mlic {

std::string SourceDirectory() { return MLIC_SOURCE_DIRECTORY; }

}  // namespace mlic

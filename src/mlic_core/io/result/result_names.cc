#include "mlic_core/io/result/result_names.h"

namespace mlic {

const std::vector<std::string>& QuantityNames() {
  static const std::vector<std::string> names{"translation", "rotation", "time_offset"};
  return names;
}

const std::vector<std::string>& TypeNames() {
  static const std::vector<std::string> names{"lidar", "camera"};
  return names;
}

const std::vector<std::string>& ImuAxesNames() {
  static const std::vector<std::string> names{"common", "gyroscope"};
  return names;
}

const std::vector<std::string>& SensorVerdictNames() {
  static const std::vector<std::string> names{"trusted", "held", "rejected"};
  return names;
}

const std::vector<std::string>& VerdictNames() {
  static const std::vector<std::string> names{"trusted", "partial", "refused"};
  return names;
}

std::string VerdictName(Verdict verdict) { return VerdictNames()[static_cast<std::size_t>(verdict)]; }

}  // namespace mlic

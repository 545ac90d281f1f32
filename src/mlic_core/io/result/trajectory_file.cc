#include "mlic_core/io/result/trajectory_file.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "mlic_core/common/error.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

constexpr TimeNs kNanosecondsPerSecond = 1000000000;  // from: structural

// Integer arithmetic: a double holds no nanoseconds of today's clock.
std::string SecondsText(TimeNs time) {
  const bool negative = time < 0;
  const unsigned long long magnitude =
      negative ? 0ull - static_cast<unsigned long long>(time) : static_cast<unsigned long long>(time);
  char text[40];
  std::snprintf(text, sizeof(text), "%s%llu.%09llu", negative ? "-" : "", magnitude / kNanosecondsPerSecond,
                magnitude % kNanosecondsPerSecond);
  return text;
}

// False when the text is no decimal number with at most nine decimals kept.
bool ParseSeconds(const std::string& text, TimeNs* time) {
  const bool negative = !text.empty() && text[0] == '-';
  TimeNs value = 0;
  int decimals = -1;  // none until the point
  for (std::size_t i = negative ? 1 : 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '.' && decimals < 0) {
      decimals = 0;
    } else if (c >= '0' && c <= '9') {
      if (decimals == 9) continue;
      value = 10 * value + (c - '0');
      if (decimals >= 0) ++decimals;
    } else {
      return false;
    }
  }
  for (int i = std::max(decimals, 0); i < 9; ++i) value *= 10;
  *time = negative ? -value : value;
  return text.size() > (negative ? 1u : 0u);
}

}  // namespace

void WriteTrajectoryFile(const std::filesystem::path& path, const std::vector<StampedPose>& trajectory) {
  std::string text = "# T_map_imu: time_s tx ty tz qx qy qz qw\n";
  for (const StampedPose& stamped : trajectory) {
    text += SecondsText(stamped.time);
    for (int k = 0; k < 3; ++k) text += " " + FixedNumber(stamped.pose.translation[k], 9);
    for (int k = 0; k < 4; ++k) text += " " + FixedNumber(stamped.pose.rotation.coeffs()[k], 12);
    text += "\n";
  }
  WriteFileAtomically(path, text);
}

std::vector<StampedPose> ReadTrajectoryFile(const std::filesystem::path& path) {
  std::istringstream lines(ReadFile(path));
  std::vector<StampedPose> trajectory;
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (line.empty() || line[0] == '#' || line == "\r") continue;
    std::istringstream fields(line);
    std::string seconds;
    StampedPose stamped;
    Eigen::Vector3d& t = stamped.pose.translation;
    Eigen::Vector4d q;
    fields >> seconds >> t[0] >> t[1] >> t[2] >> q[0] >> q[1] >> q[2] >> q[3];
    if (!fields || !ParseSeconds(seconds, &stamped.time) || !(std::abs(q.norm() - 1.0) < 0.01)) {
      throw InputError(path.string() + ":" + std::to_string(number) +
                       ": expected a pose 'seconds tx ty tz qx qy qz qw' with a unit quaternion");
    }
    stamped.pose.rotation = Eigen::Quaterniond(q).normalized();
    trajectory.push_back(stamped);
  }
  return trajectory;
}

}  // namespace mlic

#include "mlic_core/io/result/number_list.h"

#include "mlic_core/io/text_file.h"

namespace mlic {

std::string NumberList(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ", ") + FixedNumber(value, 12);
  return "[" + text + "]";
}

std::string NumberList(const Eigen::Vector3d& v) {
  return NumberList(std::vector<double>{v.x(), v.y(), v.z()});
}

std::string RowByRow(const Eigen::Matrix3d& m) {
  const Eigen::Matrix3d transposed = m.transpose();  // Eigen stores column by column
  return NumberList(std::vector<double>(transposed.data(), transposed.data() + transposed.size()));
}

}  // namespace mlic

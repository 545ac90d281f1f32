#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace mlic {

// "[1.000000000000, 2.500000000000]", which every YAML reader takes for numbers: 1e-05 is a text for some.
std::string NumberList(const std::vector<double>& values);
std::string NumberList(const Eigen::Vector3d& v);
std::string RowByRow(const Eigen::Matrix3d& m);

}  // namespace mlic

#pragma once

#include <cstddef>
#include <set>
#include <vector>

namespace mlic {

// Bodies of which some have moved, and by how many sigmas the relation of two of them differs.
struct Difference {
  std::size_t a = 0, b = 0;
  double sigmas = 0.0;
};

using BodySet = std::set<std::size_t>;

struct Cover {
  BodySet bodies;
  BodySet or_instead;  // of covers that explain the relations as well
};

// The fewest bodies without which no relation differs by more than the limit (sigmas); of several, one that
// leaves the least sum of squared differences, and of those that are as good, one without the reference.
Cover SmallestCover(const std::vector<Difference>& all, double limit, std::size_t reference);

}  // namespace mlic

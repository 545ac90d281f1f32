#pragma once

#include <Eigen/Core>
#include <vector>

namespace mlic {

// What observations of one camera err by alike in the parts of its image: what the lens model does not follow
// and what patches look like there. It does not average out over landmarks.
class ImagePattern {
 public:
  explicit ImagePattern(std::size_t parts) : parts_(parts) {}

  // The observations of one landmark in a part of the image: the sum of their errors (px) by their weights
  // (1 / px^2), and of these. What they have of their own is the landmark's, not the part's.
  void Add(std::size_t part, const Eigen::Vector2d& errors, double weight);
  void Add(const ImagePattern& other);

  // px, rms over the image of both coordinates together, of the parts' means: beyond what landmarks scatter
  // by, and one standard deviation more, by which that may be less by chance. Zero without observations.
  double Rms() const;

 private:
  // Sums over landmarks.
  struct Part {
    Eigen::Vector2d errors = Eigen::Vector2d::Zero(), errors_by_weight = errors;
    double weight = 0.0, squared_errors = 0.0, squared_weights = 0.0;
  };
  std::vector<Part> parts_;
};

}  // namespace mlic

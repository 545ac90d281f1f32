#pragma once

#include <optional>
#include <string>

#include "mlic_ros/panel/panel_model.h"

namespace rviz {
class DisplayContext;
}

namespace mlic {

// Where RViz' camera looks, of views that turn about a focal point. It follows the map as it grows, until
// somebody moves the view or looks at a sensor.
class MapView {
 public:
  explicit MapView(rviz::DisplayContext* context) : context_(context) {}

  void FollowMap(const Viewpoint& view);
  // At the map again, whatever was done to the view.
  void LookAtMap(const Viewpoint& view);
  void LookAtFrame(const std::string& frame, const Viewpoint& view);

 private:
  void Set(const std::string& frame, const Viewpoint& view);
  // Whether the view is as it was set, or as it came.
  bool IsUntouched() const;
  double Distance() const;
  // By how much farther away all is seen to the sides, too: the field of view is that of the height.
  double Narrowness() const;

  rviz::DisplayContext* context_;
  std::optional<double> set_distance_;
  bool follows_ = true;
};

}  // namespace mlic

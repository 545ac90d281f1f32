#include "mlic_ros/panel/map_view.h"

#include <rviz/display_context.h>
#include <rviz/properties/property.h>
#include <rviz/render_panel.h>
#include <rviz/view_controller.h>
#include <rviz/view_manager.h>

#include <QString>
#include <algorithm>
#include <cmath>

namespace mlic {

double MapView::Distance() const {
  return context_->getViewManager()->getCurrent()->subProp("Distance")->getValue().toDouble();
}

double MapView::Narrowness() const {
  const rviz::RenderPanel* window = context_->getViewManager()->getRenderPanel();
  return window->width() > 0 ? std::max(1.0, static_cast<double>(window->height()) / window->width()) : 1.0;
}

bool MapView::IsUntouched() const {
  return !set_distance_ || std::abs(Distance() - *set_distance_) < 1e-3 * *set_distance_;
}

void MapView::Set(const std::string& frame, const Viewpoint& view) {
  rviz::ViewController* camera = context_->getViewManager()->getCurrent();
  camera->subProp("Target Frame")->setValue(QString::fromStdString(frame));
  rviz::Property* focus = camera->subProp("Focal Point");
  focus->subProp("X")->setValue(view.x);
  focus->subProp("Y")->setValue(view.y);
  focus->subProp("Z")->setValue(view.z);
  set_distance_ = Narrowness() * view.distance;
  camera->subProp("Distance")->setValue(*set_distance_);
}

void MapView::FollowMap(const Viewpoint& view) {
  follows_ = follows_ && IsUntouched();
  if (follows_) Set("<Fixed Frame>", view);
}

void MapView::LookAtMap(const Viewpoint& view) {
  follows_ = true;
  Set("<Fixed Frame>", view);
}

void MapView::LookAtFrame(const std::string& frame, const Viewpoint& view) {
  follows_ = false;
  Set(frame, view);
}

}  // namespace mlic

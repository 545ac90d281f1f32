#include "mlic_core/io/result/urdf_merge.h"

#include <algorithm>

#include "mlic_core/common/error.h"
#include "mlic_core/common/join.h"
#include "mlic_core/io/result/sensor_tree.h"

namespace mlic {
namespace {

// What TreeNotes begin with: a merge that is repeated replaces its comment.
constexpr const char* kCommentBegin = "Sensor poses found by MLIC";

}  // namespace

ModelPlacement::ModelPlacement(const RobotModel& model, const CalibrationResult& calibration)
    : model_(model) {
  const SensorTree tree = TreeOf(calibration);
  calibrated_.emplace_back(tree.parent, RigidTransform());
  for (const TreeFrame& frame : tree.frames) calibrated_.emplace_back(frame.frame, frame.T_parent_frame);
  std::vector<std::string> names;
  for (const auto& [frame, pose] : calibrated_) {
    names.push_back(frame);
    if (!model_.Has(frame)) continue;
    if (anchor_.empty()) anchor_ = frame;
    links_.insert(frame);
  }
  if (anchor_.empty()) {
    throw InputError(
        "the robot's model has no link of the calibration (" + Joined(names) +
        "), so nothing says where the sensors are on it; add the link of one of them with its joint");
  }
  for (const std::string& link : model_.FixedChain(anchor_)) {
    if (links_.count(link) > 0) anchor_ = link;
  }
}

RigidTransform ModelPlacement::InRoot(const std::string& link) const {
  if (!model_.Has(link)) throw InputError("the robot's model has no link " + link);
  std::set<std::string> ends = links_;
  for (const std::string& carrier : model_.FixedChain(anchor_)) ends.insert(carrier);
  if (const auto up = model_.Climb(link, ends)) {
    if (links_.count(up->link) > 0) return PoseOf(up->link) * up->T_link_start;
    const RobotModel::Ascent from_anchor = *model_.Climb(anchor_, {up->link});
    return PoseOf(anchor_) * from_anchor.T_link_start.Inverse() * up->T_link_start;
  }
  throw InputError("the robot's model: a joint that is not fixed stands between the links " + link + " and " +
                   anchor_ + ", so the sensors have no fixed place in " + link);
}

RigidTransform ModelPlacement::PoseOf(const std::string& frame) const {
  const auto found = std::find_if(calibrated_.begin(), calibrated_.end(),
                                  [&](const auto& candidate) { return candidate.first == frame; });
  return found->second;
}

MergedFrames MergeInto(const CalibrationResult& calibration, const std::string& parent, RobotModel* model) {
  const ModelPlacement placement(*model, calibration);
  const SensorTree about_root = TreeOf(calibration);
  MergedFrames merged{placement.Anchor(), {}, {}};
  std::string below = model->Has(about_root.parent) ? about_root.parent : placement.Anchor();
  if (!parent.empty()) below = parent;
  struct Change {
    std::string frame, parent;
    RigidTransform T_parent_frame;
  };
  std::vector<Change> changes;  // all are found in the model as it was
  for (const TreeFrame& frame : TreeAbout(calibration, "", {}).frames) {
    if (frame.frame == placement.Anchor()) continue;
    const std::string at = model->Has(frame.frame) ? model->ParentOf(frame.frame).value_or("") : below;
    const RigidTransform T_root_parent = at.empty() ? RigidTransform() : placement.InRoot(at);
    changes.push_back({frame.frame, at, T_root_parent.Inverse() * frame.T_parent_frame});
  }
  for (const Change& change : changes) {
    if (model->Has(change.frame)) {
      model->Place(change.frame, change.T_parent_frame);
      merged.updated.push_back(change.frame);
    } else {
      model->Append(change.parent, change.frame, change.T_parent_frame);
      merged.appended.push_back(change.frame);
    }
  }
  std::string notes = " ";
  for (const std::string& note : TreeNotes(about_root)) notes += (notes == " " ? "" : "\n       ") + note;
  model->Comment(kCommentBegin, notes + " ");
  return merged;
}

}  // namespace mlic

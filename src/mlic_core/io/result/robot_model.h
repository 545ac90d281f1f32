#pragma once

#include <libxml/tree.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "mlic_core/geometry/rigid_transform.h"

namespace mlic {

// A robot's URDF that is read, changed and written again with its comments, order and blanks. Of a xacro file
// only the links and joints that stand in it as they are, outside macros and conditions, are known.
class RobotModel {
 public:
  // InputError where the file cannot be read, is no XML or has no <robot>.
  static RobotModel Open(const std::filesystem::path& path);

  bool Has(const std::string& link) const { return links_.count(link) > 0; }
  // Whether macros or included files may bring links that are not known here.
  bool HasMoreInXacro() const { return more_in_xacro_; }
  // The link that this one hangs at; none: at no link.
  std::optional<std::string> ParentOf(const std::string& link) const;
  // This link and those that carry it by fixed joints, upwards.
  std::vector<std::string> FixedChain(const std::string& link) const;

  // A link and the pose of another one in it.
  struct Ascent {
    std::string link;
    RigidTransform T_link_start;
  };
  // Up from `start` over fixed joints to the first of the links in `ends`, which may be `start`; none where
  // there is none. InputError where a joint on the way has no numbers.
  std::optional<Ascent> Climb(const std::string& start, const std::set<std::string>& ends) const;

  // T_a_b over fixed joints; none where there is no such way or no such link. InputError as of Climb.
  std::optional<RigidTransform> Pose(const std::string& a, const std::string& b) const;

  // Puts a link that hangs at another one by a fixed joint into this place. InputError where it does not.
  void Place(const std::string& link, const RigidTransform& T_parent_link);
  // Adds a link and its fixed joint at the end.
  void Append(const std::string& parent, const std::string& link, const RigidTransform& T_parent_link);
  // The comment of the robot that begins with these words is replaced by the text, or put at its begin.
  void Comment(const std::string& begin, const std::string& text);

  std::string Text() const;

 private:
  struct Joint {
    std::string name, type, parent, child;
    xmlNode* node = nullptr;
  };

  RobotModel(const std::string& file, const std::string& text);
  void ReadElement(xmlNode* node);
  const Joint* JointOf(const std::string& link) const;
  RigidTransform Origin(const Joint& joint) const;
  [[noreturn]] void Fail(const Joint& joint, const std::string& what) const;

  std::string file_;
  std::unique_ptr<xmlDoc, void (*)(xmlDoc*)> document_;
  xmlNode* robot_ = nullptr;
  std::set<std::string> links_;
  std::vector<Joint> joints_;
  bool more_in_xacro_ = false;
};

}  // namespace mlic

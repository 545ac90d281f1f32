#include "mlic_core/io/result/robot_model.h"

#include <libxml/parser.h>

#include <algorithm>
#include <sstream>

#include "mlic_core/common/error.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/io/result/urdf.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

const xmlChar* Xml(const std::string& text) { return BAD_CAST text.c_str(); }

// Of libxml2's own memory.
std::string Taken(xmlChar* text) {
  if (text == nullptr) return "";
  std::string copy(reinterpret_cast<const char*>(text));
  xmlFree(text);
  return copy;
}

std::string NameOf(const xmlNode* node) { return reinterpret_cast<const char*>(node->name); }

bool IsXacro(const xmlNode* node) {
  return node->ns != nullptr && node->ns->prefix != nullptr &&
         std::string(reinterpret_cast<const char*>(node->ns->prefix)) == "xacro";
}

std::string Attribute(xmlNode* node, const std::string& name) {
  return node == nullptr ? "" : Taken(xmlGetProp(node, Xml(name)));
}

xmlNode* ChildNamed(const xmlNode* node, const std::string& name) {
  for (xmlNode* child = node->children; child != nullptr; child = child->next) {
    if (child->type == XML_ELEMENT_NODE && NameOf(child) == name && !IsXacro(child)) return child;
  }
  return nullptr;
}

// Three numbers; zeros where the attribute is not there, none where it holds anything else.
std::optional<Eigen::Vector3d> Triple(const std::string& text) {
  if (text.empty()) return Eigen::Vector3d::Zero();
  std::istringstream words(text);
  std::vector<double> numbers;
  for (double number = 0.0; words >> number;) numbers.push_back(number);
  if (!words.eof() || numbers.size() != 3) return std::nullopt;
  return Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
}

void SetOrigin(xmlNode* joint, const RigidTransform& pose) {
  xmlNode* origin = ChildNamed(joint, "origin");
  if (origin == nullptr) {
    // Before the first element, with the same blanks.
    xmlNode* first = xmlFirstElementChild(joint);
    origin = xmlNewNode(nullptr, Xml("origin"));
    xmlAddPrevSibling(first, origin);
    if (first->prev->prev != nullptr && xmlNodeIsText(first->prev->prev) != 0) {
      xmlAddPrevSibling(first, xmlCopyNode(first->prev->prev, 1));
    }
  }
  xmlSetProp(origin, Xml("xyz"), Xml(OriginXyz(pose)));
  xmlSetProp(origin, Xml("rpy"), Xml(OriginRpy(pose)));
}

}  // namespace

RobotModel RobotModel::Open(const std::filesystem::path& path) {
  return RobotModel(path.string(), ReadFile(path));
}

RobotModel::RobotModel(const std::string& file, const std::string& text)
    : file_(file),
      document_(xmlReadMemory(text.data(), static_cast<int>(text.size()), file.c_str(), nullptr,
                              XML_PARSE_NONET | XML_PARSE_NOERROR | XML_PARSE_NOWARNING),
                xmlFreeDoc) {
  if (document_ == nullptr) {
    const xmlError* error = xmlGetLastError();
    std::string what = error == nullptr || error->message == nullptr ? "it is empty" : error->message;
    what.erase(std::remove(what.begin(), what.end(), '\n'), what.end());
    throw InputError(file_ + ":" + std::to_string(error == nullptr ? 0 : error->line) + ": no XML: " + what +
                     "; give a URDF or a xacro file");
  }
  robot_ = xmlDocGetRootElement(document_.get());
  if (NameOf(robot_) != "robot") {
    throw InputError(file_ + ": expected <robot> but found <" + NameOf(robot_) +
                     ">; give a URDF or a xacro file");
  }
  for (xmlNode* node = robot_->children; node != nullptr; node = node->next) {
    if (node->type == XML_ELEMENT_NODE) ReadElement(node);
  }
}

void RobotModel::ReadElement(xmlNode* node) {
  const std::string name = NameOf(node);
  if (IsXacro(node)) {
    more_in_xacro_ |= name != "property" && name != "arg" && name != "macro";
  } else if (name == "link") {
    links_.insert(Attribute(node, "name"));
  } else if (name == "joint") {
    joints_.push_back({Attribute(node, "name"), Attribute(node, "type"),
                       Attribute(ChildNamed(node, "parent"), "link"),
                       Attribute(ChildNamed(node, "child"), "link"), node});
  }
}

const RobotModel::Joint* RobotModel::JointOf(const std::string& link) const {
  for (const Joint& joint : joints_) {
    if (joint.child == link) return &joint;
  }
  return nullptr;
}

void RobotModel::Fail(const Joint& joint, const std::string& what) const {
  throw InputError(file_ + ":" + std::to_string(xmlGetLineNo(joint.node)) + ": joint " + joint.name + ": " +
                   what);
}

RigidTransform RobotModel::Origin(const Joint& joint) const {
  xmlNode* origin = ChildNamed(joint.node, "origin");
  const std::optional<Eigen::Vector3d> xyz = Triple(Attribute(origin, "xyz")),
                                       rpy = Triple(Attribute(origin, "rpy"));
  if (!xyz || !rpy) {
    Fail(joint,
         "expected numbers in its origin; expand the file (xacro " + file_ + " > robot.urdf) and give that");
  }
  return {FromRollPitchYaw(*rpy), *xyz};
}

std::optional<std::string> RobotModel::ParentOf(const std::string& link) const {
  const Joint* joint = JointOf(link);
  return joint == nullptr ? std::nullopt : std::make_optional(joint->parent);
}

std::vector<std::string> RobotModel::FixedChain(const std::string& link) const {
  std::vector<std::string> chain{link};
  for (const Joint* joint = JointOf(link); joint != nullptr && joint->type == "fixed";
       joint = JointOf(joint->parent)) {
    if (chain.size() > joints_.size()) Fail(*joint, "is part of a circle of joints; a link has one parent");
    chain.push_back(joint->parent);
  }
  return chain;
}

std::optional<RobotModel::Ascent> RobotModel::Climb(const std::string& start,
                                                    const std::set<std::string>& ends) const {
  Ascent ascent{start, {}};
  for (const std::string& link : FixedChain(start)) {
    if (link != start) ascent = {link, Origin(*JointOf(ascent.link)) * ascent.T_link_start};
    if (ends.count(link) > 0) return ascent;
  }
  return std::nullopt;
}

std::optional<RigidTransform> RobotModel::Pose(const std::string& a, const std::string& b) const {
  const std::vector<std::string> above_a = FixedChain(a);
  const auto from_b = Climb(b, {above_a.begin(), above_a.end()});
  if (!Has(a) || !Has(b) || !from_b) return std::nullopt;
  return Climb(a, {from_b->link})->T_link_start.Inverse() * from_b->T_link_start;
}

void RobotModel::Place(const std::string& link, const RigidTransform& T_parent_link) {
  const Joint* joint = JointOf(link);
  if (joint == nullptr) {
    throw InputError(file_ + ": link " + link +
                     " hangs at no other, so it cannot be moved; give it a fixed joint");
  }
  if (joint->type != "fixed")
    Fail(*joint, "expected type fixed, as a calibrated sensor has; found " + joint->type);
  SetOrigin(joint->node, T_parent_link);
}

void RobotModel::Append(const std::string& parent, const std::string& link,
                        const RigidTransform& T_parent_link) {
  const auto add = [](xmlNode* to, const char* blanks, const char* name) {
    xmlAddChild(to, xmlNewText(BAD_CAST blanks));
    return xmlNewChild(to, nullptr, BAD_CAST name, nullptr);
  };
  // The blanks before </robot> stay the last.
  xmlNode* last = robot_->last;
  const bool blanks = last != nullptr && xmlNodeIsText(last) != 0;
  if (blanks) xmlUnlinkNode(last);
  xmlSetProp(add(robot_, "\n  ", "link"), Xml("name"), Xml(link));
  xmlNode* joint = add(robot_, "\n  ", "joint");
  xmlSetProp(joint, Xml("name"), Xml(link + "_joint"));
  xmlSetProp(joint, Xml("type"), Xml("fixed"));
  xmlSetProp(add(joint, "\n    ", "parent"), Xml("link"), Xml(parent));
  xmlSetProp(add(joint, "\n    ", "child"), Xml("link"), Xml(link));
  add(joint, "\n    ", "origin");
  SetOrigin(joint, T_parent_link);
  xmlAddChild(joint, xmlNewText(BAD_CAST "\n  "));
  xmlAddChild(robot_, blanks ? last : xmlNewText(BAD_CAST "\n"));
  links_.insert(link);
  joints_.push_back({link + "_joint", "fixed", parent, link, joint});
}

void RobotModel::Comment(const std::string& begin, const std::string& text) {
  for (xmlNode* node = robot_->children; node != nullptr; node = node->next) {
    if (node->type != XML_COMMENT_NODE || Taken(xmlNodeGetContent(node)).find(begin) == std::string::npos)
      continue;
    xmlNodeSetContent(node, Xml(text));
    return;
  }
  xmlNode* comment = xmlNewDocComment(document_.get(), Xml(text));
  if (robot_->children == nullptr) {
    xmlAddChild(robot_, comment);
  } else {
    xmlAddPrevSibling(robot_->children, comment);
  }
  xmlAddPrevSibling(comment, xmlNewText(BAD_CAST "\n  "));
}

std::string RobotModel::Text() const {
  xmlChar* text = nullptr;
  int size = 0;
  xmlDocDumpMemory(document_.get(), &text, &size);
  return Taken(text);
}

}  // namespace mlic

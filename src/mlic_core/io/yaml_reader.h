#pragma once

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace mlic {

// One node of a YAML file that knows where it stands, so that everything wrong with it becomes one InputError
// line: "FILE:LINE: PATH.OF.KEY: what is wrong and what to do". Every accessor checks kind, size and
// finiteness.
class YamlReader {
 public:
  // Parses the whole file; InputError when it cannot be read or is no YAML.
  static YamlReader Open(const std::filesystem::path& file);

  // This node is a mapping with no keys but the allowed ones, and none twice.
  void CheckKeys(const std::vector<std::string>& allowed) const;
  void CheckIsMap(const std::string& meaning) const;

  bool Has(const std::string& key) const;
  // The value of a key that must be there; `expected` completes "missing; ".
  YamlReader Get(const std::string& key, const std::string& expected) const;
  // The value of a key known to be there (Has).
  YamlReader Get(const std::string& key) const { return Get(key, "expected here"); }

  // The entries of a mapping, or the elements of a list, in the file's order.
  std::vector<YamlReader> Entries() const;
  std::vector<YamlReader> Elements() const;
  // This node and those within it that are the scalar `text`, in the file's order.
  std::vector<YamlReader> Find(const std::string& text) const;
  // The keys from the root to here, with dots between.
  const std::string& Path() const { return path_; }
  // The last part of the path: the key or index of this node.
  const std::string& Name() const { return name_; }
  // Of the node's first byte in the file.
  std::size_t Offset() const { return static_cast<std::size_t>(node_.Mark().pos); }
  // Where this node stands, "FILE:LINE", for messages about two places.
  std::string Where() const;

  std::string String() const;  // not empty
  // The text as it stands, may be empty.
  std::string Text() const;
  double Number() const;
  bool Flag() const;
  std::vector<double> Numbers() const;
  std::vector<double> Numbers(std::size_t count, const std::string& meaning) const;
  Eigen::Vector3d Vector3(const std::string& meaning) const;
  // The index of this string among the choices.
  std::size_t Choice(const std::vector<std::string>& choices) const;

  [[noreturn]] void Fail(const std::string& what) const;

 private:
  YamlReader(const YAML::Node& node, std::string file, std::string path, std::string name, int line);
  YamlReader Child(const YAML::Node& node, const std::string& name, const YAML::Mark& mark) const;

  YAML::Node node_;
  std::string file_;
  std::string path_;  // dotted, empty for the root
  std::string name_;
  int line_;  // from 1, 0 when unknown
};

// The text as a YAML scalar in double quotes, which is read back as this text whatever it holds.
std::string QuotedYaml(const std::string& text);

}  // namespace mlic

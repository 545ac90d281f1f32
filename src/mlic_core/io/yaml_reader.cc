#include "mlic_core/io/yaml_reader.h"

#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include "mlic_core/common/error.h"
#include "mlic_core/common/join.h"
#include "mlic_core/common/printable.h"

namespace mlic {
namespace {

std::string KindOf(const YAML::Node& node) {
  if (node.IsMap()) return "a mapping";
  if (node.IsSequence()) return "a list";
  if (node.IsScalar()) return "'" + node.Scalar() + "'";
  return "nothing";
}

}  // namespace

YamlReader::YamlReader(const YAML::Node& node, std::string file, std::string path, std::string name, int line)
    : node_(node), file_(std::move(file)), path_(std::move(path)), name_(std::move(name)), line_(line) {}

YamlReader YamlReader::Open(const std::filesystem::path& file) {
  const std::string name = file.string();
  std::error_code ignored;
  std::ifstream stream(file);
  if (!stream || std::filesystem::is_directory(file, ignored)) {
    throw InputError(name + ": cannot be read; give the path of an existing YAML file");
  }
  std::ostringstream text;
  text << stream.rdbuf();
  try {
    const YAML::Node root = YAML::Load(text.str());
    return YamlReader(root, name, "", "", root.Mark().line + 1);
  } catch (const YAML::Exception& error) {
    throw InputError(name + ":" + std::to_string(error.mark.line + 1) +
                     ": not valid YAML: " + Printable(error.msg));
  }
}

void YamlReader::Fail(const std::string& what) const {
  throw InputError(Printable(Where() + ": " + (path_.empty() ? "" : path_ + ": ") + what));
}

std::string YamlReader::Where() const { return file_ + (line_ > 0 ? ":" + std::to_string(line_) : ""); }

void YamlReader::CheckIsMap(const std::string& meaning) const {
  if (!node_.IsMap()) Fail("expected " + meaning + ", found " + KindOf(node_));
}

void YamlReader::CheckKeys(const std::vector<std::string>& allowed) const {
  CheckIsMap("a mapping with the keys " + Joined(allowed));
  for (const YamlReader& entry : Entries()) {
    bool known = false;
    for (const std::string& key : allowed) known = known || key == entry.Name();
    if (!known) entry.Fail("unknown key '" + entry.Name() + "'; allowed here: " + Joined(allowed));
  }
}

bool YamlReader::Has(const std::string& key) const { return node_.IsMap() && node_[key].IsDefined(); }

YamlReader YamlReader::Child(const YAML::Node& node, const std::string& name, const YAML::Mark& mark) const {
  const std::string path = path_.empty() ? name : path_ + "." + name;
  return YamlReader(node, file_, path, name, mark.is_null() ? line_ : mark.line + 1);
}

YamlReader YamlReader::Get(const std::string& key, const std::string& expected) const {
  if (!Has(key)) Fail("key '" + key + "' is missing; " + expected);
  for (const YamlReader& entry : Entries()) {
    if (entry.Name() == key) return entry;
  }
  throw InternalError("a YAML key was there and is not");
}

std::vector<YamlReader> YamlReader::Entries() const {
  CheckIsMap("a mapping");
  std::vector<YamlReader> entries;
  std::set<std::string> seen;
  for (const auto& entry : node_) {
    const YamlReader child =
        Child(entry.second, entry.first.IsScalar() ? entry.first.Scalar() : "?", entry.first.Mark());
    if (!entry.first.IsScalar()) child.Fail("a key must be a plain word");
    // yaml-cpp keeps both of two equal keys and would use the first silently.
    if (!seen.insert(child.Name()).second)
      child.Fail("key '" + child.Name() + "' is there twice; remove one");
    entries.push_back(child);
  }
  return entries;
}

std::vector<YamlReader> YamlReader::Elements() const {
  if (!node_.IsSequence()) Fail("expected a list, found " + KindOf(node_));
  std::vector<YamlReader> elements;
  for (std::size_t i = 0; i < node_.size(); ++i) {
    elements.push_back(Child(node_[i], std::to_string(i), node_[i].Mark()));
  }
  return elements;
}

std::vector<YamlReader> YamlReader::Find(const std::string& text) const {
  if (node_.IsScalar() && node_.Scalar() == text) return {*this};
  std::vector<YamlReader> children, found;
  if (node_.IsMap()) children = Entries();
  if (node_.IsSequence()) children = Elements();
  for (const YamlReader& child : children) {
    for (const YamlReader& place : child.Find(text)) found.push_back(place);
  }
  return found;
}

std::string YamlReader::Text() const {
  if (!node_.IsScalar()) Fail("expected a text, found " + KindOf(node_));
  return node_.Scalar();
}

std::string YamlReader::String() const {
  if (!node_.IsScalar() || node_.Scalar().empty()) Fail("expected a text, found " + KindOf(node_));
  return node_.Scalar();
}

double YamlReader::Number() const {
  double value = 0.0;
  if (!node_.IsScalar() || !YAML::convert<double>::decode(node_, value) || !std::isfinite(value)) {
    Fail("expected a finite number, found " + KindOf(node_));
  }
  return value;
}

bool YamlReader::Flag() const {
  bool value = false;
  if (!node_.IsScalar() || !YAML::convert<bool>::decode(node_, value)) {
    Fail("expected true or false, found " + KindOf(node_));
  }
  return value;
}

std::vector<double> YamlReader::Numbers() const {
  std::vector<double> numbers;
  for (const YamlReader& element : Elements()) numbers.push_back(element.Number());
  return numbers;
}

std::vector<double> YamlReader::Numbers(std::size_t count, const std::string& meaning) const {
  if (!node_.IsSequence() || node_.size() != count) {
    Fail("expected " + std::to_string(count) + " numbers " + meaning + ", found " +
         (node_.IsSequence() ? std::to_string(node_.size()) : KindOf(node_)));
  }
  return Numbers();
}

Eigen::Vector3d YamlReader::Vector3(const std::string& meaning) const {
  const std::vector<double> numbers = Numbers(3, meaning);
  return {numbers[0], numbers[1], numbers[2]};
}

std::size_t YamlReader::Choice(const std::vector<std::string>& choices) const {
  const std::string text = String();
  for (std::size_t i = 0; i < choices.size(); ++i) {
    if (choices[i] == text) return i;
  }
  Fail("'" + text + "' is not known; choose one of: " + Joined(choices));
}

std::string QuotedYaml(const std::string& text) {
  YAML::Emitter emitter;
  emitter << YAML::DoubleQuoted << text;
  return emitter.c_str();
}

}  // namespace mlic

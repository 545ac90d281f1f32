#pragma once

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "mlic_core/common/error.h"

namespace mlic::sim {

template <typename Value>
using Names = std::initializer_list<std::pair<const char*, Value>>;

// A mapping of the file whose every key must be used; what is wrong is said with file, line and key.
class Section {
 public:
  Section(std::string file, std::string name, const YAML::Node& node)
      : file_(std::move(file)), name_(std::move(name)), node_(node) {
    if (!node_.IsMap()) Fail(node_, "'" + name_ + "' must be a mapping");
  }

  [[noreturn]] void Fail(const YAML::Node& node, const std::string& what) const {
    throw InputError(file_ + ":" + std::to_string(node.Mark().line + 1) + ": " + what);
  }

  bool Has(const std::string& key) const { return static_cast<bool>(node_[key]); }

  YAML::Node Need(const std::string& key) const {
    if (!Has(key)) Fail(node_, "'" + name_ + "' lacks the key '" + key + "'");
    return node_[key];
  }

  Section Sub(const std::string& key) const { return Section(file_, name_ + "." + key, Need(key)); }

  // An element of the sequence under the key.
  Section Element(const std::string& key, const YAML::Node& node) const {
    return Section(file_, name_ + "." + key, node);
  }

  template <typename T>
  void Read(const std::string& key, T& value) const {
    if (!Has(key)) return;
    try {
      value = node_[key].as<T>();
    } catch (const YAML::Exception&) {
      Fail(node_[key], "'" + name_ + "." + key + "' has a value of the wrong type");
    }
  }

  void ReadPositive(const std::string& key, double& value) const {
    Read(key, value);
    if (!(value > 0.0)) Fail(Need(key), "'" + name_ + "." + key + "' must be positive");
  }

  // Numbers of a sequence of exactly `count`.
  void ReadNumbers(const std::string& key, double* values, std::size_t count) const {
    if (!Has(key)) return;
    std::vector<double> numbers;
    Read(key, numbers);
    if (numbers.size() != count) {
      Fail(node_[key], "'" + name_ + "." + key + "' must have " + std::to_string(count) + " numbers");
    }
    std::copy(numbers.begin(), numbers.end(), values);
  }

  template <typename Value>
  void ReadName(const std::string& key, Names<Value> names, Value& value) const {
    if (!Has(key)) return;
    std::string text, known;
    Read(key, text);
    for (const auto& [name, candidate] : names) {
      if (text == name) {
        value = candidate;
        return;
      }
      known += (known.empty() ? "" : ", ") + std::string(name);
    }
    Fail(node_[key], "'" + name_ + "." + key + "' is '" + text + "', expected one of " + known);
  }

  void OnlyKeys(std::initializer_list<const char*> known) const {
    for (const auto& entry : node_) {
      const std::string key = entry.first.as<std::string>();
      bool found = false;
      for (const char* k : known) found = found || key == k;
      if (!found) Fail(entry.first, "unknown key '" + key + "' in '" + name_ + "'");
    }
  }

  const YAML::Node& node() const { return node_; }

 private:
  std::string file_, name_;
  YAML::Node node_;
};

}  // namespace mlic::sim

// The table of docs/conventions.md has the keys that the rig file's parser accepts, no more and no less.

#include <map>
#include <set>
#include <sstream>

#include "mlic_core/io/rig/rig_file.h"
#include "mlic_core/io/text_file.h"
#include "support/files.h"
#include "support/source_directory.h"

namespace mlic::rig_keys_test {
namespace {

using Keys = std::set<std::string>;

// Of each block of the table ("" for the file itself) its keys: `lidars.NAME.topic` is topic of lidars.NAME.
std::map<std::string, Keys> DocumentedKeys() {
  std::istringstream text(ReadFile(SourceDirectory() + "/docs/conventions.md"));
  std::map<std::string, Keys> blocks;
  bool in_section = false;
  for (std::string line; std::getline(text, line);) {
    if (line.rfind("## ", 0) == 0) in_section = line == "## Keys of the rig file";
    if (!in_section || line.rfind("| `", 0) != 0) continue;
    const std::string cell = line.substr(1, line.find('|', 1) - 1);
    std::istringstream quoted(cell);
    std::string between, key;
    while (std::getline(quoted, between, '`') && std::getline(quoted, key, '`')) {
      const std::size_t dot = key.rfind('.');
      blocks[dot == std::string::npos ? "" : key.substr(0, dot)].insert(key.substr(dot + 1));
    }
  }
  return blocks;
}

// The keys that the parser lists when it meets one that it does not know.
Keys AllowedKeys(const std::string& rig) {
  const TemporaryDirectory directory;
  const std::filesystem::path path = directory.Path() / "rig.yaml";
  WriteFileAtomically(path, rig);
  const std::string message = InputErrorOf([&] { LoadRigFile(path); });
  const std::string before = "unknown key 'zzz'; allowed here: ";
  const std::size_t at = message.find(before);
  EXPECT_NE(at, std::string::npos) << message;
  if (at == std::string::npos) return {};
  std::string list = message.substr(at + before.size());
  for (char& c : list) c = c == ',' ? ' ' : c;
  std::istringstream words(list);
  Keys keys;
  for (std::string key; words >> key;) keys.insert(key);
  return keys;
}

TEST(RigKeys, TableOfTheDocsIsTheParsers) {
  std::map<std::string, std::string> probes{
      {"", "zzz: 1\n"},
      {"imu", "imu: {topic: /imu, zzz: 1}\n"},
      {"imu.noise", "imu: {topic: /imu, noise: {gyroscope: 1, accelerometer: 1, zzz: 1}}\n"},
  };
  for (const std::string group : {"lidars", "cameras"}) {
    const std::string start = "imu: {topic: /imu}\n" + group + ": {a: {topic: /a, ";
    probes[group + ".NAME"] = start + "zzz: 1}}\n";
    probes[group + ".NAME.T_imu_sensor"] = start + "T_imu_sensor: {zzz: 1}}}\n";
    probes[group + ".NAME.sigma"] =
        start + "T_imu_sensor: {xyz: [0, 0, 0], rpy_deg: [0, 0, 0]}, sigma: {zzz: 1}}}\n";
  }
  const std::map<std::string, Keys> documented = DocumentedKeys();
  for (const auto& [block, rig] : probes) {
    ASSERT_TRUE(documented.count(block) > 0) << "no key of '" << block << "' in docs/conventions.md";
    EXPECT_EQ(documented.at(block), AllowedKeys(rig)) << "of '" << block << "'";
  }
  for (const auto& [block, keys] : documented) {
    EXPECT_TRUE(probes.count(block) > 0) << "the parser knows no block '" << block << "'";
  }
}

}  // namespace
}  // namespace mlic::rig_keys_test

#include "mlic_core/io/result/run_keys.h"

namespace mlic {

std::string RunText(const std::optional<RunRecord>& run) {
  if (!run) return "";
  std::string text = "run:\n  version: " + QuotedYaml(run->version) + "\n";
  text += "  command: " + QuotedYaml(run->command) + "\n";
  text += run->inputs.empty() ? "  inputs: []\n" : "  inputs:\n";
  for (const RunInput& input : run->inputs) {
    text += "    - {path: " + QuotedYaml(input.path) + ", hash: " + QuotedYaml(input.hash) + "}\n";
  }
  std::string options;
  for (const auto& [name, value] : run->options) {
    options += (options.empty() ? "" : ", ") + name + ": " + QuotedYaml(value);
  }
  return text + "  options: {" + options + "}\n";
}

std::optional<RunRecord> ReadRun(const YamlReader& root) {
  if (!root.Has("run")) return std::nullopt;
  const YamlReader node = root.Get("run");
  RunRecord run;
  run.version = node.Get("version", "give the program's version").Text();
  if (node.Has("command")) run.command = node.Get("command").Text();
  if (node.Has("inputs")) {
    for (const YamlReader& input : node.Get("inputs").Elements()) {
      run.inputs.push_back({input.Get("path", "give a path").Text(),
                            input.Get("hash", "give the hash of its content").Text()});
    }
  }
  if (node.Has("options")) {
    for (const YamlReader& option : node.Get("options").Entries()) {
      run.options.emplace_back(option.Name(), option.Text());
    }
  }
  return run;
}

}  // namespace mlic

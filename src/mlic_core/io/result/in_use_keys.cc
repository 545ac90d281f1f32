#include "mlic_core/io/result/in_use_keys.h"

#include <cstdlib>
#include <cstring>

#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

constexpr const char* kPixels = "px_at_";
constexpr const char* kCentimetres = "cm_at_";
constexpr const char* kSectors = "_by_sector";
constexpr int kDigits = 4;  // from: structural, what of a sigma is worth reading

// Of what stands in the file, in one of what the result has.
double UnitOf(SigmaInUse::Where where) { return where == SigmaInUse::Where::kImage ? 1.0 : 0.01; }

std::string Listed(const std::vector<double>& values, double unit) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ", ") + ShortNumber(value / unit, kDigits);
  return "[" + text + "]";
}

std::vector<double> Scaled(std::vector<double> values, double unit) {
  for (double& value : values) value *= unit;
  return values;
}

}  // namespace

std::string InUseText(const std::vector<SigmaInUse>& uses) {
  std::string text;
  for (const SigmaInUse& use : uses) {
    const bool image = use.where == SigmaInUse::Where::kImage;
    const std::string key = (image ? kPixels : kCentimetres) + ShortNumber(use.distance, 6) + "m";
    const double unit = UnitOf(use.where);
    text += (text.empty() ? "" : ", ") + key + ": " + Listed({use.median, use.worst}, unit);
    if (!use.sectors.empty()) text += ", " + key + kSectors + ": " + Listed(use.sectors, unit);
  }
  return "{" + text + "}";
}

std::vector<SigmaInUse> ReadInUse(const YamlReader& owner) {
  std::vector<SigmaInUse> uses;
  if (!owner.Has("use")) return uses;
  const YamlReader node = owner.Get("use");
  for (const YamlReader& entry : node.Entries()) {
    const std::string name = entry.Name();
    const bool image = name.rfind(kPixels, 0) == 0;
    if ((!image && name.rfind(kCentimetres, 0) != 0) || name.find(kSectors) != std::string::npos) continue;
    SigmaInUse use;
    use.where = image ? SigmaInUse::Where::kImage : SigmaInUse::Where::kSpace;
    use.distance = std::strtod(name.c_str() + std::strlen(kPixels), nullptr);
    const double unit = UnitOf(use.where);
    const std::vector<double> values = entry.Numbers(2, "(median and worst)");
    use.median = unit * values[0];
    use.worst = unit * values[1];
    const std::string sectors = name + kSectors;
    if (node.Has(sectors)) {
      use.sectors = Scaled(node.Get(sectors).Numbers(kUseSectors, "of the horizon's sectors"), unit);
    }
    uses.push_back(use);
  }
  return uses;
}

}  // namespace mlic

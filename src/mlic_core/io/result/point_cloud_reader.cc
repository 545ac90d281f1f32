#include "mlic_core/io/result/point_cloud_reader.h"

#include <pcl/PCLPointCloud2.h>
#include <pcl/common/io.h>
#include <pcl/console/print.h>
#include <pcl/io/pcd_io.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string>

#include "mlic_core/common/error.h"

namespace mlic {
namespace {

template <typename T>
double As(const std::uint8_t* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return static_cast<double>(value);
}

// The first of the names that the file has; nullptr for none.
const pcl::PCLPointField* Find(const pcl::PCLPointCloud2& cloud, std::initializer_list<const char*> names) {
  for (const char* name : names) {
    for (const pcl::PCLPointField& field : cloud.fields) {
      if (field.name == name) return &field;
    }
  }
  return nullptr;
}

std::uint16_t RingOf(double value) {
  return value >= 0.0 && value <= 65535.0 ? static_cast<std::uint16_t>(value) : 0;
}

// What the header says that comes after it.
struct Claim {
  double points = 0.0;
  double bytes_of_point = 0.0;
  double bytes_of_padding = 0.0;  // of these, in fields called "_", which compressed points do not have
  double unpacked = 0.0;          // bytes, of compressed ones
  std::string kind;               // ascii, binary, binary_compressed
};

// Non-negative whole numbers; nothing where one of the words is none.
std::optional<std::vector<double>> WholeNumbers(std::istringstream& words) {
  std::vector<double> numbers;
  for (std::string word; words >> word;) {
    if (word.size() > 12 || word.find_first_not_of("0123456789") != std::string::npos) return std::nullopt;
    numbers.push_back(std::stod(word));
  }
  return numbers;
}

// PCL takes memory for all that a header claims before it reads any of it, and guesses at what a header may
// mean: only one that says each thing once, in whole words, reaches it.
std::optional<Claim> ReadClaim(const std::string& name) {
  Claim claim;
  std::ifstream file(name, std::ios::binary);
  std::set<std::string> left{"VERSION", "FIELDS", "SIZE",   "TYPE",      "COUNT",
                             "WIDTH",   "HEIGHT", "POINTS", "VIEWPOINT", "DATA"};
  std::vector<std::string> fields;
  std::map<std::string, std::vector<double>> numbers{
      {"SIZE", {}}, {"COUNT", {}}, {"WIDTH", {}}, {"HEIGHT", {}}, {"POINTS", {}}};
  for (std::string line; left.count("DATA") > 0;) {
    if (!std::getline(file, line)) return std::nullopt;
    std::istringstream words(line);
    std::string key;
    if (!(words >> key) || key.front() == '#') continue;
    if (left.erase(key) == 0) return std::nullopt;
    if (key == "DATA") words >> claim.kind;
    if (key == "FIELDS") fields.assign(std::istream_iterator<std::string>(words), {});
    const auto wanted = numbers.find(key);
    if (wanted == numbers.end()) continue;
    const auto found = WholeNumbers(words);
    if (!found || found->empty()) return std::nullopt;
    wanted->second = *found;
  }
  const auto first = [&](const char* key) { return numbers[key].empty() ? 1.0 : numbers[key].front(); };
  claim.points = std::max(first("POINTS"), first("WIDTH") * first("HEIGHT"));
  std::vector<double>& counts = numbers["COUNT"];
  counts.resize(numbers["SIZE"].size(), 1.0);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double bytes = numbers["SIZE"][i] * std::max(1.0, counts[i]);
    claim.bytes_of_point += bytes;
    if (i < fields.size() && fields[i] == "_") claim.bytes_of_padding += bytes;
  }
  if (claim.kind == "binary_compressed") {
    std::uint32_t sizes[2] = {0, 0};  // packed, unpacked
    file.read(reinterpret_cast<char*>(sizes), sizeof(sizes));
    claim.unpacked = sizes[1];
  }
  return claim;
}

// How many bytes of points one byte of the file can stand for.
double MostPacked(const std::string& kind) {
  if (kind == "binary") return 1.0;
  if (kind == "ascii") return 4.0;  // from: derivation, a digit and a space for a number of eight bytes
  return 88.0;                      // from: derivation, LZF's best, 264 bytes in three
}

class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : name_(path.string()) {}

  std::vector<CloudPoint> Read() {
    Load();
    const pcl::PCLPointField* x = Require({"x"}, "x");
    const pcl::PCLPointField* y = Require({"y"}, "y");
    const pcl::PCLPointField* z = Require({"z"}, "z");
    const pcl::PCLPointField* intensity =
        Require({"intensity", "reflectivity", "i"}, "intensity (which is what is matched to photos)");
    const pcl::PCLPointField* ring = Find(cloud_, {"ring", "channel", "line"});
    std::vector<CloudPoint> points;
    const std::size_t count = static_cast<std::size_t>(cloud_.width) * cloud_.height;
    if (cloud_.data.size() < count * cloud_.point_step) Fail("holds fewer points than its header claims");
    for (std::size_t i = 0; i < count; ++i) {
      CloudPoint point;
      point.position = Eigen::Vector3d(Value(*x, i), Value(*y, i), Value(*z, i)).cast<float>();
      point.intensity = static_cast<float>(Value(*intensity, i));
      if (ring != nullptr) point.ring = RingOf(Value(*ring, i));
      if (point.position.allFinite() && std::isfinite(point.intensity)) points.push_back(point);
    }
    if (points.empty()) Fail("holds no finite points");
    return points;
  }

 private:
  [[noreturn]] void Fail(const std::string& what) const { throw InputError(name_ + ": " + what); }

  [[noreturn]] void FailAsNoPcd() const {
    Fail(
        "cannot be read as a PCD file; expected a whole one, version 0.7 (ascii, binary or "
        "binary_compressed)");
  }

  void Load() {
    if (!std::filesystem::is_regular_file(name_)) Fail("no such file");
    const auto claim = ReadClaim(name_);
    if (!claim) FailAsNoPcd();
    const auto size = static_cast<double>(std::filesystem::file_size(name_));
    if (std::max(claim->unpacked, claim->points * claim->bytes_of_point) > MostPacked(claim->kind) * size) {
      Fail("claims more points than a file of its size can hold; expected a whole PCD file");
    }
    // PCL 1.13 reads on behind what was unpacked.
    if (claim->kind == "binary_compressed" &&
        claim->unpacked < claim->points * (claim->bytes_of_point - claim->bytes_of_padding)) {
      Fail("claims more points than its compressed data hold; expected a whole PCD file");
    }
    pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);  // the one line is ours
    bool read = false;
    try {
      // PCL 1.13 crashes where it reads on after a header that says nothing.
      pcl::PCDReader reader;
      read = reader.readHeader(name_, cloud_) == 0 && !cloud_.data.empty() && reader.read(name_, cloud_) == 0;
    } catch (const std::exception&) {
      // PCL throws for what it cannot parse, and std::bad_alloc for a header that claims too much.
    }
    if (!read) FailAsNoPcd();
  }

  const pcl::PCLPointField* Require(std::initializer_list<const char*> names, const std::string& need) const {
    const pcl::PCLPointField* field = Find(cloud_, names);
    if (field != nullptr) return field;
    std::string there;
    for (const pcl::PCLPointField& other : cloud_.fields) there += " " + other.name;
    Fail("has no field " + need + "; its fields are" + there);
  }

  // Whether its first number lies within a point.
  bool Fits(const pcl::PCLPointField& field) const {
    return field.offset + static_cast<std::size_t>(pcl::getFieldSize(field.datatype)) <= cloud_.point_step;
  }

  // The first number of a field of one point. pcl::fromPCLPointCloud2 takes only fields of the very type of a
  // point struct; scanners write intensity and ring in any.
  double Value(const pcl::PCLPointField& field, std::size_t point) const {
    if (!Fits(field))
      Fail("field " + field.name + " does not fit into a point; expected a COUNT of 1 or more");
    const std::uint8_t* bytes = cloud_.data.data() + point * cloud_.point_step + field.offset;
    switch (field.datatype) {
      case pcl::PCLPointField::INT8:
        return As<std::int8_t>(bytes);
      case pcl::PCLPointField::UINT8:
        return As<std::uint8_t>(bytes);
      case pcl::PCLPointField::INT16:
        return As<std::int16_t>(bytes);
      case pcl::PCLPointField::UINT16:
        return As<std::uint16_t>(bytes);
      case pcl::PCLPointField::INT32:
        return As<std::int32_t>(bytes);
      case pcl::PCLPointField::UINT32:
        return As<std::uint32_t>(bytes);
      case pcl::PCLPointField::FLOAT32:
        return As<float>(bytes);
      case pcl::PCLPointField::FLOAT64:
        return As<double>(bytes);
      default:
        Fail("field " + field.name +
             " has a type of 8 bytes or none that is known; expected F4, F8, or I or U with " +
             "1, 2 or 4 bytes");
    }
  }

  const std::string name_;
  pcl::PCLPointCloud2 cloud_;
};

}  // namespace

std::vector<CloudPoint> ReadPointCloudFile(const std::filesystem::path& path) { return Reader(path).Read(); }

}  // namespace mlic

#include "mlic_core/io/result/point_cloud_reader.h"

#include <pcl/PCLPointCloud2.h>
#include <pcl/console/print.h>
#include <pcl/io/pcd_io.h>

#include <cmath>
#include <cstring>
#include <initializer_list>
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
    for (std::size_t i = 0; i < count; ++i) {
      CloudPoint point;
      point.position = Eigen::Vector3d(Value(*x, i), Value(*y, i), Value(*z, i)).cast<float>();
      point.intensity = static_cast<float>(Value(*intensity, i));
      if (ring != nullptr) point.ring = static_cast<std::uint16_t>(Value(*ring, i));
      if (point.position.allFinite() && std::isfinite(point.intensity)) points.push_back(point);
    }
    if (points.empty()) Fail("holds no finite points");
    return points;
  }

 private:
  [[noreturn]] void Fail(const std::string& what) const { throw InputError(name_ + ": " + what); }

  void Load() {
    if (!std::filesystem::exists(name_)) Fail("no such file");
    pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);  // the one line is ours
    bool read = false;
    try {
      // PCL 1.13 crashes where it reads on after a header that says nothing.
      pcl::PCDReader reader;
      read = reader.readHeader(name_, cloud_) == 0 && !cloud_.data.empty() && reader.read(name_, cloud_) == 0;
    } catch (const std::exception&) {
      // PCL throws for what it cannot parse, and std::bad_alloc for a header that claims too much.
    }
    if (!read) {
      Fail(
          "cannot be read as a PCD file; expected a whole one, version 0.7 (ascii, binary or "
          "binary_compressed)");
    }
  }

  const pcl::PCLPointField* Require(std::initializer_list<const char*> names, const std::string& need) const {
    const pcl::PCLPointField* field = Find(cloud_, names);
    if (field != nullptr) return field;
    std::string there;
    for (const pcl::PCLPointField& other : cloud_.fields) there += " " + other.name;
    Fail("has no field " + need + "; its fields are" + there);
  }

  // The first number of a field of one point. pcl::fromPCLPointCloud2 takes only fields of the very type of a
  // point struct; scanners write intensity and ring in any.
  double Value(const pcl::PCLPointField& field, std::size_t point) const {
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

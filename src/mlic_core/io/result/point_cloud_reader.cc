#include "mlic_core/io/result/point_cloud_reader.h"

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <initializer_list>
#include <sstream>
#include <string>

#include "mlic_core/common/error.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

constexpr std::size_t kMostPoints = 100000000;  // from: guard, memory

struct Field {
  std::string name;
  std::size_t size = 0;
  char type = 'F';
  std::size_t count = 1;
  std::size_t offset = 0;  // bytes, in a point
};

struct Header {
  std::vector<Field> fields;
  std::size_t points = 0;
  std::size_t point_bytes = 0;
  std::string encoding;
  std::size_t end = 0;  // where the data begin
};

class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : name_(path.string()), content_(ReadFile(path)) {}

  std::vector<CloudPoint> Read() {
    ReadHeader();
    std::vector<CloudPoint> points;
    if (header_.encoding == "ascii") {
      points = ReadText();
    } else {
      points = ReadBytes(header_.encoding == "binary_compressed");
    }
    if (points.empty()) Fail("holds no finite points");
    return points;
  }

 private:
  [[noreturn]] void Fail(const std::string& what) const { throw InputError(name_ + ": " + what); }

  void ReadHeader() {
    std::vector<std::string> names, sizes, types, counts;
    while (header_.encoding.empty()) {
      const std::size_t stop = content_.find('\n', header_.end);
      if (stop == std::string::npos || header_.end > 100000) {
        Fail("not a PCD file: its header has no DATA line; expected a .pcd point cloud, version 0.7");
      }
      std::istringstream line(content_.substr(header_.end, stop - header_.end));
      header_.end = stop + 1;
      std::string key, word;
      line >> key;
      std::vector<std::string> words;
      while (line >> word) words.push_back(word);
      if (key == "FIELDS") names = words;
      if (key == "SIZE") sizes = words;
      if (key == "TYPE") types = words;
      if (key == "COUNT") counts = words;
      if (key == "POINTS" && words.size() == 1) header_.points = Number(words[0], key);
      if (key == "DATA" && words.size() == 1) header_.encoding = words[0];
    }
    if (header_.encoding != "ascii" && header_.encoding != "binary" &&
        header_.encoding != "binary_compressed") {
      Fail("DATA " + header_.encoding + " is unknown; expected ascii, binary or binary_compressed");
    }
    if (names.empty() || sizes.size() != names.size() || types.size() != names.size() ||
        (!counts.empty() && counts.size() != names.size())) {
      Fail("the header's FIELDS, SIZE, TYPE and COUNT lines do not fit each other");
    }
    for (std::size_t i = 0; i < names.size(); ++i) {
      Field field;
      field.name = names[i];
      field.size = Number(sizes[i], "SIZE");
      field.type = types[i][0];
      if (!counts.empty()) field.count = Number(counts[i], "COUNT");
      field.offset = header_.point_bytes;
      header_.point_bytes += field.size * field.count;
      header_.fields.push_back(field);
    }
    if (header_.points > kMostPoints) Fail("claims more than " + std::to_string(kMostPoints) + " points");
  }

  std::size_t Number(const std::string& word, const std::string& key) const {
    if (word.empty() || word.size() > 9 || word.find_first_not_of("0123456789") != std::string::npos) {
      Fail("the header's " + key + " has '" + word + "' where a number was expected");
    }
    return std::stoul(word);
  }

  // Index of the field that has one of the names; -1 for none.
  int Find(std::initializer_list<const char*> names) const {
    for (const char* name : names) {
      for (std::size_t i = 0; i < header_.fields.size(); ++i) {
        if (header_.fields[i].name == name) return static_cast<int>(i);
      }
    }
    return -1;
  }

  int Require(std::initializer_list<const char*> names, const std::string& need) const {
    const int index = Find(names);
    if (index >= 0) return index;
    std::string there;
    for (const Field& field : header_.fields) there += " " + field.name;
    Fail("has no field " + need + "; its fields are" + there);
  }

  // value(field) gives the first number of a field of one point.
  template <typename Value>
  void Add(const Value& value, std::vector<CloudPoint>* points) const {
    CloudPoint point;
    for (int k = 0; k < 3; ++k) point.position[k] = static_cast<float>(value(columns_[k]));
    point.intensity = static_cast<float>(value(columns_[3]));
    if (columns_[4] >= 0) point.ring = static_cast<std::uint16_t>(value(columns_[4]));
    if (point.position.allFinite() && std::isfinite(point.intensity)) points->push_back(point);
  }

  void FindColumns() {
    columns_[0] = Require({"x"}, "x");
    columns_[1] = Require({"y"}, "y");
    columns_[2] = Require({"z"}, "z");
    columns_[3] =
        Require({"intensity", "reflectivity", "i"}, "intensity (which is what is matched to photos)");
    columns_[4] = Find({"ring", "channel", "line"});
  }

  std::vector<CloudPoint> ReadText() {
    FindColumns();
    std::vector<std::size_t> first;  // word of each field
    std::size_t words = 0;
    for (const Field& field : header_.fields) {
      first.push_back(words);
      words += field.count;
    }
    std::istringstream text(content_.substr(header_.end));
    std::vector<double> row(words);
    std::string word;
    std::vector<CloudPoint> points;
    for (std::size_t p = 0; p < header_.points; ++p) {
      for (double& number : row) {
        if (!(text >> word)) Fail("ends after " + std::to_string(p) + " of its points; is it whole?");
        number = std::strtod(word.c_str(), nullptr);
      }
      Add([&](int field) { return row[first[static_cast<std::size_t>(field)]]; }, &points);
    }
    return points;
  }

  std::vector<CloudPoint> ReadBytes(bool compressed) {
    FindColumns();
    for (const Field& field : header_.fields) CheckType(field);
    const std::size_t needed = header_.points * header_.point_bytes;
    const std::string data = compressed ? Decompress(needed) : content_.substr(header_.end);
    if (data.size() < needed) Fail("is shorter than its header says; is it whole?");
    std::vector<CloudPoint> points;
    for (std::size_t p = 0; p < header_.points; ++p) {
      const auto value = [&](int index) {
        const Field& field = header_.fields[static_cast<std::size_t>(index)];
        // Compressed files hold all points' first fields, then all points' second ones.
        const std::size_t at = compressed ? field.offset * header_.points + p * field.size * field.count
                                          : p * header_.point_bytes + field.offset;
        return Decode(field, data.data() + at);
      };
      Add(value, &points);
    }
    return points;
  }

  void CheckType(const Field& field) const {
    const bool real = field.type == 'F' && (field.size == 4 || field.size == 8);
    const bool whole = (field.type == 'I' || field.type == 'U') &&
                       (field.size == 1 || field.size == 2 || field.size == 4 || field.size == 8);
    if (!real && !whole) {
      Fail("field " + field.name + " has type " + field.type + std::to_string(field.size) +
           "; expected F4, F8, or I or U with 1, 2, 4 or 8 bytes");
    }
  }

  template <typename T>
  static double As(const char* bytes) {
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return static_cast<double>(value);
  }

  static double Decode(const Field& field, const char* bytes) {
    if (field.type == 'F') return field.size == 4 ? As<float>(bytes) : As<double>(bytes);
    const bool sign = field.type == 'I';
    if (field.size == 1) return sign ? As<std::int8_t>(bytes) : As<std::uint8_t>(bytes);
    if (field.size == 2) return sign ? As<std::int16_t>(bytes) : As<std::uint16_t>(bytes);
    if (field.size == 4) return sign ? As<std::int32_t>(bytes) : As<std::uint32_t>(bytes);
    return sign ? As<std::int64_t>(bytes) : As<std::uint64_t>(bytes);
  }

  // LZF: a control byte below 32 copies as many bytes and one; any other repeats earlier output: its top
  // three bits are the length less 2 (7: one more byte adds to it), the rest and the next byte how far back.
  std::string Decompress(std::size_t needed) const {
    std::uint32_t sizes[2];
    if (content_.size() < header_.end + sizeof(sizes)) Fail("is shorter than its header says; is it whole?");
    std::memcpy(sizes, content_.data() + header_.end, sizeof(sizes));
    const std::size_t begin = header_.end + sizeof(sizes);
    if (sizes[1] != needed || content_.size() - begin < sizes[0]) {
      Fail("its compressed data do not have the size that the header says; is it whole?");
    }
    const auto* in = reinterpret_cast<const unsigned char*>(content_.data()) + begin;
    const unsigned char* const end = in + sizes[0];
    std::string out;
    out.reserve(needed);
    while (in < end) {
      const std::size_t control = *in++;
      if (control < 32) {
        if (static_cast<std::size_t>(end - in) < control + 1) Fail("its compressed data are damaged");
        out.append(reinterpret_cast<const char*>(in), control + 1);
        in += control + 1;
        continue;
      }
      std::size_t length = control >> 5;
      if (end - in < (length == 7 ? 2 : 1)) Fail("its compressed data are damaged");
      if (length == 7) length += *in++;
      const std::size_t back = ((control & 31) << 8) + *in++ + 1;
      if (back > out.size() || out.size() + length + 2 > needed) Fail("its compressed data are damaged");
      for (std::size_t k = 0; k < length + 2; ++k) out.push_back(out[out.size() - back]);
    }
    if (out.size() != needed) Fail("its compressed data are damaged");
    return out;
  }

  const std::string name_, content_;
  Header header_;
  int columns_[5] = {-1, -1, -1, -1, -1};  // fields: x, y, z, intensity, ring
};

}  // namespace

std::vector<CloudPoint> ReadPointCloudFile(const std::filesystem::path& path) { return Reader(path).Read(); }

}  // namespace mlic

#include "mlic_core/camera/colmap/colmap_database.h"

#include <sqlite3.h>

#include <memory>
#include <string>

#include "mlic_core/camera/colmap/colmap_camera.h"
#include "mlic_core/common/error.h"

namespace mlic {
namespace {

constexpr int kCalibratedGeometry = 2;  // COLMAP's TwoViewGeometry::CALIBRATED; from: standard
// from: standard.
constexpr std::int64_t kPairIdFactor = 2147483647;  // pair_id = smaller id * factor + larger id

// A database handle; every failure is one line that names the file.
class Database {
 public:
  explicit Database(const std::filesystem::path& path) : path_(path) {
    sqlite3* handle = nullptr;
    const int code = sqlite3_open_v2(path.c_str(), &handle, SQLITE_OPEN_READWRITE, nullptr);
    handle_.reset(handle);
    Expect(code == SQLITE_OK);
  }
  void Run(const char* text) {
    Expect(sqlite3_exec(handle_.get(), text, nullptr, nullptr, nullptr) == SQLITE_OK);
  }
  sqlite3_stmt* Prepare(const char* text) {
    sqlite3_stmt* statement = nullptr;
    Expect(sqlite3_prepare_v2(handle_.get(), text, -1, &statement, nullptr) == SQLITE_OK);
    return statement;
  }
  void Expect(bool good) const {
    if (good) return;
    throw InputError("COLMAP's database " + path_.string() + ": " + sqlite3_errmsg(handle_.get()) +
                     "; free space, or install the COLMAP of Debian (package colmap)");
  }

 private:
  struct Close {
    void operator()(sqlite3* handle) const { sqlite3_close(handle); }
  };
  std::filesystem::path path_;
  std::unique_ptr<sqlite3, Close> handle_;
};

// An INSERT that is run once for each row.
class Insert {
 public:
  Insert(Database& database, const char* text) : database_(database), statement_(database.Prepare(text)) {}
  Insert(const Insert&) = delete;
  Insert& operator=(const Insert&) = delete;
  ~Insert() { sqlite3_finalize(statement_); }

  void Integer(int column, std::int64_t value) { sqlite3_bind_int64(statement_, column, value); }
  void Text(int column, const std::string& value) {
    sqlite3_bind_text(statement_, column, value.c_str(), -1, SQLITE_TRANSIENT);
  }
  template <typename T>
  void Blob(int column, const std::vector<T>& values) {
    sqlite3_bind_blob64(statement_, column, values.data(), values.size() * sizeof(T), SQLITE_TRANSIENT);
  }
  void Row() {
    database_.Expect(sqlite3_step(statement_) == SQLITE_DONE);
    sqlite3_reset(statement_);
  }

 private:
  Database& database_;
  sqlite3_stmt* statement_;
};

std::string ImageName(std::size_t index) {
  const std::string number = std::to_string(index);
  return std::string(6 - std::min<std::size_t>(6, number.size()), '0') + number + ".png";
}

void AddCamera(Database& database, const CameraIntrinsics& camera) {
  Insert insert(database,
                "INSERT INTO cameras(camera_id, model, width, height, params, prior_focal_length) "
                "VALUES(1, ?, ?, ?, ?, 1)");
  insert.Integer(1, static_cast<int>(ColmapModelFor(camera.model)));
  insert.Integer(2, camera.width);
  insert.Integer(3, camera.height);
  insert.Blob(4, ToColmapParameters(camera));
  insert.Row();
}

void AddImages(Database& database, const std::vector<std::vector<Eigen::Vector2f>>& keypoints) {
  Insert image(database, "INSERT INTO images(image_id, name, camera_id) VALUES(?, ?, 1)");
  Insert points(database, "INSERT INTO keypoints(image_id, rows, cols, data) VALUES(?, ?, 2, ?)");
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    image.Integer(1, static_cast<std::int64_t>(i) + 1);
    image.Text(2, ImageName(i));
    image.Row();
    std::vector<float> data;
    for (const Eigen::Vector2f& pixel : keypoints[i]) {
      data.push_back(pixel.x() + 0.5f);
      data.push_back(pixel.y() + 0.5f);
    }
    points.Integer(1, static_cast<std::int64_t>(i) + 1);
    points.Integer(2, static_cast<std::int64_t>(keypoints[i].size()));
    points.Blob(3, data);
    points.Row();
  }
}

void AddMatches(Database& database, const std::vector<PairMatches>& pairs) {
  Insert matches(database, "INSERT INTO matches(pair_id, rows, cols, data) VALUES(?, ?, 2, ?)");
  Insert verified(database,
                  "INSERT INTO two_view_geometries(pair_id, rows, cols, data, config) VALUES(?, ?, 2, ?, ?)");
  for (const PairMatches& pair : pairs) {
    Check(pair.keyframe_a < pair.keyframe_b, "a pair of keyframes is out of order");
    std::vector<std::uint32_t> data;
    for (const FeatureMatch& match : pair.matches) {
      data.push_back(static_cast<std::uint32_t>(match.a));
      data.push_back(static_cast<std::uint32_t>(match.b));
    }
    const std::int64_t id = (pair.keyframe_a + 1) * kPairIdFactor + pair.keyframe_b + 1;
    for (Insert* insert : {&matches, &verified}) {
      insert->Integer(1, id);
      insert->Integer(2, static_cast<std::int64_t>(pair.matches.size()));
      insert->Blob(3, data);
    }
    verified.Integer(4, kCalibratedGeometry);
    matches.Row();
    verified.Row();
  }
}

}  // namespace

void FillColmapDatabase(const std::filesystem::path& path, const CameraIntrinsics& camera,
                        const std::vector<std::vector<Eigen::Vector2f>>& keypoints,
                        const std::vector<PairMatches>& matches) {
  Database database(path);
  database.Run("BEGIN");
  AddCamera(database, camera);
  AddImages(database, keypoints);
  AddMatches(database, matches);
  database.Run("COMMIT");
}

}  // namespace mlic

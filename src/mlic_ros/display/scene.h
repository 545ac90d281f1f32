#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "mlic/Status.h"
#include "mlic_core/result/observer.h"
#include "mlic_ros/display/path_turning.h"

namespace mlic {

// What the scene shows of one state of the calibration.
struct Scene {
  int round = 0;                    // from 1, over all stages; 0: the result
  std::vector<std::string> lidars;  // names, by the points' index
  std::vector<MapPoint> points;
  std::vector<PlanePatch> planes;
  bool planes_of_points = true;  // points have the index of these planes
  std::vector<StampedPose> trajectory;
  PathTurning turning;  // of the trajectory
  std::vector<LandmarkMark> landmarks;
  std::vector<SensorStatus> sensors;
  visualization_msgs::MarkerArray frustums;  // of cameras, in their frames
};

// The scenes of all rounds, or of rounds evenly chosen, in bounded memory.
class RoundHistory {
 public:
  static constexpr std::size_t kMostRounds = 32;     // from: guard, memory: 32 MB with those points
  static constexpr std::size_t kMostPoints = 30000;  // of a round; from: guard, likewise

  // Thins its points out. The first and the last round are always there.
  void Add(Scene scene);
  int RoundCount() const { return rounds_; }
  const std::vector<Scene>& Scenes() const { return scenes_; }

  // The kept round that `word` names, seen from the shown one (0: the latest state): "first", "previous",
  // "next" or a number, for which the nearest one is taken. Null: the latest state.
  const Scene* Find(const std::string& word, int shown) const;
  // The first one with points of the most LiDARs: before it each LiDAR has a map of its own. There is a
  // round.
  const Scene& FirstOfAllLidars() const;
  // Null where it is not kept.
  const Scene* At(int round) const;

 private:
  int rounds_ = 0;
  std::vector<Scene> scenes_;
};

enum class Colouring { kSensor, kResidual, kPlane };
std::optional<Colouring> ColouringOf(const std::string& word);
const char* NameOf(Colouring colouring);

// 0xRRGGBB of each point; where its plane is not known as of residual zero.
std::vector<std::uint32_t> ColoursOf(const Scene& scene, Colouring colouring);
// Likewise of each plane. By residual: from white to red where its points scatter kLargeScatter times as far
// about it as those of most planes do. Grey by sensor, as a plane is no one LiDAR's, and where the points'
// planes are others.
constexpr double kLargeScatter = 3.0;  // from: structural
std::vector<std::uint32_t> PlaneColours(const Scene& scene, Colouring colouring);
// Without the points of hidden LiDARs and the hidden cameras' frustums.
Scene WithoutHidden(const Scene& scene, const std::set<std::string>& hidden);
// The sensors where the rig file has them, of those that have a guess, with the map of `first`.
Scene WithGuesses(const Scene& scene, const Scene& first);
// With points evenly chosen of them, at most so many.
void ThinOut(std::size_t most_points, Scene* scene);
// What the colours of points, landmarks and path say, one entry of legend for each of legend_colours.
void SetLegend(Colouring colouring, const Scene& scene, Status* status);

}  // namespace mlic

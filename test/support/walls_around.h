#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "mlic_core/common/random.h"
#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/joint_solver.h"
#include "mlic_core/problem/state.h"
#include "support/lidars_at_rest.h"

namespace mlic {

// A LiDAR at rest that sees two walls and a ceiling at right angles with a view of 100 deg towards each.
class WallsAround : public testing::Test {
 protected:
  static constexpr int kSeconds = 10;
  static constexpr int kPoints = 400;     // of a second, on each wall
  static constexpr double kSigma = 0.01;  // m
  static constexpr double kReflectances[] = {0.05, 0.25, 0.6};

  WallsAround() { PlaceAtRest(kSeconds, 1, &dataset_, &problem_, &state_); }

  // m: of points that meet a wall at less than 45 deg, of others on walls, of those on the ceiling.
  void AddWalls(double steep_error, double oblique_error, double level_error) {
    Random random(7);
    for (int axis = 0; axis < 3; ++axis) {
      AddPlane(axis);
      AddPoints(axis, 0, &random, [&](const Eigen::Vector3d&, double cosine) -> Echo {
        return {axis == 2 ? level_error : 2.0 * cosine * cosine > 1.0 ? steep_error : oblique_error, 0.0};
      });
    }
    SolveJointProblem(problem_, 5, CancellationToken(), &state_);
  }

  // m, of a LiDAR each: of its points on the ceiling.
  void AddLevelErrors(const std::vector<double>& errors) {
    AddWallsSeenBy(errors.size(), 9, [&](int axis, std::size_t l, const Eigen::Vector3d&, double) -> Echo {
      return {axis == 2 ? errors[l] : 0.0, 0.0};
    });
  }

  // The same walls, patches of them bright, grey and dark, seen by a LiDAR for each walk (m for each power of
  // ten). relief: m, by which dark patches lie deeper.
  void AddPaintedWalls(const std::vector<double>& walks, double relief) {
    const auto echo_of = [&](int, std::size_t l, const Eigen::Vector3d& point, double cosine) -> Echo {
      const int paint = PaintAt(point);
      const double strength = kReflectances[paint] * cosine;
      return {(paint == 0 ? relief / cosine : 0.0) - walks[l] * std::log10(strength), 100.0 * strength};
    };
    AddWallsSeenBy(walks.size(), 8, echo_of);
  }

  // Two LiDARs between walls on both sides, painted as above: what is ten times darker lies deeper by the
  // relief (m). The second sees as many bright walls besides.
  void AddWallsOnBothSides(double relief) {
    state_.lidars.resize(2);
    problem_.lidars.resize(2);
    Random random(8);
    const auto echo_of = [&](double reflectance, double cosine) -> Echo {
      return {-relief * std::log10(reflectance) / cosine, 100.0 * reflectance * cosine};
    };
    for (const double side : {-1.0, 1.0}) {
      for (int axis = 0; axis < 3; ++axis) {
        AddPlane(axis, side);
        for (std::size_t l = 0; l < 2; ++l) {
          AddPoints(axis, l, &random, [&](const Eigen::Vector3d& point, double cosine) {
            return echo_of(kReflectances[PaintAt(point)], cosine);
          });
        }
        AddPlane(axis, side);
        AddPoints(axis, 1, &random,
                  [&](const Eigen::Vector3d&, double cosine) { return echo_of(1.0, cosine); });
      }
    }
    SolveJointProblem(problem_, 5, CancellationToken(), &state_);
  }

  // m, by which dark patches of painted walls lie deeper than before to these LiDARs.
  void AddRelief(double relief, const std::vector<std::int32_t>& lidars = {0, 1}) {
    for (PlaneObservation& o : problem_.drives[0].planes.observations) {
      if (std::find(lidars.begin(), lidars.end(), o.lidar) == lidars.end()) continue;
      const bool dark = o.intensity < 110.0 * kReflectances[0] * o.cos_incidence;
      o.position *= 1.0 + (dark ? relief / o.cos_incidence : 0.0) / o.position.norm();
    }
  }

 private:
  struct Echo {
    double error;  // of the range, m
    double intensity;
  };

  // Of kReflectances.
  static int PaintAt(const Eigen::Vector3d& point) {
    return (static_cast<int>(std::floor(point.sum())) % 3 + 3) % 3;
  }

  // echo_of: the wall's axis, the LiDAR, a point and the cosine of its incidence.
  template <typename EchoOf>
  void AddWallsSeenBy(std::size_t lidars, std::uint64_t seed, const EchoOf& echo_of) {
    state_.lidars.resize(lidars);
    problem_.lidars.resize(lidars);
    Random random(seed);
    for (int axis = 0; axis < 3; ++axis) {
      AddPlane(axis);
      for (std::size_t l = 0; l < lidars; ++l) {
        AddPoints(axis, l, &random, [&](const Eigen::Vector3d& point, double cosine) {
          return echo_of(axis, l, point, cosine);
        });
      }
    }
    SolveJointProblem(problem_, 5, CancellationToken(), &state_);
  }

  // 5 m off, on the positive or the negative side.
  void AddPlane(int axis, double side = 1.0) {
    PlaneAssociation& planes = problem_.drives[0].planes;
    MapPlane plane;
    plane.plane = {-side * Eigen::Vector3d::Unit(axis), -5.0};
    plane.center = 5.0 * side * Eigen::Vector3d::Unit(axis);
    planes.planes.push_back(plane);
    planes.begin.push_back(planes.observations.size());
  }

  // On the last plane. echo_of: a point and the cosine of its incidence.
  template <typename EchoOf>
  void AddPoints(int axis, std::size_t lidar, Random* random, const EchoOf& echo_of) {
    PlaneAssociation& planes = problem_.drives[0].planes;
    for (int k = 0; k < kSeconds * kPoints; ++k) {
      Eigen::Vector3d point;
      point[axis] = planes.planes.back().center[axis];
      point[(axis + 1) % 3] = random->Uniform(-6.0, 6.0);
      point[(axis + 2) % 3] = random->Uniform(-6.0, 6.0);
      const double cosine = 5.0 / point.norm();
      const Echo echo = echo_of(point, cosine);
      point *= 1.0 + (echo.error + kSigma * random->Normal()) / point.norm();
      planes.observations.push_back({point.cast<float>(), static_cast<float>(kSigma),
                                     static_cast<float>(cosine), static_cast<float>(echo.intensity),
                                     static_cast<std::int32_t>(lidar), 0,
                                     kSeconds * k / (1.0 * kSeconds * kPoints)});
    }
    planes.begin.back() = planes.observations.size();
  }

 protected:
  Dataset dataset_;
  JointProblem problem_;
  CalibrationState state_;
  bool walks_dropped_ = false;
};

}  // namespace mlic

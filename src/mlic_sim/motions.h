#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "mlic_core/common/random.h"
#include "mlic_sim/ground.h"
#include "mlic_sim/taylor.h"

namespace mlic::sim {

// Constants of this file, from: definition of the simulated motions.

// The motions of the scenarios, internal to trajectory.cc. Each gives the body's pose at a time, generic in
// the scalar: with double the pose, with Taylor its derivatives as well.

constexpr double kDegree = M_PI / 180.0;

// Position and fixed-axis roll, pitch, yaw of the body, R = Rz(yaw) Ry(pitch) Rx(roll).
template <typename Scalar>
struct BodyPose {
  Scalar x = 0.0, y = 0.0, z = 0.0, roll = 0.0, pitch = 0.0, yaw = 0.0;
};

struct Sine {
  double amplitude;
  double rate;  // rad/s
  double phase;
};

// A sum of sines about a centre.
struct Wave {
  double center = 0.0;
  std::vector<Sine> sines;

  void Add(double amplitude, double frequency_hz, double phase) {
    sines.push_back({amplitude, 2.0 * M_PI * frequency_hz, phase});
  }
  template <typename Scalar>
  Scalar At(const Scalar& t) const {
    using std::sin;
    Scalar sum(center);
    for (const Sine& s : sines) sum += Scalar(s.amplitude) * sin(Scalar(s.rate) * t + Scalar(s.phase));
    return sum;
  }
};

inline double RandomPhase(Random& random) { return random.Uniform(0.0, 2.0 * M_PI); }

// x = a1 sin(phi) + a3 sin(3 phi), y = b2 sin(2 phi) + b4 sin(4 phi): a figure-eight of 47 x 19 m whose loops
// are nearly circles of 9.5 m radius and whose path runs nearly evenly with phi (20.7 to 21.0 m/rad), found
// by minimising the largest curvature. Speed 4 to 5 m/s, yaw rate up to about 0.5 rad/s.
class FigureEight {
 public:
  FigureEight(std::uint64_t seed, bool with_suspension, const Terrain& terrain)
      : with_suspension_(with_suspension), terrain_(terrain) {
    Random random(seed);
    phase_rate_ = random.Uniform(0.205, 0.22);
    start_ = RandomPhase(random);
    direction_ = random.Uniform() < 0.5 ? -1.0 : 1.0;
    hurry_.Add(random.Uniform(0.015, 0.025), random.Uniform(0.11, 0.16), RandomPhase(random));
    hurry_.Add(random.Uniform(0.005, 0.01), random.Uniform(0.25, 0.33), RandomPhase(random));
    roll_.Add(random.Uniform(0.15, 0.25) * kDegree, random.Uniform(0.9, 1.15), RandomPhase(random));
    roll_.Add(random.Uniform(0.08, 0.15) * kDegree, random.Uniform(1.25, 1.5), RandomPhase(random));
    pitch_.Add(random.Uniform(0.15, 0.25) * kDegree, random.Uniform(1.0, 1.25), RandomPhase(random));
    pitch_.Add(random.Uniform(0.08, 0.15) * kDegree, random.Uniform(1.3, 1.5), RandomPhase(random));
    bounce_.Add(random.Uniform(0.003, 0.005), random.Uniform(1.1, 1.4), RandomPhase(random));
  }

  template <typename Scalar>
  BodyPose<Scalar> At(const Scalar& t) const {
    using std::atan2;
    using std::cos;
    using std::sin;
    constexpr double kA1 = 20.656, kA3 = -2.852, kB2 = 9.552, kB4 = -0.479;
    const Scalar phi = Scalar(direction_) * (Scalar(phase_rate_) * t + Scalar(start_) + hurry_.At(t));
    const Scalar phi2 = phi + phi, phi3 = phi2 + phi, phi4 = phi2 + phi2;
    BodyPose<Scalar> body;
    body.x = Scalar(kA1) * sin(phi) + Scalar(kA3) * sin(phi3);
    body.y = Scalar(kB2) * sin(phi2) + Scalar(kB4) * sin(phi4);
    // Along the direction of travel, d(x, y)/dphi.
    body.yaw = atan2(Scalar(2.0 * direction_ * kB2) * cos(phi2) + Scalar(4.0 * direction_ * kB4) * cos(phi4),
                     Scalar(direction_ * kA1) * cos(phi) + Scalar(3.0 * direction_ * kA3) * cos(phi3));
    if (with_suspension_) {
      // The right-hand loop (x > 0) is driven clockwise when direction is positive: the body leans outward.
      constexpr double kCorneringRoll = 0.4 * kDegree;
      body.roll = roll_.At(t) - Scalar(direction_ * kCorneringRoll) * sin(phi);
      body.pitch = pitch_.At(t);
      body.z = Scalar(0.8) * UnevenGroundHeight(body.x, body.y) + bounce_.At(t);
      if (!terrain_.waves.empty()) {
        const Scalar forward_x = cos(body.yaw), forward_y = sin(body.yaw);
        body.z += terrain_.Height(body.x, body.y);
        body.pitch += -terrain_.Slope(body.x, body.y, forward_x, forward_y);
        body.roll += terrain_.Slope(body.x, body.y, -forward_y, forward_x);
      }
    }
    return body;
  }

 private:
  bool with_suspension_;
  Terrain terrain_;
  double phase_rate_, start_, direction_;
  Wave hurry_, roll_, pitch_, bounce_;
};

// A walk through the hall at chest height while the rig is swung about all axes; with_tilts swings it far
// enough to either side and up and down for gravity to show the accelerometer's axes one by one. Other
// grounds squeeze the walk in y by their share of the hall's free breadth, or raise it.
class Handheld {
 public:
  Handheld(std::uint64_t seed, bool with_tilts, const MotionGround& ground) : ground_(ground) {
    Random random(seed);
    x_.Add(random.Uniform(4.5, 5.8), random.Uniform(0.016, 0.022), RandomPhase(random));
    y_.Add(random.Uniform(1.8, 2.5), random.Uniform(0.03, 0.042), RandomPhase(random));
    z_.center = 1.45;
    AddSway(random, 1.0, x_);
    AddSway(random, 1.0, y_);
    AddSway(random, 0.6, z_);
    AddSwing(random, roll_);
    AddSwing(random, pitch_);
    yaw_.center = RandomPhase(random);
    yaw_.Add(random.Uniform(70.0, 110.0) * kDegree, random.Uniform(0.05, 0.075), RandomPhase(random));
    AddSwing(random, yaw_);
    if (with_tilts) {
      AddTilt(random, roll_);
      AddTilt(random, pitch_);
    }
  }

  template <typename Scalar>
  BodyPose<Scalar> At(const Scalar& t) const {
    BodyPose<Scalar> body{x_.At(t),  Scalar(ground_.breadth) * y_.At(t), z_.At(t), roll_.At(t), pitch_.At(t),
                          yaw_.At(t)};
    if (!ground_.terrain.waves.empty()) body.z += ground_.terrain.Height(body.x, body.y);
    return body;
  }

 private:
  static void AddSway(Random& random, double scale, Wave& wave) {
    wave.Add(scale * random.Uniform(0.3, 0.45), random.Uniform(0.2, 0.32), RandomPhase(random));
    wave.Add(scale * random.Uniform(0.1, 0.18), random.Uniform(0.4, 0.6), RandomPhase(random));
    wave.Add(scale * random.Uniform(0.03, 0.06), random.Uniform(0.65, 0.9), RandomPhase(random));
  }
  static void AddSwing(Random& random, Wave& wave) {
    wave.Add(random.Uniform(11.0, 16.0) * kDegree, random.Uniform(0.2, 0.35), RandomPhase(random));
    wave.Add(random.Uniform(6.0, 10.0) * kDegree, random.Uniform(0.4, 0.6), RandomPhase(random));
    wave.Add(random.Uniform(3.0, 4.0) * kDegree, random.Uniform(0.65, 0.9), RandomPhase(random));
  }
  static void AddTilt(Random& random, Wave& wave) {
    wave.Add(random.Uniform(28.0, 32.0) * kDegree, random.Uniform(0.1, 0.15), RandomPhase(random));
  }

  MotionGround ground_;
  Wave x_, y_, z_, roll_, pitch_, yaw_;
};

// The yard's free lane: what a drive of this duration (s) along it has.
struct LaneDrive {
  explicit LaneDrive(double duration)
      : speed(std::min(kFastest, kLength / std::max(duration, 1.0))), start(-0.5 * speed * duration) {}

  static constexpr double kY = -11.5;      // m; from: definition, the yard's layout
  static constexpr double kFastest = 5.0;  // m/s
  static constexpr double kLength = 56.0;  // m
  double speed, start;                     // m/s, m
};

class Straight {
 public:
  explicit Straight(double duration) : lane_(duration) {}

  template <typename Scalar>
  BodyPose<Scalar> At(const Scalar& t) const {
    BodyPose<Scalar> body;
    body.x = Scalar(lane_.start) + Scalar(lane_.speed) * t;
    body.y = Scalar(LaneDrive::kY);
    return body;
  }

 private:
  LaneDrive lane_;
};

// Along the lane with changes of speed, from side to side of it.
class Weaving {
 public:
  Weaving(std::uint64_t seed, double duration) : lane_(duration) {
    Random random(seed);
    sway_ = random.Uniform(0.3, 1.0);
    sway_rate_ = 2.0 * M_PI / random.Uniform(5.0, 8.0);
    sway_start_ = RandomPhase(random);
    // Speed by up to a third.
    hurry_rate_ = 2.0 * M_PI / random.Uniform(9.0, 13.0);
    hurry_ = random.Uniform(0.2, 0.33) * lane_.speed / hurry_rate_;
    hurry_start_ = RandomPhase(random);
  }

  template <typename Scalar>
  BodyPose<Scalar> At(const Scalar& t) const {
    using std::atan2;
    using std::cos;
    using std::sin;
    const Scalar sway = Scalar(sway_rate_) * t + Scalar(sway_start_);
    const Scalar hurry = Scalar(hurry_rate_) * t + Scalar(hurry_start_);
    BodyPose<Scalar> body;
    body.x = Scalar(lane_.start) + Scalar(lane_.speed) * t + Scalar(hurry_) * sin(hurry);
    body.y = Scalar(LaneDrive::kY) + Scalar(sway_) * sin(sway);
    body.yaw = atan2(Scalar(sway_ * sway_rate_) * cos(sway),
                     Scalar(lane_.speed) + Scalar(hurry_ * hurry_rate_) * cos(hurry));
    return body;
  }

 private:
  LaneDrive lane_;
  double sway_, sway_rate_, sway_start_;     // m, rad/s, rad
  double hurry_, hurry_rate_, hurry_start_;  // m, rad/s, rad
};

class Parked {
 public:
  explicit Parked(std::uint64_t seed) {
    Random random(seed);
    yaw_ = random.Uniform(-M_PI, M_PI);
    x_ = random.Uniform(-4.0, 4.0);
  }

  template <typename Scalar>
  BodyPose<Scalar> At(const Scalar&) const {
    BodyPose<Scalar> body;
    body.x = Scalar(x_);
    body.yaw = Scalar(yaw_);
    return body;
  }

 private:
  double yaw_, x_;
};

// Counter-clockwise about one of the yard's islands.
class Circle {
 public:
  explicit Circle(std::uint64_t seed) {
    Random random(seed);
    rate_ = random.Uniform(0.42, 0.48);
    start_ = RandomPhase(random);
  }

  template <typename Scalar>
  BodyPose<Scalar> At(const Scalar& t) const {
    using std::cos;
    using std::sin;
    constexpr double kRadius = 8.0, kCenter = 15.0;
    const Scalar angle = Scalar(rate_) * t + Scalar(start_);
    BodyPose<Scalar> body;
    body.x = Scalar(kCenter) + Scalar(kRadius) * cos(angle);
    body.y = Scalar(kRadius) * sin(angle);
    body.yaw = angle + Scalar(0.5 * M_PI);
    return body;
  }

 private:
  double rate_, start_;
};

}  // namespace mlic::sim

#include "mlic_core/camera/tracks/tracks.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <set>

#include "mlic_core/camera/tracks/image_pairs.h"
#include "mlic_core/camera/tracks/keyframes.h"
#include "mlic_core/camera/tracks/static_mask.h"
#include "mlic_core/camera/tracks/tracks_from_images.h"
#include "support/synthetic_images.h"

namespace mlic::tracks_test {
namespace {

PairMatches Pair(int a, int b, std::vector<FeatureMatch> matches) { return {a, b, std::move(matches)}; }

TEST(JoinMatches, ChainsAcrossKeyframes) {
  const auto tracks =
      JoinMatches({2, 2, 2}, {Pair(0, 1, {{0, 1, 0.9f}, {1, 0, 0.8f}}), Pair(1, 2, {{1, 0, 0.9f}})});
  ASSERT_EQ(tracks.size(), 2u);
  ASSERT_EQ(tracks[0].size(), 3u);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(tracks[0][k].keyframe, k);
  EXPECT_EQ(tracks[0][1].feature, 1);
  EXPECT_EQ(tracks[1].size(), 2u);
}

TEST(JoinMatches, NeverPutsTwoFeaturesOfOneKeyframeIntoATrack) {
  // 0.0 - 1.0 - 2.0 is right; the weaker 0.1 - 2.0 would bring in a second feature of keyframe 0.
  const std::vector<PairMatches> pairs = {Pair(0, 1, {{0, 0, 0.9f}}), Pair(1, 2, {{0, 0, 0.9f}}),
                                          Pair(0, 2, {{1, 0, 0.5f}})};
  const auto tolerant = JoinMatches({2, 1, 1}, pairs, 2, 0.5);
  ASSERT_EQ(tolerant.size(), 1u);
  EXPECT_EQ(tolerant[0].size(), 3u);
  EXPECT_EQ(tolerant[0][0].feature, 0);
  // One contradiction in three matches is too much for a strict caller.
  EXPECT_TRUE(JoinMatches({2, 1, 1}, pairs, 2, 0.1).empty());
}

TEST(JoinMatches, RandomMatchesGiveConsistentTracks) {
  Random random(3);
  std::vector<PairMatches> pairs;
  for (int a = 0; a < 8; ++a) {
    for (int b = a + 1; b < 8; ++b) {
      std::vector<FeatureMatch> matches;
      for (int f = 0; f < 40; ++f) {
        const int wrong = static_cast<int>(random.Next() % 40);
        matches.push_back({f, random.Uniform() < 0.9 ? f : wrong, static_cast<float>(random.Uniform())});
      }
      pairs.push_back(Pair(a, b, matches));
    }
  }
  const auto tracks = JoinMatches(std::vector<std::size_t>(8, 40), pairs, 2, 1.0);
  ASSERT_FALSE(tracks.empty());
  std::set<std::pair<int, int>> used;
  for (const FeatureTrack& track : tracks) {
    for (std::size_t i = 0; i < track.size(); ++i) {
      if (i > 0) {
        EXPECT_LT(track[i - 1].keyframe, track[i].keyframe);
      }
      EXPECT_TRUE(used.emplace(track[i].keyframe, track[i].feature).second);
    }
  }
}

TEST(SelectTracks, PrefersLongOnesAndSpreads) {
  TrackSet set;
  for (int k = 0; k < 4; ++k) set.keyframes.push_back({0, static_cast<std::size_t>(k), 0.1 * k});
  const auto add = [&](int length, float x, float y) {
    Track track;
    for (int k = 0; k < length; ++k) track.observations.push_back({k, {x, y}, 0.5f});
    set.tracks.push_back(track);
  };
  for (int i = 0; i < 50; ++i) add(2, 10.0f, 10.0f);
  for (int i = 0; i < 50; ++i) add(4, 12.0f, 12.0f);
  add(2, 600.0f, 400.0f);  // alone in its corner
  TrackSelectionOptions options;
  options.most_in_keyframe = 100;
  const auto chosen = SelectTracks(set, std::vector<std::pair<int, int>>(4, {640, 480}), options);
  ASSERT_FALSE(chosen.empty());
  EXPECT_LT(chosen.size(), 10u);
  EXPECT_EQ(chosen.back(), 100u);
  EXPECT_GE(chosen.front(), 50u);  // short ones where there are long ones are not taken
}

TEST(ImagePairs, SequentialOnesStayInACameraAndDouble) {
  std::vector<Keyframe> keyframes;
  for (int camera = 0; camera < 2; ++camera) {
    for (int i = 0; i < 20; ++i) keyframes.push_back({camera, static_cast<std::size_t>(i), 0.1 * i});
  }
  SequentialPairOptions options;
  options.window = 2;
  options.largest_interval = 8;
  std::set<int> intervals;
  for (const ImagePair& pair : SequentialPairs(keyframes, options)) {
    EXPECT_EQ(keyframes[pair.a].camera, keyframes[pair.b].camera);
    intervals.insert(pair.b - pair.a);
  }
  EXPECT_EQ(intervals, (std::set<int>{1, 2, 4, 8}));
}

TEST(ImagePairs, PredictedOnesShareTheirView) {
  const CameraIntrinsics intrinsics = IntrinsicsFromFieldOfView(CameraModel::kPlumbBob, 640, 480, 90.0);
  const auto looking = [&](double yaw, const Eigen::Vector3d& position) {
    PredictedView view;
    view.T_map_camera.rotation = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY());
    view.T_map_camera.translation = position;
    view.intrinsics = &intrinsics;
    return view;
  };
  const std::vector<PredictedView> views = {looking(0.0, {0, 0, 0}), looking(3.14, {0, 0, 0}),
                                            looking(0.2, {0.5, 0, 0}), looking(0.0, {0, 0, 1.0})};
  const std::vector<Keyframe> keyframes = {{0, 0, 0.0}, {0, 1, 30.0}, {1, 0, 0.0}, {0, 2, 60.0}};
  EXPECT_NEAR(SharedView(views[0], views[0], {10.0}, 0.5), 1.0, 1e-9);
  EXPECT_EQ(SharedView(views[0], views[1], {10.0}, 0.5), 0.0);
  std::set<std::pair<int, int>> pairs;
  for (const ImagePair& pair : PredictedPairs(keyframes, views)) pairs.emplace(pair.a, pair.b);
  EXPECT_EQ(pairs, (std::set<std::pair<int, int>>{{0, 2}, {0, 3}, {2, 3}}));
}

// A camera that moves over the texture; the lower left corner of the image is the vehicle itself.
std::vector<cv::Mat> DriveWithBonnet(int count) {
  const SyntheticTexture texture(5), bonnet(9);
  std::vector<cv::Mat> images;
  for (int i = 0; i < count; ++i) {
    const double turn = 0.02 * i;
    images.push_back(RenderTexture(
        texture, 320, 240,
        [&](const Eigen::Vector2d& p) {
          if (p.x() < 120.0 && p.y() > 180.0) return Eigen::Vector2d(p.x() + 5000.0, p.y());
          return Eigen::Vector2d(std::cos(turn) * p.x() - std::sin(turn) * p.y() + 7.3 * i,
                                 std::sin(turn) * p.x() + std::cos(turn) * p.y() + 1.7 * i);
        },
        1.5, 100 + i));
  }
  return images;
}

CameraRecording Recording(std::vector<cv::Mat> images) {
  CameraRecording recording;
  recording.width = images[0].cols;
  recording.height = images[0].rows;
  recording.images = std::make_shared<MemoryImages>(std::move(images));
  return recording;
}

TEST(Keyframes, FollowTheMotionAndLeaveBlurredImagesOut) {
  std::vector<cv::Mat> images = DriveWithBonnet(24);
  for (const int i : {0, 6, 12, 18}) {
    cv::Mat blurred = images[i].clone();
    for (int y = 0; y < blurred.rows; ++y) {
      for (int x = 3; x + 3 < blurred.cols; ++x) {
        int sum = 0;
        for (int k = -3; k <= 3; ++k) sum += images[i].at<std::uint8_t>(y, x + k);
        blurred.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(sum / 7);
      }
    }
    images[i] = blurred;
  }
  const CameraRecording recording = Recording(images);
  // Moves for the first 1.2 s only.
  const VehiclePose pose = [](double time) -> std::optional<RigidTransform> {
    RigidTransform result;
    result.translation.x() = 10.0 * std::min(time, 1.2);
    return result;
  };
  KeyframeOptions options;
  options.most_keyframes = 4;
  const auto keyframes = SelectKeyframes(recording, 3, pose, options);
  ASSERT_GE(keyframes.size(), 3u);
  ASSERT_LE(keyframes.size(), 5u);
  for (const Keyframe& keyframe : keyframes) {
    EXPECT_EQ(keyframe.camera, 3);
    EXPECT_NE(keyframe.image % 6, 0u);
    EXPECT_LT(keyframe.time, 1.45);
  }
}

// Cameras without LiDAR: a camera in the hand that is looked at every 1.6 s (125 s of a real one, 80
// keyframes) has turned away from what it saw.
TEST(Keyframes, LieNoFurtherApartThanHalfASecondWherePosesAreNotKnown) {
  const CameraRecording recording = Recording(DriveWithBonnet(24));
  KeyframeOptions options;
  options.most_keyframes = 3;
  const auto keyframes = SelectKeyframes(recording, 0, {}, options);
  ASSERT_GE(keyframes.size(), 2u);
  double last = -0.3;
  for (const Keyframe& keyframe : keyframes) {
    EXPECT_LT(keyframe.time - last, 0.85);  // candidates lie up to a third away
    last = keyframe.time;
  }
  EXPECT_GT(last, 1.9);
  EXPECT_GE(keyframes.size(), 4u);
}

TEST(StaticPixels, AreTheVehicleItself) {
  const CameraRecording recording = Recording(DriveWithBonnet(24));
  std::vector<Keyframe> keyframes;
  for (std::size_t i = 0; i < 24; ++i) keyframes.push_back({0, i, 0.1 * i});
  const cv::Mat mask = FindStaticPixels(recording, keyframes, {});
  int left_out = 0, wrong = 0;
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      const bool own = x < 120 && y > 180;
      left_out += own && mask.at<std::uint8_t>(y, x) == 0;
      wrong += (x > 135 || y < 165) && mask.at<std::uint8_t>(y, x) == 0;
    }
  }
  EXPECT_GT(left_out, 0.97 * 120 * 59);
  EXPECT_LT(wrong, 0.01 * 320 * 240);
}

TEST(FindTracks, FollowTheTextureAndNotTheVehicle) {
  const CameraRecording recording = Recording(DriveWithBonnet(24));
  const CameraIntrinsics intrinsics = IntrinsicsFromFieldOfView(CameraModel::kPlumbBob, 320, 240, 60.0);
  TrackingOptions options;
  options.keyframes.most_keyframes = 10;
  const auto matcher = MakeClassicalMatcher();
  const TrackSet set = FindTracks({{&recording, intrinsics}}, VehiclePose(), CameraPose(), *matcher, options);
  ASSERT_GT(set.tracks.size(), 100u);
  double square = 0.0, whitened = 0.0;
  int count = 0, wrong = 0, longest = 0;
  for (const Track& track : set.tracks) {
    longest = std::max(longest, static_cast<int>(track.observations.size()));
    std::vector<Eigen::Vector2d> places;
    for (const TrackObservation& observation : track.observations) {
      const Eigen::Vector2d p = observation.pixel.cast<double>();
      EXPECT_FALSE(p.x() < 110.0 && p.y() > 190.0);
      const double i = static_cast<double>(set.keyframes[observation.keyframe].image), turn = 0.02 * i;
      places.emplace_back(std::cos(turn) * p.x() - std::sin(turn) * p.y() + 7.3 * i,
                          std::sin(turn) * p.x() + std::cos(turn) * p.y() + 1.7 * i);
    }
    for (std::size_t i = 1; i < places.size(); ++i) {
      const double error = (places[i] - places[i - 1]).squaredNorm() / 2.0;
      const double sigma_a = track.observations[i - 1].sigma, sigma_b = track.observations[i].sigma;
      wrong += error > 0.5;
      if (error > 0.5) continue;
      square += error;
      whitened += error / (sigma_a * sigma_a + sigma_b * sigma_b);
      ++count;
    }
  }
  std::printf("%zu tracks, longest %d, %d wrong of %d, rms %.3f px, %.2f sigma\n", set.tracks.size(), longest,
              wrong, wrong + count, std::sqrt(square / count), std::sqrt(whitened / count));
  EXPECT_GE(longest, 6);
  EXPECT_LT(wrong, 0.01 * count);
  EXPECT_LT(std::sqrt(square / count), 0.1);
  EXPECT_LT(std::sqrt(whitened / count), 1.5);
  // The same once more.
  const TrackSet again =
      FindTracks({{&recording, intrinsics}}, VehiclePose(), CameraPose(), *matcher, options);
  ASSERT_EQ(again.tracks.size(), set.tracks.size());
  for (std::size_t t = 0; t < set.tracks.size(); ++t) {
    ASSERT_EQ(again.tracks[t].observations.size(), set.tracks[t].observations.size());
    EXPECT_EQ(again.tracks[t].observations[0].pixel, set.tracks[t].observations[0].pixel);
  }
}

}  // namespace
}  // namespace mlic::tracks_test

#pragma once

#include <string>
#include <vector>

#include "mlic_core/camera/features/feature_matcher.h"
#include "mlic_core/camera/learned/learned_network.h"

namespace mlic {

// LightGlue (Lindenberger, Sarlin and Pollefeys, ICCV 2023): kpts0 [1, M, 2], kpts1 [1, N, 2], desc0 [1, M,
// 256], desc1 [1, N, 256]. SuperGlue (Sarlin et al., CVPR 2020): kpts0, kpts1, scores0 [1, M], scores1 [1,
// N], desc0 [1, 256, M], desc1 [1, 256, N]. Keypoints are relative to the image's middle, divided by half of
// its longer side (LightGlue) or by 0.7 of it (SuperGlue). Both return matches0 and mscores0: K pairs of
// indices [K, 2] and K scores, or for each of the M features its match or -1 [1, M] and M scores.
enum class PairingKind { kLightGlue, kSuperGlue };

NetworkSignature PairingSignature(PairingKind kind);

// Matches of score least_score and more, each feature at most once (a pair that is the best of both), ordered
// by a; guide: as in FeatureMatcher. Features without descriptor (all zero) are not matched. Throws
// InputError where the network returns something else than announced; `file` is for the message.
std::vector<FeatureMatch> PairFeatures(const Network& network, PairingKind kind, const std::string& file,
                                       const FeatureSet& a, const FeatureSet& b, const MatchGuide* guide,
                                       float least_score);

}  // namespace mlic

#pragma once

#include <filesystem>

#include "mlic_core/camera/learned/learned_network.h"
#include "mlic_core/camera/learned/learned_pairing.h"

namespace mlic {

// Small networks with the signatures of SuperPoint, LightGlue and SuperGlue. They are computed and not
// trained, and find right matches between images that are shifted and a little turned:
// - the detector finds corners (least eigenvalue, largest within 7 x 7 px) and describes them by the 16 x 16
//   px about them, mean removed and of unit length;
// - the matchers take the mutually best products of descriptors, less the squared distance of the keypoints.
//   They score everything 0 unless the largest coordinate is as the normalisation says: 0.6 to 1.01 of the
//   border. SuperGlue's also wants positive scores of the keypoints.
// LightGlue's returns pairs, SuperGlue's the match of each feature.

// superpoint.pt and lightglue.pt or superglue.pt.
void WriteTorchToyNetworks(const std::filesystem::path& directory, PairingKind kind);

// A module with this source of forward, and nothing else.
void WriteTorchModule(const std::filesystem::path& file, const char* forward);

// superpoint.onnx and lightglue.onnx or superglue.onnx. width, height: of the only image that the detector
// takes, 0 for any.
void WriteOnnxToyNetworks(const std::filesystem::path& directory, PairingKind kind, int width = 0,
                          int height = 0);

// Networks with the given names of inputs and outputs, which only pass a tensor on.
void WriteOnnxModule(const std::filesystem::path& file, const std::vector<NetworkPort>& inputs,
                     const std::vector<NetworkPort>& outputs);

}  // namespace mlic

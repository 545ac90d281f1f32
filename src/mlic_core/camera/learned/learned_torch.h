#pragma once

#include <filesystem>
#include <memory>

#include "mlic_core/camera/learned/network.h"

namespace mlic {

// LoadNetwork (learned_network.h) by this runtime; defined in builds that have it.
std::unique_ptr<Network> LoadTorchNetwork(const std::filesystem::path& file,
                                          const NetworkSignature& signature);

}  // namespace mlic

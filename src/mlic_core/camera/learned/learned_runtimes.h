#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "mlic_core/camera/learned/learned_network.h"

namespace mlic {

// LoadNetwork for each runtime; only those of this build are defined.
std::unique_ptr<Network> LoadOnnxNetwork(const std::filesystem::path& file,
                                         const NetworkSignature& signature);
std::unique_ptr<Network> LoadTorchNetwork(const std::filesystem::path& file,
                                          const NetworkSignature& signature);

// "a, b, c": the documented names of ports, for messages.
std::string PortNames(const std::vector<NetworkPort>& ports);

// The first line of a runtime's own message: some add a trace of calls.
std::string FirstLine(const std::string& message);

}  // namespace mlic

#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "mlic_core/camera/learned/network.h"

namespace mlic {

// The programs that run networks. Each is optional when MLIC is built.
enum class NetworkRuntime { kOnnxRuntime, kLibtorch };

// Those in this build, the preferred one first.
std::vector<NetworkRuntime> NetworkRuntimes();
const char* RuntimeName(NetworkRuntime runtime);     // for messages: "ONNX Runtime", "libtorch"
const char* FileSuffix(NetworkRuntime runtime);      // of its networks: ".onnx", ".pt"
const char* RuntimePackage(NetworkRuntime runtime);  // what to install: Debian's package

// Reads a network and compares what the file declares with the signature. Throws InputError, one line with
// the file's name, where the file cannot be read, an input or output is missing, is not expected, or has
// another shape. ONNX: inputs and outputs by name. TorchScript: forward's arguments in the order of the
// signature; it returns a tuple in that order, or a dictionary by name.
std::unique_ptr<Network> LoadNetwork(NetworkRuntime runtime, const std::filesystem::path& file,
                                     const NetworkSignature& signature);

}  // namespace mlic

#include "mlic_core/camera/learned/learned_network.h"

#include "mlic_core/camera/learned/learned_onnx.h"
#include "mlic_core/camera/learned/learned_torch.h"
#include "mlic_core/common/error.h"

namespace mlic {

std::vector<NetworkRuntime> NetworkRuntimes() {
  std::vector<NetworkRuntime> runtimes;
#ifdef MLIC_HAS_ONNX_RUNTIME
  runtimes.push_back(NetworkRuntime::kOnnxRuntime);
#endif
#ifdef MLIC_HAS_LIBTORCH
  runtimes.push_back(NetworkRuntime::kLibtorch);
#endif
  return runtimes;
}

const char* RuntimeName(NetworkRuntime runtime) {
  return runtime == NetworkRuntime::kOnnxRuntime ? "ONNX Runtime" : "libtorch";
}

const char* FileSuffix(NetworkRuntime runtime) {
  return runtime == NetworkRuntime::kOnnxRuntime ? ".onnx" : ".pt";
}

const char* RuntimePackage(NetworkRuntime runtime) {
  return runtime == NetworkRuntime::kOnnxRuntime ? "libonnxruntime-dev" : "libtorch-dev";
}

std::unique_ptr<Network> LoadNetwork(NetworkRuntime runtime, const std::filesystem::path& file,
                                     const NetworkSignature& signature) {
#ifdef MLIC_HAS_ONNX_RUNTIME
  if (runtime == NetworkRuntime::kOnnxRuntime) return LoadOnnxNetwork(file, signature);
#endif
#ifdef MLIC_HAS_LIBTORCH
  if (runtime == NetworkRuntime::kLibtorch) return LoadTorchNetwork(file, signature);
#endif
  (void)signature;
  throw InputError(file.string() + ": this build of MLIC has no " + RuntimeName(runtime) + ": install " +
                   RuntimePackage(runtime) + " and build again");
}

}  // namespace mlic

#include "mlic_core/camera/learned/learned_torch.h"

#include <ATen/Parallel.h>
#include <torch/csrc/jit/runtime/graph_executor.h>
#include <torch/script.h>

#include <algorithm>
#include <mutex>

#include "mlic_core/common/error.h"

extern "C" {
void openblas_set_num_threads(int threads);
int openblas_get_num_threads();
}

namespace mlic {
namespace {

// libtorch multiplies matrices by OpenBLAS, whose number of threads is the process': one while any network
// runs, for results that do not depend on it, and because the callers are parallel already.
class OneBlasThread {
 public:
  OneBlasThread() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (users_++ > 0) return;
    before_ = openblas_get_num_threads();
    openblas_set_num_threads(1);
  }
  ~OneBlasThread() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (--users_ == 0) openblas_set_num_threads(before_);
  }
  OneBlasThread(const OneBlasThread&) = delete;
  OneBlasThread& operator=(const OneBlasThread&) = delete;

 private:
  static inline std::mutex mutex_;
  static inline int users_ = 0;
  static inline int before_ = 1;
};

torch::Tensor ToTorch(const Tensor& tensor) {
  // Read only by the network; from_blob has no other type.
  return torch::from_blob(const_cast<float*>(tensor.values.data()), tensor.shape, torch::kFloat32);
}

Tensor FromTorch(const torch::Tensor& tensor) {
  const torch::Tensor values = tensor.detach().to(torch::kCPU, torch::kFloat32).contiguous();
  return {values.sizes().vec(), {values.data_ptr<float>(), values.data_ptr<float>() + values.numel()}};
}

class TorchNetwork : public Network {
 public:
  TorchNetwork(const std::filesystem::path& file, const NetworkSignature& signature)
      : file_(file.string()), signature_(signature) {
    // Once for the process: one thread in each operation, see Network.
    at::set_num_threads(1);
    try {
      module_ = torch::jit::load(file_, torch::kCPU);
      module_.eval();
    } catch (const std::exception& error) {
      throw InputError(file_ + ": cannot be read as a TorchScript module (torch.jit.save): " + Text(error));
    }
    CheckArguments();
  }

  std::vector<Tensor> Run(const std::vector<Tensor>& inputs) const override {
    at::init_num_threads();  // takes the one thread over to the calling thread
    const OneBlasThread one_blas_thread;
    const torch::InferenceMode no_gradients;
    // The optimising executor changes how it computes after its first runs, and so the last bits of results.
    const torch::jit::GraphOptimizerEnabledGuard plain_execution(false);
    try {
      std::vector<c10::IValue> values;
      for (const Tensor& input : inputs) values.emplace_back(ToTorch(input));
      return Outputs(module_.get_method("forward")(std::move(values)));
    } catch (const InputError&) {
      throw;
    } catch (const std::exception& error) {
      throw InputError(file_ + ": the network fails: " + Text(error));
    }
  }

  std::vector<std::int64_t> DeclaredShape(int) const override { return {}; }

 private:
  static std::string Text(const std::exception& error) {
    const auto* own = dynamic_cast<const c10::Error*>(&error);
    return FirstLine(own != nullptr ? own->what_without_backtrace() : error.what());
  }

  [[noreturn]] void FailOutputs(const std::string& found) const {
    throw InputError(file_ + ": forward must return a tuple of tensors (" + PortNames(signature_.outputs) +
                     ") or a dictionary with these names, and returns " + found);
  }

  void CheckArguments() const {
    const auto forward = module_.find_method("forward");
    if (!forward) throw InputError(file_ + ": the module has no method forward");
    const auto& schema = forward->function().getSchema();
    std::string found;
    std::size_t needed = 0;
    for (std::size_t i = 1; i < schema.arguments().size(); ++i) {  // 0 is self
      if (schema.arguments()[i].default_value()) continue;
      found += (needed++ > 0 ? ", " : "") + schema.arguments()[i].name();
    }
    if (needed != signature_.inputs.size()) {
      throw InputError(file_ + ": forward must take (" + PortNames(signature_.inputs) + "), and takes (" +
                       found + ")");
    }
    const auto& type = schema.returns().at(0).type();
    if (const auto tuple = type->cast<c10::TupleType>()) {
      if (tuple->elements().size() != signature_.outputs.size()) FailOutputs(type->repr_str());
    } else if (!type->cast<c10::DictType>()) {
      FailOutputs(type->repr_str());
    }
  }

  std::vector<Tensor> Outputs(const c10::IValue& value) const {
    std::vector<Tensor> outputs;
    if (value.isTuple()) {
      for (const c10::IValue& element : value.toTupleRef().elements()) {
        if (!element.isTensor()) FailOutputs(element.tagKind() + " in it");
        outputs.push_back(FromTorch(element.toTensor()));
      }
      return outputs;
    }
    const auto dictionary = value.toGenericDict();
    for (const NetworkPort& port : signature_.outputs) {
      const auto name = std::find_if(port.names.begin(), port.names.end(),
                                     [&](const std::string& n) { return dictionary.contains(n); });
      if (name == port.names.end()) FailOutputs("no " + port.names.front());
      outputs.push_back(FromTorch(dictionary.at(*name).toTensor()));
    }
    return outputs;
  }

  std::string file_;
  NetworkSignature signature_;
  torch::jit::Module module_;
};

}  // namespace

std::unique_ptr<Network> LoadTorchNetwork(const std::filesystem::path& file,
                                          const NetworkSignature& signature) {
  return std::make_unique<TorchNetwork>(file, signature);
}

}  // namespace mlic

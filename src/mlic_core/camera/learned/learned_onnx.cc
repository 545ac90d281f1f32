#include "mlic_core/camera/learned/learned_onnx.h"

#include <onnxruntime_cxx_api.h>

#include <algorithm>
#include <iostream>
#include <sstream>

#include "mlic_core/common/error.h"
#include "mlic_core/common/join.h"

namespace mlic {
namespace {

// Swallows what is written to std::cerr. Debian's package registers its operators twice at the first network
// that it loads and says so in 567 lines, without harm: real errors are exceptions.
class SilentErrors {
 public:
  SilentErrors() : before_(std::cerr.rdbuf(nothing_.rdbuf())) {}
  ~SilentErrors() { std::cerr.rdbuf(before_); }
  SilentErrors(const SilentErrors&) = delete;
  SilentErrors& operator=(const SilentErrors&) = delete;

 private:
  std::ostringstream nothing_;
  std::streambuf* before_;
};

// ONNX Runtime wants one environment in a process, before everything else and until the end.
Ort::Env& Environment() {
  static Ort::Env environment(ORT_LOGGING_LEVEL_ERROR, "mlic");
  return environment;
}

Ort::SessionOptions OneThread() {
  Ort::SessionOptions options;
  options.SetIntraOpNumThreads(1);
  options.SetInterOpNumThreads(1);
  options.SetExecutionMode(ORT_SEQUENTIAL);
  return options;
}

std::string ShapeText(const std::vector<std::int64_t>& shape) {
  std::string text = "[";
  for (std::size_t i = 0; i < shape.size(); ++i) {
    text += (i > 0 ? ", " : "") + (shape[i] < 0 ? std::string("any") : std::to_string(shape[i]));
  }
  return text + "]";
}

template <typename Number>
std::vector<float> Numbers(const Ort::Value& value, std::size_t count) {
  const Number* first = value.GetTensorData<Number>();
  std::vector<float> numbers(count);
  std::transform(first, first + count, numbers.begin(), [](Number n) { return static_cast<float>(n); });
  return numbers;
}

class OnnxNetwork : public Network {
 public:
  OnnxNetwork(const std::filesystem::path& file, const NetworkSignature& signature)
      : file_(file.string()), signature_(signature) {
    try {
      const SilentErrors silent;
      session_ = Ort::Session(Environment(), file.c_str(), OneThread());
    } catch (const Ort::Exception& error) {
      throw InputError(file_ + ": cannot be read as an ONNX network: " + FirstLine(error.what()));
    }
    FindInputs();
    FindOutputs();
  }

  std::vector<Tensor> Run(const std::vector<Tensor>& inputs) const override {
    try {
      const auto memory = Ort::MemoryInfo::CreateCpu(OrtDeviceAllocator, OrtMemTypeCPU);
      std::vector<Ort::Value> values;
      for (const Tensor& input : inputs) {
        // Read only by the network; CreateTensor has no other type.
        values.push_back(Ort::Value::CreateTensor<float>(memory, const_cast<float*>(input.values.data()),
                                                         input.values.size(), input.shape.data(),
                                                         input.shape.size()));
      }
      const std::vector<const char*> input_names = Pointers(input_names_),
                                     output_names = Pointers(output_names_);
      const std::vector<Ort::Value> results =
          session_.Run(Ort::RunOptions{nullptr}, input_names.data(), values.data(), values.size(),
                       output_names.data(), output_names.size());
      std::vector<Tensor> outputs;
      for (std::size_t i = 0; i < results.size(); ++i)
        outputs.push_back(ToTensor(results[i], output_names_[i]));
      return outputs;
    } catch (const Ort::Exception& error) {
      throw InputError(file_ + ": the network fails: " + FirstLine(error.what()));
    }
  }

  std::vector<std::int64_t> DeclaredShape(int input) const override { return shapes_[input]; }

 private:
  static std::vector<const char*> Pointers(const std::vector<std::string>& names) {
    std::vector<const char*> pointers;
    for (const std::string& name : names) pointers.push_back(name.c_str());
    return pointers;
  }

  Tensor ToTensor(const Ort::Value& value, const std::string& name) const {
    const auto information = value.GetTensorTypeAndShapeInfo();
    const std::size_t count = information.GetElementCount();
    switch (information.GetElementType()) {
      case ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT:
        return {information.GetShape(), Numbers<float>(value, count)};
      case ONNX_TENSOR_ELEMENT_DATA_TYPE_INT64:
        return {information.GetShape(), Numbers<std::int64_t>(value, count)};
      case ONNX_TENSOR_ELEMENT_DATA_TYPE_INT32:
        return {information.GetShape(), Numbers<std::int32_t>(value, count)};
      default:
        throw InputError(file_ + ": output " + name + " must be float, int64 or int32");
    }
  }

  // The name that a port has among those in the file; empty where it has none.
  static std::string Find(const NetworkPort& port, const std::vector<std::string>& in_file) {
    for (const std::string& name : port.names) {
      if (std::find(in_file.begin(), in_file.end(), name) != in_file.end()) return name;
    }
    return "";
  }

  void FindInputs() {
    const Ort::AllocatorWithDefaultOptions allocator;
    std::vector<std::string> in_file;
    for (std::size_t i = 0; i < session_.GetInputCount(); ++i) {
      in_file.emplace_back(session_.GetInputNameAllocated(i, allocator).get());
    }
    const std::string expected =
        file_ + ": inputs must be " + PortNames(signature_.inputs) + ", and are " + Joined(in_file);
    if (in_file.size() != signature_.inputs.size()) throw InputError(expected);
    for (const NetworkPort& port : signature_.inputs) {
      const std::string name = Find(port, in_file);
      if (name.empty()) throw InputError(expected);
      const auto index = std::find(in_file.begin(), in_file.end(), name) - in_file.begin();
      const auto type = session_.GetInputTypeInfo(index);
      if (type.GetONNXType() != ONNX_TYPE_TENSOR)
        throw InputError(file_ + ": input " + name + " is no tensor");
      const auto information = type.GetTensorTypeAndShapeInfo();
      CheckShape(name, port.shape, information.GetShape());
      if (information.GetElementType() != ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT) {
        throw InputError(file_ + ": input " + name + " must be float (32 bits)");
      }
      input_names_.push_back(name);
      shapes_.push_back(information.GetShape());
    }
  }

  void CheckShape(const std::string& name, const std::vector<std::int64_t>& expected,
                  const std::vector<std::int64_t>& found) const {
    if (found.empty()) return;  // the file does not say
    bool fits = expected.size() == found.size();
    for (std::size_t i = 0; fits && i < found.size(); ++i) {
      fits = found[i] < 0 || found[i] == expected[i] || expected[i] == kAnyOrFixed;
    }
    if (!fits) {
      throw InputError(file_ + ": input " + name + " must take the shape " + ShapeText(expected) +
                       ", and takes " + ShapeText(found));
    }
  }

  void FindOutputs() {
    const Ort::AllocatorWithDefaultOptions allocator;
    std::vector<std::string> in_file;
    for (std::size_t i = 0; i < session_.GetOutputCount(); ++i) {
      in_file.emplace_back(session_.GetOutputNameAllocated(i, allocator).get());
    }
    for (const NetworkPort& port : signature_.outputs) {
      output_names_.push_back(Find(port, in_file));
      if (!output_names_.back().empty()) continue;
      throw InputError(file_ + ": outputs must be " + PortNames(signature_.outputs) + ", and are " +
                       Joined(in_file));
    }
  }

  std::string file_;
  NetworkSignature signature_;
  // Run is safe from several threads but not declared const.
  mutable Ort::Session session_{nullptr};
  std::vector<std::string> input_names_, output_names_;
  std::vector<std::vector<std::int64_t>> shapes_;
};

}  // namespace

std::unique_ptr<Network> LoadOnnxNetwork(const std::filesystem::path& file,
                                         const NetworkSignature& signature) {
  return std::make_unique<OnnxNetwork>(file, signature);
}

}  // namespace mlic

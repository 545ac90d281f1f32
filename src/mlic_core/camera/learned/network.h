#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace mlic {

// A dense array of numbers, the last dimension contiguous. Whole numbers (indices, pixels) are exact up to
// 2^24.
struct Tensor {
  std::vector<std::int64_t> shape;
  std::vector<float> values;
};

// Sizes in NetworkPort::shape: the network must take any size; or it may as well take one size only.
constexpr std::int64_t kAny = -1, kAnyOrFixed = -2;  // from: structural

// An input or output of a network. names: those it may have in the file, the first is the documented one.
// shape: of inputs only.
struct NetworkPort {
  std::vector<std::string> names;
  std::vector<std::int64_t> shape;
};

struct NetworkSignature {
  std::vector<NetworkPort> inputs;
  std::vector<NetworkPort> outputs;
};

// A trained network in memory. Runs on the calling thread alone, so that results do not depend on how many
// there are; several threads may run it at once.
class Network {
 public:
  virtual ~Network() = default;
  // Inputs and outputs in the order of the signature. Throws InputError, one line with the file's name, where
  // the network fails or returns something else than tensors of numbers.
  virtual std::vector<Tensor> Run(const std::vector<Tensor>& inputs) const = 0;
  // Shape of an input as the file declares it, -1 where it is free; empty where the file says nothing.
  virtual std::vector<std::int64_t> DeclaredShape(int input) const = 0;
};

// "a, b, c": the documented names of ports, for messages.
std::string PortNames(const std::vector<NetworkPort>& ports);

// The first line of a runtime's own message: some add a trace of calls.
std::string FirstLine(const std::string& message);

}  // namespace mlic

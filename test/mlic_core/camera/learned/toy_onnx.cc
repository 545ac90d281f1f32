#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "mlic_core/camera/learned/toy_networks.h"

namespace mlic {
namespace {

// The bytes of a protocol buffer message: fields in the order in which they are added. Field numbers below
// are those of onnx.proto (ONNX 1.8, opset 13).
class Message {
 public:
  Message& Integer(int field, std::int64_t value) {
    Varint(static_cast<std::uint64_t>(field) << 3);
    Varint(static_cast<std::uint64_t>(value));
    return *this;
  }
  Message& Bytes(int field, const std::string& bytes) {
    Varint(static_cast<std::uint64_t>(field) << 3 | 2);
    Varint(bytes.size());
    bytes_ += bytes;
    return *this;
  }
  Message& Add(int field, const Message& message) { return Bytes(field, message.bytes_); }
  const std::string& Bytes() const { return bytes_; }

 private:
  void Varint(std::uint64_t value) {
    for (; value >= 0x80; value >>= 7) bytes_ += static_cast<char>((value & 0x7F) | 0x80);
    bytes_ += static_cast<char>(value);
  }
  std::string bytes_;
};

enum ElementType { kFloat = 1, kInt64 = 7 };

// An ONNX graph that grows node by node. Every method returns the name of its result.
class Graph {
 public:
  std::string Op(const std::string& type, const std::vector<std::string>& inputs,
                 const std::vector<Message>& attributes = {}, const std::string& output = "") {
    const std::string name = output.empty() ? "t" + std::to_string(count_++) : output;
    Message node;
    for (const std::string& input : inputs) node.Bytes(1, input);
    node.Bytes(2, name).Bytes(4, type);
    for (const Message& attribute : attributes) node.Add(5, attribute);
    graph_.Add(1, node);
    return name;
  }
  std::string Floats(const std::vector<float>& values, const std::vector<std::int64_t>& shape) {
    return Constant(kFloat, values.data(), values.size() * sizeof(float), shape);
  }
  std::string Float(float value) { return Floats({value}, {}); }
  std::string Integers(const std::vector<std::int64_t>& values) {
    return Constant(kInt64, values.data(), values.size() * sizeof(std::int64_t),
                    {static_cast<std::int64_t>(values.size())});
  }
  std::string Integer(std::int64_t value) { return Constant(kInt64, &value, sizeof value, {}); }
  void Input(const std::string& name, const std::vector<std::int64_t>& shape) {
    graph_.Add(11, Port(name, kFloat, &shape));
  }
  void Output(const std::string& name, ElementType type) { graph_.Add(12, Port(name, type, nullptr)); }

  void Write(const std::filesystem::path& file) const {
    Message graph = graph_;
    graph.Bytes(2, "toy");
    const Message opset = Message().Bytes(1, "").Integer(2, 13);
    const Message model = Message().Integer(1, 7).Add(7, graph).Add(8, opset);
    std::ofstream stream(file, std::ios::binary);
    stream << model.Bytes();
  }

 private:
  static Message Port(const std::string& name, ElementType type, const std::vector<std::int64_t>* shape) {
    Message tensor = Message().Integer(1, type);
    if (shape != nullptr) {
      Message dimensions;
      for (const std::int64_t size : *shape) {
        dimensions.Add(1, size > 0 ? Message().Integer(1, size) : Message().Bytes(2, name + "_any"));
      }
      tensor.Add(2, dimensions);
    }
    return Message().Bytes(1, name).Add(2, Message().Add(1, tensor));
  }
  std::string Constant(ElementType type, const void* values, std::size_t size,
                       const std::vector<std::int64_t>& shape) {
    const std::string name = "t" + std::to_string(count_++);
    Message tensor;
    for (const std::int64_t dimension : shape) tensor.Integer(1, dimension);
    tensor.Integer(2, type).Bytes(8, name);
    tensor.Bytes(9, std::string(static_cast<const char*>(values), size));
    graph_.Add(5, tensor);
    return name;
  }

  Message graph_;
  int count_ = 0;
};

Message Integers(const std::string& name, const std::vector<std::int64_t>& integers) {
  Message attribute = Message().Bytes(1, name);
  for (const std::int64_t value : integers) attribute.Integer(8, value);
  return attribute.Integer(20, 7);
}
Message Integer(const std::string& name, std::int64_t integer) {
  return Message().Bytes(1, name).Integer(3, integer).Integer(20, 2);
}
Message Text(const std::string& name, const std::string& text) {
  return Message().Bytes(1, name).Bytes(4, text).Integer(20, 3);
}

// Mean or maximum over size x size pixels about each pixel.
std::string Pool(Graph* g, const std::string& type, const std::string& input, std::int64_t size) {
  const std::int64_t half = size / 2;
  std::vector<Message> attributes = {Integers("kernel_shape", {size, size}),
                                     Integers("pads", {half, half, half, half})};
  if (type == "AveragePool") attributes.push_back(Integer("count_include_pad", 1));
  return g->Op(type, {input}, attributes);
}

std::string CornerScore(Graph* g, const std::string& smooth) {
  const std::string gx =
      g->Op("Conv", {smooth, g->Floats({-0.5f, 0.0f, 0.5f}, {1, 1, 1, 3})}, {Integers("pads", {0, 1, 0, 1})});
  const std::string gy =
      g->Op("Conv", {smooth, g->Floats({-0.5f, 0.0f, 0.5f}, {1, 1, 3, 1})}, {Integers("pads", {1, 0, 1, 0})});
  const std::string xx = Pool(g, "AveragePool", g->Op("Mul", {gx, gx}), 5);
  const std::string xy = Pool(g, "AveragePool", g->Op("Mul", {gx, gy}), 5);
  const std::string yy = Pool(g, "AveragePool", g->Op("Mul", {gy, gy}), 5);
  const std::string determinant = g->Op("Sub", {g->Op("Mul", {xx, yy}), g->Op("Mul", {xy, xy})});
  return g->Op("Div", {determinant, g->Op("Add", {g->Op("Add", {xx, yy}), g->Float(1e-9f)})});
}

// The 16 x 16 pixels about each keypoint as rows of unit length.
std::string Describe(Graph* g, const std::string& smooth, const std::string& row, const std::string& column) {
  const std::string padded =
      g->Op("Pad", {smooth, g->Integers({0, 0, 8, 8, 0, 0, 8, 8})}, {Text("mode", "edge")});
  const std::string width = g->Op("Gather", {g->Op("Shape", {padded}), g->Integer(3)}, {Integer("axis", 0)});
  std::vector<std::int64_t> rows, columns;
  for (int i = 0; i < 256; ++i) {
    rows.push_back(i / 16);
    columns.push_back(i % 16);
  }
  const std::string offsets = g->Op("Add", {g->Op("Mul", {g->Integers(rows), width}), g->Integers(columns)});
  const std::string corner = g->Op("Add", {g->Op("Mul", {row, width}), column});
  const std::string index = g->Op("Add", {g->Op("Unsqueeze", {corner, g->Integers({1})}), offsets});
  const std::string patch = g->Op("Gather", {g->Op("Reshape", {padded, g->Integers({-1})}), index});
  const std::string centred = g->Op("Sub", {patch, g->Op("ReduceMean", {patch}, {Integers("axes", {1})})});
  const std::string length = g->Op("ReduceL2", {centred}, {Integers("axes", {1})});
  return g->Op("Div", {centred, g->Op("Add", {length, g->Float(1e-6f)})});
}

void WriteDetector(const std::filesystem::path& file, int width, int height) {
  Graph g;
  g.Input("image", {1, 1, height, width});
  const std::string smooth = Pool(&g, "AveragePool", "image", 3);
  const std::string score = CornerScore(&g, smooth);
  const std::string is_best = g.Op("Equal", {score, Pool(&g, "MaxPool", score, 7)});
  const std::string is_corner = g.Op("And", {is_best, g.Op("Greater", {score, g.Float(1e-4f)})});
  const std::string where = g.Op("NonZero", {is_corner});
  const std::string row = g.Op("Gather", {where, g.Integer(2)}),
                    column = g.Op("Gather", {where, g.Integer(3)});
  const std::string first = g.Integers({0});
  const std::string keypoints = g.Op("Transpose", {g.Op("Gather", {where, g.Integers({3, 2})})});
  g.Op("Unsqueeze", {keypoints, first}, {}, "keypoints");
  g.Op("Unsqueeze", {g.Op("GatherND", {score, g.Op("Transpose", {where})}), first}, {}, "scores");
  g.Op("Unsqueeze", {Describe(&g, smooth, row, column), first}, {}, "descriptors");
  g.Output("keypoints", kInt64);
  g.Output("scores", kFloat);
  g.Output("descriptors", kFloat);
  g.Write(file);
}

struct Agreement {
  std::string mutual, partner, score;  // of each feature of the first set
};

Agreement Agree(Graph* g, const std::string& similarity_of_descriptors, float border) {
  const std::string difference = g->Op("Sub", {g->Op("Unsqueeze", {"kpts0", g->Integers({2})}),
                                               g->Op("Unsqueeze", {"kpts1", g->Integers({1})})});
  const std::string distance = g->Op("ReduceSum", {g->Op("Mul", {difference, difference}), g->Integers({3})},
                                     {Integer("keepdims", 0)});
  const std::string largest = g->Op("ReduceMax", {g->Op("Abs", {"kpts0"})}, {Integer("keepdims", 0)});
  const std::string is_normalized = g->Op("And", {g->Op("Less", {largest, g->Float(1.01f * border)}),
                                                  g->Op("Greater", {largest, g->Float(0.6f * border)})});
  const std::string similarity = g->Op("Mul", {g->Op("Sub", {similarity_of_descriptors, distance}),
                                               g->Op("Cast", {is_normalized}, {Integer("to", kFloat)})});
  const auto flat = [&](const std::string& name) { return g->Op("Squeeze", {name, g->Integers({0})}); };
  const auto best = [&](std::int64_t axis) {
    return flat(g->Op("ArgMax", {similarity}, {Integer("axis", axis), Integer("keepdims", 0)}));
  };
  Agreement result;
  result.partner = best(2);
  const std::string back = g->Op("Gather", {best(1), result.partner});
  const std::string count = g->Op("Gather", {g->Op("Shape", {"kpts0"}), g->Integer(1)});
  result.mutual = g->Op("Equal", {back, g->Op("Range", {g->Integer(0), count, g->Integer(1)})});
  result.score = flat(g->Op("ReduceMax", {similarity}, {Integers("axes", {2}), Integer("keepdims", 0)}));
  return result;
}

void WriteLightGlue(const std::filesystem::path& file) {
  Graph g;
  for (const char* name : {"kpts0", "kpts1"}) g.Input(name, {1, 0, 2});
  for (const char* name : {"desc0", "desc1"}) g.Input(name, {1, 0, 256});
  const std::string turned = g.Op("Transpose", {"desc1"}, {Integers("perm", {0, 2, 1})});
  const Agreement agreement = Agree(&g, g.Op("MatMul", {"desc0", turned}), 1.0f);
  const std::string chosen = g.Op("Squeeze", {g.Op("NonZero", {agreement.mutual}), g.Integers({0})});
  const std::string second = g.Integers({1});
  g.Op("Concat",
       {g.Op("Unsqueeze", {chosen, second}),
        g.Op("Unsqueeze", {g.Op("Gather", {agreement.partner, chosen}), second})},
       {Integer("axis", 1)}, "matches0");
  g.Op("Gather", {agreement.score, chosen}, {}, "mscores0");
  g.Output("matches0", kInt64);
  g.Output("mscores0", kFloat);
  g.Write(file);
}

void WriteSuperGlue(const std::filesystem::path& file) {
  Graph g;
  for (const char* name : {"kpts0", "kpts1"}) g.Input(name, {1, 0, 2});
  for (const char* name : {"scores0", "scores1"}) g.Input(name, {1, 0});
  for (const char* name : {"desc0", "desc1"}) g.Input(name, {1, 256, 0});
  const std::string turned = g.Op("Transpose", {"desc0"}, {Integers("perm", {0, 2, 1})});
  const Agreement agreement = Agree(&g, g.Op("MatMul", {turned, "desc1"}), 0.5f / 0.7f);
  const auto least = [&](const std::string& name) {
    return g.Op("Greater", {g.Op("ReduceMin", {name}, {Integer("keepdims", 0)}), g.Float(0.0f)});
  };
  const std::string positive =
      g.Op("Cast", {g.Op("And", {least("scores0"), least("scores1")})}, {Integer("to", kFloat)});
  const std::string matches = g.Op("Where", {agreement.mutual, agreement.partner, g.Integer(-1)});
  g.Op("Unsqueeze", {matches, g.Integers({0})}, {}, "matches0");
  g.Op("Unsqueeze", {g.Op("Mul", {agreement.score, positive}), g.Integers({0})}, {}, "matching_scores0");
  g.Output("matches0", kInt64);
  g.Output("matching_scores0", kFloat);
  g.Write(file);
}

}  // namespace

void WriteOnnxToyNetworks(const std::filesystem::path& directory, PairingKind kind, int width, int height) {
  WriteDetector(directory / "superpoint.onnx", width, height);
  if (kind == PairingKind::kLightGlue) {
    WriteLightGlue(directory / "lightglue.onnx");
  } else {
    WriteSuperGlue(directory / "superglue.onnx");
  }
}

void WriteOnnxModule(const std::filesystem::path& file, const std::vector<NetworkPort>& inputs,
                     const std::vector<NetworkPort>& outputs) {
  Graph g;
  for (const NetworkPort& port : inputs) g.Input(port.names.front(), port.shape);
  for (const NetworkPort& port : outputs) {
    g.Op("Identity", {inputs.front().names.front()}, {}, port.names.front());
    g.Output(port.names.front(), kFloat);
  }
  g.Write(file);
}

}  // namespace mlic

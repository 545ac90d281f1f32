#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

namespace mlic {

// Types without pointers, whose bytes are their value. Eigen's fixed-size matrices are such, though the
// language does not call them trivially copyable.
template <typename T>
struct IsFlat : std::integral_constant<bool, std::is_arithmetic<T>::value || std::is_enum<T>::value> {};

// Writes and reads values with the same calls: archive(a, b, c) for flat types, strings, vectors, optionals,
// arrays, and every type with a function Members(value) beside it that gives a tuple of references to what it
// holds, or, where that is not all, with a Fields(archive, value) of its own.
template <typename Archive, typename T>
void Fields(Archive& archive, T& value) {
  std::apply([&](auto&... members) { archive(members...); }, Members(value));
}

class ByteWriter {
 public:
  template <typename... T>
  void operator()(const T&... values) {
    (Write(values), ...);
  }
  std::vector<char> Take() { return std::move(bytes_); }

 private:
  void Append(const void* data, std::size_t size) {
    const char* begin = static_cast<const char*>(data);
    bytes_.insert(bytes_.end(), begin, begin + size);
  }
  template <typename T>
  void Write(const T& value) {
    if constexpr (IsFlat<T>::value) {
      Append(&value, sizeof(T));
    } else {
      Fields(*this, const_cast<T&>(value));  // a writer only reads its fields
    }
  }
  void Write(const std::string& text) {
    Write(static_cast<std::uint64_t>(text.size()));
    Append(text.data(), text.size());
  }
  template <typename T>
  void Write(const std::vector<T>& values) {
    Write(static_cast<std::uint64_t>(values.size()));
    if constexpr (IsFlat<T>::value) {
      Append(values.data(), values.size() * sizeof(T));
    } else {
      for (const T& value : values) Write(value);
    }
  }
  void Write(const std::vector<bool>& values) {
    Write(static_cast<std::uint64_t>(values.size()));
    for (const bool value : values) Write(value);
  }
  template <typename T>
  void Write(const std::optional<T>& value) {
    Write(value.has_value());
    if (value) Write(*value);
  }
  template <typename T, std::size_t N>
  void Write(const std::array<T, N>& values) {
    for (const T& value : values) Write(value);
  }

  std::vector<char> bytes_;
};

class ByteReader {
 public:
  explicit ByteReader(const std::vector<char>& bytes) : at_(bytes.data()), end_(at_ + bytes.size()) {}

  template <typename... T>
  void operator()(T&... values) {
    (Read(values), ...);
  }
  // For Fields that find values that contradict each other.
  void Fail() { failed_ = true; }
  // Everything was there, and nothing is left.
  bool Complete() const { return !failed_ && at_ == end_; }

 private:
  bool Take(void* data, std::uint64_t size) {
    if (failed_ || size > static_cast<std::uint64_t>(end_ - at_)) {
      failed_ = true;
      return false;
    }
    if (size > 0) std::memcpy(data, at_, size);
    at_ += size;
    return true;
  }
  // A count of elements of at least `size` bytes each; 0 when the rest cannot hold them.
  std::uint64_t Count(std::uint64_t size) {
    std::uint64_t count = 0;
    Read(count);
    if (count > static_cast<std::uint64_t>(end_ - at_) / size) failed_ = true;
    return failed_ ? 0 : count;
  }
  template <typename T>
  void Read(T& value) {
    if constexpr (IsFlat<T>::value) {
      Take(static_cast<void*>(&value), sizeof(T));
    } else {
      Fields(*this, value);
    }
  }
  void Read(bool& value) {
    std::uint8_t byte = 0;
    Take(&byte, sizeof(byte));
    if (byte > 1) failed_ = true;
    value = byte == 1;
  }
  void Read(std::string& text) {
    text.resize(Count(1));
    Take(text.data(), text.size());
  }
  template <typename T>
  void Read(std::vector<T>& values) {
    if constexpr (IsFlat<T>::value) {
      values.resize(Count(sizeof(T)));
      Take(static_cast<void*>(values.data()), values.size() * sizeof(T));
    } else {
      // Grown as it is read: a count alone takes no memory.
      values.clear();
      for (std::uint64_t left = Count(1); left > 0 && !failed_; --left) Read(values.emplace_back());
    }
  }
  void Read(std::vector<bool>& values) {
    values.resize(Count(1));
    for (std::size_t i = 0; i < values.size(); ++i) {
      bool value = false;
      Read(value);
      values[i] = value;
    }
  }
  template <typename T>
  void Read(std::optional<T>& value) {
    bool has_value = false;
    Read(has_value);
    value.reset();
    if (!has_value || failed_) return;
    value.emplace();
    Read(*value);
  }
  template <typename T, std::size_t N>
  void Read(std::array<T, N>& values) {
    for (T& value : values) Read(value);
  }

  const char* at_;
  const char* end_;
  bool failed_ = false;
};

}  // namespace mlic

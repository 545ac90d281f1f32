#pragma once

#include <ros/serialization.h>

#include "mlic_ros/bag/serialized_message.h"

namespace mlic {

// For roscpp to read the message from; it must outlive the stream. Reading past its end throws.
inline ros::serialization::IStream StreamOf(const SerializedMessage& message) {
  // roscpp adds to the pointer before it compares, which must not be null; and it only reads, but its
  // interface takes a pointer to non-const.
  static const std::uint8_t none = 0;
  const std::uint8_t* begin = message.bytes.empty() ? &none : message.bytes.data();
  return {const_cast<std::uint8_t*>(begin), static_cast<std::uint32_t>(message.bytes.size())};
}

}  // namespace mlic

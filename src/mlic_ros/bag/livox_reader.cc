#include "mlic_core/common/error.h"
#include "mlic_ros/bag/livox_message.h"
#include "mlic_ros/bag/message_stream.h"

namespace mlic {

LivoxMessage ReadLivoxMessage(const SerializedMessage& bytes, const std::string& topic) {
  constexpr std::uint32_t kPointBytes = 19;  // from: standard; of a serialised point
  try {
    ros::serialization::IStream stream = StreamOf(bytes);
    LivoxMessage message;
    stream.next(message.header);
    stream.next(message.timebase);
    stream.next(message.point_num);
    stream.next(message.lidar_id);
    for (auto& byte : message.reserved) stream.next(byte);
    std::uint32_t count = 0;
    stream.next(count);
    if (count > stream.getLength() / kPointBytes) throw std::out_of_range("points");
    message.points.resize(count);
    for (LivoxPoint& point : message.points) stream.next(point);
    return message;
  } catch (const std::exception&) {
    throw InputError("topic " + topic + ": a message of type " + bytes.type +
                     " is cut off or has another layout than its type says; record it again");
  }
}

}  // namespace mlic

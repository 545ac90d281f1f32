#include "mlic_ros/bag/image_messages.h"

#include <utility>

#include "mlic_core/common/error.h"
#include "mlic_ros/bag/image_reader.h"
#include "mlic_ros/bag/message_reader.h"

namespace mlic {

ImageFormat ProbeCamera(const BagSet& bags, const std::string& topic, const BagSet::Interval& interval) {
  constexpr std::size_t kProbeMessages = 10;  // from: guard, a topic's first messages
  std::string problem = "topic " + topic + ": no images in the chosen time";
  for (const SerializedMessage& message : ReadFirst(bags, topic, interval, kProbeMessages)) {
    try {
      return FormatOf(topic, ReadImageHeader(message), DecodeImage(message, "topic " + topic));
    } catch (const InputError& error) {
      problem = error.what();
    }
  }
  throw InputError(problem);
}

ImageStream MakeImageStream(const std::shared_ptr<const BagSet>& bags, std::vector<ImageHeader> headers,
                            std::vector<BagPlace> places) {
  return {std::move(headers),
          [bags, places = std::move(places)](std::size_t index, const std::string& where) {
            return DecodeImage(ReadMessage(*bags, *places.at(index)), where);
          }};
}

}  // namespace mlic

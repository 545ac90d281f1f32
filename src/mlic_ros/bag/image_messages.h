#pragma once

#include <memory>
#include <string>
#include <vector>

#include "mlic_core/ingest/image_stream.h"
#include "mlic_ros/bag/bag_set.h"

namespace mlic {

// Where a message lies in the bags.
using BagPlace = std::shared_ptr<const rosbag::MessageInstance>;

// By the first messages of a topic. Throws InputError, one line that starts with the topic, when none of them
// can be decoded.
ImageFormat ProbeCamera(const BagSet& bags, const std::string& topic, const BagSet::Interval& interval);

// The stream whose images of headers[i] lies at places[i]. Images stay in the bags, which stay open for as
// long as the stream lives. Reading is one at a time, decoding in parallel.
ImageStream MakeImageStream(const std::shared_ptr<const BagSet>& bags, std::vector<ImageHeader> headers,
                            std::vector<BagPlace> places);

}  // namespace mlic

#pragma once

#include <memory>
#include <vector>

#include "mlic_core/ingest/drive_notes.h"
#include "mlic_core/sensors/images.h"
#include "mlic_ros/bag/bag_images.h"

namespace mlic {

// Puts one camera's images in order of time, leaves out those that cannot be used and says so. Throws
// InputError, one line that starts with the topic, when there are none or more than a fifth cannot be used.
CameraRecording BuildCamera(std::vector<ReadImage> images, const ImageFormat& format,
                            const std::shared_ptr<const BagSet>& bags, TimeNs epoch, DriveNotes& notes);

}  // namespace mlic

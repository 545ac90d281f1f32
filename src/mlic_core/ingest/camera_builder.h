#pragma once

#include "mlic_core/common/time.h"
#include "mlic_core/ingest/drive_notes.h"
#include "mlic_core/ingest/image_stream.h"
#include "mlic_core/sensors/images.h"

namespace mlic {

// Puts one camera's images in order of time, leaves out those that cannot be used and says so. Throws
// InputError, one line that starts with the topic, when there are none or more than a fifth cannot be used.
CameraRecording BuildCamera(ImageStream stream, const ImageFormat& format, TimeNs epoch, DriveNotes& notes);

}  // namespace mlic

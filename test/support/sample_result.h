#pragma once

#include "mlic_core/result/result.h"

namespace mlic {

// A made-up result of a drive with three LiDARs and a camera in which every field is used: z is unobservable.
CalibrationResult SampleResult();

}  // namespace mlic

#pragma once

#include <filesystem>
#include <functional>

#include "mlic_core/common/progress.h"
#include "mlic_core/pipeline/options.h"
#include "mlic_core/pipeline/stage_store.h"
#include "mlic_core/result/observer.h"
#include "mlic_core/result/result.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

// Dataset and rig in, result out: the whole pipeline of docs/method.md. Throws InputError for data that
// cannot be used, Cancelled when the token is set; too little motion is not an error but a refused result.
// Where a store is given, stages that it holds are taken over and those that are finished are put there. It
// must belong to this rig and dataset. The result is that of a run without it, bit for bit.
CalibrationResult Calibrate(const Rig& rig, const Dataset& dataset, const CancellationToken& cancellation,
                            CalibrationObserver& observer, StageStore* store = nullptr,
                            const CalibrationOptions& options = {});

}  // namespace mlic

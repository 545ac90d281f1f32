#pragma once

#include "mlic_core/common/progress.h"

namespace mlic {

// Lets SIGINT and SIGTERM set the returned token; a second signal ends the process at once with status 130.
const CancellationToken& CancelOnSignals();

// Sets that token, too; what a button does in place of a signal.
void CancelOnRequest();

// Whether there was such a signal.
bool WasSignalled();

}  // namespace mlic

#include "mlic_ros/programs/interrupt.h"

#include <unistd.h>

#include <csignal>

#include "mlic_ros/programs/program.h"

namespace mlic {
namespace {

CancellationToken token;

extern "C" void OnSignal(int) {
  if (token.IsCancelled()) _exit(kInterrupted);
  token.Cancel();
}

}  // namespace

const CancellationToken& CancelOnSignals() {
  struct sigaction action {};
  action.sa_handler = OnSignal;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  return token;
}

}  // namespace mlic

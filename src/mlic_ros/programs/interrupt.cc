#include "mlic_ros/programs/interrupt.h"

#include <unistd.h>

#include <csignal>

#include "mlic_ros/programs/program.h"

namespace mlic {
namespace {

CancellationToken token;
volatile std::sig_atomic_t signalled = 0;

extern "C" void OnSignal(int) {
  if (signalled != 0) _exit(kInterrupted);
  signalled = 1;
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

void CancelOnRequest() { token.Cancel(); }

bool WasSignalled() { return signalled != 0; }

}  // namespace mlic

#include "mlic_ros/programs/thread_limit.h"

extern "C" void openblas_set_num_threads(int threads);

namespace mlic {
namespace {

int DefaultThreads() {
  return static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

}  // namespace

ThreadLimit::ThreadLimit(int threads) {
  if (threads > 0) {
    limit_ = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                   static_cast<std::size_t>(threads));
  }
  openblas_set_num_threads(threads > 0 ? threads : DefaultThreads());
}

}  // namespace mlic

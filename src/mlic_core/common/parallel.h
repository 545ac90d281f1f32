#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>

namespace mlic {

// Calls body(i) for i in [0, count), in parallel. The body may write only to what belongs to its index.
template <typename Body>
void ParallelFor(std::size_t count, const Body& body) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 1), [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i) body(i);
  });
}

// Calls body(chunk, begin, end) for `chunks` contiguous parts of [0, count). The parts depend on count and
// chunks only, never on the number of threads, so per-chunk sums added in chunk order are reproducible bit
// for bit.
template <typename Body>
void ParallelChunks(std::size_t count, std::size_t chunks, const Body& body) {
  chunks = std::max<std::size_t>(1, std::min(chunks, count));
  ParallelFor(chunks, [&](std::size_t c) { body(c, count * c / chunks, count * (c + 1) / chunks); });
}

}  // namespace mlic

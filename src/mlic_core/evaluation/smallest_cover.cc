#include "mlic_core/evaluation/smallest_cover.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

namespace mlic {
namespace {

// The covers of so many bodies at most: of a difference that is not covered, one or the other end moved.
void AddCovers(const std::vector<Difference>& differences, std::size_t most, BodySet* bodies,
               std::set<BodySet>* covers) {
  const auto open = std::find_if(differences.begin(), differences.end(), [&](const Difference& d) {
    return bodies->count(d.a) == 0 && bodies->count(d.b) == 0;
  });
  if (open == differences.end()) {
    covers->insert(*bodies);
    return;
  }
  if (bodies->size() == most) return;
  for (const std::size_t end : {open->a, open->b}) {
    bodies->insert(end);
    AddCovers(differences, most, bodies, covers);
    bodies->erase(end);
  }
}

double LeftOver(const std::vector<Difference>& all, const BodySet& cover) {
  double sum = 0.0;
  for (const Difference& d : all) {
    if (cover.count(d.a) == 0 && cover.count(d.b) == 0) sum += d.sigmas * d.sigmas;
  }
  return sum;
}

}  // namespace

Cover SmallestCover(const std::vector<Difference>& all, double limit, std::size_t reference) {
  constexpr double kAsGood = 9.0;  // squared sigmas; from: derivation, three sigmas
  std::vector<Difference> differing;
  std::copy_if(all.begin(), all.end(), std::back_inserter(differing),
               [&](const Difference& d) { return d.sigmas > limit; });
  std::set<BodySet> covers;
  for (std::size_t most = 0; covers.empty(); ++most) {
    BodySet none;
    AddCovers(differing, most, &none, &covers);
  }
  double least = std::numeric_limits<double>::infinity();
  for (const BodySet& cover : covers) least = std::min(least, LeftOver(all, cover));
  const BodySet* best = nullptr;
  const auto worse = [&](const BodySet& cover) {
    return std::make_pair(cover.count(reference), LeftOver(all, cover));
  };
  for (const BodySet& cover : covers) {
    if (LeftOver(all, cover) > least + kAsGood) continue;
    if (best == nullptr || worse(cover) < worse(*best)) best = &cover;
  }
  Cover result{*best, {}};
  for (const BodySet& cover : covers) {
    if (LeftOver(all, cover) > least + kAsGood) continue;
    std::set_difference(cover.begin(), cover.end(), best->begin(), best->end(),
                        std::inserter(result.or_instead, result.or_instead.end()));
  }
  return result;
}

}  // namespace mlic

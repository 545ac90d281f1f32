// Time and memory of the own solver and of Ceres on the joint problem of IMU and LiDARs, from the same
// linearisation point, with the same residuals (ceres_reference/):
//   joint_solver_benchmark [SECONDS [CSV]]        (from the repository root; 60 s)
// Each solver runs in a process of its own. Seconds and memory (above what the data take) count from the
// problem as data until every calibration parameter is within 0.01 sigma of the minimum.

#include <tbb/global_control.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "ceres_reference/ceres_joint_problem.h"
#include "ceres_reference/comparison.h"
#include "joint_solver_case.h"
#include "measured_process.h"
#include "mlic_core/solver/blas.h"

namespace mlic {
namespace {

using ceres_reference::CeresJointProblem;
using ceres_reference::OwnMinimum;

constexpr double kReached = 0.01;  // sigmas from the minimum
constexpr int kMostIterations = 50;

struct Seconds {
  double wall = 0.0, user = 0.0;
};
Seconds Since(const Usage& usage) { return {usage.Wall(), usage.User()}; }

struct Measurement {
  int iterations = 0;
  double error = 0.0;  // where the solve ends: largest, sigmas; of the covariance: largest, of the variances
  Seconds setup, all;
  double megabytes = 0.0;
};

double Apart(const Layout& layout, const CalibrationState& state, const OwnMinimum& minimum) {
  return ceres_reference::LargestInSigmas(
      ceres_reference::CalibrationDifference(layout, state, minimum.state), minimum.covariance);
}

double LargestError(const Eigen::MatrixXd& covariance, const Eigen::MatrixXd& expected) {
  const Eigen::VectorXd sigmas = expected.diagonal().cwiseSqrt();
  return (covariance - expected).cwiseQuotient(sigmas * sigmas.transpose()).cwiseAbs().maxCoeff();
}

Measurement RunOwn(const JointSolverCase& given, const OwnMinimum& minimum) {
  const Layout layout(given.start, given.problem.estimate_imu_matrices);
  Measurement measurement;
  const Usage usage;
  JointProblem problem = given.problem;
  CalibrationState state = given.start;
  measurement.setup = Since(usage);
  do {
    ceres_reference::ContinueSolve(1, &problem, &state);
    ++measurement.iterations;
    measurement.error = Apart(layout, state, minimum);
  } while (measurement.error > kReached && measurement.iterations < kMostIterations);
  measurement.all = Since(usage);
  measurement.megabytes = usage.PeakMegabytes();
  return measurement;
}

// What the own solver does for its covariance besides one iteration: its information comes with each.
Measurement RunOwnCovariance(const OwnMinimum& minimum) {
  Measurement measurement;
  const Usage usage;
  JointProblem problem = minimum.problem;
  CalibrationState state = minimum.state;
  const SolveSummary summary = ceres_reference::ContinueSolve(1, &problem, &state);
  const Eigen::MatrixXd covariance =
      ceres_reference::CalibrationCovariance(problem, state, summary.information);
  measurement.all = Since(usage);
  measurement.megabytes = usage.PeakMegabytes();
  measurement.error = LargestError(covariance, minimum.covariance);
  return measurement;
}

// Ends Ceres where the minimum is reached.
class UntilReached : public ceres::IterationCallback {
 public:
  UntilReached(CeresJointProblem* problem, const OwnMinimum& minimum, const Usage& usage,
               Measurement* measurement)
      : problem_(problem), minimum_(minimum), usage_(usage), measurement_(measurement) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& iteration) override {
    if (iteration.iteration == 0) measurement_->setup = Since(usage_);
    measurement_->iterations = iteration.iteration;
    measurement_->error = Apart(problem_->layout(), problem_->State(), minimum_);
    return measurement_->error > kReached ? ceres::SOLVER_CONTINUE : ceres::SOLVER_TERMINATE_SUCCESSFULLY;
  }

 private:
  CeresJointProblem* problem_;
  const OwnMinimum& minimum_;
  const Usage& usage_;
  Measurement* measurement_;
};

Measurement RunCeres(const JointSolverCase& given, const OwnMinimum& minimum, ceres::LinearSolverType solver,
                     int threads) {
  Measurement measurement;
  const Usage usage;
  CeresJointProblem problem(given.problem, given.start);
  UntilReached until_reached(&problem, minimum, usage, &measurement);
  problem.Solve({solver, threads, kMostIterations, &until_reached});
  measurement.all = Since(usage);
  measurement.megabytes = usage.PeakMegabytes();
  return measurement;
}

Measurement RunCeresCovariance(const OwnMinimum& minimum, int threads) {
  Measurement measurement;
  const Usage usage;
  CeresJointProblem problem(minimum.problem, minimum.state);
  measurement.setup = Since(usage);
  const Eigen::MatrixXd covariance = problem.Covariance(threads);
  measurement.all = Since(usage);
  measurement.megabytes = usage.PeakMegabytes();
  measurement.error = LargestError(covariance, minimum.covariance);
  return measurement;
}

void Print(const std::string& drive, const std::string& solver, int threads,
           const std::optional<Measurement>& m, std::FILE* csv) {
  if (!m) {
    std::printf("| %s | %s | %d | failed | | | | | | |\n", drive.c_str(), solver.c_str(), threads);
    return;
  }
  const double count = std::max(1, m->iterations);
  std::printf("| %s | %s | %d | %d | %.2f / %.2f | %.2f / %.2f | %.2f / %.2f | %.0f | %.0e |\n",
              drive.c_str(), solver.c_str(), threads, m->iterations, m->setup.wall, m->setup.user,
              (m->all.wall - m->setup.wall) / count, (m->all.user - m->setup.user) / count, m->all.wall,
              m->all.user, m->megabytes, m->error);
  std::fprintf(csv, "%s,\"%s\",%d,%d,%.4f,%.4f,%.4f,%.4f,%.1f,%.3e\n", drive.c_str(), solver.c_str(), threads,
               m->iterations, m->setup.wall, m->setup.user, m->all.wall, m->all.user, m->megabytes, m->error);
  std::fflush(stdout);
  std::fflush(csv);
}

struct DriveCase {
  const char* name;
  const char* sensors;
  bool car;
};

void RunDrive(const DriveCase& drive, double duration, std::FILE* csv) {
  // Threads do not survive a fork: what is made before has none but this.
  auto one = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, 1);
  openblas_set_num_threads(1);
  JointSolverCase given = MakeJointSolverCase(drive.sensors, drive.car, duration);
  given.problem.dataset = &given.dataset;
  const OwnMinimum minimum = ceres_reference::FindOwnMinimum(given.problem, given.start);
  const Layout layout(given.start, given.problem.estimate_imu_matrices);
  std::fprintf(stderr, "%s: %zu observations of %zu planes, %zu IMU samples, %d + %d unknowns, %.0e sigma\n",
               drive.name, given.problem.drives[0].planes.observations.size(),
               given.problem.drives[0].planes.planes.size(), given.dataset.drives[0].imu.size(), layout.knots,
               layout.calibration, minimum.last_change);
  const auto measure = [&](const char* solver, const std::function<Measurement(int)>& run) {
    for (const int threads : {1, 2}) {
      Print(drive.name, solver, threads, InOwnProcess([&] {
              one.reset();
              const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
              openblas_set_num_threads(threads);
              return run(threads);
            }),
            csv);
    }
  };
  measure("own", [&](int) { return RunOwn(given, minimum); });
  measure("Ceres, SPARSE_SCHUR",
          [&](int threads) { return RunCeres(given, minimum, ceres::SPARSE_SCHUR, threads); });
  measure("Ceres, SPARSE_NORMAL_CHOLESKY",
          [&](int threads) { return RunCeres(given, minimum, ceres::SPARSE_NORMAL_CHOLESKY, threads); });
  measure("covariance: own", [&](int) { return RunOwnCovariance(minimum); });
  measure("covariance: Ceres, SPARSE_QR", [&](int threads) { return RunCeresCovariance(minimum, threads); });
}

}  // namespace
}  // namespace mlic

int main(int argc, char** argv) {
  const double duration = argc > 1 ? std::atof(argv[1]) : 60.0;
  std::FILE* csv = std::fopen(argc > 2 ? argv[2] : "/dev/null", "w");
  if (duration <= 0.0 || csv == nullptr) {
    std::fprintf(stderr, "usage: joint_solver_benchmark [SECONDS [CSV]]: seconds above 0, a file to write\n");
    return 1;
  }
  std::printf(
      "Seconds: wall / user CPU. Error: largest distance from the minimum, sigmas; of a covariance: largest, "
      "of "
      "the variances.\n\n"
      "| drive | solver | threads | iterations | set-up, s | each iteration, s | all, s | MB | error |\n"
      "|---|---|---|---|---|---|---|---|---|\n");
  std::fprintf(
      csv,
      "drive,solver,threads,iterations,setup_wall_s,setup_user_s,all_wall_s,all_user_s,megabytes,error\n");
  try {
    mlic::RunDrive({"hand-held, 1 LiDAR", "handheld.yaml", false}, duration, csv);
    mlic::RunDrive({"car, 4 LiDARs", "paper_rig_lidars.yaml", true}, duration, csv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "joint_solver_benchmark: %s\n", error.what());
    return 1;
  }
  return 0;
}

#include "mlic_ros/programs/evaluation.h"

#include <cstdio>
#include <opencv2/imgcodecs.hpp>

#include "mlic_core/evaluation/intrinsics_error.h"
#include "mlic_core/evaluation/truth_comparison.h"
#include "mlic_core/io/result/point_cloud_file.h"
#include "mlic_core/io/result/result_file.h"
#include "mlic_core/io/text_file.h"

namespace mlic {

namespace fs = std::filesystem;

void Evaluation::Add(const std::string& title, const std::string& table, const std::string& file,
                     const std::string& csv) {
  text += (text.empty() ? "" : "\n") + ("== " + title + "\n") + table;
  files.emplace_back(file, csv);
}

void CompareTo(const CalibrationResult& truth, const std::string& of, const std::string& prefix,
               const CalibrationResult& calibration, Evaluation* evaluation) {
  const TruthComparison comparison = CompareWithTruth(calibration, truth);
  evaluation->Add(of + "error against the truth", TableOf(comparison), prefix + "errors.csv",
                  CsvOf(comparison));
  const std::vector<IntrinsicsError> intrinsics = CompareIntrinsics(calibration, truth);
  if (intrinsics.empty()) return;
  evaluation->Add(of + "intrinsics against the truth", TableOf(intrinsics), prefix + "intrinsics_errors.csv",
                  CsvOf(intrinsics));
}

void Write(const Evaluation& evaluation, OutputDirectory* output) {
  const std::vector<std::string> kept = output->Replace([&](const fs::path& directory) {
    for (const auto& [name, content] : evaluation.files) WriteFileAtomically(directory / name, content);
    for (const auto& [name, calibration] : evaluation.rivals) {
      WriteCalibrationFile(directory / name, calibration);
    }
    for (const auto& [name, picture] : evaluation.pictures) {
      std::vector<unsigned char> png;
      cv::imencode(".png", picture, png);
      WriteFileAtomically(directory / name, std::string(png.begin(), png.end()));
    }
    if (!evaluation.coloured_map.empty()) {
      WriteColouredPointCloudFile(directory / "coloured_map.pcd", evaluation.coloured_map);
    }
    WriteFileAtomically(directory / "evaluation.txt", evaluation.text);
  });
  for (const std::string& line : kept) std::fprintf(stderr, "evaluate: %s\n", line.c_str());
  std::fputs(evaluation.text.c_str(), stdout);
}

}  // namespace mlic

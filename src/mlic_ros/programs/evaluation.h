#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>
#include <utility>
#include <vector>

#include "mlic_core/io/output_directory.h"
#include "mlic_core/result/coloured_point.h"
#include "mlic_core/result/result.h"

namespace mlic {

// What `evaluate` found: tables for evaluation.txt and the screen, and files by name. Written together once
// all is done.
struct Evaluation {
  std::string text;
  std::vector<std::pair<std::string, std::string>> files;         // CSV
  std::vector<std::pair<std::string, cv::Mat>> pictures;          // PNG
  std::vector<std::pair<std::string, CalibrationResult>> rivals;  // by the other methods, YAML
  std::vector<ColouredPoint> coloured_map;
  std::vector<std::string> findings;  // for the last line, where there is no truth

  void Add(const std::string& title, const std::string& table, const std::string& file,
           const std::string& csv);
};

// Its error against the truth and that of its intrinsics. of: begins the titles; prefix: the files' names.
void CompareTo(const CalibrationResult& truth, const std::string& of, const std::string& prefix,
               const CalibrationResult& calibration, Evaluation* evaluation);

// Into the output directory; the text on the screen as well.
void Write(const Evaluation& evaluation, OutputDirectory* output);

}  // namespace mlic

#pragma once

#include <sys/types.h>

#include <optional>
#include <string>

namespace mlic {

// RViz as a child process: it may be closed, die or be missing, and the calibration goes on.
class RvizWindow {
 public:
  // Starts rviz -d CONFIG where there is a display. log: file for what RViz prints.
  RvizWindow(const std::string& config, const std::string& log);
  // Closes it.
  ~RvizWindow();
  RvizWindow(const RvizWindow&) = delete;
  RvizWindow& operator=(const RvizWindow&) = delete;

  // False once it was closed or has died.
  bool IsOpen();
  // In one line why there is no RViz; empty where it was started.
  const std::string& Problem() const { return problem_; }

 private:
  std::optional<pid_t> process_;
  std::string problem_;
};

}  // namespace mlic

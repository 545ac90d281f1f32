#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "mlic_core/io/directory_lock.h"
#include "mlic_core/io/manifest.h"

namespace mlic {

// A folder that one program, in one process at a time, writes its results into. Nothing in it that MLIC did
// not write is touched: only what the manifest of an earlier run lists is replaced.
class OutputDirectory {
 public:
  // InputError where the folder is not one to write into: it is a file, holds files but no manifest of this
  // program, or one of the listed files was changed since. Touches nothing; a folder that is not there is
  // good.
  static void Check(const std::filesystem::path& directory, const std::string& program);

  // Checks, makes the folder, holds it for this process and leaves the mark. InputError as of Check, and when
  // another process works in it or it cannot be written.
  OutputDirectory(const std::filesystem::path& directory, const std::string& program);
  // A folder that still holds nothing is removed if it was made here.
  ~OutputDirectory();

  const std::filesystem::path& Path() const { return directory_; }

  // Identifies the results that stand there; empty where there are none, or not all that are listed.
  std::string ResultsHash() const;

  // Calls write(PARTIAL), with an empty folder beside the results, and moves what it made into their place,
  // each file whole or not at all and calibration.yaml last: a folder without it holds no result. Of the
  // results of an earlier run nothing is left (a refused run after a trusted one leaves no launch file). A
  // file of somebody else that is in the way is kept under another name, which is returned in one line for
  // each. When write throws, the results before stay. InputError when the disk is full and the like.
  std::vector<std::string> Replace(const std::function<void(const std::filesystem::path&)>& write);

 private:
  void Publish(const std::filesystem::path& partial, const Manifest& fresh, std::vector<std::string>* kept);

  std::filesystem::path directory_;
  bool made_ = false;
  std::unique_ptr<DirectoryLock> lock_;
  Manifest manifest_;
};

}  // namespace mlic

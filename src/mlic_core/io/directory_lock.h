#pragma once

#include <filesystem>

namespace mlic {

// Holds a folder for this process: a file in it, locked by flock and naming the process, which goes with the
// object. The kernel frees the lock of a process that dies, however it dies; the file it leaves behind is
// taken over.
class DirectoryLock {
 public:
  // The folder exists. InputError when another process holds it, or no file can be made there.
  explicit DirectoryLock(const std::filesystem::path& directory);
  ~DirectoryLock();
  DirectoryLock(const DirectoryLock&) = delete;
  DirectoryLock& operator=(const DirectoryLock&) = delete;

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
};

inline constexpr const char* kLockName = ".mlic_lock";

}  // namespace mlic

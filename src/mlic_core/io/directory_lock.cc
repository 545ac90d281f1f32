#include "mlic_core/io/directory_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "mlic_core/common/error.h"

namespace mlic {
namespace {

std::string Content(int descriptor) {
  char text[64];
  const ssize_t size = pread(descriptor, text, sizeof(text), 0);
  return size > 0 ? std::string(text, static_cast<std::size_t>(size)) : "";
}

// The file that is locked is still the one of that name: its owner before may have removed it in between.
bool IsStillThere(int descriptor, const std::filesystem::path& file) {
  struct stat locked {
  }, named{};
  return fstat(descriptor, &locked) == 0 && stat(file.c_str(), &named) == 0 &&
         locked.st_ino == named.st_ino && locked.st_dev == named.st_dev;
}

}  // namespace

DirectoryLock::DirectoryLock(const std::filesystem::path& directory) : file_(directory / kLockName) {
  const auto fail = [&](const std::string& what) {
    if (descriptor_ >= 0) close(descriptor_);
    throw InputError("output directory " + directory.string() + ": " + what);
  };
  do {
    if (descriptor_ >= 0) close(descriptor_);
    descriptor_ = open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor_ < 0) {
      fail("cannot be written (" + std::string(std::strerror(errno)) + "); choose another with --output");
    }
    if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
      if (errno != EWOULDBLOCK) fail("cannot be locked (" + std::string(std::strerror(errno)) + ")");
      const std::string owner = Content(descriptor_);
      fail("in use by " + (owner.empty() ? "another process" : "process " + owner) +
           "; wait for its end, or choose another with --output");
    }
  } while (!IsStillThere(descriptor_, file_));
  const std::string owner = std::to_string(getpid());
  if (ftruncate(descriptor_, 0) != 0 ||
      pwrite(descriptor_, owner.data(), owner.size(), 0) != static_cast<ssize_t>(owner.size())) {
    const std::string reason = std::strerror(errno);
    unlink(file_.c_str());
    fail("cannot be written (" + reason + "); free space or choose another with --output");
  }
}

DirectoryLock::~DirectoryLock() {
  unlink(file_.c_str());
  close(descriptor_);
}

}  // namespace mlic

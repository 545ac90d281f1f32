#pragma once

#include <stdexcept>
#include <string>

namespace mlic {

// Bad input or usage: the message is one line that says where (file, topic, key), what was expected and what
// to do. Caught only in main, which prints it and exits with status 1.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// A broken contract of our own code: exit status 3.
class InternalError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

// The user interrupted the work: exit status 130.
class Cancelled : public std::runtime_error {
 public:
  Cancelled() : std::runtime_error("interrupted") {}
};

inline void Check(bool condition, const char* message) {
  if (!condition) throw InternalError(message);
}

}  // namespace mlic

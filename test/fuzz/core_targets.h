#pragma once

#include <string>

namespace mlic {

// What others may have written, read from its bytes: what is refused ends in an InputError of one line. The
// first byte of a COLMAP model says which of its files (cameras, points, images) the rest is, beside two
// sound ones; that of a checkpoint which object.
void FuzzRig(const std::string& bytes);
void FuzzResult(const std::string& bytes);
void FuzzPointCloud(const std::string& bytes);
void FuzzColmap(const std::string& bytes);
void FuzzCheckpoint(const std::string& bytes);

}  // namespace mlic

#include "mlic_core/io/checkpoint/stage_files.h"

#include <vector>

#include "mlic_core/common/error.h"
#include "mlic_core/io/checkpoint/serialize_stages.h"

namespace mlic {

template <typename T>
bool StageFiles::LoadAny(const std::string& stage, T* value) {
  if (!files_.Has(stage)) return false;
  std::vector<char> bytes;
  if (files_.Load(stage, key_, &bytes) && FromBytes(bytes, value)) return true;
  line_("the kept stage " + stage + " is of other inputs or another program, or damaged: it is done again");
  return false;
}

template <typename T>
void StageFiles::SaveAny(const std::string& stage, const T& value) {
  try {
    files_.Save(stage, key_, ToBytes(value));
  } catch (const InputError& error) {
    line_("the stage " + stage + " cannot be kept, a killed run would do it again: " + error.what());
  }
}

template bool StageFiles::LoadAny(const std::string&, DriveOdometry*);
template bool StageFiles::LoadAny(const std::string&, Initialization*);
template bool StageFiles::LoadAny(const std::string&, Adjustment*);
template bool StageFiles::LoadAny(const std::string&, ImageFeatures*);
template bool StageFiles::LoadAny(const std::string&, TrackSet*);
template bool StageFiles::LoadAny(const std::string&, CameraInitialization*);
template void StageFiles::SaveAny(const std::string&, const DriveOdometry&);
template void StageFiles::SaveAny(const std::string&, const Initialization&);
template void StageFiles::SaveAny(const std::string&, const Adjustment&);
template void StageFiles::SaveAny(const std::string&, const ImageFeatures&);
template void StageFiles::SaveAny(const std::string&, const TrackSet&);
template void StageFiles::SaveAny(const std::string&, const CameraInitialization&);

}  // namespace mlic

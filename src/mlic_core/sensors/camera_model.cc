#include "mlic_core/sensors/camera_model.h"

namespace mlic {

int ParameterCount(CameraModel model) {
  switch (model) {
    case CameraModel::kPlumbBob:
      return 9;
    case CameraModel::kRationalPolynomial:
      return 12;
    case CameraModel::kEquidistant:
      return 8;
    case CameraModel::kDoubleSphere:
      return 6;
  }
  return 0;
}

}  // namespace mlic

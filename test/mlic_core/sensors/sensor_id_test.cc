#include "mlic_core/sensors/sensor_id.h"

#include <gtest/gtest.h>

namespace mlic::sensor_id_test {
namespace {

TEST(SensorOrder, LidarsComeFirstAndPlacesLeadBack) {
  const SensorOrder order(2, 3);
  ASSERT_EQ(order.size(), 5u);
  EXPECT_EQ(order.PlaceOf(LidarId(1)), 1u);
  EXPECT_EQ(order.PlaceOf(CameraId(0)), 2u);
  for (std::size_t place = 0; place < order.size(); ++place) {
    EXPECT_EQ(order.At(place).IsLidar(), place < 2);
    EXPECT_EQ(order.PlaceOf(order.At(place)), place);
  }
}

TEST(SensorOrder, OfCamerasAloneBeginsWithThem) {
  const SensorOrder order(0, 2);
  EXPECT_FALSE(order.At(0).IsLidar());
  EXPECT_EQ(order.At(1).index, 1u);
  EXPECT_EQ(SensorOrder().size(), 0u);
}

}  // namespace
}  // namespace mlic::sensor_id_test

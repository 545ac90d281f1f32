#include "mlic_core/io/report/report_ground.h"

#include <cmath>

#include "mlic_core/common/angles.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

// In the unit of the row.
struct GroundRow {
  const char* name;
  const char* unit;
  double mean, sigma, scatter;
  int decimals;
};

std::string Row(const GroundRow& row) {
  const auto cell = [&](double value) {
    return "<td class=\"n\">" + FixedNumber(value, row.decimals) + " " + row.unit + "</td>";
  };
  return "<tr><td>" + std::string(row.name) + "</td>" + cell(row.mean) + cell(row.sigma) + cell(row.scatter) +
         "</tr>\n";
}

}  // namespace

std::string GroundTable(const CalibrationResult& result) {
  if (!result.ground) return "";
  const PoseOverGround::Angles &mean = result.ground->mean, &sigma = result.ground->sigma,
                               &scatter = result.ground->scatter;
  const auto angle = [](const char* name, double of_mean, double of_sigma, double of_scatter) {
    return Row({name, "&deg;", kDegreesPerRadian * of_mean, kDegreesPerRadian * of_sigma,
                kDegreesPerRadian * of_scatter, 3});
  };
  return "<div class=\"wide\"><table><thead><tr><th>of the IMU</th><th class=\"n\">mean</th><th "
         "class=\"n\">&sigma; of the mean</th><th class=\"n\">scatter over the drive</th></tr></thead>\n"
         "<tbody>" +
         Row({"height", "m", mean.height, sigma.height, scatter.height, 4}) +
         angle("roll", mean.roll, sigma.roll, scatter.roll) +
         angle("pitch", mean.pitch, sigma.pitch, scatter.pitch) +
         "</tbody></table></div>\n<p class=\"note\">Over the plane of the map's ground within 2.5 m below "
         "the "
         "path, at " +
         std::to_string(result.ground->places) +
         " places. R = R<sub>y</sub>(pitch) R<sub>x</sub>(roll) turns the IMU's axes to those of the ground. "
         "The scatter of a vehicle is that of its suspension and of uneven ground; of what is carried, that "
         "of the carrier.</p>\n";
}

}  // namespace mlic

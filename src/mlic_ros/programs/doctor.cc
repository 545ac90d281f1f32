#include "mlic_ros/programs/doctor.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "mlic_core/common/parallel.h"
#include "mlic_core/inspection/cost.h"
#include "mlic_core/inspection/excitation_findings.h"
#include "mlic_core/inspection/forecast.h"
#include "mlic_core/inspection/imu_findings.h"
#include "mlic_core/inspection/rotation_findings.h"
#include "mlic_ros/bag/cloud_decoder.h"
#include "mlic_ros/bag/image_reader.h"
#include "mlic_ros/bag/imu_messages.h"
#include "mlic_ros/bag/part_choice.h"
#include "mlic_ros/bag/recording_survey.h"

namespace mlic {
namespace {

constexpr double kTableRow = 10.0;  // s; from: structural
constexpr double kStretch = 12.0;   // s; from: definition, some turns, and 2 s of work for four LiDARs

// GB that programs may still take, the file cache's included; 0 where the system does not tell.
double FreeMemory() {
  std::ifstream file("/proc/meminfo");
  std::string key;
  double kilobytes = 0.0;
  while (file >> key >> kilobytes) {
    if (key == "MemAvailable:") return 1.024e-6 * kilobytes;
    file.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
  }
  return 0.0;
}

// Whether the topic is in the bags with a type that the sensor can have; says what is wrong otherwise.
bool CheckTopic(const BagSet& bags, const std::string& sensor, const std::string& topic,
                bool (*is_type)(const std::string&), Findings* findings) {
  const auto found = bags.topics().find(topic);
  Finding finding{
      Grade::kFail,
      sensor,
      "topic",
      topic + " is not in the bag",
      "recorded",
      "correct the topic in the rig file, or set enabled: false; the bag has " + bags.ListTopics()};
  if (found != bags.topics().end() && is_type(found->second.type)) return true;
  if (found != bags.topics().end()) {
    finding.measured = topic + " is of type " + found->second.type;
    if (is_type == IsLidarType && IsRawLidarType(found->second.type)) finding.remedy = kRawLidarRemedy;
  }
  findings->push_back(finding);
  return false;
}

// The rig less the sensors whose topics are not there.
Rig WithRecordedSensors(const BagSet& bags, const Rig& rig, Findings* findings) {
  Rig recorded = rig;
  recorded.lidars.clear();
  recorded.cameras.clear();
  for (const LidarConfig& lidar : rig.lidars) {
    if (CheckTopic(bags, lidar.name, lidar.topic, IsLidarType, findings)) recorded.lidars.push_back(lidar);
  }
  for (const CameraConfig& camera : rig.cameras) {
    if (CheckTopic(bags, camera.name, camera.topic, IsImageType, findings))
      recorded.cameras.push_back(camera);
  }
  return recorded;
}

// Prints and keeps.
void Report(const std::string& heading, const Findings& more, Findings* findings) {
  if (more.empty()) return;
  std::printf("\n%s\n", heading.c_str());
  for (const Finding& finding : more) std::printf("%s\n", FindingLine(finding).c_str());
  Append(more, findings);
}

Findings FindingsOfTimes(const SensorTimes& sensor, const SensorTimes& imu, const ClockFit& imu_clock,
                         TimeNs begin) {
  const ClockFit clock = ClockOf(sensor);
  Findings findings = StampFindings(sensor, clock, begin);
  Append(OverlapFindings(sensor, imu), &findings);
  Append(DriftFindings(sensor, clock, imu_clock), &findings);
  return findings;
}

bool Moves(const std::vector<ImuSample>& imu) {
  if (imu.size() < 4) return false;
  const Finding rest = ExcitationFindings(imu).at(1);
  return rest.grade == Grade::kPass;
}

void ReportMotion(const std::vector<ImuSample>& imu, Findings* findings) {
  if (imu.size() < 4) return;
  Report("Motion", ExcitationFindings(imu), findings);
  for (const std::string& line : MotionTable(MotionOverTime(imu, RoughGyroscopeBias(imu), kTableRow)))
    std::printf("%s\n", line.c_str());
}

// The liveliest seconds of the drive, read again and followed by each LiDAR's odometry. Returns how well the
// LiDARs tell the rig's poses.
PoseNoise ReportAgreement(const BagSet& bags, const Rig& rig, const RecordingSurvey& survey,
                          const UsableImuSamples& imu, const CancellationToken& cancellation,
                          Findings* findings) {
  Findings agreement = FrameFindings(FramesOf(rig, survey.lidar_frames, survey.camera_frames));
  PoseNoise poses = TypicalPoseNoise();
  if (imu.samples.size() >= 4 && !rig.lidars.empty()) {
    const TimeInterval stretch = LiveliestStretch(imu.samples, kStretch);
    // The recorder's clock may be another: messages are found by how far they are after the IMU's first.
    const TimeNs begin = survey.imu.front().record;
    const std::vector<LidarRecording> recordings =
        ReadStretch(bags, rig, survey, {TimeFrom(begin, stretch.start), TimeFrom(begin, stretch.end)},
                    imu.epoch, cancellation);
    std::vector<LidarRotation> rotations(rig.lidars.size());
    ParallelFor(rotations.size(), [&](std::size_t i) {
      rotations[i] = MeasureRotation(rig.lidars[i], recordings[i], imu.samples, cancellation);
    });
    Append(RotationFindings(rotations), &agreement);
    poses = PoseNoiseOf(rotations);
  }
  Report("LiDARs beside the gyroscope", agreement, findings);
  return poses;
}

void DiagnoseDrive(const BagSet& bags, const Rig& rig, const BagSet::Interval& interval,
                   const CancellationToken& cancellation, Findings* findings) {
  const RecordingSurvey survey = SurveyRecording(bags, rig, interval, cancellation);
  const TimeNs begin = interval.begin;
  const ClockFit imu_clock = ClockOf(survey.imu_times);
  Findings imu = StampFindings(survey.imu_times, imu_clock, begin);
  Append(ImuFindings("imu", survey.imu, begin), &imu);
  Report("IMU " + rig.imu.topic, imu, findings);
  const UsableImuSamples usable = UsableImu(survey.imu);
  const std::vector<ImuSample>& samples = usable.samples;
  ReportMotion(samples, findings);
  for (std::size_t i = 0; i < rig.lidars.size(); ++i) {
    Findings lidar = FindingsOfTimes(survey.lidar_times[i], survey.imu_times, imu_clock, begin);
    Append(LidarFindings(survey.lidars[i], !rig.cameras.empty()), &lidar);
    Append(DeskewFindings(survey.lidars[i], samples, usable.epoch), &lidar);
    Report("LiDAR " + rig.lidars[i].topic, lidar, findings);
  }
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    Findings camera = FindingsOfTimes(survey.camera_times[i], survey.imu_times, imu_clock, begin);
    Append(CameraFindings(survey.cameras[i], begin, Moves(samples)), &camera);
    Report("Camera " + rig.cameras[i].topic, camera, findings);
  }
  const PoseNoise poses = ReportAgreement(bags, rig, survey, usable, cancellation, findings);
  if (const auto forecast = ForecastObservability(samples, rig.imu, poses)) {
    Report("Forecast of what the motion shows", ForecastFindings(*forecast, rig), findings);
  }
}

// Of what a calibration takes of the drives.
void ReportCost(const BagSet& bags, const Rig& rig, Findings* findings) {
  const SensorLoad load = LoadOf(bags, rig);
  const double longest = LongestDrive(load), length = LengthOf(bags.drives());
  if (length > longest) {
    std::printf("\nOf %.0f s recorded a calibration takes the %.0f s that show it best.\n", length, longest);
  }
  Report("Cost",
         CostFindings(ExpectedCost(load, std::min(length, longest)), FreeMemory(),
                      std::max(1u, std::thread::hardware_concurrency())),
         findings);
}

}  // namespace

Findings Diagnose(const BagSet& bags, const Rig& rig_file, const CancellationToken& cancellation) {
  const Rig rig = WithTopicsOfBag(rig_file, bags);
  Findings topics, findings;
  const bool has_imu = CheckTopic(bags, "imu", rig.imu.topic, IsImuType, &topics);
  const Rig recorded = WithRecordedSensors(bags, rig, &topics);
  Report("Topics", topics, &findings);
  if (!has_imu) return findings;
  ReportCost(bags, recorded, &findings);
  for (const BagSet::Interval& drive : bags.drives()) {
    std::printf("\nDrive of %.1f s from %.3f\n", SecondsSince(drive.begin, drive.end),
                1e-9 * static_cast<double>(drive.begin));
    DiagnoseDrive(bags, recorded, drive, cancellation, &findings);
  }
  return findings;
}

}  // namespace mlic

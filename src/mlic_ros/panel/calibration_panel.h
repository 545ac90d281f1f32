#pragma once

#include <ros/ros.h>
#include <rviz/panel.h>
#include <sensor_msgs/Image.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "mlic/Status.h"
#include "mlic_ros/panel/curve_view.h"
#include "mlic_ros/panel/map_view.h"
#include "mlic_ros/panel/panel_model.h"

class QLabel;
class QProgressBar;
class QPushButton;
class QTableWidget;

namespace mlic {

// What /mlic/status says: stage, progress, verdict, how the solves converge, and the sensors. A click on a
// sensor looks at its frame. The images' displays, off in the configuration, are turned on when there are
// images.
class CalibrationPanel : public rviz::Panel {
 public:
  explicit CalibrationPanel(QWidget* parent = nullptr);
  void onInitialize() override;

 private:
  void OnStatus(const Status& status);
  void ShowVerdict();
  void ShowSensors();
  void LookAt(int row);
  void LookAtMap();
  void Cancel();
  // Turns on the display of the topic with its first message.
  void AwaitImages(const std::string& topic);

  ros::NodeHandle node_;
  ros::Subscriber status_subscriber_;
  std::map<std::string, ros::Subscriber> images_;  // by topic, until the first
  Status status_;
  std::vector<SensorRow> rows_;
  std::unique_ptr<MapView> view_;

  QLabel *verdict_, *messages_, *stage_;
  QProgressBar* progress_;
  CurveView *changes_, *costs_;
  QTableWidget* sensors_;
  QPushButton *cancel_, *whole_map_;
};

}  // namespace mlic

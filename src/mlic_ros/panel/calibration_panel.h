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

class QComboBox;
class QHBoxLayout;
class QLabel;
class QProgressBar;
class QPushButton;
class QTableWidget;
class QTableWidgetItem;

namespace mlic {

// What /mlic/status says: stage, progress, verdict, how the solves converge, and the sensors. A click on a
// sensor looks at its frame, its box shows or hides it. The buttons call the services of calibrate_node. The
// images' displays, off in the configuration, are turned on when there are images.
class CalibrationPanel : public rviz::Panel {
 public:
  explicit CalibrationPanel(QWidget* parent = nullptr);
  void onInitialize() override;
  // Of RViz' window: where the private parameter asks_to_save is false it closes without a question.
  bool eventFilter(QObject* window, QEvent* event) override;

 private:
  void OnStatus(const Status& status);
  void ShowVerdict();
  void ShowSensors();
  void LookAt(int row);
  void LookAtMap();
  // Pressed by the mouse, or with Alt and the letter after the text's &.
  QPushButton* MakeButton(const QString& text, const QString& tip);
  QHBoxLayout* MakeSceneButtons();
  QHBoxLayout* MakeRunButtons();
  void ShowScene();
  void OnItemChanged(const QTableWidgetItem& item);
  void Trigger(const std::string& service);
  void Switch(const std::string& service, bool on);
  void Choose(const std::string& service, const std::string& word);
  void Tell(bool reached, const std::string& service, const std::string& message);
  // Turns on the display of the topic with its first message.
  void AwaitImages(const std::string& topic);

  ros::NodeHandle node_;
  ros::Subscriber status_subscriber_;
  std::map<std::string, ros::Subscriber> images_;  // by topic, until the first
  Status status_;
  std::vector<SensorRow> rows_;
  std::unique_ptr<MapView> view_;
  bool fills_ = false;    // the panel changes its widgets itself
  bool toggled_ = false;  // a box, and the view is to stay for that click

  QLabel *verdict_, *messages_, *stage_, *legend_, *round_, *answer_;
  QComboBox* colour_by_;
  QProgressBar* progress_;
  CurveView *changes_, *sigmas_, *residuals_;
  QTableWidget* sensors_;
  QPushButton *cancel_, *whole_map_, *pause_, *export_, *previous_, *next_, *latest_, *blink_;
};

}  // namespace mlic

#pragma once

#include <ros/ros.h>

#include <functional>
#include <string>
#include <vector>

#include "mlic_ros/display/scene_display.h"

namespace mlic {

// Services that ask for something and say in one line what came of it.
class DisplayServices {
 public:
  explicit DisplayServices(const ros::NodeHandle& node) : node_(node) {}

  void OfferWord(const std::string& name, std::function<Answer(const std::string&)> ask);  // mlic/Choose
  void OfferSwitch(const std::string& name, std::function<Answer(bool)> ask);              // SetBool
  void OfferTrigger(const std::string& name, std::function<Answer()> ask);                 // Trigger

 private:
  ros::NodeHandle node_;
  std::vector<ros::ServiceServer> servers_;
};

}  // namespace mlic

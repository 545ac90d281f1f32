# The catkin package. Included from the root and not a subdirectory: message generation sets variables in the
# caller's scope.
find_package(catkin REQUIRED COMPONENTS
  cv_bridge geometry_msgs message_generation nav_msgs pcl_conversions rosbag roscpp sensor_msgs std_msgs std_srvs tf2
  tf2_msgs tf2_ros visualization_msgs)

# The root's msg and srv are links to those of src/mlic_msgs: rosmsg and rossrv look nowhere else.
add_message_files(DIRECTORY msg FILES SensorStatus.msg Status.msg)
add_service_files(DIRECTORY srv FILES Choose.srv)
generate_messages(DEPENDENCIES geometry_msgs std_msgs)

catkin_package(CATKIN_DEPENDS cv_bridge geometry_msgs message_runtime nav_msgs pcl_conversions rosbag roscpp sensor_msgs
                              std_msgs std_srvs tf2 tf2_msgs tf2_ros visualization_msgs)

set(MLIC_PROGRAM_DIRECTORY ${CATKIN_DEVEL_PREFIX}/${CATKIN_PACKAGE_BIN_DESTINATION})

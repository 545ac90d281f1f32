# Tests of the ROS layer, and of what bag loading rests on in the core.
mlic_add_test(lidar_point_time_test LIBRARIES mlic_lidar)
if(MLIC_WITH_ROS)
  mlic_add_test(ros_bag_loader_test LIBRARIES mlic_bag)
endif()

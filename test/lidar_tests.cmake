# Tests of scan filter and LiDAR odometry.
mlic_add_test(lidar_scan_filter_test LIBRARIES mlic_lidar)
mlic_add_test(lidar_own_body_test LIBRARIES mlic_lidar)
if(TARGET mlic_sim)
  mlic_add_test(lidar_odometry_test LIBRARIES mlic_lidar mlic_sim)
  if(TARGET lidar_odometry_test)
    target_compile_definitions(lidar_odometry_test PRIVATE MLIC_SOURCE_DIRECTORY="${CMAKE_CURRENT_LIST_DIR}/..")
  endif()
endif()

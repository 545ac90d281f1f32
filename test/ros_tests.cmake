# Tests of the ROS layer, and of what bag loading rests on in the core.
mlic_add_test(lidar_point_time_test LIBRARIES mlic_lidar)
if(MLIC_WITH_ROS)
  mlic_add_test(ros_bag_loader_test LIBRARIES mlic_bag)
  mlic_add_test(ros_camera_loader_test LIBRARIES mlic_bag)
endif()

if(BUILD_TESTING AND TARGET calibrate_node AND TARGET simulate)
  set(drive ${PROJECT_BINARY_DIR}/test/rostest_drive)
  file(MAKE_DIRECTORY ${drive})
  add_test(NAME ros_simulate_short_drive
           COMMAND simulate --sensors ${PROJECT_SOURCE_DIR}/test/ros_camera_rig.yaml --scenario handheld
                   --duration 15 --seed 3 --output ${drive}/drive.bag)
  set_tests_properties(ros_simulate_short_drive PROPERTIES FIXTURES_SETUP short_drive LABELS slow)
  add_test(NAME ros_programs_test COMMAND ${PYTHON_EXECUTABLE} ${PROJECT_SOURCE_DIR}/test/ros_programs_test.py
           ${MLIC_PROGRAM_DIRECTORY} ${drive}/drive.bag ${drive}/drive_rig.yaml)
  set_tests_properties(ros_programs_test PROPERTIES FIXTURES_REQUIRED short_drive LABELS slow)
  # env.sh finds the messages and programs of the build; the logs stay in the build directory. Not CATKIN_ENV: that is
  # made at configure time, when a fresh build directory has neither yet.
  add_test(NAME ros_calibrate_launch_test
           COMMAND ${CMAKE_COMMAND} -E env ROS_HOME=${drive}/ros_home ${CATKIN_DEVEL_PREFIX}/env.sh rostest
                   ${PROJECT_SOURCE_DIR}/test/calibrate.test rig:=${drive}/drive_rig.yaml bag:=${drive}/drive.bag
                   output:=${drive}/calibration status_file:=${drive}/status)
  # A node that dies ends the launch before the checks, which rostest calls a success of no tests.
  set_tests_properties(ros_calibrate_launch_test PROPERTIES FIXTURES_REQUIRED short_drive LABELS slow TIMEOUT 1200
                       FAIL_REGULAR_EXPRESSION "TESTS: 0")
endif()

# The program that says how good a calibration is.
add_library(mlic_pose_topic STATIC pose_topic.cc)
target_link_libraries(mlic_pose_topic PUBLIC mlic_bag)
add_executable(evaluate evaluate_main.cc evaluation_inputs.cc interrupt.cc)
target_link_libraries(evaluate PRIVATE mlic_pose_topic mlic_io mlic_evaluation)
install(TARGETS evaluate RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})

# Tests of the evaluation room.
mlic_add_test(evaluation_trajectory_test LIBRARIES mlic_evaluation)
if(TARGET mlic_pose_topic)
  mlic_add_test(ros_pose_topic_test LIBRARIES mlic_pose_topic)
endif()

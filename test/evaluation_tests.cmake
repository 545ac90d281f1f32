# Tests of evaluate and of resumed runs.
mlic_add_test(evaluation_trajectory_test LIBRARIES mlic_evaluation)
if(TARGET mlic_pose_topic)
  mlic_add_test(ros_pose_topic_test LIBRARIES mlic_pose_topic)
endif()
if(TARGET mlic_sim)
  mlic_add_test(stage_resume_test LIBRARIES mlic_calibration mlic_io mlic_sim LABELS slow)
  target_compile_definitions(stage_resume_test PRIVATE MLIC_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endif()

# The whole with cameras, in memory: errors against the truth, and a killed run that goes on.
if(TARGET mlic_sim)
  mlic_add_test(camera_end_to_end_test LIBRARIES mlic_calibration mlic_evaluation mlic_io mlic_sim LABELS slow)
  if(TARGET camera_end_to_end_test)
    target_compile_definitions(camera_end_to_end_test PRIVATE MLIC_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  endif()
endif()

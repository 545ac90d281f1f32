# Tests of registering still pairs and of projection pictures.
mlic_add_test(io_projection_test LIBRARIES mlic_io)
if(TARGET mlic_sim)
  mlic_add_test(pair_registration_test LIBRARIES mlic_calibration mlic_sim)
  if(TARGET pair_registration_test)
    target_compile_definitions(pair_registration_test PRIVATE MLIC_SOURCE_DIRECTORY="${PROJECT_SOURCE_DIR}")
  endif()
endif()

# Tests of cameras in the joint problem and of their initialisation.
mlic_add_test(camera_doubt_test LIBRARIES mlic_calibration mlic_sim)
mlic_add_test(camera_landmarks_test LIBRARIES mlic_calibration mlic_sim)
mlic_add_test(camera_initialization_test LIBRARIES mlic_calibration mlic_sim)
mlic_add_test(visual_initialization_test LIBRARIES mlic_calibration mlic_sim LABELS slow)
mlic_add_test(map_sights_test LIBRARIES mlic_calibration mlic_sim)

# Tests of this part; owned by it.
mlic_add_test(trajectory_spline_test LIBRARIES mlic_trajectory)
mlic_add_test(imu_integration_test LIBRARIES mlic_imu)
mlic_add_test(imu_alignment_test LIBRARIES mlic_imu)
mlic_add_test(imu_hand_eye_test LIBRARIES mlic_imu)

# Tests of what keeps the joint solve linear in the drive's length.
mlic_add_test(calibration_normal_equations_test LIBRARIES mlic_calibration)
mlic_add_test(calibration_time_windows_test LIBRARIES mlic_calibration)

# Tests of what keeps the joint solve linear in the drive's length.
mlic_add_test(calibration_normal_equations_test LIBRARIES mlic_calibration)

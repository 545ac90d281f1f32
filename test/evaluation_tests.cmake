# Tests of the evaluation room.
mlic_add_test(evaluation_trajectory_test LIBRARIES mlic_evaluation)

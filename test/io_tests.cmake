# Tests of this part; owned by it.
mlic_add_test(io_rig_file_test LIBRARIES mlic_io)
target_compile_definitions(io_rig_file_test PRIVATE MLIC_RIGS_DIRECTORY="${CMAKE_SOURCE_DIR}/config/rigs")
add_library(mlic_io_sample STATIC EXCLUDE_FROM_ALL io_sample_result.cc)
target_link_libraries(mlic_io_sample PUBLIC mlic_io)
mlic_add_test(io_result_file_test LIBRARIES mlic_io_sample)
mlic_add_test(evaluation_truth_test LIBRARIES mlic_io_sample mlic_evaluation)
mlic_add_test(evaluation_map_test LIBRARIES mlic_evaluation)

# Tests of registering still pairs and of projection pictures.
mlic_add_test(io_projection_test LIBRARIES mlic_io)

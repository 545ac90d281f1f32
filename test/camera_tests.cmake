# Tests of camera models, the reprojection factor and the geometry of one or two views.
mlic_add_test(camera_model_test LIBRARIES mlic_sensors opencv_calib3d)
mlic_add_test(camera_two_view_test LIBRARIES mlic_camera)
mlic_add_test(camera_triangulation_test LIBRARIES mlic_camera)
mlic_add_test(camera_reprojection_test LIBRARIES mlic_factors)
mlic_add_test(camera_features_test LIBRARIES mlic_camera)
mlic_add_test(camera_surface_test LIBRARIES mlic_camera)
mlic_add_test(camera_colmap_test LIBRARIES mlic_camera LABELS slow)
mlic_add_test(camera_tracks_test LIBRARIES mlic_camera)

# Tests of the intensity map and of drawing it.
mlic_add_test(crossmodal_map_test LIBRARIES mlic_crossmodal)
if(TARGET mlic_sim)
  mlic_add_test(crossmodal_renderer_test LIBRARIES mlic_crossmodal mlic_sim)
  target_compile_definitions(crossmodal_renderer_test PRIVATE MLIC_SOURCE_DIRECTORY="${CMAKE_CURRENT_LIST_DIR}/..")
endif()

# Tests of the learned matcher, with small networks that they make themselves for the runtimes of this build. Without
# any runtime its tests of messages stay, and the others are skipped, visibly.
add_library(learned_toy_networks STATIC EXCLUDE_FROM_ALL learned_toy_onnx.cc)
target_link_libraries(learned_toy_networks PUBLIC mlic_learned)
get_target_property(learned_definitions mlic_learned INTERFACE_COMPILE_DEFINITIONS)
if("MLIC_HAS_LIBTORCH" IN_LIST learned_definitions)
  set(CMAKE_MESSAGE_LOG_LEVEL ERROR)
  find_package(Torch REQUIRED QUIET)  # its targets are known only where it is looked for
  unset(CMAKE_MESSAGE_LOG_LEVEL)
  target_sources(learned_toy_networks PRIVATE learned_toy_torch.cc)
  target_link_libraries(learned_toy_networks PRIVATE ${TORCH_LIBRARIES})
endif()
mlic_add_test(learned_matcher_test LIBRARIES learned_toy_networks ${OPENBLAS_LIBRARY})
mlic_add_test(learned_messages_test LIBRARIES learned_toy_networks)
if(BUILD_TESTING)
  # Without a runtime ctest shows it as skipped and not as passed.
  set_tests_properties(learned_matcher_test PROPERTIES SKIP_REGULAR_EXPRESSION "PASSED  . 0 tests")
endif()

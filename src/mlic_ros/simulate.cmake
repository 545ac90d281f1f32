# The simulator's program; left out where Embree is missing.
if(TARGET mlic_sim)
  find_package(CLI11 REQUIRED)
  add_executable(simulate simulate_main.cc drive_bag_writer.cc driver_messages.cc)
  target_include_directories(simulate SYSTEM PRIVATE ${catkin_INCLUDE_DIRS})
  target_link_libraries(simulate PRIVATE mlic_sim mlic_io CLI11::CLI11 ${catkin_LIBRARIES})
  install(TARGETS simulate RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
endif()

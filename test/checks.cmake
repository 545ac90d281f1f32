# Checks of the code itself and of the whole: layers, formatting, end to end.
add_test(NAME layers COMMAND ${Python3_EXECUTABLE} ${CMAKE_SOURCE_DIR}/test/check_layers.py ${CMAKE_SOURCE_DIR}/src)
add_test(NAME layers_self_test COMMAND ${Python3_EXECUTABLE} ${CMAKE_SOURCE_DIR}/test/check_layers.py --self-test)
add_test(NAME format COMMAND ${CMAKE_SOURCE_DIR}/test/check_format.sh ${CMAKE_SOURCE_DIR})
set_tests_properties(format PROPERTIES SKIP_RETURN_CODE 77)

if(TARGET calibrate AND TARGET simulate AND TARGET evaluate)
  # Runs the programs as a user does; they are in one directory.
  add_test(NAME end_to_end COMMAND ${Python3_EXECUTABLE} ${CMAKE_SOURCE_DIR}/test/end_to_end_test.py
                                   ${MLIC_PROGRAM_DIRECTORY} ${CMAKE_SOURCE_DIR})
  set_tests_properties(end_to_end PROPERTIES LABELS slow TIMEOUT 1800)
endif()

# Writes C++ that defines texts of files as character arrays of namespace mlic.
#   cmake -P embed_texts.cmake OUTPUT HEADER NAME FILE [NAME FILE ...]
# HEADER declares the names, relative to src. FILE may be "none": an empty text.
set(output ${CMAKE_ARGV3})
set(code "// Made by cmake/embed_texts.cmake.\n#include \"${CMAKE_ARGV4}\"\n\nnamespace mlic {\n")
math(EXPR last "${CMAKE_ARGC} - 1")
foreach(at RANGE 5 ${last} 2)
  math(EXPR next "${at} + 1")
  set(text "")
  if(NOT CMAKE_ARGV${next} STREQUAL "none")
    file(READ "${CMAKE_ARGV${next}}" text)
  endif()
  string(APPEND code "const char ${CMAKE_ARGV${at}}[] = R\"mlic_text(${text})mlic_text\";\n")
endforeach()
file(WRITE "${output}" "${code}}  // namespace mlic\n")

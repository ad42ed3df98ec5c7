# nepho_module(NAME SOURCES a.cpp ... SHADERS dir/x.comp ... USES module ... LIBS lib_x ... PRIVATE_LIBS lib_y ...)
#
#   A static library `nepho_NAME` from src/NAME. USES names other modules (public), LIBS outside libraries whose headers
#   appear in ours, PRIVATE_LIBS those that stay inside .cpp files. SHADERS are relative to shaders/; each becomes
#   SPIR-V in a header of the same path: shaders/clouds/cloud_march.comp is embedded by
#   `#include "clouds/cloud_march.comp.h"` as the array `cloud_march_comp`.
#
# nepho_test(NAME SOURCES a_test.cpp ... USES module ... [LIBS lib ...] [GPU])
#
#   A doctest program `test_NAME` and a CTest entry of that name; GPU gives it the label `gpu` and runs it alone.

add_library(nepho_options INTERFACE)
target_compile_options(nepho_options INTERFACE -Wall -Wextra -Wconversion -Wshadow)
target_compile_definitions(nepho_options INTERFACE
  GLM_FORCE_EXPLICIT_CTOR GLM_FORCE_DEPTH_ZERO_TO_ONE GLM_ENABLE_EXPERIMENTAL
  NEPHO_SOURCE_DIR="${CMAKE_SOURCE_DIR}" NEPHO_VERSION="${PROJECT_VERSION}")
if(NEPHO_SANITIZE)
  target_compile_options(nepho_options INTERFACE -fsanitize=address,undefined -fno-omit-frame-pointer)
  target_link_options(nepho_options INTERFACE -fsanitize=address,undefined)
endif()

function(nepho_tidy target)
  if(NEPHO_TIDY)
    find_program(CLANG_TIDY clang-tidy REQUIRED)
    set_target_properties(${target} PROPERTIES CXX_CLANG_TIDY ${CLANG_TIDY})
  endif()
endfunction()

function(nepho_shader target shader)
  get_filename_component(file ${shader} NAME)
  get_filename_component(dir ${shader} DIRECTORY)
  string(REGEX REPLACE "[^A-Za-z0-9]" "_" symbol ${file})
  set(out ${CMAKE_BINARY_DIR}/shaders/${shader}.h)
  file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/shaders/${dir})
  add_custom_command(
    OUTPUT ${out}
    COMMAND ${GLSLANG_VALIDATOR} --quiet -V --target-env vulkan1.3 -I${CMAKE_SOURCE_DIR}/shaders
            --depfile ${out}.d --vn ${symbol} -o ${out} ${CMAKE_SOURCE_DIR}/shaders/${shader}
    DEPENDS ${CMAKE_SOURCE_DIR}/shaders/${shader}
    DEPFILE ${out}.d
    COMMENT "shader ${shader}" VERBATIM)
  target_sources(${target} PRIVATE ${out})
endfunction()

function(nepho_module name)
  cmake_parse_arguments(M "" "" "SOURCES;SHADERS;USES;LIBS;PRIVATE_LIBS" ${ARGN})
  add_library(nepho_${name} STATIC ${M_SOURCES})
  target_include_directories(nepho_${name} PUBLIC ${CMAKE_SOURCE_DIR}/src ${CMAKE_SOURCE_DIR}/shaders
                             PRIVATE ${CMAKE_BINARY_DIR}/shaders)
  list(TRANSFORM M_USES PREPEND nepho_)
  target_link_libraries(nepho_${name} PUBLIC ${M_USES} ${M_LIBS} PRIVATE ${M_PRIVATE_LIBS} nepho_options)
  # Outside headers are not ours to warn about.
  target_compile_definitions(nepho_${name} PUBLIC GLM_FORCE_EXPLICIT_CTOR GLM_FORCE_DEPTH_ZERO_TO_ONE GLM_ENABLE_EXPERIMENTAL)
  foreach(shader ${M_SHADERS})
    nepho_shader(nepho_${name} ${shader})
  endforeach()
  nepho_tidy(nepho_${name})
endfunction()

function(nepho_test name)
  cmake_parse_arguments(T "GPU" "" "SOURCES;SHADERS;USES;LIBS" ${ARGN})
  add_executable(test_${name} ${T_SOURCES})
  list(TRANSFORM T_USES PREPEND nepho_)
  target_link_libraries(test_${name} PRIVATE nepho_test_main ${T_USES} ${T_LIBS} nepho_options)
  target_include_directories(test_${name} PRIVATE ${CMAKE_SOURCE_DIR}/tests ${CMAKE_BINARY_DIR}/shaders)
  foreach(shader ${T_SHADERS})
    nepho_shader(test_${name} ${shader})
  endforeach()
  add_test(NAME ${name} COMMAND test_${name} WORKING_DIRECTORY ${CMAKE_SOURCE_DIR})
  if(T_GPU)
    set_tests_properties(${name} PROPERTIES LABELS gpu RUN_SERIAL ON TIMEOUT 900)
  else()
    set_tests_properties(${name} PROPERTIES TIMEOUT 300)
  endif()
  nepho_tidy(test_${name})
endfunction()

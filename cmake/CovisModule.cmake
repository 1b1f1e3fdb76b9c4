# SPDX-License-Identifier: Apache-2.0
# covis_module(NAME DEPS … [TEST_DEPS …] [ONE_TEST]): a static library covis_NAME of src/covis/NAME/*.cpp, and NAME_test
# of its *_test.cpp files. ONE_TEST: the cases share what is dear to make, so ctest runs them in one process.
function(covis_module name)
  cmake_parse_arguments(M "ONE_TEST" "" "DEPS;TEST_DEPS" ${ARGN})
  set(dir ${PROJECT_SOURCE_DIR}/src/covis/${name})
  file(GLOB sources CONFIGURE_DEPENDS ${dir}/*.cpp)
  set(tests ${sources})
  list(FILTER sources EXCLUDE REGEX "_test\\.cpp$")
  list(FILTER tests INCLUDE REGEX "_test\\.cpp$")
  if(NOT sources)
    file(WRITE ${PROJECT_BINARY_DIR}/${name}_empty.cpp "")
    set(sources ${PROJECT_BINARY_DIR}/${name}_empty.cpp)
  endif()
  add_library(covis_${name} STATIC ${sources})
  target_link_libraries(covis_${name} PUBLIC covis_flags ${M_DEPS})
  if(COVIS_TESTS AND tests)
    add_executable(${name}_test ${tests})
    target_link_libraries(${name}_test PRIVATE covis_${name} GTest::gmock_main ${M_TEST_DEPS})
    target_compile_definitions(${name}_test PRIVATE COVIS_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
    if(M_ONE_TEST)
      add_test(NAME ${name}_test COMMAND ${name}_test)
      # Long as it is, it starts first, beside the others.
      set_tests_properties(${name}_test PROPERTIES LABELS ${name} TIMEOUT 900 COST 1000
        ENVIRONMENT "${covis_test_environment}")
    else()
      covis_discover_tests(${name}_test ${name})
    endif()
  endif()
endfunction()

# Debian's Ceres frees what the standard library gave it by operator new.
set(covis_test_environment
  "ASAN_OPTIONS=alloc_dealloc_mismatch=0"
  "UBSAN_OPTIONS=print_stacktrace=1"
  "TSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/tools/tsan.supp")

# covis_discover_tests(TARGET LABEL): one ctest entry for each GoogleTest case, labelled LABEL. Cases with "Long" in their
# name are labelled long as well: the sanitizer runs leave them out.
function(covis_discover_tests target label)
  gtest_discover_tests(${target} DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60 NO_PRETTY_VALUES TEST_LIST ${target}_cases
    PROPERTIES LABELS ${label} TIMEOUT 900)
  # Lists don't survive gtest_discover_tests' PROPERTIES; they are set by a file that ctest reads after the cases are known.
  set(file ${CMAKE_CURRENT_BINARY_DIR}/${target}_properties.cmake)
  file(CONFIGURE OUTPUT ${file} @ONLY CONTENT [=[
set(environment "@covis_test_environment@")
foreach(test IN LISTS @target@_cases)
  set_tests_properties("${test}" PROPERTIES ENVIRONMENT "${environment}")
  if(test MATCHES "Long")
    set_tests_properties("${test}" PROPERTIES LABELS "@label@;long")
  endif()
endforeach()
]=])
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${file})
endfunction()

# SPDX-License-Identifier: Apache-2.0
# covis_module(NAME DEPS … [TEST_DEPS …]): a static library covis_NAME of src/covis/NAME/*.cpp, and NAME_test of its
# *_test.cpp files.
function(covis_module name)
  cmake_parse_arguments(M "" "" "DEPS;TEST_DEPS" ${ARGN})
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
    covis_discover_tests(${name}_test ${name})
  endif()
endfunction()

# covis_discover_tests(TARGET LABEL): one ctest entry for each GoogleTest case, labelled LABEL. Cases with "Long" in their
# name are labelled long as well: the sanitizer runs leave them out.
function(covis_discover_tests target label)
  set(environment "ASAN_OPTIONS=detect_stack_use_after_return=1"
    "UBSAN_OPTIONS=print_stacktrace=1"
    "TSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/tools/tsan.supp second_deadlock_stack=1")
  list(JOIN environment "\\;" environment)
  gtest_discover_tests(${target} DISCOVERY_MODE PRE_TEST TEST_FILTER "-*Long*" TEST_LIST ${target}_short
    PROPERTIES LABELS ${label} TIMEOUT 900 ENVIRONMENT "${environment}")
  gtest_discover_tests(${target} DISCOVERY_MODE PRE_TEST TEST_FILTER "*Long*" TEST_LIST ${target}_long
    PROPERTIES LABELS "${label}\\;long" TIMEOUT 900 ENVIRONMENT "${environment}")
endfunction()

# SPDX-License-Identifier: Apache-2.0
# covis_module(NAME DEPS … [DIR …] [TEST_DEPS …] [TEST_NAME …] [APP] [LIGHT] [ONE_TEST] [ADDRESSED FILTER] [THREADED NAME …]): a static library
# covis_NAME of the *.cpp files below src/covis/NAME, and a test of the *_test.cpp files among them.
#   DIR         the folder of the sources, from the project's root, when it is another
#   TEST_NAME   the test's name, where it is not to be NAME_test
#   APP         it is of the command and leaves the work to the library
#   LIGHT       its tests compute little: under sanitizers they are compiled without optimisations
#   ONE_TEST    the cases share what is dear to make or to load (OpenCV), so ctest runs them in one process
#   ADDRESSED   of such a test, the cases (a GoogleTest filter) the address sanitizer is to run; without it all
#   THREADED    NAME_test.cpp starts threads, or holds what threads share: the thread sanitizer has these alone
function(covis_module name)
  cmake_parse_arguments(M "APP;LIGHT;ONE_TEST" "DIR;TEST_NAME;ADDRESSED" "DEPS;TEST_DEPS;THREADED" ${ARGN})
  if(NOT M_DIR)
    set(M_DIR src/covis/${name})
  endif()
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${M_DIR}/*.cpp)
  set(tests ${sources})
  list(FILTER sources EXCLUDE REGEX "_test\\.cpp$|/src/covis/io/plugin_[a-z0-9_]+\\.cpp$")
  list(FILTER tests INCLUDE REGEX "_test\\.cpp$")
  if(COVIS_SANITIZE MATCHES thread)
    list(JOIN M_THREADED "|" threaded)
    list(FILTER tests INCLUDE REGEX "/(${threaded})_test\\.cpp$")
  endif()
  if(NOT sources)
    file(WRITE ${PROJECT_BINARY_DIR}/${name}_empty.cpp "")
    set(sources ${PROJECT_BINARY_DIR}/${name}_empty.cpp)
  endif()
  # Kernels of Highway are compiled once for each instruction set, each by itself.
  foreach(source ${sources})
    file(STRINGS ${source} kernels REGEX "HWY_TARGET_INCLUDE" LIMIT_COUNT 1)
    if(kernels)
      set_source_files_properties(${source} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    endif()
  endforeach()
  add_library(covis_${name} STATIC ${sources})
  target_link_libraries(covis_${name} PUBLIC covis_flags ${M_DEPS})
  set(light)
  if(M_APP OR M_LIGHT)
    set(light LIGHT)
  endif()
  if(M_APP)
    covis_compile_fast(covis_${name} ${light})
    covis_use_headers(covis_${name} covis_app_headers)
  else()
    covis_use_headers(covis_${name} covis_library_headers)
  endif()
  if(COVIS_TESTS AND tests)
    set(test ${name}_test)
    if(M_TEST_NAME)
      set(test ${M_TEST_NAME})
    endif()
    add_executable(${test} ${tests})
    target_link_libraries(${test} PRIVATE covis_${name} GTest::gmock_main ${M_TEST_DEPS})
    target_compile_definitions(${test} PRIVATE COVIS_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
    target_include_directories(${test} PRIVATE ${PROJECT_SOURCE_DIR})
    covis_compile_fast(${test} ${light})
    if(light AND COVIS_SANITIZE)
      covis_use_headers(${test} covis_light_test_headers)
    else()
      covis_use_headers(${test} covis_test_headers)
    endif()
    set_target_properties(${test} PROPERTIES UNITY_BUILD_BATCH_SIZE 16)
    if(M_ONE_TEST)
      set(filter *)
      if(COVIS_SANITIZE)
        set(filter *-*Long*)
      endif()
      if(M_ADDRESSED AND COVIS_SANITIZE MATCHES address)
        set(filter ${M_ADDRESSED})
      endif()
      covis_one_test(${test} ${test} ${name} ${filter})
    else()
      covis_discover_tests(${test} ${name})
    endif()
  endif()
endfunction()

# covis_plugin(NAME DEPS …): the plug-in covis_NAME.so, of src/covis/io/plugin_NAME.cpp, which the module io opens when it is first
# needed (src/covis/io/plugin.h). It goes where a program of the build finds it, and beside the build's Python package.
function(covis_plugin name)
  add_library(covis_${name} MODULE src/covis/io/plugin_${name}.cpp)
  target_link_libraries(covis_${name} PRIVATE covis_flags ${ARGN})
  target_compile_definitions(covis_${name} PRIVATE COVIS_PLUGIN_VERSION="${PROJECT_VERSION}")
  set_target_properties(covis_${name} PROPERTIES PREFIX "" SUFFIX .so
    LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/${CMAKE_INSTALL_LIBDIR}/covis)
  # It takes nothing from the program that opens it. A sanitizer's functions are the program's.
  if(NOT COVIS_SANITIZE)
    target_link_options(covis_${name} PRIVATE LINKER:--no-undefined)
  endif()
  add_dependencies(covis_io covis_${name})
  if(COVIS_PYTHON)
    add_custom_command(TARGET covis_${name} POST_BUILD
      COMMAND ${CMAKE_COMMAND} -E copy $<TARGET_FILE:covis_${name}> ${PROJECT_BINARY_DIR}/python/covis/covis_${name}.so)
  endif()
  if(COVIS_APPS)
    install(TARGETS covis_${name} COMPONENT command LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/covis)
  endif()
endfunction()

# covis_compile_fast(TARGET [LIGHT]): for programs of the preset `test` that leave all work to the library, with fewer
# optimisations: three quarters of the time to compile. So little inlined, GCC 12 takes matrices of Eigen for unset. LIGHT: under
# sanitizers with none, half the time. Not for what computes: of a template that the library has too, the linker may keep this one.
function(covis_compile_fast target)
  set(level -O1)
  if(COVIS_SANITIZE AND "LIGHT" IN_LIST ARGN)
    set(level -O0)
  endif()
  target_compile_options(${target} PRIVATE $<$<CONFIG:RelWithDebInfo>:${level} -Wno-maybe-uninitialized>)
endfunction()

# covis_precompile(NAME HEADER …): a library of precompiled headers. It must be compiled with the flags of what uses it.
function(covis_precompile name)
  file(WRITE ${PROJECT_BINARY_DIR}/${name}.cpp "")
  add_library(${name} OBJECT ${PROJECT_BINARY_DIR}/${name}.cpp)
  target_link_libraries(${name} PRIVATE covis_flags Threads::Threads Eigen3::Eigen)
  target_precompile_headers(${name} PRIVATE ${ARGN})
endfunction()

# covis_use_headers(TARGET NAME): the target's sources find them parsed already.
function(covis_use_headers target name)
  if(COVIS_PRECOMPILE)
    target_precompile_headers(${target} REUSE_FROM ${name})
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>)
  endif()
endfunction()

# Debian's Ceres frees what the standard library gave it by operator new.
set(covis_test_environment
  "ASAN_OPTIONS=alloc_dealloc_mismatch=0"
  "UBSAN_OPTIONS=print_stacktrace=1"
  "TSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/tools/tsan.supp")

# covis_one_test(NAME TARGET LABELS FILTER): one ctest entry for all cases that the GoogleTest filter names.
function(covis_one_test name target labels filter)
  add_test(NAME ${name} COMMAND ${target} --gtest_filter=${filter})
  # Long as it is, it starts first, beside the others.
  set_tests_properties(${name} PROPERTIES LABELS "${labels}" TIMEOUT 900 COST 1000
    ENVIRONMENT "${covis_test_environment}")
endfunction()

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

# SPDX-License-Identifier: Apache-2.0
# The project's build options, and the compile flags every target shares.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
# libcovis shows its public API alone: templates of Eigen compiled into it must not meet those of its users.
set(CMAKE_CXX_VISIBILITY_PRESET hidden)
set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)

option(COVIS_TESTS "Build the tests" ON)
option(COVIS_APPS "Build the covis command" ON)
option(COVIS_BENCHMARKS "Build the benchmarks" OFF)
option(COVIS_PYTHON "Build the Python package" OFF)
find_program(COVIS_NPM npm)
if(COVIS_NPM)
  option(COVIS_VIEWER "Build the viewer in the browser into the command" ON)
else()
  option(COVIS_VIEWER "Build the viewer in the browser into the command" OFF)
endif()
find_package(RosbagStorage QUIET)
if(RosbagStorage_FOUND)
  option(COVIS_ROSBAG "Read ROS 1 bags" ON)
else()
  option(COVIS_ROSBAG "Read ROS 1 bags" OFF)
endif()
find_package(OpenCV 4 QUIET COMPONENTS aruco)
if(OpenCV_FOUND AND TARGET opencv_aruco)
  option(COVIS_CHARUCO "Find ChArUco boards" ON)
else()
  option(COVIS_CHARUCO "Find ChArUco boards" OFF)
endif()
option(COVIS_WERROR "Warnings are errors" OFF)
option(COVIS_PRECOMPILE "Parse the headers that most sources include once" OFF)
option(COVIS_COVERAGE "Instrument for coverage" OFF)
option(COVIS_HARDEN "Harden optimised builds as Debian hardens its packages" ON)
option(COVIS_FUZZ "Build fuzz/ for libFuzzer, with the address and undefined-behaviour sanitizers (Clang)" OFF)
set(COVIS_SANITIZE "" CACHE STRING "Sanitizers, for example address,undefined or thread")
if(COVIS_FUZZ AND NOT COVIS_SANITIZE)
  set(COVIS_SANITIZE address,undefined)
endif()

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Release, Debug or RelWithDebInfo" FORCE)
endif()
# Release is what is shipped. RelWithDebInfo is for tests and sanitizers: optimised, but assertions are on; debug
# information, a tenth of the time to compile, is for the sanitizers' reports alone. Debug keeps light optimisation: Eigen
# without any is too slow to test with.
set(CMAKE_CXX_FLAGS_RELEASE "-O3 -DNDEBUG")
set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O2")
set(CMAKE_CXX_FLAGS_DEBUG "-Og -g")
if(COVIS_SANITIZE)
  # Two thirds of the time to compile.
  set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O1 -g1")
endif()

find_program(COVIS_CCACHE ccache)
if(COVIS_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # It keeps results of precompiled headers only when told so (its manual, "Precompiled headers").
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${COVIS_CCACHE})
endif()

add_library(covis_flags INTERFACE)
target_include_directories(covis_flags INTERFACE
  ${PROJECT_SOURCE_DIR}/src ${PROJECT_SOURCE_DIR}/include ${PROJECT_BINARY_DIR}/include)
target_compile_options(covis_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wold-style-cast -Wcast-qual -Woverloaded-virtual
  # In Debug alone: without assertions the compiler can't know that a handle was checked, and with full optimisation GCC 12
  # follows impossible paths through the standard library.
  $<$<CONFIG:Debug>:-Wnull-dereference>
  # GCC 12 sees overlaps in "text" + std::string that are not there (its bug 105651).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
  $<$<BOOL:${COVIS_WERROR}>:-Werror>
  # The same bits on every SIMD target: no fused multiply-add the source did not ask for.
  -ffp-contract=off
  # Rounding and roots inline; nobody reads errno after them.
  -fno-math-errno)
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  # GCC collects its garbage from 500 MB on instead of 128: 8 % less time to compile; what is compiled together takes more anyway.
  target_compile_options(covis_flags INTERFACE --param=ggc-min-heapsize=500000 --param=ggc-min-expand=300)
endif()
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  # The oldest machine we run on; wider SIMD is chosen at run time (Highway).
  target_compile_options(covis_flags INTERFACE -march=x86-64-v2 -mtune=generic)
endif()
# What reads an entry of a matrix nobody wrote gets a NaN and shows.
target_compile_definitions(covis_flags INTERFACE $<$<NOT:$<CONFIG:Release>>:EIGEN_INITIALIZE_MATRICES_BY_NAN>)
if(COVIS_SANITIZE)
  target_compile_options(covis_flags INTERFACE -fsanitize=${COVIS_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  if(COVIS_SANITIZE MATCHES address AND NOT COVIS_FUZZ)
    # A quarter of the time to compile: the address sanitizer finds most of what the first two do, nothing here casts between
    # classes, and the last two instrument nearly every access. tools/fuzz has them all.
    target_compile_options(covis_flags INTERFACE -fno-sanitize=null,object-size,vptr,alignment,pointer-overflow)
  endif()
  target_link_options(covis_flags INTERFACE -fsanitize=${COVIS_SANITIZE})
endif()
# A flaw in a reader is to end the process rather than to run what a file wants (docs/security.md).
if(COVIS_HARDEN AND CMAKE_BUILD_TYPE MATCHES "^Rel" AND NOT COVIS_SANITIZE AND NOT COVIS_COVERAGE)
  include(CheckCXXCompilerFlag)
  include(CheckPIESupported)
  check_pie_supported(LANGUAGES CXX)
  # -fstack-protector-strong would guard each small matrix as well.
  foreach(flag -fstack-protector -fstack-clash-protection -fcf-protection -mbranch-protection=standard)
    string(MAKE_C_IDENTIFIER "COVIS_HAS${flag}" known)
    check_cxx_compiler_flag(${flag} ${known})
    if(${known})
      target_compile_options(covis_flags INTERFACE ${flag})
    endif()
  endforeach()
  # Undefined first: the compiler or its user may define it too.
  target_compile_options(covis_flags INTERFACE -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2)
  target_link_options(covis_flags INTERFACE LINKER:-z,relro,-z,now)
endif()
if(COVIS_FUZZ)
  target_compile_options(covis_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()
if(COVIS_COVERAGE)
  target_compile_options(covis_flags INTERFACE --coverage -fprofile-update=atomic)
  target_link_options(covis_flags INTERFACE --coverage)
endif()

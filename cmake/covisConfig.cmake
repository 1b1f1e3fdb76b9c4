# SPDX-License-Identifier: Apache-2.0
# find_package(covis) reads this from the installed tree and gives covis::covis.
include(CMakeFindDependencyMacro)
find_dependency(tl-expected)
include(${CMAKE_CURRENT_LIST_DIR}/covisTargets.cmake)

# SPDX-License-Identifier: Apache-2.0
# libcovis: one shared library of the core modules with the public API of include/covis, installed so that
# find_package(covis) gives covis::covis. Nothing of Eigen or Highway is in its interface.
# It shares tl::expected, which is a header alone.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

configure_file(${PROJECT_SOURCE_DIR}/include/covis/version.h.in ${PROJECT_BINARY_DIR}/include/covis/version.h @ONLY)

add_library(covis_library SHARED)
add_library(covis::covis ALIAS covis_library)
set(core_modules core geometry features vocabulary map matching optimization tracking mapping loops slam storage api)
foreach(module ${core_modules})
  target_sources(covis_library PRIVATE $<TARGET_OBJECTS:covis_${module}>)
endforeach()
target_link_libraries(covis_library PUBLIC tl::expected PRIVATE covis_flags PkgConfig::HWY PkgConfig::ZSTD Threads::Threads)
target_link_options(covis_library PRIVATE LINKER:--as-needed)
if(NOT COVIS_SANITIZE)
  target_link_options(covis_library PRIVATE LINKER:--no-undefined)
endif()
target_include_directories(covis_library INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
target_compile_features(covis_library INTERFACE cxx_std_20)
set_target_properties(covis_library PROPERTIES
  OUTPUT_NAME covis EXPORT_NAME covis LINKER_LANGUAGE CXX
  VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})

set(config_dir ${CMAKE_INSTALL_LIBDIR}/cmake/covis)
install(TARGETS covis_library EXPORT covis COMPONENT library
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} NAMELINK_COMPONENT development)
install(EXPORT covis NAMESPACE covis:: FILE covisTargets.cmake DESTINATION ${config_dir} COMPONENT development)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/covisConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_SOURCE_DIR}/cmake/covisConfig.cmake ${PROJECT_BINARY_DIR}/covisConfigVersion.cmake DESTINATION ${config_dir} COMPONENT development)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/covis ${PROJECT_BINARY_DIR}/include/covis
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development FILES_MATCHING PATTERN "*.h" PATTERN "*.hpp")
install(FILES ${PROJECT_SOURCE_DIR}/vocabulary/default.covis-voc
  DESTINATION ${CMAKE_INSTALL_DATADIR}/covis COMPONENT data)
if(TARGET covis)
  install(TARGETS covis COMPONENT command RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()

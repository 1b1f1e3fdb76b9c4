# SPDX-License-Identifier: Apache-2.0
# RosbagStorage::RosbagStorage: Debian's library for ROS 1 bags (package librosbag-storage-dev). Its own files for CMake and
# pkg-config ask for build tools of ROS, which reading a bag does not need.
find_path(RosbagStorage_INCLUDE_DIR rosbag/bag.h)
set(rosbag_variables RosbagStorage_INCLUDE_DIR)
set(rosbag_libraries)
set(rosbag_directories ${RosbagStorage_INCLUDE_DIR})
# The library, and those that its headers call.
foreach(library rosbag_storage rostime cpp_common roscpp_serialization class_loader rcutils console_bridge)
  find_library(RosbagStorage_${library}_LIBRARY ${library})
  list(APPEND rosbag_variables RosbagStorage_${library}_LIBRARY)
  list(APPEND rosbag_libraries ${RosbagStorage_${library}_LIBRARY})
endforeach()
# What rosbag/bag.h includes lies in folders of their own.
foreach(header pluginlib/class_loader.hpp class_loader/class_loader.hpp rcpputils/shared_library.hpp rcutils/shared_library.h
    ament_index_cpp/get_resource.hpp)
  get_filename_component(folder ${header} DIRECTORY)
  find_path(RosbagStorage_${folder}_DIR ${header} PATH_SUFFIXES ${folder})
  list(APPEND rosbag_variables RosbagStorage_${folder}_DIR)
  list(APPEND rosbag_directories ${RosbagStorage_${folder}_DIR})
endforeach()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(RosbagStorage REQUIRED_VARS ${rosbag_variables})
mark_as_advanced(${rosbag_variables})
if(RosbagStorage_FOUND AND NOT TARGET RosbagStorage::RosbagStorage)
  add_library(RosbagStorage::RosbagStorage INTERFACE IMPORTED)
  set_target_properties(RosbagStorage::RosbagStorage PROPERTIES
    INTERFACE_INCLUDE_DIRECTORIES "${rosbag_directories}"
    INTERFACE_LINK_LIBRARIES "${rosbag_libraries}")
endif()

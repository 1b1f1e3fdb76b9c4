// SPDX-License-Identifier: Apache-2.0
// A look at the records of a ROS 1 bag before rosbag_storage reads them: that believes lengths and places it finds, and
// a damaged one would lead it out of its memory. Source: wiki.ros.org/Bags/Format/2.0.
#pragma once

#include <string_view>

#include "covis/core/error.h"

namespace covis::io {

// Checks that all records lie within the file, and all that the index names where it says. A compressed chunk is not
// looked into. Bags of an older format than 2.0 are left to rosbag_storage. bytes: the whole file.
Result<void> check_ros1_records(std::string_view bytes);

}  // namespace covis::io

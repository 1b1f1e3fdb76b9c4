// SPDX-License-Identifier: Apache-2.0
// ROS 1 bags: they are checked here, and read by rosbag_storage in a plug-in.
#include "covis/core/mapped_file.h"
#include "covis/io/bag.h"
#include "covis/io/bag_ros1_check.h"
#include "covis/io/plugin.h"

namespace covis::io {

#ifdef COVIS_ROSBAG

bool reads_ros1_bags() { return true; }

Result<std::unique_ptr<Bag>> open_ros1_bag(const std::filesystem::path& file) {
  {
    const auto mapped = MappedFile::open(file);
    if (!mapped) return tl::unexpected(mapped.error());
    const auto bytes = (*mapped)->bytes();
    if (auto checked = check_ros1_records({reinterpret_cast<const char*>(bytes.data()), bytes.size()}); !checked)
      return damaged_ros1_bag(file, checked.error().message);
  }
  const auto bags = plugin<Ros1BagPlugin>();
  if (!bags) return fail(file.string() + ": " + bags.error().message);
  return (*bags)->open(file);
}

#else

bool reads_ros1_bags() { return false; }

Result<std::unique_ptr<Bag>> open_ros1_bag(const std::filesystem::path& file) {
  return fail(file.string() +
              ": this build of Covis reads no ROS 1 bags. Install Debian's package librosbag-storage-dev (tools/setup "
              "does) and build Covis again with -DCOVIS_ROSBAG=ON");
}

#endif

}  // namespace covis::io

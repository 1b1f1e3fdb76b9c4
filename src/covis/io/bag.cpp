// SPDX-License-Identifier: Apache-2.0
#include "covis/io/bag.h"

#include <algorithm>
#include <cctype>
#include <optional>

#include "covis/core/message_text.h"
#include "covis/io/files.h"
#include "covis/io/yaml.h"

namespace covis::io {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kZstd = "\x28\xb5\x2f\xfd";  // the beginning of compressed data

enum class BagFormat { ros1, ros2, mcap, zstd };

std::optional<BagFormat> format_of(const fs::path& file) {
  const auto head = read_head(file, 16);
  if (!head) return std::nullopt;
  if (head->starts_with("#ROSBAG")) return BagFormat::ros1;
  if (head->starts_with("SQLite format 3")) return BagFormat::ros2;
  if (head->starts_with("\x89MCAP0")) return BagFormat::mcap;
  if (head->starts_with(kZstd)) return BagFormat::zstd;
  return std::nullopt;
}

bool is_bag_name(const fs::path& file) {
  std::string name = file.filename().string();
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return name.ends_with(".bag") || name.ends_with(".bag.active") || name.ends_with(".db3") ||
         name.ends_with(".db3.zstd") || name.ends_with(".mcap");
}

// Says how a bag becomes one that can be read.
Error convertible(const fs::path& path, const std::string& problem) {
  return {path.string() + ": " + problem + ". Write a file sqlite.yaml with" + std::string(kBagConversion) +
          path.string() + " -o sqlite.yaml"};
}

// The files of a folder's .db3 bag, as its metadata.yaml lists them.
Result<std::vector<fs::path>> listed_files(const fs::path& folder, const fs::path& metadata) {
  const auto root = load_yaml(metadata);
  if (!root) return tl::unexpected(root.error());
  const YAML::Node info = root->IsMap() ? (*root)["rosbag2_bagfile_information"] : YAML::Node();
  if (!info || !info.IsMap())
    return fail(metadata.string() + ": 'rosbag2_bagfile_information' is missing; it is not that of a ROS 2 bag");
  const auto text = [&](const char* key) {
    return info[key] && info[key].IsScalar() ? info[key].Scalar() : std::string();
  };
  const std::string storage = text("storage_identifier");
  if (storage == "mcap") return tl::unexpected(convertible(folder, "bags in MCAP can't be read"));
  if (storage != "sqlite3")
    return fail(metadata.string() + ": storage_identifier is '" + storage + "', it must be sqlite3");
  if (!text("compression_format").empty())
    return tl::unexpected(convertible(folder, "bags compressed by " + text("compression_format") + " can't be read"));
  const YAML::Node files = info["relative_file_paths"];
  if (!files || !files.IsSequence() || files.size() == 0)
    return fail(metadata.string() + ": 'relative_file_paths' is missing, a list of .db3 files is expected");
  std::vector<fs::path> found;
  for (const auto& file : files) {
    // Early versions wrote the folder's name before that of the file.
    if (!file.IsScalar()) return fail(yaml_place(metadata, file) + ": the name of a .db3 file is expected");
    const fs::path name = file.Scalar();
    found.push_back(is_there(folder / name) ? folder / name : folder / name.filename());
    if (!is_there(found.back())) return fail(found.back().string() + ": the file is listed but missing");
  }
  return found;
}

// True when the first message begins as zstd's output; metadata.yaml says so, too, but a file may lie alone.
bool compressed_messages(Bag& bag) {
  std::string bytes;
  for (const BagTopic& topic : bag.topics()) {
    if (!topic.messages.empty()) return bag.read(topic.messages.front(), bytes, kZstd.size()) && bytes == kZstd;
  }
  return false;
}

std::vector<fs::path> databases(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".db3") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

bool is_bag(const fs::path& path) {
  if (!fs::is_directory(path)) return is_bag_name(path) || format_of(path) == BagFormat::ros1;
  if (!databases(path).empty()) return true;
  const auto metadata = read_text(path / "metadata.yaml");
  return metadata && metadata->find("rosbag2_bagfile_information") != std::string::npos;
}

Result<std::unique_ptr<Bag>> open_bag(const fs::path& path) {
  if (!fs::exists(path)) return fail(path.string() + ": it does not exist");
  std::vector<fs::path> files{path};
  if (fs::is_directory(path)) {
    files = databases(path);
    if (fs::exists(path / "metadata.yaml")) {
      auto listed = listed_files(path, path / "metadata.yaml");
      if (!listed) return tl::unexpected(listed.error());
      files = *listed;
    }
    if (files.empty()) return fail(path.string() + ": there is neither metadata.yaml nor a .db3 file in it");
  }
  for (const fs::path& file : files) {
    const std::optional<BagFormat> format = format_of(file);
    if (format == BagFormat::mcap) return tl::unexpected(convertible(path, "bags in MCAP can't be read"));
    if (format == BagFormat::zstd) return tl::unexpected(convertible(path, "bags compressed by zstd can't be read"));
    if (format == BagFormat::ros1 && files.size() == 1) return open_ros1_bag(file);
    if (format != BagFormat::ros2) {
      return fail(file.string() +
                  ": it is no bag that can be read: it begins neither as a ROS 1 bag ('#ROSBAG') nor as an SQLite "
                  "database, as those of ROS 2 do");
    }
  }
  auto bag = open_ros2_bag(files);
  if (bag && compressed_messages(**bag))
    return tl::unexpected(convertible(path, "bags whose messages are compressed by zstd can't be read"));
  return bag;
}

}  // namespace covis::io

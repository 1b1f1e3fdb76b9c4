// SPDX-License-Identifier: Apache-2.0
#include "covis/io/output_check.h"

#include <algorithm>
#include <string_view>
#include <system_error>

#include "covis/io/files.h"

namespace covis::io {
namespace {

namespace fs = std::filesystem;
using std::literals::operator""sv;

constexpr std::string_view kPng = "\x89PNG\r\n\x1a\n";
constexpr size_t kPngHeader = 33;  // bytes of the signature and of the first chunk
// A chunk of text (the PNG specification, section 11.3.3.2): length, type, keyword, text, checksum.
constexpr std::string_view kMark = "\0\0\0\x0etEXtSoftware\0Covis\xf9\x0b\x3b\xc4"sv;

// Nine decimals each: of TUM's format eight numbers, of KITTI's twelve with an exponent.
bool is_pose(std::string_view line) {
  const std::vector<std::string_view> words = split(line);
  const auto ours = [&](std::string_view word) {
    const size_t point = word.find('.'), exponent = std::min(word.find('e'), word.size());
    const bool kitti = words.size() == 12;
    return parse_double(word) && point != word.npos && exponent == point + 10 && kitti == (exponent < word.size());
  };
  return (words.size() == 8 || words.size() == 12) && std::all_of(words.begin(), words.end(), ours);
}

bool is_trajectory(std::string_view bytes) {
  return bytes.starts_with("#timestamp [ns],p_x [m],") || is_pose(bytes.substr(0, bytes.find('\n')));
}

// A sensor file of ours begins without a comment.
bool is_camera(std::string_view bytes) {
  return bytes.starts_with(kCameraFile) || bytes.starts_with(kCameraEstimate) ||
         bytes.starts_with("sensor_type: camera");
}

// Binary, or as text: branching, depth, 0 0. (Four numbers of a camera are none.)
bool is_vocabulary(std::string_view bytes) {
  if (bytes.starts_with("COVISVOC")) return true;
  const std::vector<std::string_view> words = split(bytes.substr(0, bytes.find('\n')));
  if (words.size() != 4 || words[2] != "0" || words[3] != "0") return false;
  const auto branching = parse_double(words[0]), depth = parse_double(words[1]);
  return branching && depth && *branching >= 2 && *branching <= 256 && *depth >= 1 && *depth <= 16;
}

bool is_of(OutputKind kind, std::string_view bytes) {
  switch (kind) {
    case OutputKind::picture:
      return bytes.starts_with(kPng) && bytes.substr(std::min(kPngHeader, bytes.size())).starts_with(kMark);
    case OutputKind::png:
      return bytes.starts_with(kPng);
    case OutputKind::page:
      return bytes.starts_with("<!doctype html>\n<html lang=\"en\">");
    case OutputKind::point_cloud:
      return bytes.starts_with("ply\n");
    case OutputKind::trajectory:
      return is_trajectory(bytes);
    case OutputKind::times:
      return bytes.starts_with("# seconds of each row of ");
    case OutputKind::camera:
      return is_camera(bytes);
    case OutputKind::camera_estimate:
      return bytes.starts_with(kCameraEstimate);
    case OutputKind::vocabulary:
      return is_vocabulary(bytes);
    case OutputKind::geojson:
      return bytes.starts_with("{\n \"features\": [\n");
    case OutputKind::colmap:
      return bytes.starts_with("# CAMERA_ID, MODEL, WIDTH, HEIGHT, fx, fy, cx, cy\n");
    case OutputKind::nerfstudio:
      return bytes.starts_with("{\n \"camera_model\": \"PINHOLE\",\n");
    case OutputKind::bundler:
      return bytes.starts_with("# Bundle file v0.3\n");
    case OutputKind::scene:
      return bytes.starts_with("COVISVW");
    case OutputKind::json:
      return bytes.starts_with("{\"") || bytes.starts_with("{\n");
  }
  return false;
}

const char* name(OutputKind kind) {
  static constexpr const char* kNames[] = {"a picture that Covis made",
                                           "a PNG picture",
                                           "an HTML page of Covis",
                                           "a PLY point cloud",
                                           "a trajectory that Covis wrote",
                                           "a file of stamps that Covis wrote",
                                           "a camera file that Covis wrote",
                                           "a camera that covis run found from a recording",
                                           "a vocabulary",
                                           "a path in GeoJSON that Covis wrote",
                                           "a COLMAP model that Covis wrote",
                                           "a nerfstudio model that Covis wrote",
                                           "a Bundler model",
                                           "a scene of Covis",
                                           "JSON"};
  return kNames[static_cast<size_t>(kind)];
}

bool same_file(const fs::path& a, const fs::path& b) {
  std::error_code none;
  if (fs::exists(a, none) && fs::exists(b, none)) return fs::equivalent(a, b, none);
  return normal_path(a) == normal_path(b);
}

}  // namespace

Result<bool> may_replace(const fs::path& file, OutputKind kind) {
  constexpr size_t kFirst = 2000;  // bytes
  std::error_code none;
  if (!fs::is_regular_file(file, none) || fs::file_size(file, none) == 0) return true;
  const auto head = read_head(file, kFirst);
  if (!head) return tl::unexpected(head.error());
  return is_of(kind, *head);
}

Result<void> check_other_file(const fs::path& out, const std::vector<fs::path>& inputs) {
  for (const fs::path& input : inputs) {
    if (!input.empty() && same_file(out, input))
      return fail(out.string() + ": it is also " + input.string() +
                  ", and files given are left as they are; choose another name for what is written");
  }
  return {};
}

Result<void> check_output(const fs::path& out, OutputKind kind, const std::vector<fs::path>& inputs) {
  if (auto other = check_other_file(out, inputs); !other) return other;
  const auto replaceable = may_replace(out, kind);
  if (!replaceable) return tl::unexpected(replaceable.error());
  if (*replaceable) return {};
  return fail(out.string() + ": it is there and is not " + name(kind) +
              ", so that it is not replaced; remove it or choose another name");
}

bool is_marked_picture(const fs::path& file) {
  const auto head = read_head(file, kPngHeader + kMark.size());
  return head && is_of(OutputKind::picture, *head);
}

std::string marked_picture(std::string png) { return png.insert(std::min(kPngHeader, png.size()), kMark); }

}  // namespace covis::io

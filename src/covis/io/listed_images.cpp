// SPDX-License-Identifier: Apache-2.0
#include "covis/io/listed_images.h"

#include "covis/io/bad_frames.h"
#include "covis/io/files.h"
#include "covis/io/stamp_pairs.h"

namespace covis::io {
namespace {

std::vector<Timestamp> stamps_of(const std::vector<ListedRow>& rows) {
  std::vector<Timestamp> stamps;
  for (const auto& row : rows) stamps.push_back(row[0].stamp);
  return stamps;
}

}  // namespace

Result<std::vector<ListedRow>> read_listed_images(const std::filesystem::path& list, size_t pairs) {
  const auto text = read_text(list);
  if (!text) return tl::unexpected(text.error());
  std::vector<ListedRow> rows;
  std::string problem;
  for_each_line(*text, [&](std::string_view line, int number) {
    const auto parts = split(line);
    if (parts.size() != 2 * pairs) {
      problem = place(list, number) + ": it must hold " + std::to_string(pairs) + " pair(s) of stamp and file name";
      return false;
    }
    ListedRow row;
    for (size_t p = 0; p < pairs; ++p) {
      const auto stamp = parse_stamp(parts[2 * p]);
      if (!stamp) {
        problem = place(list, number) + ": '" + std::string(parts[2 * p]) + "' is not a stamp in seconds";
        return false;
      }
      row.push_back({*stamp, std::string(parts[2 * p + 1]), list.parent_path() / parts[2 * p + 1]});
    }
    rows.push_back(std::move(row));
    return true;
  });
  if (!problem.empty()) return fail(problem);
  if (rows.empty()) return fail(list.string() + ": no file is listed in it");
  return rows;
}

// Two cameras that are not triggered together lose frames apart: 29 of 723 images of freiburg1_rpy have no
// depth image.
constexpr double kFewAlone = 0.1;

Result<std::vector<FrameFiles>> pair_with_depth(const std::filesystem::path& images_file,
                                                const std::filesystem::path& depths_file, Recording& recording) {
  const auto images = read_listed_images(images_file, 1);
  if (!images) return tl::unexpected(images.error());
  const auto depths = read_listed_images(depths_file, 1);
  if (!depths) return tl::unexpected(depths.error());
  std::vector<FrameFiles> frames;
  for (const auto& [i, d] : pair_by_stamps(stamps_of(*images), stamps_of(*depths)))
    frames.push_back({(*images)[i][0].stamp, (*images)[i][0].file, {}, (*depths)[d][0].file});
  if (frames.empty()) {
    return fail(images_file.parent_path().string() + ": no image of " + images_file.filename().string() +
                " has a depth image of " + depths_file.filename().string() +
                " within 20 ms; are the stamps in seconds?");
  }
  if (const size_t alone = images->size() - frames.size(); alone > 0)
    note_left_out(alone, images->size(), "images have no depth image within 20 ms", recording, kFewAlone);
  return frames;
}

}  // namespace covis::io

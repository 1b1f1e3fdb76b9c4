// SPDX-License-Identifier: Apache-2.0
// covis calibrate: makes a camera file from a video or images of a board.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <string>

#include "apps/calibrate/board.h"
#include "apps/calibrate/board_frames.h"
#include "apps/calibrate/calibration.h"
#include "apps/calibrate/charuco.h"
#include "commands.h"
#include "common.h"
#include "covis/core/atomic_file.h"
#include "covis/core/log.h"
#include "covis/io/camera_file.h"
#include "covis/io/output_check.h"

namespace covis::app {
namespace {

struct CalibrateArguments {
  std::string path, board, dictionary = "4X4_50", out = "camera.yaml", picture;
  double square = 0, marker = 0;
  bool charuco = false, fisheye = false;
  int stride = 0;
};

Result<Board> board_of(const CalibrateArguments& a) {
  Board board;
  board.kind = a.charuco ? Board::Kind::charuco : Board::Kind::checkerboard;
  char end = 0;
  if (std::sscanf(a.board.c_str(), "%dx%d%c", &board.columns, &board.rows, &end) != 2 || board.columns < 3 ||
      board.rows < 3 || board.columns > 100 || board.rows > 100)
    return fail("--board " + a.board + ": COLUMNSxROWS is wanted, 3 to 100 each, for example 9x6");
  board.square = a.square;
  board.marker = a.marker;
  if (!a.charuco && (a.marker != 0 || a.dictionary != CalibrateArguments{}.dictionary))
    return fail("--marker, --dictionary: they are those of a ChArUco board; --charuco says that it is one");
  if (!a.charuco) return board;
  if (const auto there = charuco_is_there(); !there) return tl::unexpected(there.error());
  if (!(a.marker > 0 && a.marker < a.square))
    return fail("--marker: the side of a marker is wanted, less than a square's");
  const auto dictionary = dictionary_of(a.dictionary);
  if (!dictionary) return tl::unexpected(dictionary.error());
  board.dictionary = *dictionary;
  const int markers = board.columns * board.rows / 2,
            known = std::stoi(a.dictionary.substr(a.dictionary.find('_') + 1));
  if (markers > known) {
    return fail("--board " + a.board + ": it has " + std::to_string(markers) + " markers, the dictionary " +
                a.dictionary + " " + std::to_string(known));
  }
  return board;
}

std::string file_text(const Calibration& c) {
  char head[200];
  std::snprintf(head, sizeof head, "calibrate: %zu views, rms %.3f pixels", c.views, c.rms);
  std::string text = std::string(io::kCameraFile).append(head);
  if (c.fx_sigma > 0) {
    std::snprintf(head, sizeof head, "; standard deviations: fx %.2f, cx %.2f pixels", c.fx_sigma, c.cx_sigma);
    text += head;
  }
  io::CameraFile file;
  file.camera = c.camera;
  return text + "\n" + io::camera_text(file);
}

// Both outputs are asked about before the work.
Result<void> check_outputs(const CalibrateArguments& a) {
  auto fits = io::check_output(a.out, io::OutputKind::camera, {a.path});
  if (fits && !a.picture.empty()) fits = io::check_output(a.picture, io::OutputKind::picture, {a.path, a.out});
  return fits;
}

int run(const CalibrateArguments& a) {
  const auto board = board_of(a);
  if (!board) return fail_with(board.error());
  if (const auto fits = check_outputs(a); !fits) return fail_with(fits.error());
  end_well_on_signals();
  constexpr size_t kMost = 60;  // views
  const auto seen = look_for_board(a.path, BoardFinder(*board), a.stride, interrupted);
  if (!seen) return fail_with(seen.error());
  if (interrupted != 0) {
    log(LogLevel::warning, "interrupted; nothing is written");
    return 128 + interrupted;
  }
  std::printf("board found in %zu of %d images\n", seen->views.size(), seen->frames);
  const auto made = calibrate(choose_views(seen->views, seen->image, kMost), seen->image,
                              a.fisheye ? Distortion::kannala_brandt : Distortion::brown_conrady);
  if (!made) return fail_with(a.path + ": " + made.error().message);
  if (const auto written = write_atomically(a.out, file_text(*made)); !written) return fail_with(written.error());
  if (!a.picture.empty()) {
    if (const auto written = write_plots(a.picture, {residual_plot(*made)}); !written)
      return fail_with(written.error());
  }
  const Pinhole& p = made->camera.pinhole;
  std::printf("%zu views, %zu left out; rms %.3f pixels; fx %.2f fy %.2f cx %.2f cy %.2f\nwritten to %s\n", made->views,
              made->left_out, made->rms, p.fx, p.fy, p.cx, p.cy, a.out.c_str());
  if (made->fx_sigma > 0.005 * p.fx)
    log(LogLevel::warning, "the focal length is uncertain by " + std::to_string(100 * made->fx_sigma / p.fx) +
                               " %: show the board more tilted, nearer, and in the corners of the image");
  return 0;
}

}  // namespace
}  // namespace covis::app

void add_calibrate_command(CLI::App& app, int& exit_code) {
  using namespace covis::app;
  auto a = std::make_shared<CalibrateArguments>();
  CLI::App* command = app.add_subcommand("calibrate", "Make a camera file from a video or images of a board");
  command->add_option("PATH", a->path, "video file or folder of images that show the board from many sides")
      ->required();
  command->add_option("--board", a->board, "COLUMNSxROWS: inner corners of a checkerboard, squares of a ChArUco board")
      ->required();
  command->add_option("--square", a->square, "side of a square, metres")->required()->check(positive_number());
  command->add_flag("--charuco", a->charuco, "the board is a ChArUco board, which may be seen in part");
  command->add_option("--marker", a->marker, "ChArUco: side of a marker, metres");
  command->add_option("--dictionary", a->dictionary, "ChArUco: 4X4_50, 5X5_100, 6X6_250 …")->capture_default_str();
  command->add_flag("--fisheye", a->fisheye, "lens of more than about 120 degrees (kannala_brandt)");
  command->add_option("--stride", a->stride, "look at every n-th image (default: 5 of a video, 1 of a folder)")
      ->transform(whole_number_from(1, 10000));
  command->add_option("--out", a->out, "camera file to write")->capture_default_str();
  command->add_option("--picture", a->picture, "PNG file for a picture of the residuals");
  command->footer(
      "Examples:\n"
      "  covis calibrate board.mp4 --board 9x6 --square 0.025 --out phone.yaml --picture residuals.png\n"
      "  covis calibrate images --charuco --board 8x6 --square 0.04 --marker 0.03 --dictionary 5X5_100\n"
      "Move the board, not the camera, or the other way round: near and far, tilted to all sides, into all corners.");
  command->callback([a, &exit_code] { exit_code = run(*a); });
}

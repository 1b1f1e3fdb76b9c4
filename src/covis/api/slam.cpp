// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <exception>
#include <limits>
#include <mutex>
#include <optional>
#include <utility>

#include "covis/api/convert.h"
#include "covis/api/events.h"
#include "covis/api/frame_colours.h"
#include "covis/api/rectifier.h"
#include "covis/core/failure_reason.h"
#include "covis/core/fields.h"
#include "covis/core/log.h"
#include "covis/core/stamp_bounds.h"
#include "covis/covis.h"
#include "covis/slam/system.h"
#include "covis/storage/compatibility.h"
#include "covis/vocabulary/vocabulary.h"

namespace covis {
namespace {

using Failure = tl::unexpected<std::string>;
template <class T>
using Expected = tl::expected<T, std::string>;

// Makes an error of what is thrown, as a lack of memory in any thread; what was made before stays. An event's handler
// is not called in it, for what that throws is its owner's.
template <class Function>
auto without_exceptions(const char* name, Function&& function) -> decltype(function()) {
  try {
    return function();
  } catch (const std::exception& error) {
    return Failure(std::string(name) + ": it was given up: " + std::string(reason_of(error)));
  }
}

Expected<SystemOptions> to_system_options(const SlamOptions& given) {
  SystemOptions options;
  const Fields known = fields(options);
  for (const auto& [name, value] : given.settings) {
    if (const char* member = member_of_options(name))
      return Failure(name + ": it is not a setting here; " + member + " says it");
    if (const auto done = set_field(known, name, value); !done) return Failure(done.error().message);
  }
  options.sensor = to_sensor(given.sensor);
  options.realtime = given.timing == Timing::realtime;
  options.localize = given.mode == Mode::localisation;
  return options;
}

TrackingMode to_tracking_mode(Mode mode) {
  return mode == Mode::mapping ? TrackingMode::mapping : TrackingMode::localisation;
}

template <class Enum>
bool is_one_of(Enum value, Enum last) {
  return static_cast<int>(value) >= 0 && static_cast<int>(value) <= static_cast<int>(last);
}

// A value that is none of the enum's, as a cast from a file or another language may bring.
std::optional<std::string> enum_problem(const SlamOptions& options) {
  const auto number = [](auto value) { return ", not " + std::to_string(static_cast<int>(value)); };
  if (!is_one_of(options.sensor, SensorType::rgbd))
    return "sensor: it must be monocular, stereo or rgbd" + number(options.sensor);
  if (!is_one_of(options.timing, Timing::deterministic))
    return "timing: it must be realtime or deterministic" + number(options.timing);
  if (!is_one_of(options.mode, Mode::localisation))
    return "mode: it must be mapping or localisation" + number(options.mode);
  constexpr const char* kLens = ": lens must be none, brown_conrady or kannala_brandt";
  if (!is_one_of(options.camera.lens, LensType::kannala_brandt))
    return std::string("camera") + kLens + number(options.camera.lens);
  if (options.right && !is_one_of(options.right->camera.lens, LensType::kannala_brandt))
    return std::string("right") + kLens + number(options.right->camera.lens);
  return std::nullopt;
}

// `row`: elements that a row has at least.
template <class Image>
std::optional<std::string> image_problem(const Image& image, const Camera& camera, const char* which, ptrdiff_t row) {
  const auto size = [](int width, int height) { return std::to_string(width) + "x" + std::to_string(height); };
  std::string problem(which);
  if (!image.data || image.width != camera.width || image.height != camera.height) {
    problem.append(": the image is empty or is ").append(size(image.width, image.height));
    problem.append("; the camera is ").append(size(camera.width, camera.height));
  } else if (image.stride < row) {
    problem.append(": the stride, ").append(std::to_string(image.stride)).append(", is less than a row of pixels");
  } else {
    return std::nullopt;
  }
  return problem;
}

}  // namespace

struct Slam::Impl {
  // From one reset to the next.
  struct Session {
    System system;
    storage::MapHeader header;  // of its map when it is saved
    std::exception_ptr thrown;  // by the system, which may be half changed since; the tracking thread's

    Session(const Camera& camera, const SystemOptions& options, std::shared_ptr<const Vocabulary> vocabulary)
        : system(camera, options, vocabulary),
          header(storage::header_of(camera, options.sensor, options.orb, vocabulary.get())) {}
  };
  using SessionPtr = std::shared_ptr<Session>;

  static Expected<std::unique_ptr<Impl>> make(const SlamOptions& options);
  // With the map of a file, or without a map for an empty name.
  Expected<SessionPtr> make_session(const std::string& file, Mode now) const;
  void begin(SessionPtr made, Mode now, TrackingState state);
  // Any thread may hold on to what it gets.
  SessionPtr current() const {
    const std::lock_guard lock(mutex);
    return session;
  }
  System& system() { return session->system; }
  // The same as without_exceptions() for work of the system, with which nothing is done after it threw.
  template <class Function>
  auto attempt(const char* name, Function&& function) -> decltype(function()) {
    return without_exceptions(name, [&] {
      std::exception_ptr& thrown = session->thrown;
      if (thrown) std::rethrow_exception(thrown);
      try {
        return function();
      } catch (...) {
        thrown = std::current_exception();
        throw;
      }
    });
  }
  // Checks the images of a frame, makes a grey one of the colour image where there is none, and rectifies a pair where
  // it is to be.
  Expected<System::Input> input(const Frame& frame);
  std::optional<std::string> problem_of(const Frame& frame) const;
  void tell(const std::vector<Event>& events) const {
    for (const Event& event : events) {
      const auto told = handler;  // it may put another in its place
      if (told) (*told)(event);
    }
  }

  SystemOptions options;
  CameraParameters given;  // of rectified pairs the rectified camera
  Camera camera;
  std::optional<Rectifier> rectifier;
  FrameColours colours;
  std::shared_ptr<const Vocabulary> vocabulary;
  SessionPtr session;        // the tracking thread alone puts another in its place
  mutable std::mutex mutex;  // held when it does, and when another thread takes it
  std::atomic<Mode> mode = Mode::mapping;
  PublicSnapshots snapshots;
  EventTeller teller{TrackingState::not_initialised};
  std::shared_ptr<const std::function<void(const Event&)>> handler;  // null: there is none
  int64_t next_frame = 0;
  int64_t last_stamp = std::numeric_limits<int64_t>::min();
};

auto Slam::Impl::make_session(const std::string& file, Mode now) const -> Expected<SessionPtr> {
  SystemOptions set = options;
  set.localize = now == Mode::localisation;
  auto made = std::make_shared<Session>(camera, set, vocabulary);
  if (file.empty()) {
    if (now == Mode::localisation) return Failure("localisation needs a map: SlamOptions::map is empty");
    return made;
  }
  const auto use = set.localize ? storage::MapUse::localization : storage::MapUse::continuation;
  auto saved = storage::load_compatible_map(file, made->header, use);
  if (!saved) return Failure(saved.error().message);
  made->header = storage::header_after(made->header, saved->header);
  if (const auto placed = made->system.set_map(std::move(saved->map), saved->header.camera); !placed)
    return Failure(file + ": " + placed.error().message);
  return made;
}

void Slam::Impl::begin(SessionPtr made, Mode now, TrackingState state) {
  {
    const std::lock_guard lock(mutex);
    session.swap(made);
  }
  mode = now;
  teller = EventTeller(state);
  colours = {};
  next_frame = 0;
  last_stamp = std::numeric_limits<int64_t>::min();
}

std::optional<std::string> Slam::Impl::problem_of(const Frame& frame) const {
  const bool stereo = options.sensor == Sensor::stereo, rgbd = options.sensor == Sensor::rgbd;
  if (!stereo && frame.right.data) return "right: only a stereo pair has a right image";
  if (!rgbd && frame.depth.data) return "depth: only an RGB-D camera has depth";
  if (frame.colour.data && !is_one_of(frame.colour.order, ColourOrder::bgr))
    return "colour: order must be rgb or bgr, not " + std::to_string(static_cast<int>(frame.colour.order));
  const ptrdiff_t width = camera.width;
  std::optional<std::string> problem;
  if (frame.colour.data) problem = image_problem(frame.colour, camera, "colour", 3 * width);
  if (!problem && (frame.image.data || !frame.colour.data))
    problem = image_problem(frame.image, camera, "image", width);
  if (!problem && stereo) problem = image_problem(frame.right, camera, "right", width);
  if (!problem && rgbd) problem = image_problem(frame.depth, camera, "depth", width);
  return problem;
}

Expected<System::Input> Slam::Impl::input(const Frame& frame) {
  if (const auto problem = problem_of(frame)) return Failure(*problem);
  System::Input input;
  input.frame = next_frame;
  input.stamp = frame.stamp;
  input.image = frame.image.data ? to_view(frame.image) : colours.grey(frame.colour);
  input.right = to_view(frame.right);
  input.depth = to_view(frame.depth);
  if (rectifier) rectifier->rectify(input.image, input.right);
  return input;
}

Expected<std::unique_ptr<Slam::Impl>> Slam::Impl::make(const SlamOptions& options) {
  if (const auto problem = enum_problem(options)) return Failure(*problem);
  if (const auto problem = camera_problem(options)) return Failure(*problem);
  const auto system_options = to_system_options(options);
  if (!system_options) return Failure(system_options.error());
  auto impl = std::make_unique<Impl>();
  impl->options = *system_options;
  impl->given = options.camera;
  impl->camera = to_camera(options.camera, options.sensor);
  if (options.right) {
    auto rectifier = Rectifier::create(impl->camera, *options.right);
    if (!rectifier) return Failure("right: " + rectifier.error().message);
    const double row_time = impl->camera.pinhole.row_time;
    impl->camera = rectifier->camera();
    impl->camera.pinhole.row_time = row_time;  // rows of rectified images are nearly those that were exposed
    impl->given = to_parameters(impl->camera);
    impl->rectifier = std::move(*rectifier);
  }
  if (!options.vocabulary.empty()) {
    auto loaded = Vocabulary::load(options.vocabulary);
    if (!loaded) return Failure(loaded.error().message);
    impl->vocabulary = std::move(*loaded);
  }
  auto session = impl->make_session(options.map, options.mode);
  if (!session) return Failure(session.error());
  impl->begin(std::move(*session), options.mode,
              options.map.empty() ? TrackingState::not_initialised : TrackingState::lost);
  return impl;
}

Slam::Slam(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Slam::~Slam() = default;

Expected<std::unique_ptr<Slam>> Slam::create(const SlamOptions& options) {
  return without_exceptions("create", [&]() -> Expected<std::unique_ptr<Slam>> {
    auto impl = Impl::make(options);
    if (!impl) return Failure(impl.error());
    return std::unique_ptr<Slam>(new Slam(std::move(*impl)));
  });
}

Expected<FrameResult> Slam::track(const Frame& frame) {
  std::vector<Event> events;
  auto result = impl_->attempt("track", [&]() -> Expected<FrameResult> {
    if (!is_usable_stamp(frame.stamp))
      return Failure("stamp: it must be less than 2^62 ns (146 years) from 0, not " + std::to_string(frame.stamp));
    const auto input = impl_->input(frame);
    if (!input) return Failure(input.error());
    if (frame.stamp <= impl_->last_stamp) return Failure("stamp: stamps must rise from frame to frame");
    impl_->last_stamp = frame.stamp;
    ++impl_->next_frame;
    const FrameReport report = impl_->system().process(*input);
    if (report.track.key_frame && frame.colour.data)
      impl_->colours.keep(input->frame, frame.colour, impl_->rectifier ? &*impl_->rectifier : nullptr);
    impl_->colours.give(impl_->system());
    events = impl_->teller.of_frame(frame.stamp, report, impl_->system().map());
    return to_result(report);
  });
  impl_->tell(events);
  return result;
}

std::vector<TrackedPoint> Slam::tracked_points() {
  if (impl_->session->thrown) return {};
  return impl_->system().tracked_points();
}

Expected<std::optional<Location>> Slam::locate(const Frame& frame) {
  return impl_->attempt("locate", [&]() -> Expected<std::optional<Location>> {
    const auto input = impl_->input(frame);
    if (!input) return Failure(input.error());
    const auto found = impl_->system().locate(*input);
    if (!found) return std::nullopt;
    return to_location(*found);
  });
}

Expected<void> Slam::set_mode(Mode mode) {
  if (!is_one_of(mode, Mode::localisation))
    return Failure("mode: it must be mapping or localisation, not " + std::to_string(static_cast<int>(mode)));
  System& system = impl_->system();
  const auto events = impl_->attempt("set_mode", [&]() -> Expected<std::vector<Event>> {
    if (mode == Mode::localisation && system.map_size().key_frames == 0)
      return Failure("localisation needs a map, and there is none yet");
    const auto reports = system.set_mode(to_tracking_mode(mode));
    if (!reports) return Failure(reports.error().message);
    impl_->colours.give(system);
    impl_->mode = mode;
    return impl_->teller.of_end(impl_->last_stamp, *reports, system.take_warnings(), system.map());
  });
  if (!events) return Failure(events.error());
  impl_->tell(*events);
  return {};
}

Mode Slam::mode() const { return impl_->mode; }

void Slam::finish() {
  const auto events = impl_->attempt("finish", [&]() -> Expected<std::vector<Event>> {
    const std::vector<MappingReport> reports = impl_->system().finish();
    impl_->colours.give(impl_->system());
    System& system = impl_->system();
    return impl_->teller.of_end(impl_->last_stamp, reports, system.take_warnings(), system.map());
  });
  if (!events) return log(LogLevel::error, events.error());
  impl_->tell(*events);
}

void Slam::reset() {
  const auto made = without_exceptions("reset", [&]() -> Expected<Impl::SessionPtr> {
    try {
      return impl_->make_session("", Mode::mapping);
    } catch (...) {
      impl_->session->thrown = std::current_exception();  // what was to be forgotten is not to be continued
      throw;
    }
  });
  if (!made) return log(LogLevel::error, made.error());
  impl_->begin(*made, Mode::mapping, TrackingState::not_initialised);
}

Expected<void> Slam::load_map(const std::string& file) {
  return without_exceptions("load_map", [&]() -> Expected<void> {
    if (file.empty()) return Failure("load_map: the name of the file is empty");
    auto session = impl_->make_session(file, mode());
    if (!session) return Failure(session.error());
    impl_->begin(std::move(*session), mode(), TrackingState::lost);
    return {};
  });
}

void Slam::on_event(std::function<void(const Event&)> handler) {
  impl_->handler = handler ? std::make_shared<const std::function<void(const Event&)>>(std::move(handler)) : nullptr;
}

std::shared_ptr<const MapSnapshot> Slam::snapshot() const {
  Impl::SessionPtr session;
  const auto current = [&]() -> const System& {
    session = impl_->current();
    return session->system;
  };
  return impl_->snapshots.get(current, impl_->given);
}

std::vector<TrajectoryPose> Slam::trajectory() const { return to_trajectory(impl_->current()->system.trajectory()); }

Expected<void> Slam::save_map(const std::string& file) const {
  return without_exceptions("save_map", [&]() -> Expected<void> {
    const auto session = impl_->current();
    const MapState state = session->system.map_state();
    if (state.key_frames.empty()) return Failure(file + ": there is no map to save yet");
    if (const auto saved = storage::save_map(file, state, session->header); !saved)
      return Failure(saved.error().message);
    return {};
  });
}

CameraParameters Slam::camera() const { return in_use(impl_->given, impl_->current()->system.camera()); }

Pose Slam::rectified_left() const { return impl_->rectifier ? impl_->rectifier->rectified_left() : Pose(); }

std::vector<Setting> Slam::settings() const {
  SystemOptions options = impl_->options;
  return to_settings(fields(options));
}

std::vector<Setting> default_settings() {
  SystemOptions options;
  return to_settings(fields(options));
}

}  // namespace covis

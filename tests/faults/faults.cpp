// SPDX-License-Identifier: Apache-2.0
#include "tests/faults/faults.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace covis::faults {
namespace {

template <class T>
Image<T> copy_of(const Image<T>& image) {
  Image<T> made;
  if (image.empty()) return made;
  made.resize(image.width(), image.height());
  for (int y = 0; y < image.height(); ++y) std::copy(image.row(y), image.row(y) + image.width(), made.row(y));
  return made;
}

// An image whose pixel (x, y) is value(x, y).
template <class T, class Value>
Image<T> painted(int width, int height, Value value) {
  Image<T> made(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) made.row(y)[x] = static_cast<T>(value(x, y));
  }
  return made;
}

// The image as seen through `from`, which gives the place of a pixel's value; outside it is `outside`.
template <class T, class From>
Image<T> moved(const Image<T>& image, From from, T outside = 0) {
  return painted<T>(image.width(), image.height(), [&](int x, int y) {
    const auto [u, v] = from(x, y);
    const int a = static_cast<int>(std::lround(u)), b = static_cast<int>(std::lround(v));
    return a >= 0 && b >= 0 && a < image.width() && b < image.height() ? image(a, b) : outside;
  });
}

template <class T>
Image<T> shifted(const Image<T>& image, double dx, double dy) {
  return moved(image, [&](int x, int y) { return std::pair(x - dx, y - dy); });
}

template <class T>
Image<T> turned(const Image<T>& image, double degrees) {
  const double c = std::cos(degrees * M_PI / 180), s = std::sin(degrees * M_PI / 180);
  const double mx = image.width() / 2.0, my = image.height() / 2.0;
  return moved(image, [&](int x, int y) {
    return std::pair(mx + c * (x - mx) + s * (y - my), my - s * (x - mx) + c * (y - my));
  });
}

template <class T, class Change>
Image<T> changed(const Image<T>& image, Change change) {
  return painted<T>(image.width(), image.height(), [&](int x, int y) { return change(image(x, y)); });
}

uint8_t grey(double value) { return static_cast<uint8_t>(std::clamp(std::lround(value), 0L, 255L)); }

using Change = std::function<void(Moment& moment, int i, const GoodFrames& good, Random& random)>;

// A fault that changes the frame.
Fault fault(std::string name, Change change) {
  return {std::move(name), [change = std::move(change)](int i, const GoodFrames& good, Random& random) {
            std::optional<Moment> moment(copy(good(i)));
            change(*moment, i, good, random);
            return moment;
          }};
}

// A fault that changes both grey images alike.
template <class Of>
Fault both_images(std::string name, Of of) {
  return fault(std::move(name), [of](Moment& m, int i, const GoodFrames&, Random& random) {
    m.left = of(m.left, i, random);
    if (!m.right.empty()) m.right = of(m.right, i, random);
  });
}

ImageU8 noisy(const ImageU8& image, double sigma, Random& random) {
  return changed(image, [&](uint8_t value) { return grey(value + sigma * random.normal()); });
}

std::vector<Fault> depth_faults() {
  const auto depth = [](std::string name, auto of) {
    return fault(std::move(name),
                 [of](Moment& m, int, const GoodFrames&, Random& random) { m.depth = of(m.depth, random); });
  };
  const auto each = [&](std::string name, auto of) {
    return depth(std::move(name), [of](const ImageF& d, Random&) { return changed(d, of); });
  };
  const auto late = [](std::string name, int frames) {
    return fault(std::move(name), [frames](Moment& m, int i, const GoodFrames& good, Random&) {
      m.depth = copy_of(good(i - frames).depth);
    });
  };
  return {depth("random",
                [](const ImageF& d, Random& random) {
                  return changed(d, [&](float) { return static_cast<float>(random.uniform(0.5, 6)); });
                }),
          each("constant", [](float) { return 2.0f; }),
          each("inverse", [](float z) { return z > 0 ? 4 / z : 0; }),
          each("reversed", [](float z) { return z > 0 && z < 8 ? 8 - z : 0; }),
          depth("mirrored",
                [](const ImageF& d, Random&) {
                  return moved(d, [&](int x, int y) { return std::pair(d.width() - 1 - x, y); });
                }),
          depth("upside_down",
                [](const ImageF& d, Random&) {
                  return moved(d, [&](int x, int y) { return std::pair(x, d.height() - 1 - y); });
                }),
          depth("turned_round", [](const ImageF& d, Random&) { return turned(d, 180); }),
          depth("shifted_eighth", [](const ImageF& d, Random&) { return shifted(d, d.width() / 8.0, 0); }),
          depth("smaller",
                [](const ImageF& d, Random&) {  // the middle of the image, stretched
                  return moved(d,
                               [&](int x, int y) { return std::pair(d.width() / 4 + x / 2, d.height() / 4 + y / 2); });
                }),
          late("late_5", 5),
          late("late_20", 20),
          late("frozen", 1 << 20),
          each("scale_fifth", [](float z) { return z / 5; }),
          each("scale_five", [](float z) { return z * 5; })};
}

std::vector<Fault> right_faults() {
  const auto right = [](std::string name, auto of) {
    return fault(std::move(name),
                 [of](Moment& m, int, const GoodFrames&, Random& random) { m.right = of(m.right, random); });
  };
  const auto late = [](std::string name, int frames) {
    return fault(std::move(name), [frames](Moment& m, int i, const GoodFrames& good, Random&) {
      m.right = copy_of(good(i - frames).right);
    });
  };
  return {fault("left_twice", [](Moment& m, int, const GoodFrames&, Random&) { m.right = copy_of(m.left); }),
          fault("swapped", [](Moment& m, int, const GoodFrames&, Random&) { m.left.swap(m.right); }),
          late("late_1", 1),
          late("late_2", 2),
          late("late_10", 10),
          late("frozen", 1 << 20),
          right("rows_3_lower", [](const ImageU8& r, Random&) { return shifted(r, 0, 3); }),
          right("rows_10_lower", [](const ImageU8& r, Random&) { return shifted(r, 0, 10); }),
          right("turned_2_degrees", [](const ImageU8& r, Random&) { return turned(r, 2); }),
          right("upside_down", [](const ImageU8& r, Random&) { return turned(r, 180); }),
          right("mirrored",
                [](const ImageU8& r, Random&) {
                  return moved(r, [&](int x, int y) { return std::pair(r.width() - 1 - x, y); });
                }),
          right("shifted_right", [](const ImageU8& r, Random&) { return shifted(r, r.width() / 32.0, 0); }),
          right("noise", [](const ImageU8& r, Random& random) { return noisy(r, 120, random); }),
          right("black", [](const ImageU8& r, Random&) { return changed(r, [](uint8_t) { return 0; }); })};
}

}  // namespace

Moment copy(const Moment& m) { return {copy_of(m.left), copy_of(m.right), copy_of(m.depth), m.stamp}; }

std::vector<Fault> sensor_faults(Sensor sensor) {
  if (sensor == Sensor::rgbd) return depth_faults();
  if (sensor == Sensor::stereo) return right_faults();
  return {};
}

std::vector<Fault> stream_faults(Sensor sensor) {
  std::vector<Fault> all{
      {"dropped", [](int, const GoodFrames&, Random&) { return std::optional<Moment>(); }},
      {"every_second_dropped",
       [](int i, const GoodFrames& good, Random&) { return i % 2 ? std::optional<Moment>() : copy(good(i)); }},
      {"third_dropped",
       [](int i, const GoodFrames& good, Random& random) {
         return random.uniform(0, 1) < 1.0 / 3 ? std::optional<Moment>() : copy(good(i));
       }},
      both_images("black", [](const ImageU8& m, int, Random&) { return changed(m, [](uint8_t) { return 0; }); }),
      both_images("white", [](const ImageU8& m, int, Random&) { return changed(m, [](uint8_t) { return 255; }); }),
      both_images("noise", [](const ImageU8& m, int, Random& random) { return noisy(m, 30, random); }),
      both_images("noise_alone",
                  [](const ImageU8& m, int, Random& random) {
                    return changed(m, [&](uint8_t) { return grey(random.uniform(0, 255)); });
                  }),
      both_images("half_as_bright",
                  [](const ImageU8& m, int, Random&) { return changed(m, [](uint8_t v) { return v / 2; }); }),
      both_images("twice_as_bright",
                  [](const ImageU8& m, int, Random&) { return changed(m, [](uint8_t v) { return grey(2.0 * v); }); }),
      both_images("flicker", [](const ImageU8& m, int i,
                                Random&) { return changed(m, [i](uint8_t v) { return i % 2 ? v / 3 : v; }); }),
      both_images("half_covered",
                  [](const ImageU8& m, int, Random&) {
                    return painted<uint8_t>(m.width(), m.height(),
                                            [&](int x, int y) { return x < m.width() / 2 ? 0 : m(x, y); });
                  }),
      both_images("turned_round", [](const ImageU8& m, int, Random&) { return turned(m, 180); }),
      both_images("mirrored",
                  [](const ImageU8& m, int, Random&) {
                    return moved(m, [&](int x, int y) { return std::pair(m.width() - 1 - x, y); });
                  }),
      both_images("torn",
                  [](const ImageU8& m, int, Random&) {  // the lower half belongs elsewhere
                    return moved(m, [&](int x, int y) {
                      return std::pair(y < m.height() / 2 ? x : (x + m.width() / 3) % m.width(), y);
                    });
                  }),
      fault("frozen",
            [](Moment& m, int i, const GoodFrames& good, Random&) {
              const Timestamp stamp = m.stamp;
              m = copy(good(i / 12 * 12));
              m.stamp = stamp;
            }),
      fault("out_of_order",
            [](Moment& m, int i, const GoodFrames& good, Random&) {
              const Timestamp stamp = m.stamp;
              m = copy(good(i ^ 1));
              m.stamp = stamp;
            }),
      fault("elsewhere",
            [](Moment& m, int i, const GoodFrames& good, Random&) {
              const Timestamp stamp = m.stamp;
              m = copy(good(i - 30));
              m.stamp = stamp;
            }),
      fault("stamps_stand",
            [](Moment& m, int i, const GoodFrames& good, Random&) { m.stamp = good(i / 12 * 12).stamp; }),
      fault("stamps_back", [](Moment& m, int, const GoodFrames&, Random&) { m.stamp -= from_seconds(100); }),
      fault("stamps_jitter", [](Moment& m, int, const GoodFrames&,
                                Random& random) { m.stamp += from_seconds(random.uniform(-0.3, 0.3)); }),
      fault("other_size", [](Moment& m, int, const GoodFrames&, Random&) {
        m.left = painted<uint8_t>(m.left.width() / 2, m.left.height() / 2,
                                  [&](int x, int y) { return m.left(2 * x, 2 * y); });
      })};
  for (Fault& fault : sensor_faults(sensor)) {
    fault.name = (sensor == Sensor::rgbd ? "depth_" : "right_") + fault.name;
    all.push_back(std::move(fault));
  }
  return all;
}

}  // namespace covis::faults

// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/image_rotation.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <vector>

#include "covis/geometry/se3.h"

namespace covis {
namespace {

constexpr double kMinOverlap = 1.0 / 3;  // share of the image that both must see
constexpr double kMinContrast = 1.5;     // standard deviation of the grey levels there, below which it is flat
constexpr double kMinCorrelation = 0.8;  // with less the two images show different things
constexpr double kMaxZoom = 1.4;
constexpr int kMinSide = 8;  // small pixels

// Sums over the pixels that both images see, from which their correlation follows.
struct Moments {
  double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
  void add(double va, double vb) { n += 1, a += va, b += vb, aa += va * va, bb += vb * vb, ab += va * vb; }
  double deviation_a() const { return std::sqrt(std::max(0.0, aa / n - a / n * (a / n))); }
  double deviation_b() const { return std::sqrt(std::max(0.0, bb / n - b / n * (b / n))); }
  // 0 where either is flat.
  double correlation() const {
    if (n == 0) return 0;
    const double sa = deviation_a(), sb = deviation_b();
    return std::min(sa, sb) < kMinContrast ? 0 : (ab / n - a / n * (b / n)) / (sa * sb);
  }
  // How unlikely the correlation is by chance (Fisher's z, in sigmas but for a factor): a wide overlap says more than
  // a narrow one.
  double significance() const { return std::atanh(std::clamp(correlation(), 0.0, 0.999)) * std::sqrt(n); }
};

// A grey image of half the size of the small one, for the search of all shifts.
struct Coarse {
  int width = 0, height = 0;
  std::vector<int16_t> grey;
  std::vector<int32_t> sums, squares;  // integral images, one row and column larger

  int16_t at(int x, int y) const {
    return grey[static_cast<size_t>(std::clamp(y, 0, height - 1) * width + std::clamp(x, 0, width - 1))];
  }
  void integrate();
};

void Coarse::integrate() {
  const auto stride = static_cast<size_t>(width) + 1;
  sums.assign(stride * (static_cast<size_t>(height) + 1), 0);
  squares = sums;
  for (size_t y = 0; y < static_cast<size_t>(height); ++y) {
    int32_t sum = 0, square = 0;
    for (size_t x = 0; x + 1 < stride; ++x) {
      const int32_t v = grey[y * (stride - 1) + x];
      sum += v;
      square += v * v;
      sums[(y + 1) * stride + x + 1] = sums[y * stride + x + 1] + sum;
      squares[(y + 1) * stride + x + 1] = squares[y * stride + x + 1] + square;
    }
  }
}

Coarse halved(const SmallImage& image) {
  Coarse half;
  half.width = image.width / 2;
  half.height = image.height / 2;
  for (int y = 0; y < half.height; ++y) {
    for (int x = 0; x < half.width; ++x) {
      const uint8_t* p = image.grey.data() + 2 * y * image.width + 2 * x;
      half.grey.push_back(static_cast<int16_t>((p[0] + p[1] + p[image.width] + p[image.width + 1] + 2) / 4));
    }
  }
  half.integrate();
  return half;
}

// The image turned about its centre, so that a point at p goes to R(roll) p.
Coarse rolled(const Coarse& image, double roll) {
  if (roll == 0) return image;
  Coarse turned;
  turned.width = image.width;
  turned.height = image.height;
  const double c = std::cos(roll), s = std::sin(roll), cx = (image.width - 1) / 2.0, cy = (image.height - 1) / 2.0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const double u = c * (x - cx) + s * (y - cy) + cx, v = -s * (x - cx) + c * (y - cy) + cy;
      const int x0 = static_cast<int>(std::floor(u)), y0 = static_cast<int>(std::floor(v));
      const double fx = u - x0, fy = v - y0;
      const double grey = (1 - fy) * ((1 - fx) * image.at(x0, y0) + fx * image.at(x0 + 1, y0)) +
                          fy * ((1 - fx) * image.at(x0, y0 + 1) + fx * image.at(x0 + 1, y0 + 1));
      turned.grey.push_back(static_cast<int16_t>(std::lround(grey)));
    }
  }
  turned.integrate();
  return turned;
}

// A motion of the coarse image: a roll about its centre, then a shift.
struct Shift {
  int dx = 0, dy = 0;  // coarse pixels
  double roll = 0;     // radians
  double significance = 0;
};

int32_t over(const std::vector<int32_t>& integral, int width, int x0, int y0, int x1, int y1) {
  const auto at = [&](int x, int y) { return integral[static_cast<size_t>(y * (width + 1) + x)]; };
  return at(x1, y1) - at(x0, y1) - at(x1, y0) + at(x0, y0);
}

// Compares a's pixel (x, y) with b's (x + dx, y + dy).
Moments compare(const Coarse& a, const Coarse& b, int dx, int dy) {
  const int x0 = std::max(0, -dx), x1 = std::min(a.width, b.width - dx);
  const int y0 = std::max(0, -dy), y1 = std::min(a.height, b.height - dy);
  int32_t product = 0;
  for (int y = y0; y < y1; ++y) {
    const int16_t* pa = a.grey.data() + y * a.width;
    const int16_t* pb = b.grey.data() + (y + dy) * b.width + dx;
    for (int x = x0; x < x1; ++x) product += pa[x] * pb[x];
  }
  Moments m;
  m.n = static_cast<double>(x1 - x0) * (y1 - y0);
  m.a = over(a.sums, a.width, x0, y0, x1, y1);
  m.aa = over(a.squares, a.width, x0, y0, x1, y1);
  m.b = over(b.sums, b.width, x0 + dx, y0 + dy, x1 + dx, y1 + dy);
  m.bb = over(b.squares, b.width, x0 + dx, y0 + dy, x1 + dx, y1 + dy);
  m.ab = product;
  return m;
}

// The most significant shifts of all, one for each hill of the significance.
std::vector<Shift> best_shifts(const Coarse& first, const Coarse& second) {
  constexpr std::array<double, 5> kRolls = {0, -10, 10, -20, 20};  // degrees
  constexpr size_t kKept = 5;
  const int w = first.width, h = first.height;
  std::vector<Shift> hills;
  std::vector<double> score;
  const int most_x = w - 1, most_y = h - 1, columns = 2 * most_x + 1, rows = 2 * most_y + 1;
  for (const double degrees : kRolls) {
    const double roll = degrees * std::numbers::pi / 180;
    const Coarse turned = rolled(first, roll);
    score.assign(static_cast<size_t>(columns) * static_cast<size_t>(rows), 0);
    const auto at = [&](int dx, int dy) -> double& {
      return score[static_cast<size_t>((dy + most_y) * columns + dx + most_x)];
    };
    for (int dy = -most_y; dy <= most_y; ++dy) {
      for (int dx = -most_x; dx <= most_x; ++dx) {
        if ((w - std::abs(dx)) * (h - std::abs(dy)) < kMinOverlap * w * h) continue;
        at(dx, dy) = compare(turned, second, dx, dy).significance();
      }
    }
    for (int dy = -most_y + 1; dy < most_y; ++dy) {
      for (int dx = -most_x + 1; dx < most_x; ++dx) {
        const double here = at(dx, dy);
        if (here > 0 && here > at(dx - 1, dy) && here > at(dx, dy - 1) && here >= at(dx + 1, dy) &&
            here >= at(dx, dy + 1))
          hills.push_back({dx, dy, roll, here});
      }
    }
  }
  std::stable_sort(hills.begin(), hills.end(),
                   [](const Shift& a, const Shift& b) { return a.significance > b.significance; });
  hills.resize(std::min(hills.size(), kKept));
  return hills;
}

// The rotation that moves two points beside the image's centre as the shift does.
Eigen::Matrix3d rotation_of(const Shift& shift, const SmallImage& image, const Pinhole& camera) {
  const double cx = (image.width - 1) / 2.0, cy = (image.height - 1) / 2.0, beside = image.width / 8.0;
  const auto frame = [&](double u, double v, double du, double dv) {  // axes on the rays through (u, v) -+ (du, dv)
    const Eigen::Vector3d left = camera.unproject(u - du, v - dv).normalized();
    const Eigen::Vector3d right = camera.unproject(u + du, v + dv).normalized();
    Eigen::Matrix3d axes;
    axes.col(0) = (right - left).normalized();
    axes.col(2) = (right + left).normalized();
    axes.col(1) = axes.col(2).cross(axes.col(0));
    return axes;
  };
  const Eigen::Matrix3d to =
      frame(cx + 2 * shift.dx, cy + 2 * shift.dy, beside * std::cos(shift.roll), beside * std::sin(shift.roll));
  return to * frame(cx, cy, beside, 0).transpose();
}

// Finds the rotation between two small images by Gauss-Newton, with gain and offset of the grey levels taken off. A
// zoom about the principal point is found beside it: a camera that moves forward would else seem to turn.
class Aligner {
 public:
  Aligner(const SmallImage& first, const SmallImage& second, const Pinhole& camera)
      : first_(first), second_(second), camera_(camera) {
    pairs_.reserve(first.grey.size());
  }

  // Improves R_21 in some steps. Returns the comparison of the images by it.
  Moments align(Eigen::Matrix3d& R_21) {
    constexpr int kSteps = 12;
    constexpr double kSmall = 0.01;  // small pixels
    double zoom = 1;
    Moments m;
    for (int k = 0; k < kSteps; ++k) {
      m = look(R_21, zoom);
      if (m.correlation() <= 0) return m;
      const Eigen::Vector4d step = solve(m, zoom);
      if (step.norm() * camera_.fx < kSmall || k + 1 == kSteps) break;
      R_21 = so3_exp(step.head<3>()) * R_21;
      zoom = std::clamp(zoom * std::exp(step[3]), 1 / kMaxZoom, kMaxZoom);
    }
    return m;
  }

 private:
  struct Pair {
    double a, b;    // grey levels in the first image and where it is in the second
    double gx, gy;  // gradient there
    double x, y;    // the ray there, z = 1
  };

  // Lists the pixels that both images see.
  Moments look(const Eigen::Matrix3d& R_21, double zoom) {
    Moments m;
    pairs_.clear();
    const uint8_t* grey = first_.grey.data();
    for (int y = 0; y < first_.height; ++y) {
      for (int x = 0; x < first_.width; ++x, ++grey) {
        const Eigen::Vector3d ray = R_21 * camera_.unproject(x, y);
        if (ray.z() < 0.1) continue;
        Pair p{static_cast<double>(*grey), 0, 0, 0, ray.x() / ray.z(), ray.y() / ray.z()};
        if (!sample(zoom * camera_.fx * p.x + camera_.cx, zoom * camera_.fy * p.y + camera_.cy, p)) continue;
        m.add(p.a, p.b);
        pairs_.push_back(p);
      }
    }
    if (m.n < kMinOverlap * static_cast<double>(first_.grey.size())) return {};
    return m;
  }

  // Reads the second image, bilinearly.
  bool sample(double u, double v, Pair& p) const {
    if (!(u >= 0 && v >= 0 && u < second_.width - 1 && v < second_.height - 1)) return false;
    const int x = static_cast<int>(u), y = static_cast<int>(v);
    const double fx = u - x, fy = v - y;
    const uint8_t* above = second_.grey.data() + y * second_.width + x;
    const uint8_t* below = above + second_.width;
    const double left = above[0] + fy * (below[0] - above[0]), right = above[1] + fy * (below[1] - above[1]);
    p.b = left + fx * (right - left);
    p.gx = right - left;
    p.gy = (below[0] - above[0]) + fx * ((below[1] - above[1]) - (below[0] - above[0]));
    return true;
  }

  // The rotation vector and the logarithm of the zoom that make the standardised images more alike.
  Eigen::Vector4d solve(const Moments& m, double zoom) const {
    const double mean_a = m.a / m.n, mean_b = m.b / m.n, gain = m.deviation_b() / m.deviation_a();
    Eigen::Matrix4d H = Eigen::Matrix4d::Zero();
    Eigen::Vector4d g = Eigen::Vector4d::Zero();
    for (const Pair& p : pairs_) {
      const double gx = p.gx * camera_.fx * zoom, gy = p.gy * camera_.fy * zoom;
      const Eigen::Vector4d J(-p.x * p.y * gx - (1 + p.y * p.y) * gy, (1 + p.x * p.x) * gx + p.x * p.y * gy,
                              -p.y * gx + p.x * gy, p.x * gx + p.y * gy);
      H += J * J.transpose();
      g += J * ((p.b - mean_b) - gain * (p.a - mean_a));
    }
    H.diagonal() *= 1 + 1e-6;
    return H.ldlt().solve(-g);
  }

  const SmallImage& first_;
  const SmallImage& second_;
  const Pinhole camera_;
  std::vector<Pair> pairs_;
};

}  // namespace

std::optional<Eigen::Matrix3d> image_rotation(const SmallImage& first, const SmallImage& second,
                                              const Pinhole& camera) {
  if (first.width != second.width || first.height != second.height || first.block != second.block) return std::nullopt;
  if (std::min(first.width, first.height) < kMinSide) return std::nullopt;
  const Pinhole small = first.camera(camera);
  Aligner aligner(first, second, small);
  std::optional<Eigen::Matrix3d> best;
  double most = 0;
  for (const Shift& shift : best_shifts(halved(first), halved(second))) {
    Eigen::Matrix3d R_21 = rotation_of(shift, first, small);
    const Moments m = aligner.align(R_21);
    if (m.n == 0 || m.correlation() < kMinCorrelation || m.significance() <= most || !R_21.allFinite()) continue;
    most = m.significance();
    best = R_21;
  }
  return best;
}

}  // namespace covis

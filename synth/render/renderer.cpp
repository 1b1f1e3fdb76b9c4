// SPDX-License-Identifier: Apache-2.0
#include "synth/render/renderer.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace covis::synth {
namespace {

constexpr uint32_t kNone = 0;   // no polygon; visible polygon k has number k + 1
constexpr int kBandRows = 24;   // number of image rows shaded at a time, so that the z-buffer stays in the cache
constexpr double kNear = 0.03;  // distance of the near plane, metres
constexpr int kMaxCorners = 16;

}  // namespace

Result<Renderer> Renderer::create(const Camera& camera) {
  Renderer r;
  r.camera_ = camera;
  r.distorted_ = camera.distortion != Distortion::none;
  const Pinhole& k = camera.pinhole;
  r.pixel_x_ = static_cast<float>(1 / k.fx);
  r.pixel_y_ = static_cast<float>(1 / k.fy);
  const size_t pixels = static_cast<size_t>(camera.width) * static_cast<size_t>(camera.height);
  r.ray_x_.resize(pixels + kShadeOverrun);
  r.ray_y_.resize(pixels + kShadeOverrun);
  const int sample_columns = 2 * camera.width + 1, sample_rows = 2 * camera.height + 1;
  const auto ray_of = [&](double u, double v) -> std::optional<Eigen::Vector2d> {
    if (!r.distorted_) return Eigen::Vector2d((u - k.cx) / k.fx, (v - k.cy) / k.fy);
    const auto ray = camera.unproject({u, v});
    if (!ray || ray->z() < 0.1) return std::nullopt;
    return Eigen::Vector2d(ray->x() / ray->z(), ray->y() / ray->z());
  };
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const auto ray = ray_of(x, y);
      if (!ray)
        return fail("the lens distortion cannot be inverted at pixel " + std::to_string(x) + ", " + std::to_string(y));
      const size_t i = static_cast<size_t>(y) * static_cast<size_t>(camera.width) + static_cast<size_t>(x);
      r.ray_x_[i] = static_cast<float>(ray->x());
      r.ray_y_[i] = static_cast<float>(ray->y());
    }
  }
  if (!r.distorted_) {
    r.stretch_.assign(static_cast<size_t>(camera.width + kShadeOverrun), 1.0f);
    r.columns_ = sample_columns;
    r.rows_ = sample_rows;
    r.origin_x_ = 2 * k.cx + 1;
    r.origin_y_ = 2 * k.cy + 1;
    return r;
  }
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Matrix2f J = r.ray_jacobian(x, y);
      const float area = std::abs(J.determinant());
      r.to_pixels_.push_back(J.inverse());
      r.stretch_.push_back(std::sqrt(area / (r.pixel_x_ * r.pixel_y_)));
    }
  }
  r.stretch_.resize(pixels + kShadeOverrun);
  // The pinhole image that contains every ray of the distorted one.
  std::vector<Eigen::Vector2d> rays;
  Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);
  for (int j = 0; j < sample_rows; ++j) {
    for (int i = 0; i < sample_columns; ++i) {
      const auto ray = ray_of(0.5 * (i - 1), 0.5 * (j - 1));
      if (!ray) return fail("the lens distortion cannot be inverted at the edge of the image");
      rays.push_back(*ray);
      low = low.cwiseMin(*ray);
      high = high.cwiseMax(*ray);
    }
  }
  r.origin_x_ = 1 - std::floor(2 * k.fx * low.x());
  r.origin_y_ = 1 - std::floor(2 * k.fy * low.y());
  r.columns_ = static_cast<int>(std::ceil(2 * k.fx * high.x() + r.origin_x_)) + 2;
  r.rows_ = static_cast<int>(std::ceil(2 * k.fy * high.y() + r.origin_y_)) + 2;
  if (r.columns_ > 8 * camera.width || r.rows_ > 8 * camera.height)
    return fail("the lens distortion is too strong to render");
  for (const Eigen::Vector2d& ray : rays) {
    const int column = static_cast<int>(std::lround(2 * k.fx * ray.x() + r.origin_x_));
    const int row = static_cast<int>(std::lround(2 * k.fy * ray.y() + r.origin_y_));
    r.sample_of_.push_back(row * r.columns_ + column);
  }
  for (int begin = 0; begin < camera.height; begin += kBandRows) {
    const int end = std::min(begin + kBandRows, camera.height);
    int first = r.rows_, last = 0;
    for (int s = 2 * begin * sample_columns; s < (2 * end + 1) * sample_columns; ++s) {
      const int row = r.sample_of_[static_cast<size_t>(s)] / r.columns_;
      first = std::min(first, row);
      last = std::max(last, row);
    }
    r.band_row_begin_.push_back(first);
    r.band_row_end_.push_back(last + 1);
  }
  return r;
}

Eigen::Matrix2f Renderer::ray_jacobian(int x, int y) const {
  if (!distorted_) return Eigen::Vector2f(pixel_x_, pixel_y_).asDiagonal();
  const int x0 = std::max(x - 1, 0), x1 = std::min(x + 1, camera_.width - 1);
  const int y0 = std::max(y - 1, 0), y1 = std::min(y + 1, camera_.height - 1);
  Eigen::Matrix2f J;
  J.col(0) = (ray(x1, y) - ray(x0, y)) / static_cast<float>(x1 - x0);
  J.col(1) = (ray(x, y1) - ray(x, y0)) / static_cast<float>(y1 - y0);
  return J;
}

Eigen::Vector2f Renderer::to_pixels(int x, int y, float ray_dx, float ray_dy) const {
  if (!distorted_) return {ray_dx / pixel_x_, ray_dy / pixel_y_};
  return to_pixels_[static_cast<size_t>(y * camera_.width + x)] * Eigen::Vector2f(ray_dx, ray_dy);
}

void Renderer::render(const Scene& scene, const SE3& T_wc, ImageF& tone, ImageF& depth) {
  tone.resize(camera_.width, camera_.height);
  depth.resize(camera_.width, camera_.height);
  collect(scene, T_wc);
  const int sample_columns = 2 * camera_.width + 1;
  for (int begin = 0, band = 0; begin < camera_.height; begin += kBandRows, ++band) {
    const int end = std::min(begin + kBandRows, camera_.height);
    const uint32_t* ids = nullptr;
    if (distorted_) {
      const int first = band_row_begin_[static_cast<size_t>(band)];
      rasterise(first, band_row_end_[static_cast<size_t>(band)]);
      warped_.resize(static_cast<size_t>(sample_columns) * static_cast<size_t>(2 * (end - begin) + 1));
      const int32_t* from = sample_of_.data() + static_cast<ptrdiff_t>(2 * begin) * sample_columns;
      for (size_t i = 0; i < warped_.size(); ++i) warped_[i] = id_[static_cast<size_t>(from[i] - first * columns_)];
      ids = warped_.data();
    } else {
      rasterise(2 * begin, 2 * end + 1);
      ids = id_.data();
    }
    for (int y = begin; y < end; ++y) {
      const uint32_t* above = ids + static_cast<ptrdiff_t>(2 * (y - begin)) * sample_columns;
      shade_row(y, above, above + sample_columns, above + 2 * sample_columns, tone.row(y), depth.row(y));
    }
  }
}

void Renderer::collect(const Scene& scene, const SE3& T_wc) {
  visible_.clear();
  edges_.clear();
  order_.clear();
  const SE3 T_cw = T_wc.inverse();
  for (const Polygon& polygon : scene.polygons) {
    const double side = polygon.normal.dot(T_wc.t()) - polygon.offset;
    if (std::abs(side) < 1e-6 || (side < 0 && !polygon.two_sided)) continue;
    const double z = (T_cw.R().row(2) * polygon.centre)(0) + T_cw.t().z();
    if (z + polygon.radius < kNear) continue;
    if (add_visible(scene, polygon, T_cw))
      order_.emplace_back(-visible_.back().surface.w_max, static_cast<int>(visible_.size()) - 1);
  }
  std::sort(order_.begin(), order_.end());
}

bool Renderer::add_visible(const Scene& scene, const Polygon& polygon, const SE3& T_cw) {
  std::array<Vector3d, kMaxCorners> points, clipped;
  const int corners = std::min(polygon.count, kMaxCorners - 1);
  bool in_front = true;
  for (int i = 0; i < corners; ++i) {
    points[static_cast<size_t>(i)] = T_cw * scene.vertices[static_cast<size_t>(polygon.first + i)];
    in_front = in_front && points[static_cast<size_t>(i)].z() >= kNear;
  }
  int count = corners;
  const Vector3d* outline = points.data();
  if (!in_front) {  // clips the polygon at the near plane
    count = 0;
    for (int i = 0; i < corners; ++i) {
      const Vector3d& a = points[static_cast<size_t>(i)];
      const Vector3d& b = points[static_cast<size_t>((i + 1) % corners)];
      if (a.z() >= kNear) clipped[static_cast<size_t>(count++)] = a;
      if ((a.z() >= kNear) != (b.z() >= kNear)) {
        clipped[static_cast<size_t>(count++)] = a + (kNear - a.z()) / (b.z() - a.z()) * (b - a);
      }
    }
    if (count < 3) return false;
    outline = clipped.data();
  }
  Visible v;
  if (!add_outline(outline, count, v)) return false;

  const Vector3d n = T_cw.R() * polygon.normal;
  const double d = n.dot(points[0]);
  const Vector3d w = n / d, u = T_cw.R() * polygon.u_w, t = T_cw.R() * polygon.v_w;
  // p_w = R_wc (p_c - t_cw), so u = u_w . p_w + u_0 has this constant part in camera coordinates.
  const Vector3d uw = u + (polygon.u_0 - u.dot(T_cw.t())) * w, vw = t + (polygon.v_0 - t.dot(T_cw.t())) * w;
  const auto set = [](const Vector3d& from, float& x, float& y, float& one) {
    x = static_cast<float>(from.x());
    y = static_cast<float>(from.y());
    one = static_cast<float>(from.z());
  };
  set(w, v.surface.w_x, v.surface.w_y, v.surface.w_1);
  set(uw, v.surface.u_x, v.surface.u_y, v.surface.u_1);
  set(vw, v.surface.v_x, v.surface.v_y, v.surface.v_1);
  v.plane_x = w.x() / (2 * camera_.pinhole.fx);
  v.plane_y = w.y() / (2 * camera_.pinhole.fy);
  v.plane_1 = w.z() - v.plane_x * origin_x_ - v.plane_y * origin_y_;
  v.surface.texture = scene.textures[static_cast<size_t>(polygon.texture)].view();
  v.surface.detail = scene.textures[0].view();
  v.surface.gain = polygon.gain;
  v.surface.detail_strength = polygon.detail / 128;
  v.surface.detail_u = polygon.detail_u;
  v.surface.detail_v = polygon.detail_v;
  v.surface.light.texels = nullptr;
  if (polygon.light_map >= 0) {
    const LightMap& map = scene.light_maps[static_cast<size_t>(polygon.light_map)];
    v.surface.light = map.texture.view();
    v.surface.light_u_scale = map.u_scale;
    v.surface.light_v_scale = map.v_scale;
    v.surface.light_u_0 = map.u_0;
    v.surface.light_v_0 = map.v_0;
  }
  v.sky = polygon.sky;
  visible_.push_back(v);
  return true;
}

bool Renderer::add_outline(const Vector3d* points, int count, Visible& visible) {
  std::array<Eigen::Vector2d, kMaxCorners> at;
  Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);
  double z_min = 1e9, z_max = 0, area = 0;
  for (int i = 0; i < count; ++i) {
    const Vector3d& p = points[i];
    Eigen::Vector2d& s = at[static_cast<size_t>(i)];
    s = {2 * camera_.pinhole.fx * p.x() / p.z() + origin_x_, 2 * camera_.pinhole.fy * p.y() / p.z() + origin_y_};
    low = low.cwiseMin(s);
    high = high.cwiseMax(s);
    z_min = std::min(z_min, p.z());
    z_max = std::max(z_max, p.z());
  }
  if (high.x() < 0 || high.y() < 0 || low.x() > columns_ - 1 || low.y() > rows_ - 1) return false;
  visible.row_begin = static_cast<int>(std::ceil(std::max(low.y(), 0.0)));
  visible.row_end = static_cast<int>(std::floor(std::min(high.y(), rows_ - 1.0))) + 1;
  if (visible.row_begin >= visible.row_end) return false;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d &a = at[static_cast<size_t>(i)], &b = at[static_cast<size_t>((i + 1) % count)];
    area += a.x() * b.y() - a.y() * b.x();
  }
  const double inside = area > 0 ? 1 : -1;
  visible.first_edge = static_cast<int>(edges_.size());
  visible.edges = count;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d &a = at[static_cast<size_t>(i)], &b = at[static_cast<size_t>((i + 1) % count)];
    const double dy = b.y() - a.y();
    // A horizontal edge does not limit the columns of any row; row_begin and row_end take it into account.
    Edge edge{0, 0, 0};
    if (std::abs(dy) > 1e-9) {
      edge.slope = (b.x() - a.x()) / dy;
      edge.at = a.x() - edge.slope * a.y();
      edge.kind = dy * inside < 0 ? 1 : -1;
    }
    edges_.push_back(edge);
  }
  visible.surface.w_min = static_cast<float>(1 / z_max);
  visible.surface.w_max = static_cast<float>(1 / z_min);
  return true;
}

void Renderer::rasterise(int row_begin, int row_end) {
  const size_t samples = static_cast<size_t>(row_end - row_begin) * static_cast<size_t>(columns_);
  z_.assign(samples, 0.0f);
  id_.assign(samples, kNone);
  for (const auto& [key, index] : order_) {
    const Visible& v = visible_[static_cast<size_t>(index)];
    const int first = std::max(v.row_begin, row_begin), last = std::min(v.row_end, row_end);
    const uint32_t number = static_cast<uint32_t>(index) + 1;
    for (int row = first; row < last; ++row) {
      double low = 0, high = columns_;
      for (int e = 0; e < v.edges; ++e) {
        const Edge& edge = edges_[static_cast<size_t>(v.first_edge + e)];
        const double x = edge.slope * row + edge.at;
        if (edge.kind == 1) low = std::max(low, x);
        if (edge.kind == -1) high = std::min(high, x);
      }
      // Samples on a shared edge belong to the polygon to their right.
      const int begin = static_cast<int>(std::ceil(low)), end = static_cast<int>(std::ceil(high));
      if (begin >= end) continue;
      const size_t base =
          static_cast<size_t>(row - row_begin) * static_cast<size_t>(columns_) + static_cast<size_t>(begin);
      const double w_0 = v.plane_1 + v.plane_y * row + v.plane_x * begin;
      fill_span(static_cast<float>(w_0), static_cast<float>(v.plane_x), number, end - begin, z_.data() + base,
                id_.data() + base);
    }
  }
}

void Renderer::shade_row(int y, const uint32_t* above, const uint32_t* middle, const uint32_t* below, float* tone,
                         float* depth) {
  const int width = camera_.width, sample_columns = 2 * width + 1;
  uniform_.resize(static_cast<size_t>(sample_columns));
  for (int i = 0; i < sample_columns; ++i) {
    uniform_[static_cast<size_t>(i)] = above[i] == middle[i] && below[i] == middle[i];
  }
  const float* ray_x = ray_x_.data() + static_cast<ptrdiff_t>(y) * width;
  const float* ray_y = ray_y_.data() + static_cast<ptrdiff_t>(y) * width;
  const uint32_t* rows[3] = {above, middle, below};
  const float* stretch = stretch_.data() + (distorted_ ? static_cast<ptrdiff_t>(y) * width : 0);
  const auto inside = [&](int x) {
    const uint8_t* same = uniform_.data() + 2 * x;
    const uint32_t* id = middle + 2 * x;
    return (same[0] & same[1] & same[2]) && id[0] == id[1] && id[2] == id[1];
  };
  for (int x = 0; x < width;) {
    const uint32_t id = middle[2 * x + 1];
    if (id == kNone || !inside(x)) {
      tone[x] = shade_edge(rows, x, y);
      depth[x] = id == kNone ? 0 : depth_of(visible_[id - 1], ray_x[x], ray_y[x]);
      ++x;
      continue;
    }
    int end = x + 1;
    while (end < width && middle[2 * end + 1] == id && inside(end)) ++end;
    const Visible& v = visible_[id - 1];
    shade_surface(v.surface, pixel_x_, pixel_y_, ray_x + x, ray_y + x, stretch + x, end - x, tone + x);
    for (; x < end; ++x) depth[x] = depth_of(v, ray_x[x], ray_y[x]);
  }
}

float Renderer::depth_of(const Visible& v, float x, float y) const {
  const Surface& s = v.surface;
  return v.sky ? 0 : 1 / std::min(std::max(s.w_x * x + s.w_y * y + s.w_1, s.w_min), s.w_max);
}

float Renderer::shade_edge(const uint32_t* const (&rows)[3], int x, int y) const {
  // Each polygon under the 3 x 3 samples is shaded once, at the mean position of its samples.
  struct Part {
    uint32_t id;
    float weight, x, y;
  };
  std::array<Part, 9> parts;
  size_t count = 0;
  float total = 0;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      const uint32_t id = rows[r][2 * x + c];
      if (id == kNone) continue;
      const float weight = (r == 1 ? 2.0f : 1.0f) * (c == 1 ? 2.0f : 1.0f);
      size_t p = 0;
      while (p < count && parts[p].id != id) ++p;
      if (p == count) parts[count++] = {id, 0, 0, 0};
      parts[p].weight += weight;
      parts[p].x += weight * 0.5f * static_cast<float>(c - 1);
      parts[p].y += weight * 0.5f * static_cast<float>(r - 1);
      total += weight;
    }
  }
  if (count == 0) return 0;
  const Eigen::Vector2f centre = ray(x, y);
  const float scale = distorted_ ? stretch_[static_cast<size_t>(y * camera_.width + x)] : 1;
  float sum = 0;
  for (size_t p = 0; p < count; ++p) {
    const Part& part = parts[p];
    std::array<float, 1 + kShadeOverrun> part_x, part_y, part_scale, tone;
    part_x[0] = centre.x() + part.x / part.weight * scale * pixel_x_;
    part_y[0] = centre.y() + part.y / part.weight * scale * pixel_y_;
    part_scale[0] = scale;
    shade_surface(visible_[part.id - 1].surface, pixel_x_, pixel_y_, part_x.data(), part_y.data(), part_scale.data(), 1,
                  tone.data());
    sum += part.weight * tone[0];
  }
  return sum / total;
}

}  // namespace covis::synth

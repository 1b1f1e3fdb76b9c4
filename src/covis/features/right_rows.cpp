// SPDX-License-Identifier: Apache-2.0
#include "covis/features/right_rows.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <optional>

#include "covis/core/quantile.h"
#include "covis/geometry/alike_errors.h"
#include "covis/geometry/field_estimate.h"

namespace covis {
namespace {

using Vector = FieldEstimate::Vector;
using Matrix = FieldEstimate::Matrix;

// Matches after which the field is asked for: soon, as key frames are made from the first pair on, and then to be sure.
constexpr std::array<size_t, 2> kRounds{1000, 8000};

// Pixels.
constexpr double kLeastShift = 0.15;  // root mean square over matches: worth resampling each right image for
constexpr double kMostSpread = 0.5;   // median of what is left; rows that have nothing to do with each other leave more
constexpr double kMostNoise = 0.3;    // root mean square over the image, for places without matches will have some

constexpr double kShown = 5;  // standard deviations

enum class Along { rows, columns };

Vector terms_at(const Pinhole& camera, Along along, double u, double v) {
  const double x = (u - camera.cx) / camera.fx, y = (v - camera.cy) / camera.fy;
  return FieldEstimate::vector(along == Along::rows ? ShiftField::terms(y, x) : ShiftField::terms(x, y));
}

struct Match {
  Vector terms;
  double shift = 0;  // pixels
  size_t part = 0;   // the image's part: errors of matches in one part are alike
};

constexpr size_t kColumns = 8, kRows = 6;                // parts
constexpr ptrdiff_t kLeastParts = kColumns * kRows / 2;  // with matches: fewer corners can be off alike by chance

Match match_at(const Camera& camera, Along along, float u, float v, float shift) {
  const auto part = [](float at, int size, size_t parts) {
    return std::min(static_cast<size_t>(std::max(0.0f, at) / static_cast<float>(size) * static_cast<float>(parts)),
                    parts - 1);
  };
  return {terms_at(camera.pinhole, along, static_cast<double>(u), static_cast<double>(v)), static_cast<double>(shift),
          part(v, camera.height, kRows) * kColumns + part(u, camera.width, kColumns)};
}

// The errors of matches that a field leaves, and their median size.
struct Remainder {
  std::vector<double> errors;
  double median = 0;

  Remainder(const std::vector<Match>& matches, const ShiftField& field) {
    const Vector pixels = FieldEstimate::vector(field.pixels);
    std::vector<double> sizes;
    for (const Match& match : matches) {
      errors.push_back(match.shift - pixels.dot(match.terms));
      sizes.push_back(std::abs(errors.back()));
    }
    median = quantile(std::move(sizes), 0.5);
  }
  // Cauchy's, as the corners of other things are among the matches.
  double weight(size_t k) const {
    constexpr double kSigmas = 1.48, kLeast = 1e-3;  // the sigma of normal errors by their median; pixels
    const double e = errors[k] / std::max(kSigmas * median, kLeast);
    return 1 / (1 + e * e);
  }
};

// The mean of terms * terms^T over all of an image, and the greatest shift there.
struct OverImage {
  Matrix mean = Matrix::Zero();
  double greatest = 0;

  OverImage(const Camera& camera, Along along, const ShiftField& field) {
    constexpr int kSteps = 8;
    for (int i = 0; i <= kSteps; ++i) {
      for (int k = 0; k <= kSteps; ++k) {
        const Vector terms = terms_at(camera.pinhole, along, camera.width * static_cast<double>(i) / kSteps,
                                      camera.height * static_cast<double>(k) / kSteps);
        mean += terms * terms.transpose() / ((kSteps + 1) * (kSteps + 1));
        greatest = std::max(greatest, std::abs(terms.dot(FieldEstimate::vector(field.pixels))));
      }
    }
  }
};

struct FoundField {
  ShiftField field;
  double shift = 0, noise = 0;  // root mean square over matches, and its standard deviation
  double spread = 0;            // median of what is left
};

// Nothing: matches do not say it over all of the image.
std::optional<FoundField> find_field(const Camera& camera, Along along, const std::vector<Match>& matches) {
  constexpr int kIterations = 10;
  FieldEstimate estimate;
  Remainder left(matches, {});
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    estimate = {};
    for (size_t k = 0; k < matches.size(); ++k) estimate.add(matches[k].terms, matches[k].shift, left.weight(k));
    if (!estimate.solve()) return std::nullopt;
    left = Remainder(matches, estimate.field);
  }
  std::vector<Vector> parts(kColumns * kRows, Vector::Zero());
  std::array<uint8_t, kColumns * kRows> filled{};
  Matrix seen = Matrix::Zero();
  for (size_t k = 0; k < matches.size(); ++k) {
    const Match& match = matches[k];
    parts[match.part] += left.weight(k) * left.errors[k] * match.terms;
    filled[match.part] = 1;
    seen += match.terms * match.terms.transpose() / static_cast<double>(matches.size());
  }
  if (std::count(filled.begin(), filled.end(), 1) < kLeastParts) return std::nullopt;
  const OverImage image(camera, along, estimate.field);
  const Matrix covariance = covariance_of_parts(estimate.inverse(), parts);
  if (!(std::sqrt((covariance * image.mean).trace()) <= kMostNoise) || image.greatest > kMostRectificationError)
    return std::nullopt;
  return FoundField{estimate.field, estimate.size(seen), std::sqrt((covariance * seen).trace()), left.median};
}

}  // namespace

RightRows::RightRows(const Camera& camera) : camera_(camera) { differences_.reserve(kRounds.back()); }

std::optional<ShiftField> RightRows::add(std::span<const RowDifference> differences) {
  if (round_ == kRounds.size()) return std::nullopt;
  const size_t taken = std::min(differences.size(), kRounds[round_] - differences_.size());
  differences_.insert(differences_.end(), differences.begin(), differences.begin() + static_cast<ptrdiff_t>(taken));
  if (differences_.size() < kRounds[round_]) return std::nullopt;
  ++round_;
  std::vector<Match> matches;
  matches.reserve(differences_.size());
  for (const RowDifference& d : differences_) matches.push_back(match_at(camera_, Along::rows, d.u, d.v, d.lower));
  differences_.clear();
  const auto more = find_field(camera_, Along::rows, matches);
  if (!more || more->spread > kMostSpread || more->shift < std::max(kLeastShift, kShown * more->noise))
    return std::nullopt;
  return field_ + more->field;
}

bool RightRows::take(const ShiftField& field, std::span<const ColumnDifference> differences) {
  std::vector<Match> matches;
  for (const ColumnDifference& d : differences) matches.push_back(match_at(camera_, Along::columns, d.u, d.v, d.right));
  const auto columns = matches.empty() ? std::nullopt : find_field(camera_, Along::columns, matches);
  if (!columns) return false;
  field_ = field;
  columns_ = columns->field;
  return true;
}

std::string RightRows::description() const {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "up to %.2f pixels", OverImage(camera_, Along::rows, field_).greatest);
  return text.data();
}

ResamplingMap RightRows::resampling(const ShiftField& field) const {
  const Pinhole& c = camera_.pinhole;
  ResamplingMap map(camera_.width, camera_.height, camera_.width, camera_.height);
  for (int v = 0; v < camera_.height; ++v) {
    for (int u = 0; u < camera_.width; ++u) {
      const double lower = field.at((v - c.cy) / c.fy, (u - c.cx) / c.fx);
      map.set(u, v, static_cast<float>(u), static_cast<float>(v + lower));
    }
  }
  return map;
}

}  // namespace covis

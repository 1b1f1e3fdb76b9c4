// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/lens_adjustment.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "covis/geometry/alike_errors.h"
#include "covis/optimization/reprojection.h"

namespace covis {
namespace {

constexpr int kLens = 5;            // parameters of the lens, which come first; of the focal length the logarithm
constexpr double kStays = 1e-6;     // standard deviation of a parameter that stays
constexpr double kFarBehind = 1e3;  // residual of a point behind the camera, sigmas

using Matrix2x6d = Eigen::Matrix<double, 2, 6>;
using Matrix2x3d = Eigen::Matrix<double, 2, 3>;
using Vector2d = Eigen::Vector2d;
using LensVector = Eigen::Matrix<double, kLens, 1>;
using LensMatrix = Eigen::Matrix<double, kLens, kLens>;

// One observation's residual, and its Jacobians with their signs turned round: those of the prediction.
struct Row {
  Vector2d residual = Vector2d::Zero();
  Matrix2x6d pose;
  Matrix2x3d point;
  Eigen::Matrix<double, 2, kLens> lens;
  double weight = 0;  // robust weight over the variance
  double cost = 0;
};

// The state that the adjustment moves.
struct State {
  std::vector<SE3> poses;
  std::vector<Eigen::Vector3d> points;
  Lens lens;
};

LensVector vector_of(const Lens& lens) { return {lens.focal, lens.k1, lens.k2, lens.cx, lens.cy}; }
Lens lens_of(const LensVector& v) { return {v(0), v(1), v(2), v(3), v(4)}; }

// Returns the information on each parameter before anything was seen.
LensVector information_of(const LensOptions& options) {
  LensVector deviation = vector_of(options.usual);
  deviation(0) = options.usual_focal;
  return deviation.cwiseMax(kStays).cwiseAbs2().cwiseInverse();
}

Vector2d distorted(const Eigen::Vector3d& p_c, const Lens& lens) {
  const Vector2d at = p_c.head<2>() / p_c.z();
  const double r2 = at.squaredNorm();
  return lens.focal * (1 + (lens.k1 + lens.k2 * r2) * r2) * at + Vector2d(lens.cx, lens.cy);
}

// Returns nullopt where the point is behind the camera, or where the lens would fold the image over itself.
std::optional<Vector2d> residual_of(const BundleObservation& o, const Eigen::Vector3d& p_c, const Lens& lens,
                                    const Pinhole& camera) {
  if (!(p_c.z() > kMinDepth)) return std::nullopt;
  const double r2 = p_c.head<2>().squaredNorm() / (p_c.z() * p_c.z());
  if (!(1 + (3 * lens.k1 + 5 * lens.k2 * r2) * r2 > 0)) return std::nullopt;
  return Vector2d(Vector2d(static_cast<double>(o.u) - camera.cx, static_cast<double>(o.v) - camera.cy) -
                  distorted(p_c, lens));
}

class LensProblem {
 public:
  LensProblem(const BundleProblem& problem, const Lens& given, const LensOptions& options)
      : camera_(problem.camera), given_focal_(given.focal), observations_(problem.observations) {
    information_ = information_of(options);
    std::erase_if(observations_, [](const BundleObservation& o) { return !o.active; });
    std::stable_sort(observations_.begin(), observations_.end(),
                     [](const BundleObservation& a, const BundleObservation& b) { return a.point < b.point; });
    unknowns_ = kLens + 6 * (static_cast<int>(problem.poses.size()) - 1);
  }

  const std::vector<BundleObservation>& observations() const { return observations_; }
  int unknowns() const { return unknowns_; }
  const LensVector& information() const { return information_; }  // prior of the lens
  // Observations have weights relative to one another: once their variance is known, what was known of the lens before
  // has to be on the same scale.
  void scale_information(double variance) { information_ *= variance; }

  // How far a lens is from what was usual.
  LensVector off(const Lens& l) const { return {std::log(l.focal / given_focal_), l.k1, l.k2, l.cx, l.cy}; }

  double cost(const State& state) const {
    double sum = information_.dot(off(state.lens).cwiseAbs2());
    for (const BundleObservation& o : observations_) {
      double weight = 1;
      const auto r = residual_of(o, camera_point(state, o), state.lens, camera_);
      const double chi2 = r ? r->squaredNorm() * static_cast<double>(o.inv_sigma2) : kFarBehind * kFarBehind;
      sum += huber(chi2, kChi2Mono, weight);
    }
    return sum;
  }

  Row row(const State& state, const BundleObservation& o) const {
    Row row;
    const Eigen::Vector3d p_c = camera_point(state, o);
    const auto r = residual_of(o, p_c, state.lens, camera_);
    if (!r) {
      row.pose.setZero();
      row.point.setZero();
      row.lens.setZero();
      return row;
    }
    row.residual = *r;
    const double chi2 = r->squaredNorm() * static_cast<double>(o.inv_sigma2);
    row.cost = huber(chi2, kChi2Mono, row.weight);
    row.weight *= static_cast<double>(o.inv_sigma2);
    const Vector2d at = p_c.head<2>() / p_c.z();
    const auto& [focal, k1, k2, cx, cy] = state.lens;
    const double r2 = at.squaredNorm(), d = 1 + (k1 + k2 * r2) * r2;
    Matrix2x3d ray;  // d at / d p_c
    ray << 1, 0, -at.x(), 0, 1, -at.y();
    ray /= p_c.z();
    const Matrix2x3d J = focal * (d * Eigen::Matrix2d::Identity() + 2 * (k1 + 2 * k2 * r2) * at * at.transpose()) * ray;
    row.pose.leftCols<3>() = J;
    row.pose.rightCols<3>() = -J * hat(p_c);
    row.point = J * state.poses[static_cast<size_t>(o.pose)].R();
    row.lens.col(0) = focal * d * at;
    row.lens.col(1) = focal * r2 * at;
    row.lens.col(2) = focal * r2 * r2 * at;
    row.lens.rightCols<2>().setIdentity();
    return row;
  }

  // Returns the index of a pose's first parameter; nullopt for the first pose, which stays.
  std::optional<int> offset(const BundleObservation& o) const {
    return o.pose == 0 ? std::nullopt : std::optional(kLens + 6 * (o.pose - 1));
  }

  // Calls visit(first, last) for the observations of each point.
  template <class Visit>
  void for_each_point(Visit&& visit) const {
    for (size_t first = 0; first < observations_.size();) {
      size_t last = first;
      while (last < observations_.size() && observations_[last].point == observations_[first].point) ++last;
      visit(first, last);
      first = last;
    }
  }

 private:
  static Eigen::Vector3d camera_point(const State& state, const BundleObservation& o) {
    return state.poses[static_cast<size_t>(o.pose)] * state.points[static_cast<size_t>(o.point)];
  }

  Pinhole camera_;
  double given_focal_;
  std::vector<BundleObservation> observations_;  // by point
  LensVector information_;
  int unknowns_ = 0;
};

// The normal equations without the points, and what is needed to find these again.
class ReducedSystem {
 public:
  ReducedSystem(const LensProblem& problem, const State& state, double damping)
      : problem_(problem),
        S(Eigen::MatrixXd::Zero(problem.unknowns(), problem.unknowns())),
        g(Eigen::VectorXd::Zero(problem.unknowns())),
        damping_(damping) {
    rows_.reserve(problem.observations().size());
    for (const BundleObservation& o : problem.observations()) rows_.push_back(problem.row(state, o));
    problem.for_each_point([&](size_t first, size_t last) { add_point(first, last); });
    S.topLeftCorner<kLens, kLens>().diagonal() += problem.information();
    g.head<kLens>() -= problem.information().cwiseProduct(problem.off(state.lens));
    S.diagonal() += damping * diagonal_of_poses();
  }

  const std::vector<Row>& rows() const { return rows_; }

  // The changes of the points, given those of lens and poses; `gradient` 0: only how the points follow.
  template <class Visit>
  void for_each_point_step(const Eigen::VectorXd& step, double gradient, Visit&& visit) const {
    size_t index = 0;
    problem_.for_each_point([&](size_t first, size_t last) {
      const PointBlock& block = points_[index++];
      Eigen::Vector3d rhs = gradient * block.g;
      for (size_t k = first; k < last; ++k) rhs -= rows_[k].weight * rows_[k].point.transpose() * seen_step(k, step);
      visit(first, last, Eigen::Vector3d(block.inverse * rhs));
    });
  }

  // The change of an observation's prediction, given those of lens and poses, while its point stays.
  Vector2d seen_step(size_t k, const Eigen::VectorXd& step) const {
    Vector2d change = rows_[k].lens * step.head<kLens>();
    if (const auto at = problem_.offset(problem_.observations()[k])) change += rows_[k].pose * step.segment<6>(*at);
    return change;
  }

 private:
  struct PointBlock {
    Eigen::Matrix3d inverse;
    Eigen::Vector3d g;
  };
  struct Coupling {  // couples the parameters from `at` on with the point
    int at = 0, size = 0;
    Eigen::Matrix<double, 6, 3> W;  // the lens has a parameter less than a pose and fills the first rows
  };

  void add_point(size_t first, size_t last) {
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    PointBlock block{.inverse = {}, .g = Eigen::Vector3d::Zero()};
    couplings_.clear();
    couplings_.push_back({0, kLens, Eigen::Matrix<double, 6, 3>::Zero()});
    for (size_t k = first; k < last; ++k) {
      const Row& row = rows_[k];
      H += row.weight * row.point.transpose() * row.point;
      block.g += row.weight * row.point.transpose() * row.residual;
      S.topLeftCorner<kLens, kLens>() += row.weight * row.lens.transpose() * row.lens;
      g.head<kLens>() += row.weight * row.lens.transpose() * row.residual;
      couplings_.front().W.topRows<kLens>() += row.weight * row.lens.transpose() * row.point;
      const auto at = problem_.offset(problem_.observations()[k]);
      if (!at) continue;
      S.block<6, 6>(*at, *at) += row.weight * row.pose.transpose() * row.pose;
      S.block<kLens, 6>(0, *at) += row.weight * row.lens.transpose() * row.pose;
      g.segment<6>(*at) += row.weight * row.pose.transpose() * row.residual;
      couplings_.push_back({*at, 6, row.weight * row.pose.transpose() * row.point});
    }
    H.diagonal() *= 1 + damping_;
    H.diagonal().array() += 1e-12 * H.trace() + 1e-30;
    block.inverse = H.inverse();
    points_.push_back(block);
    for (const Coupling& a : couplings_) {
      const Eigen::Matrix<double, 6, 3> WH = a.W * block.inverse;
      g.segment(a.at, a.size) -= (WH * block.g).head(a.size);
      for (const Coupling& b : couplings_) {
        if (b.at < a.at) continue;
        S.block(a.at, b.at, a.size, b.size) -= (WH * b.W.transpose()).topLeftCorner(a.size, b.size);
      }
    }
  }

  Eigen::VectorXd diagonal_of_poses() const {
    Eigen::VectorXd diagonal = S.diagonal();
    return diagonal.cwiseMax(1e-9 * diagonal.maxCoeff());
  }

  const LensProblem& problem_;

 public:
  Eigen::MatrixXd S;  // upper triangle
  Eigen::VectorXd g;

 private:
  double damping_;
  std::vector<Row> rows_;
  std::vector<PointBlock> points_;
  std::vector<Coupling> couplings_;
};

State moved(const LensProblem& problem, const State& state, const ReducedSystem& system, const Eigen::VectorXd& step) {
  State next = state;
  LensVector lens = vector_of(state.lens) + step.head<kLens>();
  lens(0) = state.lens.focal * std::exp(step(0));
  next.lens = lens_of(lens);
  for (size_t k = 1; k < next.poses.size(); ++k) {
    const Vector6d change = step.segment<6>(kLens + 6 * (static_cast<int>(k) - 1));
    next.poses[k] = (SE3::exp(change) * next.poses[k]).normalized();
  }
  system.for_each_point_step(step, 1, [&](size_t first, size_t, const Eigen::Vector3d& change) {
    next.points[static_cast<size_t>(problem.observations()[first].point)] += change;
  });
  return next;
}

// Levenberg and Marquardt; damping grows as Nielsen's. A change of the focal length bends a long path, which steps
// along straight lines follow badly. So up to four steps in a row may have a greater cost than the least one found; if
// none comes below that, the search goes back to it (the watchdog technique: Nocedal and Wright, "Numerical
// optimization", 2006, section 15.6). Where motion does not tell the lens it may end before the cost is least, with a
// large deviation. Returns false when interrupted.
bool minimise(const LensProblem& problem, State& state, const std::function<bool()>& interrupted) {
  constexpr int kIterations = 100;
  constexpr double kEnough = 1e-6;      // relative decrease of the cost
  constexpr double kStill = 1e-4;       // change of the focal length's logarithm
  constexpr double kFree = 1e-5;        // damping that does not shorten steps much
  constexpr double kMaxStep = 0.3;      // bound for it
  constexpr int kUphill = 4;            // steps in a row with a greater cost than the least
  constexpr double kGreatestCost = 10;  // relative to the least
  constexpr int kPatience = 12;         // steps in which the least cost falls by less than enough
  double damping = 1e-4, growth = 2, least = problem.cost(state), before = least;
  State at = state;
  int uphill = 0, waited = 0;
  for (int i = 0; i < kIterations && waited < kPatience; ++i) {
    if (interrupted && interrupted()) return false;
    const ReducedSystem system(problem, at, damping);
    const Eigen::VectorXd step = system.S.selfadjointView<Eigen::Upper>().ldlt().solve(system.g);
    at = moved(problem, at, system, step);
    const double cost = problem.cost(at);
    const bool bounded = step.allFinite() && std::abs(step(0)) < kMaxStep;
    if (bounded && cost < least) {
      const bool enough = damping < kFree && least - cost < kEnough * least && std::abs(step(0)) < kStill;
      state = at;
      least = cost;
      damping = std::max(damping / 5, 1e-9);
      growth = 2;
      uphill = 0;
      if (enough) break;
    } else if (bounded && cost < kGreatestCost * least && uphill < kUphill) {
      ++uphill;
    } else {
      at = state;
      damping *= growth;
      growth *= 2;
      uphill = 0;
    }
    ++waited;
    if (before - least > kEnough * before) before = least, waited = 0;
  }
  return true;
}

// The variance of the observations within the 95 % bound; 0 where they are too few for all that is free.
void measure_variance(const LensProblem& problem, const State& state, LensAdjustment& found) {
  double chi2 = 0;
  found.observations = 0;
  for (const BundleObservation& o : problem.observations()) {
    const Row row = problem.row(state, o);
    if (!(row.weight > 0) || row.cost > kChi2Mono) continue;
    chi2 += row.cost;
    ++found.observations;
  }
  int points = 0;  // those that have an observation
  problem.for_each_point([&](size_t, size_t) { ++points; });
  const double freedom = 2.0 * static_cast<double>(found.observations) - 3.0 * points - problem.unknowns();
  found.variance = freedom > 0 ? chi2 / freedom : 0;
}

// How sure the lens is, once the cost is least: the observations' scores, projected on what poses and points can't
// take.
void add_certainty(const LensProblem& problem, const State& state, LensAdjustment& found) {
  constexpr double kTiny = 1e-9;  // holds the scale, which nothing tells and the lens does not depend on
  const ReducedSystem system(problem, state, kTiny);
  const int poses = problem.unknowns() - kLens;
  const Eigen::MatrixXd S = system.S.selfadjointView<Eigen::Upper>();
  Eigen::MatrixXd response(problem.unknowns(), kLens);
  response.topRows<kLens>().setIdentity();
  response.bottomRows(poses) = -S.bottomRightCorner(poses, poses).ldlt().solve(S.bottomLeftCorner(poses, kLens));
  const LensMatrix information = S.topRows<kLens>() * response;
  const LensMatrix covariance = information.inverse();
  std::vector<LensVector> scores(state.poses.size(), LensVector::Zero());
  for (int lens = 0; lens < kLens; ++lens) {
    const Eigen::VectorXd step = response.col(lens);
    system.for_each_point_step(step, 0, [&](size_t first, size_t last, const Eigen::Vector3d& change) {
      for (size_t k = first; k < last; ++k) {
        const Row& row = system.rows()[k];
        const double score = row.weight * row.residual.dot(system.seen_step(k, step) + row.point * change);
        scores[static_cast<size_t>(problem.observations()[k].pose)](lens) += score;
      }
    });
  }
  LensVector scatter = LensVector::Zero();
  for (const size_t pieces : kNumbersOfPieces) {
    const LensMatrix of_pieces = covariance_of_parts(covariance, sums_over_pieces(scores, pieces));
    scatter = scatter.cwiseMax(of_pieces.diagonal().cwiseSqrt());
  }
  const LensVector sigma = (found.variance * covariance.diagonal()).cwiseSqrt();
  found.sigma = lens_of(sigma);
  found.scatter = lens_of(scatter);
  found.ok = sigma.allFinite() && scatter.allFinite();
}

}  // namespace

Lens LensAdjustment::deviation() const { return lens_of(vector_of(sigma).cwiseMax(vector_of(scatter))); }

LensAdjustment adjust_lens(BundleProblem& problem, const Lens& lens, const LensOptions& options) {
  LensAdjustment found;
  LensProblem all(problem, lens, options);
  if (problem.poses.size() < 3 || all.observations().empty()) return found;
  State state{problem.poses, problem.points, lens};
  for (int round = 0; round < 2; ++round) {
    if (!minimise(all, state, options.interrupted)) return found;
    measure_variance(all, state, found);
    if (!(found.variance > 0)) return found;
    if (round == 0) all.scale_information(found.variance);
  }
  found.lens = state.lens;
  add_certainty(all, state, found);
  if (!found.ok) return found;
  problem.poses = std::move(state.poses);
  problem.points = std::move(state.points);
  return found;
}

}  // namespace covis

// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/observation_blocks.h"

#include "covis/core/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "covis/optimization/observation_blocks.cpp"
#include <hwy/foreach_target.h>
// after foreach_target
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace covis::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// The rows of three factors by one column of the other: always in the order of the scalar twin.
template <class D>
HWY_INLINE hn::Vec<D> Product(D d, const hn::Vec<D>* rows, const double* column) {
  const auto sum = hn::Add(hn::Mul(rows[0], hn::Set(d, column[0])), hn::Mul(rows[1], hn::Set(d, column[1])));
  return hn::Add(sum, hn::Mul(rows[2], hn::Set(d, column[2])));
}

// Adds to the rows [first, 6), as many at once as a vector of D holds. Returns the first row that is left.
template <class D>
HWY_INLINE size_t AddRows(D d, size_t first, const WeightedJacobians& jacobians, const double* e, double* U, double* b,
                          double* W) {
  const double *const J_c = jacobians.J_c.data(), *const wJ_c = jacobians.wJ_c.data(),
                      *const J_p = jacobians.J_p.data();
  const size_t lanes = hn::Lanes(d);
  for (; first + lanes <= 6; first += lanes) {
    const hn::Vec<D> rows[3] = {hn::LoadU(d, J_c + first), hn::LoadU(d, J_c + 6 + first),
                                hn::LoadU(d, J_c + 12 + first)};
    const hn::Vec<D> weighted[3] = {hn::LoadU(d, wJ_c + first), hn::LoadU(d, wJ_c + 6 + first),
                                    hn::LoadU(d, wJ_c + 12 + first)};
    for (size_t c = 0; c < 6; ++c) {
      const double column[3] = {wJ_c[c], wJ_c[6 + c], wJ_c[12 + c]};
      double* const at = U + 6 * c + first;
      hn::StoreU(hn::Add(hn::LoadU(d, at), Product(d, rows, column)), d, at);
    }
    hn::StoreU(hn::Add(hn::LoadU(d, b + first), Product(d, weighted, e)), d, b + first);
    for (size_t c = 0; c < 3; ++c) hn::StoreU(Product(d, weighted, J_p + 3 * c), d, W + 6 * c + first);
  }
  return first;
}

void AddObservation(const WeightedJacobians& jacobians, const double* e, double* U, double* b, double* W) {
  size_t row = AddRows(hn::CappedTag<double, 4>(), 0, jacobians, e, U, b, W);
  row = AddRows(hn::CappedTag<double, 2>(), row, jacobians, e, U, b, W);
  AddRows(hn::CappedTag<double, 1>(), row, jacobians, e, U, b, W);
}

}  // namespace covis::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace covis {
namespace {

HWY_EXPORT(AddObservation);

}  // namespace

void add_observation(const WeightedJacobians& jacobians, const Eigen::Vector3d& e, Matrix6d& U, Vector6d& b,
                     Matrix6x3d& W) {
  if (simd_enabled()) {
    HWY_DYNAMIC_DISPATCH(AddObservation)(jacobians, e.data(), U.data(), b.data(), W.data());
    return;
  }
  // Written out: Eigen's products would be contracted on some machines.
  const auto& [J_c, wJ_c, J_p] = jacobians;
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) U(r, c) += J_c(r, 0) * wJ_c(c, 0) + J_c(r, 1) * wJ_c(c, 1) + J_c(r, 2) * wJ_c(c, 2);
    b[r] += wJ_c(r, 0) * e[0] + wJ_c(r, 1) * e[1] + wJ_c(r, 2) * e[2];
    for (int c = 0; c < 3; ++c) W(r, c) = wJ_c(r, 0) * J_p(0, c) + wJ_c(r, 1) * J_p(1, c) + wJ_c(r, 2) * J_p(2, c);
  }
}

}  // namespace covis
#endif

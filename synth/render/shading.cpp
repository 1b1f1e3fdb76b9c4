// SPDX-License-Identifier: Apache-2.0
#include "synth/render/shading.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "synth/render/shading.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace covis::synth::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// The vector types that belong to a float vector type.
template <class F>
using IntTag = hn::RebindToSigned<F>;
template <class F>
using UnsignedTag = hn::RebindToUnsigned<F>;

constexpr float kMaxTaps = 6;        // greatest number of look-ups along the longer axis of a pixel's footprint
constexpr float kLodBias = -0.2f;    // slightly sharper than the footprint: bilinear look-ups blur by themselves
constexpr float kDetailLod = 4.5f;   // level of detail at which the fine detail has vanished
constexpr float kNearLevel = 0.06f;  // levels this close (in lod) are treated as the level itself

// Binary logarithm, exact at powers of two and otherwise at most 0.09 too small.
template <class F, class VF = hn::Vec<F>>
HWY_INLINE VF Log2(F f, VF x) {
  const IntTag<F> i;
  const auto bits = hn::BitCast(i, x);
  const VF mantissa = hn::BitCast(f, hn::Or(hn::And(bits, hn::Set(i, 0x007fffff)), hn::Set(i, 0x3f800000)));
  const auto exponent = hn::Sub(hn::ShiftRight<23>(bits), hn::Set(i, 127));
  return hn::Sub(hn::Add(hn::ConvertTo(f, exponent), mantissa), hn::Set(f, 1.0f));
}

// Mirrors values that lie outside [0, 1] by less than 1.
template <class F, class VF = hn::Vec<F>>
HWY_INLINE VF Fold(F f, VF s) {
  const VF one = hn::Set(f, 1.0f);
  return hn::Max(hn::Sub(one, hn::Abs(hn::Sub(one, hn::Abs(s)))), hn::Zero(f));
}

template <class VF>
struct Line {
  VF u, v, du, dv, taps;  // middle, in [0, 1]; steps; number of points
  int most_taps;          // largest `taps` of all lanes
};

// Mean of bilinear look-ups along a line, within one level.
template <class F, class VF = hn::Vec<F>, class VI = hn::Vec<IntTag<F>>>
HWY_INLINE VF MeanOfLine(F f, const TextureView& texture, const Line<VF>& line, VI level) {
  const IntTag<F> i;
  const UnsignedTag<F> u;
  const VF half = hn::Set(f, 0.5f);
  VF columns, rows;
  VI stride, offset;
  const int first = hn::GetLane(level);
  if (hn::AllTrue(i, hn::Eq(level, hn::Set(i, first)))) {  // the usual case
    columns = hn::Set(f, texture.columns[first]);
    rows = hn::Set(f, texture.rows[first]);
    stride = hn::Set(i, texture.stride[first]);
    offset = hn::Set(i, texture.offset[first]);
  } else {
    columns = hn::GatherIndex(f, texture.columns, level);
    rows = hn::GatherIndex(f, texture.rows, level);
    stride = hn::GatherIndex(i, texture.stride, level);
    offset = hn::GatherIndex(i, texture.offset, level);
  }
  const auto* texels = reinterpret_cast<const uint32_t*>(texture.texels);  // offsets are in bytes
  const auto byte = hn::Set(u, 255u);
  VF sum = hn::Zero(f);
  for (int k = 0; k < line.most_taps; ++k) {
    const VF index = hn::Set(f, static_cast<float>(k));
    const VF at = hn::Sub(index, hn::Mul(half, hn::Sub(line.taps, hn::Set(f, 1.0f))));
    // The border of one repeated texel on each side covers the half texel outside.
    const VF x = hn::Add(hn::Mul(Fold(f, hn::Add(line.u, hn::Mul(at, line.du))), columns), half);
    const VF y = hn::Add(hn::Mul(Fold(f, hn::Add(line.v, hn::Mul(at, line.dv))), rows), half);
    const VI xi = hn::ConvertTo(i, x), yi = hn::ConvertTo(i, y);
    const VF fx = hn::Sub(x, hn::ConvertTo(f, xi)), fy = hn::Sub(y, hn::ConvertTo(f, yi));
    const VI address = hn::Add(hn::Add(offset, hn::Mul(yi, stride)), xi);
    const auto above = hn::GatherOffset(u, texels, address),
               below = hn::GatherOffset(u, texels, hn::Add(address, stride));
    const auto tone = [&](auto bits) { return hn::ConvertTo(f, hn::BitCast(i, hn::And(bits, byte))); };
    const VF a = tone(above), b = tone(hn::ShiftRight<8>(above)), c = tone(below), d = tone(hn::ShiftRight<8>(below));
    const VF top = hn::Add(a, hn::Mul(fx, hn::Sub(b, a))), bottom = hn::Add(c, hn::Mul(fx, hn::Sub(d, c)));
    const VF value = hn::Add(top, hn::Mul(fy, hn::Sub(bottom, top)));
    sum = hn::Add(sum, hn::IfThenElseZero(hn::Lt(index, line.taps), value));
  }
  return hn::Div(sum, line.taps);
}

// Mean along a line of points spaced by (du, dv) around (u, v), for pixels that cover 2^lod texels of level 0.
template <class F, class VF = hn::Vec<F>>
HWY_INLINE VF Sample(F f, const TextureView& texture, VF u, VF v, VF du, VF dv, VF taps, int most_taps, VF lod) {
  const IntTag<F> i;
  const VF one = hn::Set(f, 1.0f);
  const auto into_cell = [&](VF& t, VF& dt) {  // every second repeat is mirrored
    const VF cell = hn::Floor(t);
    t = hn::Sub(t, cell);
    const auto odd = hn::RebindMask(f, hn::Eq(hn::And(hn::ConvertTo(i, cell), hn::Set(i, 1)), hn::Set(i, 1)));
    t = hn::IfThenElse(odd, hn::Sub(one, t), t);
    dt = hn::IfThenElse(odd, hn::Neg(dt), dt);
  };
  into_cell(u, du);
  into_cell(v, dv);
  const Line<VF> line{u, v, du, dv, taps, most_taps};
  const VF level = hn::Min(hn::Max(lod, hn::Zero(f)), hn::Set(f, texture.max_lod));
  const auto fine = hn::ConvertTo(i, hn::Add(level, hn::Set(f, kNearLevel)));
  const VF t = hn::Sub(level, hn::ConvertTo(f, fine));
  const VF tone = MeanOfLine(f, texture, line, fine);
  const auto between = hn::Ge(t, hn::Set(f, kNearLevel));
  if (hn::AllFalse(f, between)) return tone;
  const auto coarse = hn::Add(fine, hn::IfThenElseZero(hn::RebindMask(i, between), hn::Set(i, 1)));
  const VF other = MeanOfLine(f, texture, line, coarse);
  return hn::Add(tone, hn::IfThenElseZero(between, hn::Mul(t, hn::Sub(other, tone))));
}

template <class F, class VF = hn::Vec<F>>
HWY_INLINE void Shade(F f, const Surface& s, float pixel_x, float pixel_y, const float* x_in, const float* y_in,
                      const float* scale_in, int count, float* tone_out) {
  const IntTag<F> i;
  const auto set = [&](float value) { return hn::Set(f, value); };
  const int lanes = static_cast<int>(hn::Lanes(f));
  const VF columns = set(s.texture.columns[0]), rows = set(s.texture.rows[0]), tiny = set(1e-12f);
  const VF finer = Log2(f, set(s.detail.columns[0] * s.detail_u / s.texture.columns[0]));
  for (int first = 0; first < count; first += lanes) {
    // Lanes past the end repeat the first point, so that no memory outside the texture is read.
    const auto valid = hn::FirstN(f, static_cast<size_t>(count - first));
    const VF x = hn::IfThenElse(valid, hn::LoadU(f, x_in + first), set(x_in[first]));
    const VF y = hn::IfThenElse(valid, hn::LoadU(f, y_in + first), set(y_in[first]));
    const VF scale = hn::IfThenElse(valid, hn::LoadU(f, scale_in + first), set(scale_in[first]));
    const auto linear = [&](float a, float b, float c) {
      return hn::Add(hn::Add(hn::Mul(set(a), x), hn::Mul(set(b), y)), set(c));
    };
    const VF w = hn::Min(hn::Max(linear(s.w_x, s.w_y, s.w_1), set(s.w_min)), set(s.w_max));
    const VF z = hn::Div(set(1), w);
    const VF u = hn::Mul(linear(s.u_x, s.u_y, s.u_1), z), v = hn::Mul(linear(s.v_x, s.v_y, s.v_1), z);
    // Steps from one pixel to the next.
    const VF zx = hn::Mul(hn::Mul(z, scale), set(pixel_x)), zy = hn::Mul(hn::Mul(z, scale), set(pixel_y));
    const auto step = [&](float a, VF t, float b, VF zs) { return hn::Mul(hn::Sub(set(a), hn::Mul(t, set(b))), zs); };
    const VF ux = step(s.u_x, u, s.w_x, zx), uy = step(s.u_y, u, s.w_y, zy);
    const VF vx = step(s.v_x, v, s.w_x, zx), vy = step(s.v_y, v, s.w_y, zy);
    // The footprint in texels of level 0. The number of look-ups along the longer axis is the ratio of the two axes.
    const auto length2 = [&](VF a, VF b) {
      const VF c = hn::Mul(a, columns), r = hn::Mul(b, rows);
      return hn::Add(hn::Mul(c, c), hn::Mul(r, r));
    };
    const VF along_x = length2(ux, vx), along_y = length2(uy, vy);
    const VF area = hn::Mul(hn::Mul(hn::Abs(hn::Sub(hn::Mul(ux, vy), hn::Mul(uy, vx))), columns), rows);
    const auto x_longer = hn::Gt(along_x, along_y);
    const VF longest2 = hn::Add(hn::Max(along_x, along_y), tiny);
    const VF wanted = hn::Min(hn::Div(longest2, hn::Add(area, tiny)), set(kMaxTaps));
    const VF taps = hn::Max(hn::ConvertTo(f, hn::ConvertTo(i, hn::Add(wanted, set(0.5f)))), set(1));
    const VF du = hn::Div(hn::IfThenElse(x_longer, ux, uy), taps), dv = hn::Div(hn::IfThenElse(x_longer, vx, vy), taps);
    const VF lod = hn::Add(hn::Mul(set(0.5f), Log2(f, hn::Div(longest2, hn::Mul(taps, taps)))), set(kLodBias));
    const int most_taps = static_cast<int>(hn::GetLane(hn::MaxOfLanes(f, taps)));
    VF tone = hn::Mul(Sample(f, s.texture, u, v, du, dv, taps, most_taps, lod), set(s.gain));

    const VF detail_lod = hn::Add(lod, finer);
    const VF seen = hn::Min(hn::Max(hn::Sub(set(kDetailLod), detail_lod), hn::Zero(f)), set(1));
    if (s.detail_strength > 0 && !hn::AllTrue(f, hn::Eq(seen, hn::Zero(f)))) {
      const VF grain = Sample(f, s.detail, hn::Mul(u, set(s.detail_u)), hn::Mul(v, set(s.detail_v)), hn::Zero(f),
                              hn::Zero(f), set(1), 1, detail_lod);
      const VF change = hn::Mul(hn::Mul(set(s.detail_strength), seen), hn::Sub(grain, set(128)));
      tone = hn::Mul(tone, hn::Add(set(1), change));
    }
    if (s.light.texels) {
      const VF light_lod = hn::Add(lod, Log2(f, set(s.light.columns[0] * s.light_u_scale / s.texture.columns[0])));
      const VF light_u = hn::Add(hn::Mul(u, set(s.light_u_scale)), set(s.light_u_0));
      const VF light_v = hn::Add(hn::Mul(v, set(s.light_v_scale)), set(s.light_v_0));
      const VF light =
          Sample(f, s.light, light_u, light_v, hn::Zero(f), hn::Zero(f), set(1), 1, hn::Max(light_lod, hn::Zero(f)));
      tone = hn::Mul(tone, hn::Mul(light, set(1 / kLightAsPainted)));
    }
    hn::StoreU(tone, f, tone_out + first);
  }
}

void ShadeSurface(const Surface& s, float pixel_x, float pixel_y, const float* x, const float* y, const float* scale,
                  int count, float* tone) {
  if (count <= 4) {  // at edges: wide look-ups would be wasted on few points
    Shade(hn::CappedTag<float, 4>(), s, pixel_x, pixel_y, x, y, scale, count, tone);
  } else {
    Shade(hn::ScalableTag<float>(), s, pixel_x, pixel_y, x, y, scale, count, tone);
  }
}

void FillSpan(float w_0, float w_x, uint32_t number, int count, float* z, uint32_t* id) {
  const hn::ScalableTag<float> f;
  const UnsignedTag<decltype(f)> u;
  const int lanes = static_cast<int>(hn::Lanes(f));
  int first = 0;
  const auto numbers = hn::Set(u, number);
  const auto slope = hn::Set(f, w_x), start = hn::Set(f, w_0), ramp = hn::Iota(f, 0);
  for (; first + lanes <= count; first += lanes) {
    const auto index = hn::Add(ramp, hn::Set(f, static_cast<float>(first)));
    const auto w = hn::Add(start, hn::Mul(slope, index)), before = hn::LoadU(f, z + first);
    const auto nearer = hn::Gt(w, before);
    hn::StoreU(hn::IfThenElse(nearer, w, before), f, z + first);
    hn::StoreU(hn::IfThenElse(hn::RebindMask(u, nearer), numbers, hn::LoadU(u, id + first)), u, id + first);
  }
  for (; first < count; ++first) {
    const float w = w_0 + w_x * static_cast<float>(first);
    if (!(w > z[first])) continue;
    z[first] = w;
    id[first] = number;
  }
}

void MeanAlongSteps(ImageView<const float> image, int y, const float* step_x, const float* step_y,
                    const float* steps_in, int count, float* mean) {
  const hn::ScalableTag<float> f;
  const IntTag<decltype(f)> i;
  const auto limit_x = hn::Set(f, static_cast<float>(image.width) - 1.001f);
  const auto limit_y = hn::Set(f, static_cast<float>(image.height) - 1.001f);
  const auto zero = hn::Zero(f), one = hn::Set(f, 1.0f), half = hn::Set(f, 0.5f);
  const auto stride = hn::Set(i, static_cast<int32_t>(image.stride));
  const int lanes = static_cast<int>(hn::Lanes(f));
  for (int first = 0; first < count; first += lanes) {
    const auto valid = hn::FirstN(f, static_cast<size_t>(count - first));
    const auto steps = hn::IfThenElse(valid, hn::LoadU(f, steps_in + first), one);
    const auto dx = hn::IfThenElseZero(valid, hn::LoadU(f, step_x + first));
    const auto dy = hn::IfThenElseZero(valid, hn::LoadU(f, step_y + first));
    const auto before = hn::Mul(half, hn::Sub(steps, one));
    auto x = hn::Sub(hn::Iota(f, static_cast<float>(first)), hn::Mul(before, dx));
    auto v = hn::Sub(hn::Set(f, static_cast<float>(y)), hn::Mul(before, dy));
    auto sum = zero;
    const int most = static_cast<int>(hn::GetLane(hn::MaxOfLanes(f, steps)));
    for (int k = 0; k < most; ++k, x = hn::Add(x, dx), v = hn::Add(v, dy)) {
      const auto u_in = hn::Min(hn::Max(x, zero), limit_x), v_in = hn::Min(hn::Max(v, zero), limit_y);
      const auto ui = hn::ConvertTo(i, u_in), vi = hn::ConvertTo(i, v_in);
      const auto fu = hn::Sub(u_in, hn::ConvertTo(f, ui)), fv = hn::Sub(v_in, hn::ConvertTo(f, vi));
      const auto at = hn::Add(hn::Mul(vi, stride), ui), below = hn::Add(at, stride), right = hn::Set(i, 1);
      const auto a = hn::GatherIndex(f, image.data, at), b = hn::GatherIndex(f, image.data, hn::Add(at, right));
      const auto c = hn::GatherIndex(f, image.data, below), d = hn::GatherIndex(f, image.data, hn::Add(below, right));
      const auto top = hn::Add(a, hn::Mul(fu, hn::Sub(b, a))), bottom = hn::Add(c, hn::Mul(fu, hn::Sub(d, c)));
      const auto value = hn::Add(top, hn::Mul(fv, hn::Sub(bottom, top)));
      sum = hn::Add(sum, hn::IfThenElseZero(hn::Lt(hn::Set(f, static_cast<float>(k)), steps), value));
    }
    hn::StoreU(hn::Div(sum, steps), f, mean + first);
  }
}

}  // namespace covis::synth::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace covis::synth {

HWY_EXPORT(ShadeSurface);
HWY_EXPORT(FillSpan);
HWY_EXPORT(MeanAlongSteps);

void shade_surface(const Surface& surface, float pixel_x, float pixel_y, const float* x, const float* y,
                   const float* scale, int count, float* tone) {
  HWY_DYNAMIC_DISPATCH(ShadeSurface)(surface, pixel_x, pixel_y, x, y, scale, count, tone);
}

void fill_span(float w_0, float w_x, uint32_t number, int count, float* z, uint32_t* id) {
  HWY_DYNAMIC_DISPATCH(FillSpan)(w_0, w_x, number, count, z, id);
}

void mean_along_steps(ImageView<const float> image, int y, const float* step_x, const float* step_y, const float* steps,
                      int count, float* mean) {
  HWY_DYNAMIC_DISPATCH(MeanAlongSteps)(image, y, step_x, step_y, steps, count, mean);
}

}  // namespace covis::synth
#endif

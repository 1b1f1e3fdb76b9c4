// SPDX-License-Identifier: Apache-2.0
// Images: a view (pointer, size, stride in elements) that does not own the pixels, and an owner. Row-major; pixel
// centres lie at integer coordinates.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <utility>

namespace covis {

template <class T>
struct ImageView {
  T* data = nullptr;
  int width = 0;
  int height = 0;
  ptrdiff_t stride = 0;  // distance between rows, elements

  bool empty() const { return data == nullptr || width <= 0 || height <= 0; }
  T* row(int y) const { return data + y * stride; }
  T& operator()(int x, int y) const { return data[y * stride + x]; }
  operator ImageView<const T>() const { return {data, width, height, stride}; }
};

// Owns its pixels. Rows start at multiples of 64 bytes, and at least 64 readable bytes follow the last row. The memory
// is kept when the image is resized to something that fits, so there is no allocation in the steady state.
template <class T>
class Image {
 public:
  Image() = default;
  Image(int width, int height) { resize(width, height); }
  Image(const Image&) = delete;
  Image& operator=(const Image&) = delete;
  Image(Image&& other) noexcept { swap(other); }
  Image& operator=(Image&& other) noexcept {
    swap(other);
    return *this;
  }

  // The contents are undefined afterwards.
  void resize(int width, int height) {
    const ptrdiff_t stride = (static_cast<ptrdiff_t>(width) * static_cast<ptrdiff_t>(sizeof(T)) + 63) / 64 * 64 /
                             static_cast<ptrdiff_t>(sizeof(T));
    const size_t need = static_cast<size_t>(stride) * static_cast<size_t>(height) + 64 / sizeof(T);
    if (need > capacity_) {
      memory_.reset(static_cast<T*>(::operator new (need * sizeof(T), std::align_val_t{64})));
      capacity_ = need;
    }
    width_ = width;
    height_ = height;
    stride_ = stride;
  }
  void swap(Image& other) noexcept {
    std::swap(memory_, other.memory_);
    std::swap(capacity_, other.capacity_);
    std::swap(width_, other.width_);
    std::swap(height_, other.height_);
    std::swap(stride_, other.stride_);
  }

  bool empty() const { return width_ <= 0 || height_ <= 0; }
  int width() const { return width_; }
  int height() const { return height_; }
  ptrdiff_t stride() const { return stride_; }
  T* row(int y) { return memory_.get() + y * stride_; }
  const T* row(int y) const { return memory_.get() + y * stride_; }
  T& operator()(int x, int y) { return row(y)[x]; }
  const T& operator()(int x, int y) const { return row(y)[x]; }
  ImageView<T> view() { return {memory_.get(), width_, height_, stride_}; }
  ImageView<const T> view() const { return {memory_.get(), width_, height_, stride_}; }

 private:
  struct Free {
    void operator()(T* p) const { ::operator delete (p, std::align_val_t{64}); }
  };
  std::unique_ptr<T, Free> memory_;
  size_t capacity_ = 0;
  int width_ = 0;
  int height_ = 0;
  ptrdiff_t stride_ = 0;
};

using ImageU8 = Image<uint8_t>;
using ImageF = Image<float>;

}  // namespace covis

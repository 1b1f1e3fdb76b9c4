// SPDX-License-Identifier: Apache-2.0
// What the vocabulary's tests share: made-up images and a trained vocabulary, files in a folder of their own.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "covis/core/random.h"
#include "covis/vocabulary/train.h"
#include "covis/vocabulary/vocabulary.h"

namespace covis {

inline Descriptor random_descriptor(Random& random) {
  return {{random.next(), random.next(), random.next(), random.next()}};
}

// A descriptor with some bits of another turned.
inline Descriptor near(const Descriptor& centre, int turned, Random& random) {
  Descriptor descriptor = centre;
  for (int i = 0; i < turned; ++i) {
    const uint32_t bit = random.below(256);
    descriptor.bits[bit / 64] ^= uint64_t{1} << (bit % 64);
  }
  return descriptor;
}

// Images of descriptors around some centres: there is something to cluster.
struct MadeImages {
  std::vector<Descriptor> descriptors;
  std::vector<uint64_t> offsets{0};

  MadeImages(uint64_t seed, int images, int features, int centres) {
    Random random(seed);
    std::vector<Descriptor> centre;
    for (int c = 0; c < centres; ++c) centre.push_back(random_descriptor(random));
    for (int i = 0; i < images; ++i) {
      for (int f = 0; f < features; ++f) {
        const Descriptor& about = centre[random.below(static_cast<uint32_t>(centres))];
        descriptors.push_back(near(about, static_cast<int>(random.below(40)), random));
      }
      offsets.push_back(descriptors.size());
    }
  }
  std::span<const Descriptor> image(size_t i) const {
    return std::span(descriptors).subspan(offsets[i], offsets[i + 1] - offsets[i]);
  }
};

inline std::shared_ptr<const Vocabulary> train_made(const MadeImages& images, int branching, int depth) {
  TrainOptions options;
  options.branching = branching;
  options.depth = depth;
  options.threads = 1;
  auto vocabulary = train_vocabulary(images.descriptors, images.offsets, options);
  EXPECT_TRUE(vocabulary) << vocabulary.error().message;
  return *vocabulary;
}

class TemporaryFolder {
 public:
  TemporaryFolder() {
    const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    path_ = std::filesystem::temp_directory_path() / ("covis_vocabulary_" + name + std::to_string(::getpid()));
    std::filesystem::create_directories(path_);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code error;
    std::filesystem::remove_all(path_, error);
  }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline std::string read_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

inline void write_file(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

}  // namespace covis

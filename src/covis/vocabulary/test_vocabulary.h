// SPDX-License-Identifier: Apache-2.0
// Shared by the vocabulary's tests: synthetic images and a trained vocabulary.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "covis/core/random.h"
#include "covis/core/test_folder.h"
#include "covis/vocabulary/train.h"
#include "covis/vocabulary/vocabulary.h"

namespace covis {

inline Descriptor random_descriptor(Random& random) {
  return {{random.next(), random.next(), random.next(), random.next()}};
}

// Returns the descriptor with some random bits flipped.
inline Descriptor near(const Descriptor& centre, int turned, Random& random) {
  Descriptor descriptor = centre;
  for (int i = 0; i < turned; ++i) {
    const uint32_t bit = random.below(256);
    descriptor.bits[bit / 64] ^= uint64_t{1} << (bit % 64);
  }
  return descriptor;
}

// Makes images of descriptors around common centres, so that they can be clustered.
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

// A trained vocabulary in a file, and its bytes to be changed.
class VocabularyFile : public testing::Test {
 protected:
  void SetUp() override {
    vocabulary_ = train_made(images_, 4, 3);
    ASSERT_TRUE(vocabulary_->save(folder_ / "good"));
    bytes_ = read_file(folder_ / "good");
  }
  // The message of loading these bytes; "loaded" if it succeeds.
  std::string load(const std::string& bytes) {
    write_file(folder_ / "bad", bytes);
    const auto loaded = Vocabulary::load(folder_ / "bad");
    if (!loaded) return loaded.error().message;
    for (size_t i = 0; i < 5; ++i) EXPECT_LE((*loaded)->transform(images_.image(i)).words.size(), (*loaded)->words());
    return "loaded";
  }

  const TemporaryFolder folder_;
  MadeImages images_{21, 12, 60, 40};
  std::shared_ptr<const Vocabulary> vocabulary_;
  std::string bytes_;
};

}  // namespace covis

// SPDX-License-Identifier: Apache-2.0
// Training a vocabulary: hierarchical k-medians over the descriptors of many images, and idf weights (Nistér and
// Stewénius 2006, sections 3 and 4; Gálvez-López and Tardós 2012, section III). The same input, options and seed give
// the same vocabulary, whatever the number of threads.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "covis/core/aligned.h"
#include "covis/core/error.h"
#include "covis/core/fields.h"
#include "covis/vocabulary/vocabulary.h"

namespace covis {

struct TrainOptions {
  int branching = 10;    // children of a node
  int depth = 5;         // levels below the root: at most branching^depth words
  int seed = 0;          // seed of all that is drawn
  int threads = 0;       // 0: one a core
  int memory_mb = 4096;  // for descriptors and the work on them; more are sampled
  int iterations = 25;   // most rounds of k-medians in a node
};
Fields fields(TrainOptions& options);

// The descriptors of many images within a given memory. When there are more than fit, a fixed part of each image's is
// kept: those whose hash is below a limit, which is halved as often as needed.
class TrainingSet {
 public:
  TrainingSet(int memory_mb, int seed);
  void add_image(std::span<const Descriptor> descriptors);

  std::span<const Descriptor> descriptors() const { return descriptors_; }
  std::span<const uint64_t> offsets() const { return offsets_; }  // image i's are [offsets[i], offsets[i + 1])
  uint64_t images() const { return offsets_.size() - 1; }
  uint64_t seen() const { return seen_; }  // descriptors given

 private:
  bool keeps(const Descriptor& descriptor, uint64_t image) const;
  void halve();

  uint64_t seed_, capacity_, seen_ = 0;
  uint64_t limit_ = UINT64_MAX;  // greatest hash that is kept
  AlignedVector<Descriptor> descriptors_;
  std::vector<uint64_t> offsets_{0};
};

// Told how much of the work is done (0 to 1), from any of the threads, one at a time; false stops the training.
using TrainProgress = std::function<bool(double done)>;

// A word's weight is ln(N / n), n of the N images having it. Errors: options out of range, too few or too many
// descriptors, offsets that do not fit them, stopped.
Result<std::shared_ptr<const Vocabulary>> train_vocabulary(std::span<const Descriptor> descriptors,
                                                           std::span<const uint64_t> image_offsets,
                                                           const TrainOptions& options,
                                                           const TrainProgress& progress = {});

}  // namespace covis

// SPDX-License-Identifier: Apache-2.0
#include "covis/vocabulary/train.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>
#include <numeric>
#include <string>
#include <thread>
#include <utility>

#include "covis/core/random.h"
#include "covis/vocabulary/kmedians.h"

namespace covis {
namespace {

// Memory per descriptor: the descriptor, its entries in members_ and moved_, its cluster and distance.
constexpr uint64_t kBytesPerDescriptor = sizeof(Descriptor) + 4 + 4 + 1 + 2;
constexpr size_t kShared = 1 << 16;  // nodes with more members than this are processed by all threads together …
constexpr size_t kRange = 1 << 13;   // … in ranges of this size

// Calls work(i) for i in [0, count) on several threads; each takes the next i that is left.
void run_parallel(int threads, size_t count, const std::function<void(size_t)>& work) {
  std::atomic<size_t> next = 0;
  const auto loop = [&] {
    for (size_t i = next++; i < count; i = next++) work(i);
  };
  std::vector<std::jthread> others;  // when one can't be started, the others are waited for
  for (size_t t = 1; t < std::min(static_cast<size_t>(threads), count); ++t) others.emplace_back(loop);
  loop();
  for (std::jthread& thread : others) thread.join();
}

// A node to be split; its members are members_[begin, end).
struct Split {
  uint32_t node;  // number of the node; 0 is the root
  size_t begin, end;
  AlignedVector<Descriptor> centres = {};  // centres of its clusters, set by splitting
  std::vector<size_t> ends = {};           // end of each cluster's members
};

class Trainer {
 public:
  Trainer(std::span<const Descriptor> descriptors, std::span<const uint64_t> offsets, const TrainOptions& options,
          const TrainProgress& progress)
      : descriptors_(descriptors), offsets_(offsets), options_(options), progress_(progress) {
    if (options_.threads == 0) options_.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    members_.resize(descriptors.size());
    std::iota(members_.begin(), members_.end(), 0u);
    moved_.resize(descriptors.size());
  }

  Result<std::shared_ptr<const Vocabulary>> run() {
    std::vector<Split> level{{.node = 0, .begin = 0, .end = members_.size()}};
    for (int l = 0; l < options_.depth && !level.empty(); ++l) {
      split_level(level, l);
      if (stopped_) return fail("the training was stopped");
      level = add_children(level, l + 1);
    }
    if (nodes_.empty()) return fail("all descriptors are the same: there are no words to tell apart");
    return Vocabulary::build(options_.branching, options_.depth, nodes_);
  }

 private:
  void split_level(std::vector<Split>& level, int l) {
    std::vector<size_t> small;
    const size_t before = done_;
    const ForRanges alone = [](size_t n, const auto& work) { work(0, n); };
    const ForRanges together = [&](size_t n, const auto& work) {
      run_parallel(options_.threads, (n + kRange - 1) / kRange,
                   [&](size_t r) { work(r * kRange, std::min(n, (r + 1) * kRange)); });
    };
    for (size_t i = 0; i < level.size(); ++i) {
      if (level[i].end - level[i].begin > kShared) {
        split(level[i], l, i, together);
      } else {
        small.push_back(i);
      }
    }
    run_parallel(options_.threads, small.size(), [&](size_t s) { split(level[small[s]], l, small[s], alone); });
    done_ = before + members_.size();  // includes the words found above this level
  }

  void split(Split& node, int l, size_t index, const ForRanges& for_ranges) {
    if (stopped_) return;
    const std::span<uint32_t> members = std::span(members_).subspan(node.begin, node.end - node.begin);
    Random random(hash_seed(static_cast<uint64_t>(options_.seed), static_cast<uint64_t>(l), index));
    Clusters clusters = k_medians(descriptors_, members, options_.branching, options_.iterations, random, for_ranges);
    // Groups the members by cluster, in their order.
    node.ends.assign(clusters.centres.size(), 0);
    for (const uint8_t c : clusters.of) ++node.ends[c];
    std::exclusive_scan(node.ends.begin(), node.ends.end(), node.ends.begin(), node.begin);
    for (size_t i = 0; i < members.size(); ++i) moved_[node.ends[clusters.of[i]]++] = members[i];
    std::copy_n(moved_.begin() + static_cast<ptrdiff_t>(node.begin), members.size(), members.begin());
    node.centres = std::move(clusters.centres);
    report(members.size());
  }

  void report(size_t members) {
    const std::lock_guard lock(mutex_);
    done_ += members;
    if (!progress_) return;
    const double all = static_cast<double>(members_.size()) * options_.depth;
    if (!progress_(std::min(1.0, static_cast<double>(done_) / all))) stopped_ = true;
  }

  // Appends the children, of level `depth`, to the list, breadth first; returns those to be split.
  std::vector<Split> add_children(std::vector<Split>& level, int depth) {
    std::vector<Split> next;
    for (Split& split : level) {
      if (split.centres.size() < 2) {  // all members are equal: the node is a word
        if (split.node > 0) nodes_[split.node - 1].weight = idf(split.begin, split.end);
        continue;
      }
      for (size_t c = 0; c < split.centres.size(); ++c) {
        const size_t begin = c == 0 ? split.begin : split.ends[c - 1], end = split.ends[c];
        nodes_.push_back({.descriptor = split.centres[c], .parent = split.node, .weight = 0});
        if (depth == options_.depth) {
          nodes_.back().weight = idf(begin, end);
        } else {
          next.push_back({.node = static_cast<uint32_t>(nodes_.size()), .begin = begin, .end = end});
        }
      }
    }
    return next;
  }

  // Members are in ascending order, and so are their images.
  float idf(size_t begin, size_t end) const {
    size_t images = 0;
    uint64_t image_end = 0;
    for (size_t i = begin; i < end; ++i) {
      if (i > begin && members_[i] < image_end) continue;
      image_end = *std::upper_bound(offsets_.begin(), offsets_.end(), uint64_t{members_[i]});
      ++images;
    }
    return static_cast<float>(std::log(static_cast<double>(offsets_.size() - 1) / static_cast<double>(images)));
  }

  std::span<const Descriptor> descriptors_;
  std::span<const uint64_t> offsets_;
  TrainOptions options_;
  const TrainProgress& progress_;
  std::vector<uint32_t> members_;  // descriptor indices, grouped by node, ascending within a node
  std::vector<uint32_t> moved_;
  std::vector<VocabularyNode> nodes_;
  std::mutex mutex_;
  size_t done_ = 0;  // number of descriptors processed, counted once per level
  std::atomic<bool> stopped_ = false;
};

}  // namespace

Fields fields(TrainOptions& options) {
  return {
      {"train.branching", &options.branching, "children per node", 2, Vocabulary::kMaxBranching},
      {"train.depth", &options.depth, "levels below the root; at most branching^depth words", 1, Vocabulary::kMaxDepth},
      {"train.seed", &options.seed, "seed of all random numbers", 0},
      {"train.threads", &options.threads, "number of threads; 0: one per core. The result does not depend on it", 0,
       1024},
      {"train.memory", &options.memory_mb, "megabytes for descriptors; more of them are sampled", 1, 1 << 20},
      {"train.iterations", &options.iterations, "greatest number of k-medians rounds in a node", 1, 1000},
  };
}

TrainingSet::TrainingSet(int memory_mb, int seed)
    : seed_(static_cast<uint64_t>(seed)), capacity_((static_cast<uint64_t>(memory_mb) << 20) / kBytesPerDescriptor) {
  descriptors_.reserve(capacity_);  // growing later would need twice the memory
}

bool TrainingSet::keeps(const Descriptor& descriptor, uint64_t image) const {
  uint64_t hash = hash_seed(seed_, image);
  for (const uint64_t bits : descriptor.bits) hash = mix64(hash ^ bits);
  return hash <= limit_;
}

void TrainingSet::add_image(std::span<const Descriptor> descriptors) {
  const uint64_t image = images();
  offsets_.push_back(descriptors_.size());
  for (const Descriptor& descriptor : descriptors) {
    if (!keeps(descriptor, image)) continue;
    while (descriptors_.size() >= capacity_) halve();
    if (!keeps(descriptor, image)) continue;
    descriptors_.push_back(descriptor);
    offsets_.back() = descriptors_.size();
  }
  seen_ += descriptors.size();
}

void TrainingSet::halve() {
  limit_ /= 2;
  uint64_t begin = 0, kept = 0;
  for (uint64_t image = 0; image < images(); ++image) {
    const uint64_t end = offsets_[image + 1];
    for (uint64_t i = begin; i < end; ++i) {
      if (keeps(descriptors_[i], image)) descriptors_[kept++] = descriptors_[i];
    }
    begin = end;
    offsets_[image + 1] = kept;
  }
  descriptors_.resize(kept);
}

Result<std::shared_ptr<const Vocabulary>> train_vocabulary(std::span<const Descriptor> descriptors,
                                                           std::span<const uint64_t> image_offsets,
                                                           const TrainOptions& options, const TrainProgress& progress) {
  TrainOptions checked = options;
  for (const Field& field : fields(checked)) {
    if (auto ok = set_field({field}, field.name, field_text(field)); !ok) return tl::unexpected(ok.error());
  }
  if (descriptors.size() < 2) return fail("a vocabulary can't be trained from fewer than 2 descriptors");
  if (descriptors.size() > std::numeric_limits<uint32_t>::max()) return fail("too many descriptors: at most 2^32 - 1");
  if (image_offsets.size() < 2 || image_offsets.front() != 0 || image_offsets.back() != descriptors.size() ||
      !std::is_sorted(image_offsets.begin(), image_offsets.end())) {
    return fail("the images' offsets must rise from 0 to the number of descriptors");
  }
  return Trainer(descriptors, image_offsets, options, progress).run();
}

}  // namespace covis

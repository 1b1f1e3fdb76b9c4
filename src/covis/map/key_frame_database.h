// SPDX-License-Identifier: Apache-2.0
// The inverted index word -> key frames, and the query for places seen before, which serves loops and relocalisation.
// It belongs to the map: Map::set_words(), Map::erase_key_frame() and Map::erase_submap() keep it, Map::check() tests
// it.
// Source: Gálvez-López and Tardós, "Bags of Binary Words", T-RO 2012, section IV-B; Mur-Artal, Montiel, Tardós,
// "ORB-SLAM", T-RO 2015, sections III-E (share of words, groups) and VII-A.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <vector>

#include "covis/core/ids.h"
#include "covis/vocabulary/vocabulary.h"

namespace covis {

class Map;

class KeyFrameDatabase {
 public:
  void add(KeyFrameId id, const Words& words);
  void erase(KeyFrameId id, const Words& words);

  // The slots of the key frames that have a word, rising; empty when none has.
  const std::vector<uint32_t>& holders(uint32_t word) const;
  size_t words() const { return list_of_.size(); }  // one more than the greatest word ever added

  struct Candidate {
    KeyFrameId key_frame;
    double score = 0;  // the key frame's own (WeightsByWord::score)
  };
  // Returns the key frames of the map that look most like an image of these words. It keeps those that share at least
  // 80 % of the greatest number of shared words and score at least `min_score`; those that are excluded are left out
  // (by an empty function: none). Each makes a group with its 10 best covisible key frames, those that are kept too,
  // and the group's score is their sum. Each group of at least 75 % of the best sum gives its best key frame, once;
  // best group first (ties: lower handle).
  std::vector<Candidate> query(const Map& map, const Words& words, const std::function<bool(KeyFrameId)>& excluded,
                               double min_score) const;

 private:
  std::vector<uint32_t>& list_of(uint32_t word);

  // Most words of a vocabulary are never met: only those that are have a list.
  std::vector<uint32_t> list_of_;  // by word: 1 + index of its list, or 0
  // Slots of key frames, rising. All of them live, so that a slot serves for a handle in half the memory.
  std::deque<std::vector<uint32_t>> lists_;
};

}  // namespace covis

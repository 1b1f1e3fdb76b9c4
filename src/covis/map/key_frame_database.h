// SPDX-License-Identifier: Apache-2.0
// The inverted index word -> key frames, and the query for places seen before, which serves loops and
// relocalisation. P of the map: Map::set_words()
// and Map::erase_key_frame() keep it, Map::check() tests it.
// Source: Gálvez-López and Tardós, "Bags of Binary Words", T-RO 2012, section IV-B; Mur-Artal, Montiel, Tardós,
// "ORB-SLAM", T-RO 2015, sections III-E (share of words, groups) and VII-A.
#pragma once

#include <cstdint>
#include <vector>

#include "covis/core/ids.h"
#include "covis/vocabulary/vocabulary.h"

namespace covis {

class Map;

class KeyFrameDatabase {
 public:
  void add(KeyFrameId id, const Words& words);
  void erase(KeyFrameId id, const Words& words);
  void clear() { index_.clear(); }

  // The slots of the key frames that have a word, rising; empty when none has.
  const std::vector<uint32_t>& holders(uint32_t word) const;
  size_t words() const { return index_.size(); }  // one more than the greatest word ever added

  struct Candidate {
    KeyFrameId key_frame;
    double score = 0;  // word_score() of the key frame itself
  };
  // Places like `words` of the map: of the key frames that share words (but not those of `excluded`, sorted), those
  // sharing at least 80 % of the greatest number; scored, kept from `min_score` on; scores added up over each one's 10
  // best covisible key frames that are kept too; of the groups of at least 75 % of the best sum the best key frame of
  // each, without repeats, best group first (ties: lower handle).
  std::vector<Candidate> query(const Map& map, const Words& words, const std::vector<KeyFrameId>& excluded,
                               double min_score) const;

 private:
  // By word. What stands here is alive: its slot says all, in half the memory of its handle.
  std::vector<std::vector<uint32_t>> index_;
};

}  // namespace covis

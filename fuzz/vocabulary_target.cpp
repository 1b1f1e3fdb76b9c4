// SPDX-License-Identifier: Apache-2.0
// Vocabularies, binary (with checksums mended) and text.
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "covis/core/random.h"
#include "covis/features/test_features.h"
#include "covis/vocabulary/vocabulary.h"
#include "covis/vocabulary/vocabulary_file.h"
#include "scratch.h"
#include "target.h"

namespace covis::fuzz {
namespace {

void run_vocabulary(std::string_view given) {
  std::string file(given);
  if (file.size() >= sizeof(VocabularyHeader) && file.starts_with(kVocabularyMagic)) {
    VocabularyHeader header;
    std::memcpy(&header, file.data(), sizeof header);
    header.version = kVocabularyVersion;
    header.checksum = vocabulary_checksum(header, std::as_bytes(std::span(file)).subspan(sizeof header));
    header.header_checksum = header_checksum(header);
    std::memcpy(file.data(), &header, sizeof header);
  }
  const MemoryFile memory(file);
  const auto loaded = Vocabulary::load(memory.path());
  if (!loaded) return;
  Random random(3);
  std::vector<Descriptor> descriptors;
  for (int i = 0; i < 20; ++i) descriptors.push_back(random_descriptor(random));
  for (const WordWeight& w : (*loaded)->transform(descriptors).words)
    require(w.word < (*loaded)->words() && w.weight >= 0, "words are the vocabulary's");
  require((*loaded)->direct_index(descriptors).feature.size() <= descriptors.size(), "features are those given");
}

std::vector<std::string> seeds() {
  Random random(5);
  std::vector<VocabularyNode> nodes;
  for (uint32_t i = 0; i < 12; ++i) nodes.push_back({random_descriptor(random), i < 3 ? 0 : 1 + i % 3, 0.5f});
  const auto vocabulary = Vocabulary::build(4, 2, nodes);
  require(vocabulary.has_value(), "a seed can be built");
  std::vector<std::string> made;
  for (const bool text : {false, true}) {
    const std::filesystem::path file = scratch_folder() / "seed";
    require((text ? (*vocabulary)->save_text(file) : (*vocabulary)->save(file)).has_value(), "a seed can be saved");
    made.push_back(read_file(file));
  }
  return made;
}

}  // namespace

std::vector<Target> vocabulary_targets() { return {{"vocabulary", run_vocabulary, seeds}}; }

}  // namespace covis::fuzz

// SPDX-License-Identifier: Apache-2.0
// Files: written and read again, and all the ways in which they can be wrong.
#include "covis/vocabulary/vocabulary_file.h"

#include <gmock/gmock.h>

#include <cstring>

#include "covis/vocabulary/test_vocabulary.h"

namespace covis {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST_F(VocabularyFile, SavesWhatItLoads) {
  const auto loaded = Vocabulary::load(folder_ / "good");
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_TRUE((*loaded)->verify());
  EXPECT_EQ((*loaded)->branching(), 4);
  EXPECT_EQ((*loaded)->depth(), 3);
  EXPECT_EQ((*loaded)->words(), vocabulary_->words());
  EXPECT_EQ((*loaded)->nodes(), vocabulary_->nodes());
  EXPECT_EQ((*loaded)->checksum(), vocabulary_->checksum());
  for (size_t i = 0; i < 12; ++i) {
    EXPECT_EQ((*loaded)->transform(images_.image(i)), vocabulary_->transform(images_.image(i)));
  }
  ASSERT_TRUE((*loaded)->save(folder_ / "again"));
  EXPECT_EQ(read_file(folder_ / "again"), bytes_);
  ASSERT_TRUE((*loaded)->save(folder_ / "good"));  // over the file that it was loaded from
  EXPECT_TRUE((*loaded)->verify());
  EXPECT_EQ(read_file(folder_ / "good"), bytes_);
}

// A file that is mapped ends the process by a signal then.
TEST_F(VocabularyFile, AFileThatIsCutShortLaterChangesNothing) {
  const auto loaded = Vocabulary::load(folder_ / "good");
  ASSERT_TRUE(loaded);
  std::filesystem::resize_file(folder_ / "good", 1000);
  EXPECT_TRUE((*loaded)->verify());
  EXPECT_EQ((*loaded)->transform(images_.image(0)), vocabulary_->transform(images_.image(0)));
}

TEST_F(VocabularyFile, SavingThroughALinkReplacesWhatItNames) {
  write_file(folder_ / "target", "old");
  std::filesystem::create_symlink("target", folder_ / "link");
  ASSERT_TRUE(vocabulary_->save(folder_ / "link"));
  EXPECT_TRUE(std::filesystem::is_symlink(folder_ / "link"));
  EXPECT_EQ(read_file(folder_ / "target"), bytes_);
}

TEST_F(VocabularyFile, CutShortAnywhereIsAnError) {
  for (size_t length = 0; length < bytes_.size(); length += length < 200 ? 1 : 61) {
    const std::string said = load(bytes_.substr(0, length));
    EXPECT_THAT(said, HasSubstr("bad: ")) << length;
    EXPECT_THAT(said, testing::AnyOf(HasSubstr("cut short"), HasSubstr("empty"))) << length;
  }
  EXPECT_THAT(load(bytes_.substr(0, bytes_.size() - 1)), HasSubstr("cut short"));
  EXPECT_THAT(load(bytes_ + "x"), HasSubstr("follows its end"));
}

TEST_F(VocabularyFile, TurnedBitsAreFound) {
  Random random(22);
  for (int i = 0; i < 3000; ++i) {
    std::string damaged = bytes_;
    const size_t at = i < 512 ? static_cast<size_t>(i) / 8 : random.below(static_cast<uint32_t>(bytes_.size()));
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << (i % 8)));
    EXPECT_THAT(load(damaged), HasSubstr("bad: ")) << at;
  }
}

// A descriptor that is damaged breaks no rule of the tree, and once made other words under the same checksum.
TEST_F(VocabularyFile, ADamagedDescriptorIsToldByTheChecksum) {
  std::string damaged = bytes_;
  damaged[sizeof(VocabularyHeader) + 50] ^= 1;
  EXPECT_THAT(load(damaged), HasSubstr("its content is damaged (checksum)"));
}

// A file that was made to deceive: its header's checksum is right.
TEST_F(VocabularyFile, SizesThatCanNotBeAreErrors) {
  const auto with = [&](auto change) {
    VocabularyHeader header;
    std::memcpy(&header, bytes_.data(), sizeof header);
    change(header);
    header.header_checksum = header_checksum(header);
    std::string bytes = bytes_;
    std::memcpy(bytes.data(), &header, sizeof header);
    return bytes;
  };
  EXPECT_EQ(load(with([](VocabularyHeader&) {})), "loaded");
  EXPECT_THAT(load(with([](VocabularyHeader& h) { h.version = 2; })), HasSubstr("version 2"));
  EXPECT_THAT(load(with([](VocabularyHeader& h) { h.branching = 1; })), HasSubstr("sizes"));
  EXPECT_THAT(load(with([](VocabularyHeader& h) { h.branching = 257; })), HasSubstr("sizes"));
  EXPECT_THAT(load(with([](VocabularyHeader& h) { h.branching = 3; })), HasSubstr("tree"));
  EXPECT_THAT(load(with([](VocabularyHeader& h) { h.depth = 2; })), HasSubstr("tree"));
  EXPECT_THAT(load(with([](VocabularyHeader& h) { h.nodes = 0; })), HasSubstr("sizes"));
  EXPECT_THAT(load(with([](VocabularyHeader& h) { h.nodes = UINT32_MAX; })), HasSubstr("sizes"));
  EXPECT_THAT(load(with([](VocabularyHeader& h) { h.words = h.nodes; })), HasSubstr("sizes"));
  EXPECT_THAT(load(with([](VocabularyHeader& h) { h.bytes = 64; })), HasSubstr("sizes"));
}

TEST_F(VocabularyFile, ForeignAndMissingFilesAreErrors) {
  EXPECT_THAT(load("\x89PNG\r\n\x1a\n something"), HasSubstr("no vocabulary"));
  EXPECT_THAT(load(std::string(1000, '\0')), HasSubstr("no vocabulary"));
  EXPECT_THAT(load("%YAML:1.0\n---\n"), HasSubstr("no vocabulary"));
  EXPECT_THAT(load(""), HasSubstr("empty"));
  const auto missing = Vocabulary::load(folder_ / "missing");
  ASSERT_FALSE(missing);
  EXPECT_THAT(missing.error().message, HasSubstr("missing: can't be opened"));
  const auto folder = Vocabulary::load(folder_.path());
  ASSERT_FALSE(folder);
  EXPECT_THAT(folder.error().message, HasSubstr("not a regular file"));
}

TEST_F(VocabularyFile, WhatCanNotBeWrittenIsAnError) {
  const auto saved = vocabulary_->save(folder_ / "missing" / "file");
  ASSERT_FALSE(saved);
  EXPECT_THAT(saved.error().message, HasSubstr("can't be written"));
  std::filesystem::create_directories(folder_ / "taken" / "by");
  EXPECT_FALSE(vocabulary_->save(folder_ / "taken"));
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
    EXPECT_THAT(entry.path().string(), testing::Not(HasSubstr(".tmp")));
  }
}

TEST(DefaultVocabulary, IsWholeAndOfTheSizeItIsSaidToHave) {
  const std::filesystem::path file = COVIS_SOURCE_DIR "/vocabulary/default.covis-voc";
  const auto vocabulary = Vocabulary::load(file);
  ASSERT_TRUE(vocabulary) << vocabulary.error().message;
  EXPECT_TRUE((*vocabulary)->verify());
  EXPECT_EQ((*vocabulary)->branching(), 10);
  EXPECT_EQ((*vocabulary)->depth(), 5);
  EXPECT_GT((*vocabulary)->words(), 90000u);
  EXPECT_LE(std::filesystem::file_size(file), 8u << 20);
  Random random(23);
  std::vector<Descriptor> descriptors;
  for (int i = 0; i < 5000; ++i) descriptors.push_back(random_descriptor(random));
  const DirectIndex index = (*vocabulary)->direct_index(descriptors);
  EXPECT_LE(index.node.size(), 100u);
  EXPECT_GT(index.node.size(), 80u);
}

}  // namespace
}  // namespace covis

// SPDX-License-Identifier: Apache-2.0
// The container of a map file: a header, a table, and compressed sections (docs/map-format.md has it byte for byte).
// What is in the sections is map_file.cpp's matter. Every byte of a file is under a checksum, and nothing read from one
// is trusted: lengths are held against what is there before memory is taken.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "covis/core/error.h"

namespace covis::storage {

inline constexpr uint16_t kMapFileMajor = 1;  // files of another one can't be read
inline constexpr uint16_t kMapFileMinor = 1;  // a newer one moves no field: read, but for what it may newly contain

static_assert(std::endian::native == std::endian::little, "fields go to the file as they lie in memory");

// The CRC-32 of ISO 3309 (as of PNG and gzip): tells every change within 32 bits in a row, so every changed byte.
uint32_t crc32(std::string_view bytes, uint32_t crc = 0);

// Fields one after the other, without padding. Writer and Reader have the same calls, so that one function describes a
// layout for both directions.
class FieldWriter {
 public:
  template <class T>
  void operator()(const T& value) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  // `count` values without their number.
  template <class T>
  void array(const T* values, size_t count) {
    bytes_.append(reinterpret_cast<const char*>(values), count * sizeof(T));
  }
  // The number of values (32 bits) and the values: a std::string or a std::vector.
  template <class List>
  void list(const List& values) {
    (*this)(static_cast<uint32_t>(values.size()));
    array(values.data(), values.size());
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

// Reads past the end give zeros and nothing; ask whole() at last.
class FieldReader {
 public:
  explicit FieldReader(std::string_view bytes) : rest_(bytes) {}
  template <class T>
  void operator()(T& value) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    array(&value, 1);
  }
  template <class T>
  void array(T* values, size_t count) {
    if (!fits<T>(count)) return;
    if (count > 0) std::memcpy(static_cast<void*>(values), rest_.data(), count * sizeof(T));
    rest_.remove_prefix(count * sizeof(T));
  }
  template <class List>
  void list(List& values) {
    uint32_t count = 0;
    (*this)(count);
    sized_list(values, count);
  }
  // A list whose length is known from elsewhere.
  template <class List>
  void sized_list(List& values, size_t count) {
    if (!fits<typename List::value_type>(count)) return;
    values.resize(count);
    array(values.data(), count);
  }
  // Every read found its bytes so far.
  bool ok() const { return ok_; }
  // And nothing is left.
  bool whole() const { return ok_ && rest_.empty(); }

 private:
  template <class T>
  bool fits(size_t count) {
    if (rest_.size() / sizeof(T) < count) ok_ = false;
    return ok_;
  }
  std::string_view rest_;
  bool ok_ = true;
};

struct Section {
  uint32_t id = 0;
  std::string bytes;
};

// The bytes of a file of these sections, compressed; the same for the same sections.
Result<std::string> pack_sections(std::vector<Section> sections, uint16_t major = kMapFileMajor,
                                  uint16_t minor = kMapFileMinor);

// A map file open for reading: opening looks at header and table, read() at one section. Errors name the file.
class SectionFile {
 public:
  static Result<SectionFile> open(const std::filesystem::path& file);
  // The section's bytes, uncompressed. `name` is for messages.
  Result<std::string> read(uint32_t id, std::string_view name);
  // An error when stored bytes of sections not read so far, unknown ones as well, are not as they were written.
  Result<void> verify_others();
  uint16_t major() const { return major_; }
  uint16_t minor() const { return minor_; }
  uint64_t size() const { return size_; }  // size of the file
  std::string error(std::string_view what) const { return file_.string() + ": " + std::string(what); }

 private:
  struct Entry {
    uint32_t id = 0, crc = 0;
    uint64_t stored = 0, raw = 0, offset = 0;
    bool read = false;
  };
  std::filesystem::path file_;
  std::ifstream stream_;
  uint16_t major_ = 0, minor_ = 0;
  uint64_t size_ = 0;
  std::vector<Entry> entries_;

  Result<void> read_table(uint32_t count, uint32_t so_far, uint32_t wanted_crc);
  Result<std::string> read_stored(Entry& entry, std::string_view name);
};

}  // namespace covis::storage

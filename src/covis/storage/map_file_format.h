// SPDX-License-Identifier: Apache-2.0
// The container of a map file: a header, a table, and compressed sections (docs/map-format.md specifies every byte).
// The contents of the sections are defined in map_file.cpp. Every byte of a file is covered by a checksum, and no value
// read from a file is trusted: lengths are compared with the bytes present before memory is allocated.
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

#include "covis/core/atomic_file.h"
#include "covis/core/error.h"

struct ZSTD_CCtx_s;  // zstd's ZSTD_CCtx

namespace covis::storage {

inline constexpr uint16_t kMapFileMajor = 1;  // files of another major version cannot be read
// Newer minor versions move no field and are read, except for added contents. A file gets the least that its contents
// need.
inline constexpr uint16_t kMapFileMinor = 10, kMapFileMinorWithShutter = 9, kMapFileMinorWithRegistration = 8,
                          kMapFileMinorWithAnchors = 7, kMapFileMinorWithResiduals = 6, kMapFileMinorWithCameras = 5,
                          kMapFileMinorWithSizes = 4, kMapFileMinorWithColours = 3, kMapFileMinorLeast = 2;

inline constexpr const char* kNotRightLength = "it is damaged: a section has not the length that its contents ask for";

static_assert(std::endian::native == std::endian::little, "fields go to the file as they lie in memory");

// CRC-32 of ISO 3309 (as in PNG and gzip). It detects every change within 32 consecutive bits, so every changed byte.
uint32_t crc32(std::string_view bytes, uint32_t crc = 0);

// Fields in sequence, without padding. Writer and reader have the same interface, so that one function describes a
// layout for both directions.
class FieldWriter {
 public:
  template <class T>
  void operator()(const T& value) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  // Writes `count` values without their number.
  template <class T>
  void array(const T* values, size_t count) {
    bytes_.append(reinterpret_cast<const char*>(values), count * sizeof(T));
  }
  // Writes the number of values (32 bits) and the values of a std::string or a std::vector.
  template <class List>
  void list(const List& values) {
    (*this)(static_cast<uint32_t>(values.size()));
    array(values.data(), values.size());
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

// Reads past the end leave values unchanged and make ok() false; call whole() at the end.
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
  // Reads a list whose length is stored elsewhere.
  template <class List>
  void sized_list(List& values, size_t count) {
    if (!fits<typename List::value_type>(count)) return;
    values.resize(count);
    array(values.data(), count);
  }
  // True when no read so far went past the end.
  bool ok() const { return ok_; }
  // True when, in addition, no bytes are left.
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

// Writes a map file section by section, each in pieces of any size, so that little of it is held in memory. Equal
// sections give equal bytes, whatever their pieces.
class SectionWriter {
 public:
  // Leaves room for the header and the table of so many sections.
  SectionWriter(FileSink& sink, size_t sections, uint16_t major, uint16_t minor);
  ~SectionWriter();
  SectionWriter(const SectionWriter&) = delete;
  SectionWriter& operator=(const SectionWriter&) = delete;

  // A section whose pieces have `size` bytes together.
  void begin(uint32_t id, uint64_t size);
  void add(std::string_view piece);
  void end();
  // A section of one piece.
  void write(uint32_t id, std::string_view bytes);
  // Fills in header and table. Returns the size of the file.
  Result<uint64_t> finish();

 private:
  void compress(std::string_view piece, bool last);

  FileSink& sink_;
  const size_t sections_;
  const uint16_t major_, minor_;
  ZSTD_CCtx_s* const zstd_;
  std::string packed_;  // a piece, compressed
  FieldWriter table_;
  uint64_t size_;                  // bytes of the file so far
  uint32_t id_ = 0, crc_ = 0;      // the present section's
  uint64_t raw_ = 0, stored_ = 0;  // bytes of the present section, before and after compression
  std::string problem_;
};

// True for a file that begins like a map, whatever follows.
bool is_map_file(const std::filesystem::path& file);

// An open map file: open() reads header and table, read() a single section. Errors name the file.
class SectionFile {
 public:
  static Result<SectionFile> open(const std::filesystem::path& file);
  // Returns the section's uncompressed bytes. `name` is used in messages.
  Result<std::string> read(uint32_t id, std::string_view name);
  // Verifies the checksums of the sections not read so far, unknown ones included.
  Result<void> verify_others();
  bool has(uint32_t id) const;
  uint16_t major() const { return major_; }
  uint16_t minor() const { return minor_; }
  uint64_t size() const { return size_; }  // size of the file, bytes
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
  uint64_t unpacked_ = 0;  // bytes uncompressed so far
  std::vector<Entry> entries_;

  Result<void> read_table(uint32_t count, uint32_t so_far, uint32_t wanted_crc);
  Result<std::string> read_stored(Entry& entry, std::string_view name);
};

}  // namespace covis::storage

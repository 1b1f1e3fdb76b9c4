// SPDX-License-Identifier: Apache-2.0
#include "covis/storage/map_file_format.h"

#include <zstd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <new>
#include <system_error>

#include "covis/storage/load_cost.h"

namespace covis::storage {
namespace {

constexpr std::string_view kMagic = "COVISMAP";
constexpr size_t kHeaderSize = 32, kEntrySize = 24;
constexpr uint32_t kMostSections = 1000;  // empty ones cost nothing but the time to look at them
constexpr int kLevel = 3;  // zstd's default: descriptors hardly compress, so a higher level is wasted effort

// tables[k][b] is the checksum of byte b followed by k zero bytes; with all eight, eight bytes are processed at once.
using CrcTables = std::array<std::array<uint32_t, 256>, 8>;

constexpr CrcTables make_crc_tables() {
  CrcTables tables{};
  for (uint32_t b = 0; b < 256; ++b) {
    uint32_t crc = b;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0xedb88320u : 0u);
    tables[0][b] = crc;
  }
  for (size_t k = 1; k < 8; ++k) {
    for (size_t b = 0; b < 256; ++b) {
      const uint32_t before = tables[k - 1][b];
      tables[k][b] = (before >> 8) ^ tables[0][before & 255];
    }
  }
  return tables;
}

constexpr CrcTables kCrc = make_crc_tables();

}  // namespace

uint32_t crc32(std::string_view bytes, uint32_t crc) {
  crc = ~crc;
  for (; bytes.size() >= 8; bytes.remove_prefix(8)) {
    uint64_t word = 0;
    std::memcpy(&word, bytes.data(), 8);
    word ^= crc;
    crc = 0;
    for (size_t k = 0; k < 8; ++k) crc ^= kCrc[7 - k][(word >> (8 * k)) & 255];
  }
  for (const char c : bytes) crc = (crc >> 8) ^ kCrc[0][(crc ^ static_cast<uint8_t>(c)) & 255];
  return ~crc;
}

SectionWriter::SectionWriter(FileSink& sink, size_t sections, uint16_t major, uint16_t minor)
    : sink_(sink),
      sections_(sections),
      major_(major),
      minor_(minor),
      zstd_(ZSTD_createCCtx()),
      packed_(ZSTD_CStreamOutSize(), '\0'),
      size_(kHeaderSize + kEntrySize * sections) {
  if (!zstd_) throw std::bad_alloc();
  sink_.append(std::string(size_, '\0'));
  ZSTD_CCtx_setParameter(zstd_, ZSTD_c_compressionLevel, kLevel);
}

SectionWriter::~SectionWriter() { ZSTD_freeCCtx(zstd_); }

void SectionWriter::begin(uint32_t id, uint64_t size) {
  id_ = id;
  crc_ = 0;
  raw_ = size;
  stored_ = 0;
  ZSTD_CCtx_setPledgedSrcSize(zstd_, size);
}

void SectionWriter::compress(std::string_view piece, bool last) {
  ZSTD_inBuffer in{piece.data(), piece.size(), 0};
  bool more = true;
  while (more && problem_.empty()) {
    ZSTD_outBuffer out{packed_.data(), packed_.size(), 0};
    const size_t left = ZSTD_compressStream2(zstd_, &out, &in, last ? ZSTD_e_end : ZSTD_e_continue);
    if (ZSTD_isError(left)) problem_ = std::string("zstd: ") + ZSTD_getErrorName(left);
    const std::string_view made = std::string_view(packed_).substr(0, out.pos);
    sink_.append(made);
    crc_ = crc32(made, crc_);
    stored_ += made.size();
    more = last ? left != 0 : in.pos < in.size;
  }
}

void SectionWriter::add(std::string_view piece) { compress(piece, false); }

void SectionWriter::end() {
  compress({}, true);
  table_(id_);
  table_(crc_);
  table_(stored_);
  table_(raw_);
  size_ += stored_;
}

void SectionWriter::write(uint32_t id, std::string_view bytes) {
  begin(id, bytes.size());
  add(bytes);
  end();
}

Result<uint64_t> SectionWriter::finish() {
  if (!problem_.empty()) return fail(problem_);
  FieldWriter header;
  header.array(kMagic.data(), kMagic.size());
  header(major_);
  header(minor_);
  header(static_cast<uint32_t>(sections_));
  header(size_);
  header(uint32_t{0});  // reserved field
  const std::string head = header.take(), table = table_.take();
  FieldWriter crc;
  crc(crc32(table, crc32(head)));
  sink_.rewrite(0, head + crc.take() + table);
  return size_;
}

bool is_map_file(const std::filesystem::path& file) {
  std::string magic(kMagic.size(), '\0');
  std::ifstream stream(file, std::ios::binary);
  return stream.read(magic.data(), static_cast<std::streamsize>(magic.size())) && magic == kMagic;
}

Result<SectionFile> SectionFile::open(const std::filesystem::path& path) {
  SectionFile file;
  file.file_ = path;
  std::error_code none;
  const auto status = std::filesystem::status(path, none);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    return fail(file.error("it is a folder or a device; a map file is expected"));
  }
  file.stream_.open(path, std::ios::binary);
  if (!file.stream_) return fail(file.error("it can't be opened: " + std::generic_category().message(errno)));
  file.size_ = std::filesystem::file_size(path, none);
  if (none) return fail(file.error("it can't be read: " + none.message()));
  std::string header(kHeaderSize, '\0');
  file.stream_.read(header.data(), kHeaderSize);
  const auto got = static_cast<size_t>(file.stream_.gcount());
  if (got == 0) return fail(file.error("it is empty"));
  if (header.compare(0, kMagic.size(), kMagic) != 0) return fail(file.error("it is not a map of Covis"));
  if (got < kHeaderSize) return fail(file.error("it is cut off within its header"));
  FieldReader fields(std::string_view(header).substr(kMagic.size()));
  uint32_t count = 0, reserved = 0, crc = 0;
  uint64_t size = 0;
  fields(file.major_);
  fields(file.minor_);
  fields(count);
  fields(size);
  fields(reserved);
  fields(crc);
  if (file.major_ != kMapFileMajor) {
    return fail(file.error("it is of version " + std::to_string(file.major_) + "." + std::to_string(file.minor_) +
                           " of the map format; this Covis reads version " + std::to_string(kMapFileMajor)));
  }
  if (size != file.size_) {
    return fail(file.error("it is damaged: it has " + std::to_string(file.size_) + " bytes, its header says " +
                           std::to_string(size)));
  }
  const uint32_t so_far = crc32(std::string_view(header).substr(0, kHeaderSize - sizeof crc));
  if (auto table = file.read_table(count, so_far, crc); !table) return tl::unexpected(table.error());
  return file;
}

Result<void> SectionFile::read_table(uint32_t count, uint32_t so_far, uint32_t wanted_crc) {
  if (count > (size_ - kHeaderSize) / kEntrySize) return fail(error("it is damaged: its header is wrong"));
  if (count > kMostSections)
    return fail(error("it has " + std::to_string(count) + " sections, and no map has more than " +
                      std::to_string(kMostSections)));
  std::string table(kEntrySize * count, '\0');
  stream_.read(table.data(), static_cast<std::streamsize>(table.size()));
  if (!stream_ || crc32(table, so_far) != wanted_crc) return fail(error("it is damaged: its header is wrong"));
  FieldReader fields(table);
  uint64_t offset = kHeaderSize + table.size();
  for (uint32_t i = 0; i < count; ++i) {
    Entry e;
    fields(e.id);
    fields(e.crc);
    fields(e.stored);
    fields(e.raw);
    e.offset = offset;
    if (has(e.id)) return fail(error("it is damaged: it has section " + std::to_string(e.id) + " twice"));
    if (e.stored > size_ - offset) return fail(error("it is damaged: its sections do not fit into it"));
    offset += e.stored;
    entries_.push_back(e);
  }
  if (offset != size_) return fail(error("it is damaged: there are bytes after its sections"));
  return {};
}

Result<std::string> SectionFile::read_stored(Entry& entry, std::string_view name) {
  std::string stored(entry.stored, '\0');
  stream_.seekg(static_cast<std::streamoff>(entry.offset));
  stream_.read(stored.data(), static_cast<std::streamsize>(stored.size()));
  if (!stream_) return fail(error("it can't be read"));
  if (crc32(stored) != entry.crc) {
    return fail(error("it is damaged: the checksum of its section '" + std::string(name) + "' is wrong"));
  }
  entry.read = true;
  return stored;
}

bool SectionFile::has(uint32_t id) const {
  return std::any_of(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.id == id; });
}

Result<std::string> SectionFile::read(uint32_t id, std::string_view name) {
  const auto entry = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.id == id; });
  if (entry == entries_.end()) return fail(error("it has no section '" + std::string(name) + "'"));
  auto stored = read_stored(*entry, name);
  if (!stored) return stored;
  const std::string problem = error("its section '" + std::string(name) + "' can't be uncompressed");
  // No memory is allocated for an implausible size, nor for one section many times.
  const uint64_t most = kUnpackedTimes * counted_size(size_);
  if (entry->raw > most || unpacked_ > most - entry->raw) {
    return fail(problem + ": with it the file would grow to more than " + std::to_string(kUnpackedTimes) +
                " times its size, which no map of Covis does");
  }
  unpacked_ += entry->raw;
  std::string raw(entry->raw, '\0');
  const size_t size = ZSTD_decompress(raw.data(), raw.size(), stored->data(), stored->size());
  if (ZSTD_isError(size) || size != raw.size()) return fail(problem);
  return raw;
}

Result<void> SectionFile::verify_others() {
  for (Entry& entry : entries_) {
    if (entry.read) continue;
    if (auto stored = read_stored(entry, std::to_string(entry.id)); !stored) return tl::unexpected(stored.error());
  }
  return {};
}

}  // namespace covis::storage

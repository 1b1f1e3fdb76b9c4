// SPDX-License-Identifier: Apache-2.0
// Files that are there whole or not at all.
#pragma once

#include <filesystem>
#include <string_view>

#include "covis/core/error.h"

namespace covis {

// durable: the bytes and the name have reached the disk when the call returns, so that even a loss of power leaves the
// old file or the new one, whole. That takes the disk's time. fast: the same holds while the system itself keeps
// running, whatever becomes of the process.
enum class Durability { fast, durable };

// Writes to a temporary file in the same folder and renames it: on an error (a full disk, no right to write) the old
// file is as it was and nothing else is left. A link stays a link, its target is replaced; one that leads nowhere is an
// error. A file that is replaced keeps its permissions. A pipe or a device is written to directly. Threads and
// processes may write the same file at once: one of them wins.
Result<void> write_atomically(const std::filesystem::path& file, std::string_view bytes,
                              Durability durability = Durability::fast);

}  // namespace covis

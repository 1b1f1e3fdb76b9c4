// SPDX-License-Identifier: Apache-2.0
// Files that are written completely or not at all.
#pragma once

#include <filesystem>
#include <string_view>

#include "covis/core/error.h"

namespace covis {

// durable: the bytes and the name are on disk when the call returns, so that even after a power failure either the old
// or the new file is there, complete. Waiting for the disk takes time. fast: the same guarantee as long as the
// operating system keeps running, even if the process is killed.
enum class Durability { fast, durable };

// Writes to a temporary file in the same folder and renames it. On an error (a full disk, no write permission) the old
// file is unchanged and no temporary file is left. A symbolic link is kept and its target replaced; a link without a
// target is an error. A replaced file keeps its permissions. A pipe or a device is written to directly. Threads and
// processes may write the same file at once: one of them wins.
Result<void> write_atomically(const std::filesystem::path& file, std::string_view bytes,
                              Durability durability = Durability::fast);

}  // namespace covis
